#pragma once

#include <vector>

#include <Eigen/Core>

#include "trunnion/machine/kinematics.hpp"
#include "trunnion/machine/machine.hpp"

namespace trunnion::deformation {

/// How the tool axis n answers to the two rotary axes: ∂n/∂θ₁ = a₁ × n and ∂n/∂θ₂ = a₂ × n, with a₁ the direction of
/// the axis nearest to the workpiece and a₂ that of the other one where θ₁ has turned it to. In the workpiece,
/// control's count.
struct RotaryJacobian {
    Eigen::Vector3d nearest, other;  ///< 1 per rad, across n
    /// |∂n/∂θ₁ × ∂n/∂θ₂|, in [0, 1]: 0 where the rank is lost.
    double determinant() const { return nearest.cross(other).norm(); }
    /// Velocity of each axis while the tool axis turns at 1 rad/s in the direction that asks most of it: 1/(sin e₁ |sin
    /// ψ|) and sin β/(sin e₁ sin e₂ |sin ψ|), ψ the turn of the second axis from where it folds the tool onto the
    /// first. Infinite where the rank is lost.
    double nearest_gain() const { return other.norm() / determinant(); }
    double other_gain() const { return nearest.norm() / determinant(); }
};

/// Precondition: a machine with two rotary axes. No allocation. Cost about 0.5 µs.
RotaryJacobian rotary_jacobian(const machine::Kinematics& kinematics, const machine::RotaryPosition& rotary_rad);

/// Where the rotary axes lose a degree of freedom, and how far around the tool cannot be turned at a given rate.
///
/// All orientations that a machine reaches lie in a band about a₁, |e₁ − e₂| ≤ β ≤ e₁ + e₂ (machine/kinematics.hpp).
/// The rank is lost on both its borders. A border that is a point, β = 0 or π, is a *pole*: the axis nearest to the
/// workpiece may stand anywhere, and beside it turns without bound: the singular cone. A border that is a circle is a
/// *rim*: both branches meet, and both axes turn without bound across it.
struct SingularCone {
    bool pole = true;                                      ///< false: a rim
    Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  ///< unit, workpiece: the pole; a rim: a₁
    double angle_rad = 0;  ///< β from `direction` at which the rank is lost: 0 at a pole, that of the rim else
    /// Tool axes whose β is within so much of angle_rad can ask a rotary axis for more than its velocity limit. Where
    /// that is so everywhere (the rate exceeds the limit at the best place too): the whole way to the other border.
    double half_angle_rad = 0;
    int axis = 0;  ///< index in Machine::axes: which one reaches its limit first
};

/// All singular cones of a machine for a tool axis that turns at a rate in rad/s, that of feed × |dn/ds|; > 0. None for
/// fewer than two rotary axes, else two: both poles at right angles, the pole and the rim of a 45° axis, two rims.
/// Ranges are not looked at: a rim behind the end of an axis' range is told too. Allocates; cost about 5 µs.
/// Source: ψ by the spherical triangle of a₁, a₂ and n: cos β = cos e₁ cos e₂ + sin e₁ sin e₂ cos ψ.
std::vector<SingularCone> singular_cones(const machine::Machine& machine, const machine::Kinematics& kinematics,
                                         double turn_rate_rad_s);

}  // namespace trunnion::deformation
