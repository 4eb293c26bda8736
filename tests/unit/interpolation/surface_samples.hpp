#pragma once

#include <cmath>
#include <vector>

#include "trunnion/interpolation/surface_curve.hpp"
#include "trunnion/machine/machine.hpp"

namespace trunnion::interpolation::samples {

using geometry::BsplineCurve;
using geometry::BsplineSurface;
using geometry::SurfaceDirection;

/// The curve of Lin & Koren's Eq. 8 as the border v = 0 of a surface that goes straight up from it.
inline BsplineSurface koren_surface() {
    const Eigen::Vector3d up(0, 0, 20), none(0, 0, 0);
    return geometry::polynomial_surface(3, 1, {{10, 0, 0}, up, {0, 10, 0}, none, {10, 10, 0}, none, {10, 0, 0}, none})
        .value();
}

/// A bicubic of one piece with hills and hollows, size × size mm.
inline BsplineSurface hills(double size, double height) {
    const SurfaceDirection cubic{3, {0, 0, 0, 0, 1, 1, 1, 1}};
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) {
            const double x = i / 3.0, y = j / 3.0;
            points.emplace_back(size * x, size * y, height * (std::sin(3 * x) * std::cos(2.5 * y) + 0.4 * x * y));
        }
    return BsplineSurface::make(cubic, cubic, points).value();
}

/// The same with knots inside, where it is C².
inline BsplineSurface patched_hills(double size, double height) {
    const SurfaceDirection cubic{3, {0, 0, 0, 0, 0.3, 0.55, 0.8, 1, 1, 1, 1}};
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < 7; ++i)
        for (int j = 0; j < 7; ++j) {
            const double x = i / 6.0, y = j / 6.0;
            points.emplace_back(size * x, size * y, height * std::sin(4 * x) * std::cos(3 * y));
        }
    return BsplineSurface::make(cubic, cubic, points).value();
}

/// A sphere's belt as a rational quadratic with three pieces round: C¹ at the knots as it is parametrised, though
/// round.
inline BsplineSurface belt(double radius, double height) {
    const double quarter = std::sqrt(0.5);
    const SurfaceDirection round{2, {0, 0, 0, 1, 1, 2, 2, 2}}, up{1, {0, 0, 1, 1}};
    const std::vector<Eigen::Vector3d> plan{{0, -1, 0}, {1, -1, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    std::vector<Eigen::Vector3d> points;
    std::vector<double> weights;
    for (int i = 0; i < 5; ++i)
        for (const double z : {0.0, height}) {
            points.emplace_back(radius * plan[i] + Eigen::Vector3d(0, 0, z));
            weights.push_back(i % 2 ? quarter : 1);
        }
    return BsplineSurface::make(round, up, points, weights).value();
}

/// Straight in (u, v).
inline BsplineCurve line(double u0, double v0, double u1, double v1) {
    return BsplineCurve::make(1, {0, 0, 1, 1}, {{u0, v0, 0}, {u1, v1, 0}}).value();
}

/// Bent in (u, v): a cubic from (0.05, 0.1) to (0.95, 0.8).
inline BsplineCurve bow() {
    return BsplineCurve::make(3, {0, 0, 0, 0, 1, 1, 1, 1},
                              {{0.05, 0.1, 0}, {0.3, 0.5, 0}, {0.6, 0.3, 0}, {0.95, 0.8, 0}})
        .value();
}

inline SurfaceTool flat_tool(double radius) {
    return {.radius_mm = radius};
}

/// Second points over hills(60, 12), some 50 mm up, that lean by 10 to 25°; with knots at 0.3, 0.55, 0.8 or none.
inline BsplineSurface leaning(bool knots_inside) {
    const SurfaceDirection one{3, {0, 0, 0, 0, 1, 1, 1, 1}}, four{3, {0, 0, 0, 0, 0.3, 0.55, 0.8, 1, 1, 1, 1}};
    const SurfaceDirection& along = knots_inside ? four : one;
    const int rows = static_cast<int>(along.points());
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < rows; ++i)
        for (int j = 0; j < rows; ++j) {
            const double x = static_cast<double>(i) / (rows - 1), y = static_cast<double>(j) / (rows - 1);
            points.emplace_back(60 * x + 18 + 4 * std::sin(5 * x + y), 60 * y + 6 * std::cos(4 * y - x), 50 + 6 * x);
        }
    return BsplineSurface::make(along, along, points).value();
}

inline SurfaceTool on(const BsplineSurface& orientation, double radius_mm, double corner_mm) {
    return {.radius_mm = radius_mm, .corner_mm = corner_mm, .orientation = &orientation};
}

/// C A X Y Z: A turns a table that carries C.
inline machine::Machine trunnion_table() {
    machine::Machine out;
    out.axis_count = 5;
    out.rotary_count = 2;
    out.chain = {4, 3, 0, 1, 2};
    for (int i = 0; i < 5; ++i) {
        machine::Axis& axis = out.axes[i];
        axis.letter = "XYZAC"[i];
        axis.rotary = i > 2;
        axis.direction = Eigen::Vector3d::Unit(i == 3 ? 0 : i == 4 ? 2 : i);
        axis.feed = i > 2 ? machine::AxisLimits{2, 5, 50} : machine::AxisLimits{500, 2500, 20000};
        axis.rapid = axis.feed;
    }
    return out;
}

}  // namespace trunnion::interpolation::samples
