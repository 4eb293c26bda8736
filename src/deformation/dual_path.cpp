#include "trunnion/deformation/dual_path.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "detail/spline_equations.hpp"

namespace trunnion::deformation {

using Eigen::Vector3d;

namespace {

constexpr int parts_of_interval = 8;

/// Least and largest Bernstein coefficient of |D|² for the Bézier points of a cubic D.
std::array<double, 2> squared_length_hull(const std::array<Vector3d, 4>& d) {
    constexpr std::array<double, 4> choose3{1, 3, 3, 1};
    constexpr std::array<double, 7> choose6{1, 6, 15, 20, 15, 6, 1};
    std::array<double, 7> coefficient{};
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = 0; j < 4; ++j)
            coefficient[i + j] += choose3[i] * choose3[j] / choose6[i + j] * d[i].dot(d[j]);
    const auto [least, largest] = std::ranges::minmax(coefficient);
    return {least, largest};
}

std::array<Vector3d, 4> difference(const geometry::DualSpline& spline, double from, double to) {
    const auto top = spline.top().piece(from, to), bottom = spline.bottom().piece(from, to);
    std::array<Vector3d, 4> out;
    for (std::size_t k = 0; k < 4; ++k) out[k] = (top.control[k] - bottom.control[k]).head<3>();
    return out;
}

}  // namespace

Pose DualPath::at(double u) const noexcept {
    const Vector3d tip = spline.bottom().evaluate(u)[0];
    return {tip, (spline.top().evaluate(u)[0] - tip).normalized()};
}

Vector3d DualPath::point_mm(double u, double height_mm) const noexcept {
    const Pose pose = at(u);
    return pose.tip_in_workpiece_mm + height_mm * pose.axis_in_workpiece;
}

double distance_error_mm(const DualPath& path, double from, double to) {
    double worst = 0;
    for (int part = 0; part < parts_of_interval; ++part) {
        const double step = (to - from) / parts_of_interval, begin = from + part * step;
        const bool last = part + 1 == parts_of_interval;
        const auto [least, largest] = squared_length_hull(difference(path.spline, begin, last ? to : begin + step));
        worst = std::max({worst, std::abs(std::sqrt(largest) - path.distance_mm),
                          std::abs(std::sqrt(std::max(least, 0.0)) - path.distance_mm)});
    }
    return worst;
}

double distance_error_mm(const DualPath& path) {
    const std::vector<double> at = stations_of(path.spline.bottom().knots());
    double worst = 0;
    for (std::size_t k = 0; k + 1 < at.size(); ++k) worst = std::max(worst, distance_error_mm(path, at[k], at[k + 1]));
    return worst;
}

}  // namespace trunnion::deformation
