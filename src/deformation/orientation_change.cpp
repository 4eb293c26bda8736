#include "trunnion/deformation/orientation_change.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "detail/spline_equations.hpp"

namespace trunnion::deformation {

using Eigen::Vector3d;
using Hull = std::array<Vector3d, 4>;

namespace {

constexpr int parts_of_interval = 4;
constexpr int looks_a_part = 4;

/// Bézier points of D = g − f over a part of a knot interval.
Hull axis_vectors(const DualPath& path, double from, double to) {
    const auto top = path.spline.top().piece(from, to), bottom = path.spline.bottom().piece(from, to);
    Hull out;
    for (std::size_t k = 0; k < 4; ++k) out[k] = (top.control[k] - bottom.control[k]).head<3>();
    return out;
}

double deviation_bound(const Hull& before, const Hull& after) {
    const Vector3d middle = (before[0] + 3 * before[1] + 3 * before[2] + before[3]).normalized();
    double change = 0, length = before[0].dot(middle);
    for (std::size_t k = 0; k < 4; ++k) {
        change = std::max(change, (after[k] - before[k]).norm());
        length = std::min(length, before[k].dot(middle));
    }
    return length > change ? std::asin(change / length) : HUGE_VAL;
}

}  // namespace

OrientationChange orientation_change(const DualPath& before, const DualPath& after, const machine::Tool& tool) {
    std::vector<double> at = stations_of(before.spline.bottom().knots());
    const std::vector<double> other = stations_of(after.spline.bottom().knots());
    at.insert(at.end(), other.begin(), other.end());
    std::ranges::sort(at);
    at.erase(std::unique(at.begin(), at.end()), at.end());
    const double height = tool.controlled_height_mm();
    OrientationChange out;
    for (std::size_t k = 0; k + 1 < at.size(); ++k)
        for (int part = 0; part < parts_of_interval; ++part) {
            const double step = (at[k + 1] - at[k]) / parts_of_interval, from = at[k] + part * step;
            const double to = part + 1 == parts_of_interval ? at[k + 1] : from + step;
            const double bound = deviation_bound(axis_vectors(before, from, to), axis_vectors(after, from, to));
            out.orientation_deviation_rad = std::max(out.orientation_deviation_rad, bound);
            for (int i = 0; i <= looks_a_part; ++i) {
                const double u = from + (to - from) * i / looks_a_part;
                const double moved = (after.point_mm(u, height) - before.point_mm(u, height)).norm();
                out.controlled_point_mm = std::max(out.controlled_point_mm, moved);
            }
        }
    out.surface_mm = out.controlled_point_mm + turned_surface_mm(tool, out.orientation_deviation_rad);
    return out;
}

double turned_surface_mm(const machine::Tool& tool, double angle_rad) {
    const double radius = tool.diameter_mm / 2;
    const double corner = tool.kind == machine::ToolKind::ball   ? radius
                          : tool.kind == machine::ToolKind::flat ? 0
                                                                 : tool.corner_radius_mm;
    return 2 * std::sin(angle_rad / 2) * std::hypot(radius - corner, corner - tool.controlled_height_mm());
}

}  // namespace trunnion::deformation
