#pragma once

#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "trunnion/base/quantity.hpp"
#include "trunnion/machine/machine.hpp"
#include "trunnion/surfacing/face.hpp"

namespace trunnion::surfacing::samples {

/// An arc of a circle as a rational quadratic: points in a plane (x, y) with weights, from angle `from` over `turn` <
/// π.
struct ArcPoint {
    double x, y, weight;
};
inline std::vector<ArcPoint> arc(double radius, double from, double turn) {
    const double half = turn / 2, middle = from + half, out = radius / std::cos(half);
    return {{radius * std::cos(from), radius * std::sin(from), 1},
            {out * std::cos(middle), out * std::sin(middle), std::cos(half)},
            {radius * std::cos(from + turn), radius * std::sin(from + turn), 1}};
}

inline const geometry::SurfaceDirection& line() {
    static const geometry::SurfaceDirection one{1, {0, 0, 1, 1}};
    return one;
}
inline const geometry::SurfaceDirection& quadratic() {
    static const geometry::SurfaceDirection one{2, {0, 0, 0, 1, 1, 1}};
    return one;
}

/// Up to normal +z, a × b mm.
inline geometry::BsplineSurface plane(double a, double b) {
    return geometry::BsplineSurface::make(line(), line(), {{0, 0, 0}, {0, b, 0}, {a, 0, 0}, {a, b, 0}}).value();
}

/// Round the y axis, its top at z = radius, `turn` wide; u along y.
inline geometry::BsplineSurface cylinder(double radius, double length, double turn) {
    std::vector<Eigen::Vector3d> points;
    std::vector<double> weights;
    for (const double y : {0.0, length})
        for (const ArcPoint& p : arc(radius, std::numbers::pi / 2 - turn / 2, turn)) {
            points.emplace_back(p.x, y, p.y);
            weights.push_back(p.weight);
        }
    return geometry::BsplineSurface::make(line(), quadratic(), points, weights).value();
}

/// A patch of a torus about the z axis: the tube from `tube_from` over `tube_turn` (0 = outermost), round by `turn`; a
/// sphere with ring = 0.
inline geometry::BsplineSurface torus(double ring, double tube, double tube_from, double tube_turn, double turn) {
    std::vector<Eigen::Vector3d> points;
    std::vector<double> weights;
    for (const ArcPoint& t : arc(tube, tube_from, tube_turn))
        for (const ArcPoint& r : arc(1, -turn / 2, turn)) {
            points.emplace_back((ring + t.x) * r.x, (ring + t.x) * r.y, t.y);
            weights.push_back(t.weight * r.weight);
        }
    return geometry::BsplineSurface::make(quadratic(), quadratic(), points, weights).value();
}

/// z(x, y) interpolated by a bicubic of one piece through values at a 4 × 4 grid of control points, size × size mm.
inline geometry::BsplineSurface bicubic(double size, const std::function<double(double, double)>& z) {
    const geometry::SurfaceDirection cubic{3, {0, 0, 0, 0, 1, 1, 1, 1}};
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) {
            const double x = size * i / 3, y = size * j / 3;
            points.emplace_back(x, y, z(x / size, y / size));
        }
    return geometry::BsplineSurface::make(cubic, cubic, points).value();
}

/// The side whose normal is nearer to a direction, in the middle of the surface.
inline Face facing(geometry::BsplineSurface surface, const Eigen::Vector3d& towards) {
    const geometry::SurfacePlace middle{0.5 * (surface.u().begin() + surface.u().end()),
                                        0.5 * (surface.v().begin() + surface.v().end())};
    const auto shape = geometry::shape_at(surface, middle, geometry::Side::along);
    const bool along = shape && shape->normal.dot(towards) > 0;
    return whole_face(std::move(surface), along ? geometry::Side::along : geometry::Side::against);
}

inline machine::Tool flat_tool(double diameter) {
    return {.kind = machine::ToolKind::flat, .diameter_mm = diameter};
}
inline machine::Tool ball_tool(double diameter) {
    return {.kind = machine::ToolKind::ball, .diameter_mm = diameter};
}
inline machine::Tool torus_tool(double diameter, double corner) {
    return {.kind = machine::ToolKind::torus, .diameter_mm = diameter, .corner_radius_mm = corner};
}

/// Two flat sheets that meet in a sharp edge at a share of the way along u, turned by some angle there; the part before
/// it is short.
inline Face roof(double share, double turn_deg) {
    const geometry::SurfaceDirection once{1, {0, 0, share, 1, 1}};
    const double turn = turn_deg * degree, length = 16 * share;
    const Eigen::Vector3d before(-length * std::cos(turn), 0, -length * std::sin(turn)), after(16 - length, 0, 0);
    const Eigen::Vector3d top(0, 0, 0), wide(0, 9, 0);
    return facing(
        geometry::BsplineSurface::make(once, line(), {before, before + wide, top, top + wide, after, after + wide})
            .value(),
        {0, 0, 1});
}

}  // namespace trunnion::surfacing::samples
