#pragma once

#include <Eigen/Core>

namespace trunnion::geometry {

/// The rotation by `angle_rad` about `axis` (any length ≠ 0), right-handed: x ↦ cos φ x + sin φ (u × x) + (1 − cos
/// φ)(u·x) u with u the unit axis (Rodrigues). Orthogonal to rounding. No allocation. Precondition: |axis| > 0 and
/// finite.
Eigen::Matrix3d rotation_about(const Eigen::Vector3d& axis, double angle_rad);

}  // namespace trunnion::geometry
