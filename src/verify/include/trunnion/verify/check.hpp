#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "trunnion/base/result.hpp"
#include "trunnion/machine/machine.hpp"
#include "trunnion/verify/programmed_path.hpp"
#include "trunnion/verify/setpoint_table.hpp"

namespace trunnion::verify {

struct CheckOptions {
    double tip_tolerance_mm = 0.02;                                 ///< of the controlled point; > 0
    double orientation_tolerance_rad = 0.1 * 0.017453292519943295;  ///< where flank_tolerance_mm is 0; > 0
    double flank_tolerance_mm = 0;    ///< of the point at flank_height_mm, in place of the angle; 0 = off
    double flank_height_mm = 30;      ///< up the tool axis from the tip; one radian counts as so much; > 0
    double controlled_height_mm = 0;  ///< of poses that do not say: the controlled point is so far up the axis
    double limit_excess = 1.001;      ///< peak / limit above this is a breach
};

/// The first place where one thing is broken.
struct Breach {
    std::string what;  ///< the Verdict's field; of axes `axes.<letter>.<field>`
    double time_s = 0;
    std::int32_t line = 0;  ///< of the program
    double value = 0;       ///< there, in the unit of the field (the worst is in the field itself)
    double limit = 0;
};

/// Peak / limit by first, second and third differences over the period, standstill before the first row and after the
/// last one included.
struct AxisVerdict {
    char letter = 'X';
    bool rotary = false;
    double velocity_ratio = 0, acceleration_ratio = 0, jerk_ratio = 0;
    double range_excess = 0;  ///< mm or rad
};

/// What a motion is worth against program and machine. `…_deviation_…`: maxima over the setpoints of the distance from
/// the programmed path at the corresponding place. `…_to_poses_…`: maxima over the programmed poses of the distance
/// from the motion (chords between rows).
struct Verdict {
    std::size_t rows = 0;
    double period_s = 0, cycle_time_s = 0;
    std::vector<AxisVerdict> axes;
    double tip_deviation_mm = 0, orientation_deviation_deg = 0, height_deviation_mm = 0;
    double tip_to_poses_mm = 0, orientation_to_poses_deg = 0, height_to_poses_mm = 0;
    /// Of the rotary axes from literal rotary words, up to the first that is missed: where the program asks for
    /// standstill, and at all other poses.
    double words_at_stops_deg = 0, words_on_the_way_deg = 0;
    double path_covered = 0;  ///< share of the programmed path (tip and turning) that the motion came through
    double start_error_mm = 0, end_error_mm = 0;  ///< tip of the first and last row from the first and last pose
    bool ok = false;                              ///< nothing is broken
    std::vector<Breach> broken;                   ///< at most one for each thing, by time

    /// The breach of one thing, or null.
    const Breach* first_of(std::string_view what) const;
};

/// Checks setpoints against the programmed poses and the machine's limits.
///
/// Corresponding places: with x = (controlled point, flank height · tool axis), six numbers in mm, every row gets the
/// place on the programmed path that makes the sum of |x_row − x_path|² over all rows least while places never go back
/// (but for a slack of 0.02 mm and half the tolerance, angles counting at the flank height; on paths of over 100 m a
/// two-millionth of their length where that is more). So passes that nearly touch, reversals and crossings are
/// told apart by order. Distances are then exact: closed form on straight moves, Gauss-Newton on turning ones.
/// The nearest place weighs tip against turn by the flank height, not by the tolerances: where a row breaks one of them
/// there, a place within the slack that keeps both is taken instead, if there is one. The same for poses: the nearest
/// point of the motion within the window around the pose's place, or where that breaks a tolerance one that keeps both.
/// Rapid limits count for differences that touch a row on a rapid, feed limits for all others.
/// A thing is broken when: a ratio exceeds limit_excess, an axis leaves its range by more than 1e-9, a deviation of a
/// row or of a pose exceeds its tolerance by more than 1e-6 mm or 1e-6°, the start or end of the tip is farther than
/// the tip tolerance from the programmed one, the way that is not covered exceeds the tolerances, or literal rotary
/// words are missed: at standstills by more than 1e-6° and what the axis may move by its jerk in half a period,
/// elsewhere by more than 50 times the orientation tolerance (a rotary axis turns the tool by a fiftieth of its own
/// turn at least). At the first and last pose the first and last row count, at all others the rows at places around the
/// pose's.
///
/// Precondition: what setpoint_table() and programmed_poses() promise.
/// Errors: VER0301 no setpoints, VER0302 no poses, VER0108 a number that is not finite, VER0303 a tolerance, height or
/// axis limit that is not above 0, VER0304 the programmed path turns through more than a million steps, VER0105
/// opposite tool axes. Cost: linear, 1-2 µs a row and 3 µs a pose where blocks are longer than the tolerance, more
/// where hundreds of blocks lie within half a millimetre. Memory: 140 bytes a pose and 2.5 kB a millimetre of path, at
/// most 280 MB, and about 100 bytes a row.
Result<Verdict> check(const SetpointTable& setpoints, const std::vector<ProgrammedPose>& poses,
                      const machine::Machine& machine, const machine::Setup& setup, const CheckOptions& options);

}  // namespace trunnion::verify
