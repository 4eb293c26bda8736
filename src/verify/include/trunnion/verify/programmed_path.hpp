#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "trunnion/base/result.hpp"
#include "trunnion/machine/machine.hpp"
#include "trunnion/program/program.hpp"

namespace trunnion::verify {

/// How the tool comes to a pose from the pose before. The tip goes straight in all of them.
enum class PoseKind : std::uint8_t {
    vector,  ///< the axis turns in one plane, in proportion to the tip's way
    rotary,  ///< the rotary axes go linearly from where they stood to where they stand: rotary_rad of both poses
    rapid    ///< as vector, at rapid rate
};

/// One programmed pose, in the frame of the setup's [workpiece], work offsets applied.
struct ProgrammedPose {
    Eigen::Vector3d tip_mm = Eigen::Vector3d::Zero();
    Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< unit, tip → spindle
    /// Where the machine's rotary axes stand, rad, control's count; NaN where the program does not say.
    std::array<double, machine::max_rotary_axes> rotary_rad{std::numeric_limits<double>::quiet_NaN(),
                                                            std::numeric_limits<double>::quiet_NaN()};
    PoseKind kind = PoseKind::vector;
    bool at_rapid = false;  ///< the machine may use its rapid limits on the way here (kind may still be `rotary`)
    bool literal = false;   ///< rotary_rad is what the program's own words say
    bool stands = false;    ///< the program asks for standstill here
    std::int32_t line = 0;  ///< in the program, from 1
    /// Gauge line → tip of the tool in use; NaN: that of Setup::tool. Where it differs from the pose before the tool
    /// was changed and the machine stands still between the two.
    double tool_length_mm = std::numeric_limits<double>::quiet_NaN();
    /// The controlled point of the tool in use is so far up the axis from the tip; NaN: as CheckOptions says.
    double controlled_height_mm = std::numeric_limits<double>::quiet_NaN();
};

/// How far chords may be from arcs, curves and from moves that are linear in the machine axes: the tip and the point
/// `chord_height_mm` above.
inline constexpr double chord_tolerance_mm = 1e-4;
inline constexpr double chord_height_mm = 30.0;
/// So far the tool axis of a stand may be from the programmed one.
inline constexpr double stand_axis_tolerance_rad = 2e-6;
/// So far the axes of a stand may be from literal words.
inline constexpr double stand_word_tolerance_rad = 1e-9;

/// More are not given at once.
inline constexpr std::size_t most_programmed_poses = 10'000'000;

/// The poses that a program asks for, in order: one a move, and as many chords as it takes for arcs, curves and for
/// moves in machine and untransformed space.
///
/// `stands`: where the rotary axes stand at the end of every move, or none. They are not taken on trust: they must be
/// the program's words under law rotary, and bring the programmed tool axis under law vector.
///
/// `standing`: the rotary axes stand so before the program, which is a part behind another one; NaN and none: at
/// Setup::start, else at 0.
///
/// Tool axes come from rotary words by the checker's own forward kinematics. Rotary axes that the program never names
/// stand as before the program; those without a word since a move of law vector where the stands say. rotary_rad
/// is there for every pose that the words determine, for re-branched rapids, and for the pose before each of them:
/// along these the rotary axes go linearly. It is NaN for all others.
/// Rapids in workpiece space are `rotary` where they have rotary words or are re-branched, else `rapid`. Coordinates
/// that are NaN stay what they are in the move's space and work offset. A change of tool gives one pose more: the same
/// place of the machine seen by the new tool.
/// A tool that the program names is looked up by Setup::tool_named; where Setup::tools is empty the first one named is
/// Setup::tool. G54 that Setup::offsets lacks is [workpiece] itself.
///
/// Errors: VER0101 no moves, VER0102 rotary words of an axis that the machine has not, VER0103 tool not in the setup,
/// VER0104 work offset not in the setup, VER0105 opposite tool axes in consecutive poses, VER0106 a move by rotary axes
/// or in machine coordinates from or to an unknown rotary position, VER0107 the linear axes do not span space, VER0108
/// a number that is not finite or an axis of length 0, VER0109 more than 10⁷ poses, VER0110 stands that are not those
/// of the program, VER0111 an arc without radius or direction, or that does not lead to the end of its move, VER0112 a
/// part of a curve that does not exist, is not one of a sound curve within one knot interval, does not lead from the
/// end of the move before to that of its own within 1 µm (and the same at `chord_height_mm`), or says a direction
/// without TCP. Cost: about 0.2 µs a straight move, 1 µs a chord.
Result<std::vector<ProgrammedPose>> programmed_poses(
    const program::Program& program, const machine::Machine& machine, const machine::Setup& setup,
    std::span<const program::RotaryStand> stands = {},
    const std::optional<std::array<double, machine::max_rotary_axes>>& standing = {});

}  // namespace trunnion::verify
