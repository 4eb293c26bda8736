#include "trunnion/surfacing/path_interval.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/LU>

namespace trunnion::surfacing {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

/// How far from its axis, in a direction of the given curvature of the surface, the end of an upright tool is `scallop`
/// above the surface: flat out to F, then rounded, with the wall at R.
double radius_of_height_mm(const Cutter& cutter, double curvature, double scallop_mm) noexcept {
    const double corner = cutter.corner_mm(), flat = cutter.flat_radius_mm();
    const double by_edge = flat + std::sqrt(std::max(0.0, scallop_mm * (2 * corner - scallop_mm)));
    if (curvature <= 0) return std::min(by_edge, cutter.radius_mm());
    const double by_surface = std::sqrt(2 * scallop_mm / curvature);
    if (by_surface <= flat || corner == 0) return std::min(by_surface, cutter.radius_mm());
    // Newton's method from beyond on a function that bends upwards never passes its root.
    double out = std::min(by_edge, by_surface);
    for (int step = 0; step < 6; ++step) {
        const double beyond = std::max(0.0, out - flat);
        const double under = std::sqrt(std::max(1e-30, corner * corner - beyond * beyond));
        const double off = 0.5 * curvature * out * out + corner - under - scallop_mm;
        out -= off / (curvature * out + beyond / under);
    }
    return out;
}

/// How far across the feed the end of an upright tool reaches while it is no higher than `scallop` above the surface:
/// the support function of that part of its end, by the golden section over directions.
double upright_reach_mm(const Cutter& cutter, const Eigen::Matrix2d& shape, const Eigen::Vector2d& across,
                        double scallop_mm) noexcept {
    const Eigen::Vector2d feed(-across.y(), across.x());
    const auto reach = [&](double angle) {
        const double cosine = std::cos(angle);
        const Eigen::Vector2d way = cosine * across + std::sin(angle) * feed;
        return cosine * radius_of_height_mm(cutter, way.dot(shape * way), scallop_mm);
    };
    constexpr double golden = 0.3819660112501051;
    double low = -std::numbers::pi / 2, high = std::numbers::pi / 2;
    double a = low + golden * (high - low), b = high - golden * (high - low);
    double at_a = reach(a), at_b = reach(b);
    for (int step = 0; step < 32; ++step) {
        if (at_a > at_b) {
            high = b, b = a, at_b = at_a;
            a = low + golden * (high - low), at_a = reach(a);
        } else {
            low = a, a = b, at_a = at_b;
            b = high - golden * (high - low), at_b = reach(b);
        }
    }
    return std::max({at_a, at_b, reach(0)});
}

/// Of M = K + W: nᵀMn; but the edge of a tool that leans to both sides may be as sharp as any in the normal section,
/// where what it sweeps along the feed is round. So at most 1/(nᵀ(K + κI)⁻¹n), κ the larger curvature of W: neither is
/// below 1/(nᵀM⁻¹n).
double normal_curvature_across(const Eigen::Matrix2d& matrix, const Eigen::Matrix2d& surface,
                               const Eigen::Vector2d& across) noexcept {
    const double bend = geometry::principal_curvatures(surface).larger;
    const Eigen::Matrix2d swept = matrix - surface + bend * Eigen::Matrix2d::Identity();
    return std::min(across.dot(matrix * across), 1 / geometry::conjugate_radius(swept, across));
}

}  // namespace

double flat_interval_mm(double radius, double scallop) noexcept {
    if (std::isinf(radius)) return infinite;
    return 2 * radius / (radius + scallop) * std::sqrt(2 * radius * scallop + scallop * scallop);
}

double flat_reach_mm(double radius, double diameter) noexcept {
    if (std::isinf(radius)) return diameter;
    return 2 * radius * std::sin(std::atan(diameter / (2 * radius)));
}

