#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "trunnion/deformation/flank_milling.hpp"

#include "detail/flank_walk.hpp"

namespace trunnion::deformation {

using Eigen::Vector3d;

namespace {

constexpr int most_steps = 60;
constexpr double settled_mm = 1e-10;

/// The point of the axis beside a contact: off by the radius, across the axis, on the side of the surface's normal.
Vector3d axis_point(const geometry::SurfaceShape& contact, double radius_mm, const Vector3d& axis) {
    const Vector3d& n = contact.normal;
    return contact.point + radius_mm * (n - axis * axis.dot(n)).normalized();
}

/// The line that touches at both contacts, by iteration: heights and axis depend on each other.
std::optional<Pose> touching(const geometry::SurfaceShape& lower, const geometry::SurfaceShape& upper,
                             const FlankTool& tool, double lower_height_mm) {
    Vector3d axis = (upper.point - lower.point).normalized();
    double apart = (upper.point - lower.point).norm();
    for (int step = 0; step < most_steps; ++step) {
        const Vector3d below = axis_point(lower, tool.at(lower_height_mm).radius_mm, axis);
        const Vector3d above = axis_point(upper, tool.at(lower_height_mm + apart).radius_mm, axis);
        const Vector3d between = above - below;
        const double change = std::abs(between.norm() - apart) + apart * (between.normalized() - axis).norm();
        apart = between.norm();
        axis = between / apart;
        if (!std::isfinite(change)) return {};
        if (change < settled_mm) return Pose{below - lower_height_mm * axis, axis};
    }
    return {};
}

/// Refuses an outline of this radius where the surface is hollow along `direction`.
std::optional<Diagnostic> too_round(const geometry::SurfaceShape& shape, const Vector3d& direction, double radius_mm,
                                    double outline_share, const FlankSample& sample, const char* what) {
    Eigen::Vector2d along = shape.components(direction);
    if (!(along.norm() > 0)) return {};
    along.normalize();
    const double hollow = -shape.normal_curvature(along);
    if (!(hollow * radius_mm >= 1)) return {};
    return Diagnostic{.code = "DEFO0110",
                      .text = fmt::format("the surface is hollow at u = {:.6g}, {:.4g} mm up: {} does not fit into it",
                                          sample.u, sample.height_mm, what),
                      .value = fmt::format("{:.6g} mm", radius_mm * outline_share),
                      .limit = fmt::format("{:.6g} mm", outline_share / hollow),
                      .hint = "a tool below the limit"};
}

}  // namespace

Result<std::vector<Pose>> two_point_poses(const DesignedSurface& surface, const FlankTool& tool, int count,
                                          double lower_height_mm) {
    if (count < 2) return fail({.code = "DEFO0105", .text = "fewer than 2 poses are asked for"});
    std::vector<Pose> out;
    for (int i = 0; i < count; ++i) {
        const double share = static_cast<double>(i) / (count - 1);
        const auto lower = surface.shape(surface.place_at(share, 0)), upper = surface.shape(surface.place_at(share, 1));
        if (!lower || !upper)
            return fail({.code = "DEFO0112",
                         .text = fmt::format("the surface has no normal at its edge, {:.3g} along", share)});
        const double apart = (upper->point - lower->point).norm();
        if (auto sound = check(tool, lower_height_mm, lower_height_mm + apart); !sound) return fail(sound.error());
        const auto pose = touching(*lower, *upper, tool, lower_height_mm);
        if (!pose)
            return fail({.code = "DEFO0114",
                         .text = fmt::format("no pose touches both edges of the surface, {:.3g} along", share),
                         .hint = "a thinner tool"});
        out.push_back(*pose);
    }
    return out;
}

Result<void> check_hollows(const DualPath& path, const FlankTool& tool, const DesignedSurface& surface,
                           const FlankRange& range) {
    const auto samples = walk_flank(path, tool, surface, range);
    if (!samples) return fail(samples.error());
    for (const FlankSample& sample : *samples) {
        const auto shape = surface.shape(sample.facing.place);
        if (!shape) continue;
        const Vector3d axis = path.at(sample.u).axis_in_workpiece;
        const auto outline = tool.at(sample.height_mm);
        const double widening = std::sqrt(1 + outline.slope * outline.slope);  // normal radius over radius
        if (auto refused = too_round(*shape, shape->normal.cross(axis), outline.radius_mm * widening, 1 / widening,
                                     sample, "the tool"))
            return fail(std::move(*refused));
        if (tool.kind != FlankKind::barrel) continue;
        if (auto refused = too_round(*shape, axis, tool.outline_radius_mm, 1, sample, "the outline of the barrel"))
            return fail(std::move(*refused));
    }
    return {};
}

}  // namespace trunnion::deformation
