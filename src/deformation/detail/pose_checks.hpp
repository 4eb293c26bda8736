#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "trunnion/base/diagnostic.hpp"
#include "trunnion/deformation/dual_path.hpp"

namespace trunnion::deformation {

inline constexpr double unit_within = 1e-6;  // of an axis or normal
inline constexpr double rounding_mm = 1e-9;  // two poses that differ by less are one; a bound so far beyond is kept

/// √(|Δtip|² + (ρ Δω)²): a step of the path parameter p.
double pose_step_mm(const Pose& from, const Pose& to);

/// What makes poses unfit for a spline: DEFO0101 … DEFO0104.
std::optional<Diagnostic> check_poses(std::span<const Pose> poses, std::size_t fewest);

}  // namespace trunnion::deformation
