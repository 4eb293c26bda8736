#pragma once

#include <array>
#include <optional>

#include "trunnion/base/result.hpp"
#include "trunnion/deformation/dual_path.hpp"
#include "trunnion/machine/kinematics.hpp"
#include "trunnion/machine/machine.hpp"

namespace trunnion::deformation {

/// What a path is reshaped for: a machine, how the tool and the part sit in it, the tool and the feed. Keeps
/// references.
struct Machining {
    const machine::Machine& machine;
    const machine::Kinematics& kinematics;  ///< of this machine, with tool length and workpiece frame
    const machine::Tool& tool;              ///< its shape, and which of its points must not move
    double feed_mm_s = 0;                   ///< programmed speed
    /// Where the rotary axes stand before the path, rad, order of RotaryPosition: branch and winding at its beginning
    /// are the nearest ones. None: those of least rotary travel, of both branches and the windings beside 0.
    std::optional<machine::RotaryPosition> begin_rad;
};

/// What a path asks of the machine axes when the tool's controlled point c goes at the feed. Where it moves less than
/// ρ = 30 mm times the turn of the tool, that turn counts in its place: du ↦ dt = max(|dc|, ρ|dn|)/feed. (Not the tip:
/// how far that goes changes when the tool is turned about its centre, and times could not be compared.)
struct RotaryUse {
    double travel_rad = 0;               ///< way of all rotary axes, ∫ Σ|dθ|
    std::array<double, 2> velocity{};    ///< rad/s: peak of each rotary axis, order of RotaryPosition
    double velocity_ratio = 0;           ///< largest velocity over its axis' limit; above 1: the feed must drop there
    double time_at_feed_s = 0;           ///< ∫ dt
    double velocity_limited_time_s = 0;  ///< ∫ max(dt, |dq_k|/V_k) over all axes: with c at the feed none is faster
    machine::RotaryPosition begin_rad{}, end_rad{};
};

/// Follows the path through the machine (path::AxisPath, ranges included) and adds up. Peaks are looked for at eight
/// places in every part of the path on which no rotary axis turns by more than 20°, and refined. Allocates; cost some 5
/// µs a knot interval, more beside a pole; that for each of up to six beginnings where none is given.
/// Errors: DEFO0201, and PATH0101 orientation out of reach, PATH0102 an axis leaves its range, PATH0103 the path passes
/// a pole too closely to be followed.
Result<RotaryUse> rotary_use(const DualPath& path, const Machining& machining);

}  // namespace trunnion::deformation
