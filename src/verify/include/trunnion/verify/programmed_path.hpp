#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "trunnion/base/result.hpp"
#include "trunnion/machine/machine.hpp"
#include "trunnion/program/program.hpp"

namespace trunnion::verify {

/// How the tool comes to a pose from the pose before. The tip goes straight in all of them.
enum class PoseKind : std::uint8_t {
    vector,  ///< the axis turns in one plane, in proportion to the tip's way
    rotary,  ///< the rotary words are linear in the tip's way
    rapid    ///< as vector, at rapid rate
};

/// One programmed pose, in the frame of the setup's [workpiece], work offsets applied.
struct ProgrammedPose {
    Eigen::Vector3d tip_mm = Eigen::Vector3d::Zero();
    Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< unit, tip → spindle
    /// Literal words in the order of the machine's rotary axes, rad, control's count; NaN where the program has none.
    std::array<double, machine::max_rotary_axes> rotary_rad{std::numeric_limits<double>::quiet_NaN(),
                                                            std::numeric_limits<double>::quiet_NaN()};
    PoseKind kind = PoseKind::vector;
    bool at_rapid = false;  ///< the machine may use its rapid limits on the way here (kind may still be `rotary`)
    std::int32_t line = 0;  ///< in the program, from 1
    /// Gauge line → tip of the tool in use; NaN: that of Setup::tool. Where it differs from the pose before the tool
    /// was changed and the machine stands still between the two.
    double tool_length_mm = std::numeric_limits<double>::quiet_NaN();
};

/// How far chords may be from a move that is linear in the machine axes: the tip and the point `chord_height_mm` above.
inline constexpr double chord_tolerance_mm = 1e-4;
inline constexpr double chord_height_mm = 30.0;

/// The poses that a program asks for, in order: one a move, and as many chords as it takes for moves in machine space.
///
/// Rotary words become tool axes by the checker's own forward kinematics; axes that the program never names stand at
/// Setup::start, else at 0. Rapids in workpiece space are `rotary` where they have rotary words, else `rapid`. A change
/// of tool gives one pose more: the same place of the machine seen by the new tool.
/// A tool that the program names is looked up in Setup::tools; where that table is empty the first one named is
/// Setup::tool. G54 that Setup::offsets lacks is [workpiece] itself.
///
/// Errors: VER0101 no moves, VER0102 rotary words of an axis that the machine has not, VER0103 tool not in the setup,
/// VER0104 work offset not in the setup, VER0105 opposite tool axes in consecutive poses, VER0106 a move in machine
/// coordinates from or to an unknown rotary position, VER0107 the linear axes do not span space, VER0108 a number that
/// is not finite or an axis of length 0, VER0109 more than 10⁷ poses.
/// Cost: about 0.2 µs a pose.
Result<std::vector<ProgrammedPose>> programmed_poses(const program::Program& program, const machine::Machine& machine,
                                                     const machine::Setup& setup);

}  // namespace trunnion::verify
