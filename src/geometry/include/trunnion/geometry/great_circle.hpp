#pragma once

#include <array>

#include <Eigen/Core>

#include "trunnion/numeric/taylor3.hpp"

namespace trunnion::geometry {

/// Angle between two directions, in [0, π] rad. Accurate at 0 and π too (arc tangent of sine and cosine, not arc
/// cosine). Precondition: both vectors ≠ 0; their lengths do not matter. No allocation.
double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) noexcept;

/// The turn of a direction in one plane from one unit vector to another, in proportion to w: the great circle
///     n(w) = cos(wθ) a + sin(wθ) t,  θ = angle(a, b),  t ⟂ a the unit direction in which it starts.
/// Equal vectors, and vectors however near, are fine: n(0) = a and n(1) = b to 1e-15. Immutable, 56 bytes.
class GreatCircle {
  public:
    /// Preconditions: `from` and `to` are unit vectors and not opposite: there the plane is undefined, and within about
    /// 1e-8 rad of it, it is noise. Callers that read programs refuse such pairs before.
    GreatCircle(const Eigen::Vector3d& from, const Eigen::Vector3d& to) noexcept;

    double angle_rad() const noexcept { return angle_rad_; }  ///< in [0, π)

    /// Direction at w; w outside [0, 1] continues the circle. Unit to rounding. Cost about 30 ns.
    Eigen::Vector3d at(double w) const noexcept;
    /// The same with three derivatives of whatever w is a function of.
    std::array<Taylor3, 3> at(const Taylor3& w) const noexcept;

  private:
    Eigen::Vector3d from_, start_direction_;
    double angle_rad_;
};

/// GreatCircle(from, to).at(w); same preconditions.
Eigen::Vector3d slerp(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double w) noexcept;

}  // namespace trunnion::geometry
