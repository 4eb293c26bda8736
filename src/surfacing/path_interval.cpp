#include "trunnion/surfacing/path_interval.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace trunnion::surfacing {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

/// Half the interval at which flat part and rounded edge of an upright tool are `scallop` above a surface that falls
/// away as a circle of radius R.
double torus_half_interval_mm(const Cutter& cutter, double radius_mm, double scallop_mm) noexcept {
    const auto gap = [&](double w) {
        const double beyond = std::max(0.0, w - cutter.flat_radius_mm());
        const double corner =
            cutter.corner_mm() - std::sqrt(std::max(0.0, std::pow(cutter.corner_mm(), 2) - beyond * beyond));
        return corner + w * w / (2 * radius_mm);
    };
    double low = 0, high = cutter.radius_mm();
    for (int halving = 0; halving < 60; ++halving) {
        const double middle = 0.5 * (low + high);
        (gap(middle) < scallop_mm ? low : high) = middle;
    }
    return low;
}

/// 1/(nᵀM⁻¹n), or nᵀMn.
double curvature_across(const Eigen::Matrix2d& matrix, const Eigen::Vector2d& across, bool by_normal_radius) noexcept {
    if (by_normal_radius) return across.dot(matrix * across);
    return 1 / geometry::conjugate_radius(matrix, across);
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

double path_interval_mm(const Cutter& cutter, const geometry::SurfaceShape& at, const Eigen::Vector3d& axis,
                        const Eigen::Vector2d& across, double scallop, bool by_normal_radius) noexcept {
    const double longest = longest_interval_mm(cutter, at, axis, across);
    const Eigen::Matrix2d matrix = parting(cutter, at, axis);
    const double relative = curvature_across(matrix, across, by_normal_radius);
    if (!cutter.is_ball() && Cutter::upright(at.normal, axis)) {
        const double radius = relative > 1e-12 ? 1 / relative : infinite;
        if (cutter.corner_mm() > 0) return 2 * torus_half_interval_mm(cutter, radius, scallop);
        return std::min(flat_interval_mm(radius, scallop), longest);
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
