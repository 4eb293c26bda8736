#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "trunnion/machine/kinematics.hpp"

namespace trunnion::path {

/// The pole: a direction n of the tool, unit, in the workpiece, at which the rotary axis nearest to the workpiece may
/// stand anywhere. A path that passes it within the tolerance may be shifted sideways so that it goes through it: then
/// that axis hardly turns and the other one goes through the value it has there, where it would otherwise turn back.
///
/// The shift is a vector δ across the pole, added to n over a stretch of p around the place p₀ of the passage,
///     n(p) + δ·h(|p − p₀| / reach),   h = 1 up to `level_share`, then smoothly down to 0 at 1 (degree 7, C³).
/// Around p₀ it changes nothing but the place: the free axis turns as the path itself bends there.

/// A run is to go through a pole near the place `share` of the length of blocks[block].
struct PolePassage {
    std::size_t block = 0;
    double share = 0;  ///< in [0, 1], where the programmed tool axis comes nearest
    Eigen::Vector3d pole = Eigen::Vector3d::UnitZ();
};

/// The shift reaches at most so far to either side, mm of p.
inline constexpr double longest_shift_mm = 30;
/// Up to this share of the reach the shift is whole.
inline constexpr double level_share = 0.3;

/// h(t), t ≥ 0.
double shift_share(double t) noexcept;

/// All poles of a machine: none, one or two. Cost about 1 µs.
std::vector<Eigen::Vector3d> poles_of(const machine::Kinematics& kinematics);

/// The part of a direction across the pole.
inline Eigen::Vector3d beside_pole(const Eigen::Vector3d& direction, const Eigen::Vector3d& pole) {
    return direction - direction.dot(pole) * pole;
}

/// Where the great circle from one direction to another comes nearest to the pole.
struct NearestToPole {
    double share = 0;                                                   ///< of the turn, in [0, 1]
    Eigen::Vector3d beside = Eigen::Vector3d::Zero();                   ///< beside_pole there
    double height = 0;                                                  ///< along the pole there
    double distance() const { return height > 0 ? beside.norm() : 2; }  ///< sin of the angle; 2: the other hemisphere
};
NearestToPole nearest_to_pole(const Eigen::Vector3d& from, const Eigen::Vector3d& to, const Eigen::Vector3d& pole);

}  // namespace trunnion::path
