#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "trunnion/machine/machine.hpp"

namespace trunnion::controller {

/// What the tool does to the surface: the velocity of the tool against the part at the point A where it touches,
///     V_A = V_B + AB ∧ Ω,   B the tip, Ω the turning of the tool against the part (the spindle's own turning left
///     out).
/// Lavernhe 2006, Eq. 12-14, without the approximation V_A ≈ V_B: on a blend of radius 5 mm with a torus of 10 mm it is
/// wrong by a third.
/// Assumed: the surface lies across the plane of tool axis and feed (no sideways tilt), and its normal there is the
/// tool axis turned by the lead angle against the feed.

/// From the tip to the contact point, mm, in the frame of the arguments. `feed`: direction of the tip's motion, not 0;
/// where it is parallel to the tool axis, or the lead angle is 0 and the tool has a flat end, the tip itself is taken.
/// `lead_rad`: tool axis leaning towards the feed, in ]−π/2, π/2[. A taper counts as its end: torus or flat.
Eigen::Vector3d contact_from_tip_mm(const machine::Tool& tool, const Eigen::Vector3d& tool_axis,
                                    const Eigen::Vector3d& feed, double lead_rad);

/// Ω in the workpiece frame, rad/s, from positions and velocities of the machine axes.
Eigen::Vector3d tool_turning_rad_s(const machine::Machine& machine, const machine::Frame& workpiece,
                                   const machine::AxisPosition& position, const machine::AxisVelocity& velocity);

/// V_A of V_B, Ω and the way from tip to contact.
inline Eigen::Vector3d contact_velocity(const Eigen::Vector3d& tip_velocity, const Eigen::Vector3d& turning_rad_s,
                                        const Eigen::Vector3d& contact_from_tip_mm) {
    return tip_velocity + turning_rad_s.cross(contact_from_tip_mm);
}

}  // namespace trunnion::controller
