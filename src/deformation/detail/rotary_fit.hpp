#pragma once

#include <vector>

#include <Eigen/Core>

#include "trunnion/deformation/dual_path.hpp"
#include "trunnion/deformation/rotary_use.hpp"

#include "detail/orientation_limits.hpp"

namespace trunnion::deformation::detail {

/// Axis vectors of control points with which the rotary axes move less and more evenly, from the beginning at which the
/// machining has them (begin_rad is set). First and last are those of the path. Limits are kept nearly, not strictly.
Result<std::vector<Eigen::Vector3d>> calmer_axis_vectors(const DualPath& path, const Machining& machining,
                                                         const OrientationLimits& limits);

}  // namespace trunnion::deformation::detail
