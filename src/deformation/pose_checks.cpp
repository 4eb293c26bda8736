#include "detail/pose_checks.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/geometry/great_circle.hpp"
#include "trunnion/path/run.hpp"

#include "detail/spline_equations.hpp"

namespace trunnion::deformation {

using Eigen::Vector3d;

namespace {

constexpr double opposite_from_rad = 170 * degree;

Diagnostic at_pose(const char* code, std::size_t index, const char* text) {
    return {.code = code, .text = fmt::format("pose {}: {}", index + 1, text)};
}

}  // namespace

double pose_step_mm(const Pose& from, const Pose& to) {
    return std::hypot(
        (to.tip_in_workpiece_mm - from.tip_in_workpiece_mm).norm(),
        path::reference_height_mm * geometry::angle_between(from.axis_in_workpiece, to.axis_in_workpiece));
}

std::optional<Diagnostic> check_poses(std::span<const Pose> poses, std::size_t fewest) {
    if (poses.size() < fewest)
        return Diagnostic{.code = "DEFO0101",
                          .text = "too few poses for a path of this kind",
                          .value = fmt::format("{}", poses.size()),
                          .limit = fmt::format("{}", fewest)};
    for (std::size_t i = 0; i < poses.size(); ++i) {
        const Pose& pose = poses[i];
        if (!pose.tip_in_workpiece_mm.allFinite() || !pose.axis_in_workpiece.allFinite())
            return at_pose("DEFO0104", i, "not finite");
        if (std::abs(pose.axis_in_workpiece.norm() - 1) > unit_within)
            return at_pose("DEFO0104", i, "the tool axis is not a unit vector");
        if (i == 0) continue;
        if (pose_step_mm(poses[i - 1], pose) < rounding_mm) return at_pose("DEFO0102", i, "the same as the one before");
        if (geometry::angle_between(poses[i - 1].axis_in_workpiece, pose.axis_in_workpiece) > opposite_from_rad)
            return at_pose("DEFO0103", i, "the tool axis is opposite to that of the one before");
    }
    return {};
}

}  // namespace trunnion::deformation