double round_interval_mm(double radius, double tool, double scallop) noexcept {
    if (std::isinf(radius)) return 2 * std::sqrt(std::max(0.0, scallop * (2 * tool - scallop)));
    // The ridge, R + h from the surface's centre, is `tool` away from the tool's centre at R + tool: 1 − cos of half
    // the angle between two contacts, as a product that is exact for the largest radii too.
    const double off = scallop * (2 * tool - scallop) / (2 * (radius + scallop) * (radius + tool));
    return 2 * std::abs(radius) * std::sqrt(std::max(0.0, off * (2 - off)));
}

Eigen::Matrix2d parting(const Cutter& cutter, const geometry::SurfaceShape& at, const Eigen::Vector3d& axis) noexcept {
    return cutter.curvature(at, axis) + at.shape;
}

double gap_nearby_mm(const Cutter& cutter, const geometry::SurfaceShape& at, const CutterPose& pose) noexcept {
    const double beside = cutter.distance_mm(pose, at.point);
    if (!cutter.is_ball() && Cutter::upright(at.normal, pose.axis)) return beside;
    // touching() tells where the tip stands from the contact, and so the contact from the tip.
    const Eigen::Vector3d off = pose.tip_mm - cutter.touching(at.point, at.normal, pose.axis).tip_mm;
    const Eigen::Vector2d d = at.components(off);
    if (!cutter.is_ball() && d.norm() > 0.5 * cutter.flat_radius_mm()) return beside;
    const Eigen::Matrix2d matrix = parting(cutter, at, pose.axis);
    if (!(matrix.determinant() > 0 && matrix.trace() > 0)) return beside;
    const Eigen::Vector2d bent = at.shape * d;
    return at.normal.dot(off) + 0.5 * (d.dot(bent) - bent.dot(matrix.inverse() * bent));
}

double path_interval_mm(const Cutter& cutter, const geometry::SurfaceShape& at, const Eigen::Vector3d& axis,
                        const Eigen::Vector2d& across, double scallop, bool by_normal_radius) noexcept {
    const double longest = longest_interval_mm(cutter, at, axis, across);
    const Eigen::Matrix2d matrix = parting(cutter, at, axis);
    const double relative = by_normal_radius ? normal_curvature_across(matrix, at.shape, across)
                                             : 1 / geometry::conjugate_radius(matrix, across);
    if (!cutter.is_ball() && Cutter::upright(at.normal, axis)) {
        const double radius = relative > 1e-12 ? 1 / relative : infinite;
        if (by_normal_radius && cutter.corner_mm() > 0)
            return std::min(2 * radius_of_height_mm(cutter, relative, scallop), longest);
        const double by_surface = std::sqrt(8 * scallop * radius);
        const double by_end = by_normal_radius ? by_surface : 2 * upright_reach_mm(cutter, at.shape, across, scallop);
        // Where neither rim nor rounded edge plays a part Eq. 2 is exact.
        const bool by_surface_alone = by_surface <= (1 + 1e-6) * by_end;
        return std::min(by_surface_alone ? flat_interval_mm(radius, scallop) : by_end, longest);
    }
    if (!cutter.is_ball()) return std::min(longest, std::sqrt(8 * scallop / std::max(relative, 1e-12)));
    const double surface = relative - 1 / cutter.radius_mm();
    const double radius = std::abs(surface) > 1e-12 ? 1 / surface : infinite;
    return std::min(longest, round_interval_mm(radius, cutter.radius_mm(), scallop));
}

double longest_interval_mm(const Cutter& cutter, const geometry::SurfaceShape& at, const Eigen::Vector3d& axis,
                           const Eigen::Vector2d& across) noexcept {
    const double diameter = 2 * cutter.radius_mm();
    if (cutter.corner_mm() > 0 || !Cutter::upright(at.normal, axis)) return diameter;
    const double curvature = 1 / geometry::conjugate_radius(at.shape, across);
    return flat_reach_mm(curvature > 1e-12 ? 1 / curvature : infinite, diameter);
}

}  // namespace trunnion::surfacing
