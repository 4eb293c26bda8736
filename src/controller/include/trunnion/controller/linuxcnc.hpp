#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "trunnion/base/result.hpp"
#include "trunnion/machine/machine.hpp"
#include "trunnion/motion/controller.hpp"
#include "trunnion/motion/prediction.hpp"
#include "trunnion/program/program.hpp"

namespace trunnion::controller {

/// Words at which LinuxCNC drains its queue and waits.
enum class LinuxcncWait : std::uint8_t {
    spindle,          ///< M3 M4 M5, S
    other,            ///< changes of work offset, tool length or TCP, M0, M1
    dwell,            ///< G4, beyond its own time
    coolant,          ///< M7 M8 M9; the control's varies between 0.008 and 0.325 s
    tool_change,      ///< M6 after its T
    tool_preparation  ///< more than that for a T in the block of its M6
};
inline constexpr std::size_t linuxcnc_wait_count = 6;

/// How long it stands still then, s, beyond the stop itself. Measured on LinuxCNC 2.9 with simulated input and output;
/// on a real machine spindle, coolant and tool changer answer in their own time.
struct LinuxcncWaits {
    std::array<double, linuxcnc_wait_count> seconds{0.004, 0.004, 0.005, 0.1, 0.222, 0.2};
    double& operator[](LinuxcncWait wait) { return seconds[static_cast<std::size_t>(wait)]; }
    double operator[](LinuxcncWait wait) const { return seconds[static_cast<std::size_t>(wait)]; }
};

/// What LinuxCNC's INI file says. The defaults are those of LinuxCNC 2.9 where it has any. Limits of the axes are those
/// of the machine unless given here. Every limit is above 0.
struct LinuxcncSettings {
    double servo_period_s = 0.001;  ///< [EMCMOT]SERVO_PERIOD
    /// [AXIS_*]MAX_VELOCITY, MAX_ACCELERATION, mm and rad, by letter; LinuxCNC does not look at the limits of joints.
    struct AxisLimits {
        std::optional<double> velocity, acceleration;  ///< empty: the machine's
    };
    std::map<char, AxisLimits> axis_limits;
    /// [TRAJ]MAX_LINEAR_VELOCITY: of the tip in the workpiece, in all segments with linear motion.
    double max_linear_velocity_mm_s = std::numeric_limits<double>::infinity();
    double max_feed_override = 1.0;      ///< [DISPLAY]MAX_FEED_OVERRIDE
    int optimization_depth = 50;         ///< [TRAJ]ARC_BLEND_OPTIMIZATION_DEPTH; below 2: no tangent joints
    double gap_cycles = 4;               ///< [TRAJ]ARC_BLEND_GAP_CYCLES
    double ramp_frequency_hz = 100;      ///< [TRAJ]ARC_BLEND_RAMP_FREQ
    double kink_ratio = 0.1;             ///< [TRAJ]ARC_BLEND_KINK_RATIO
    bool arc_blends = true;              ///< [TRAJ]ARC_BLEND_ENABLE
    double feed_override = 1.0;          ///< of feeds, above 0, at most max_feed_override
    double rapid_override = 1.0;         ///< of rapids, above 0, at most 1
    std::size_t queue_full = 1780;       ///< segments in the planner at which commands wait
    double missed_periods = 0;           ///< share of the periods, evenly spread, in which no command arrives; below 1
    double unset_direction_cosine = 0;   ///< stands for a direction that the control reads where nobody has set it
    double start_tolerance_mm = 0.0254;  ///< G64's tolerance before the program says a word of path control
    double longest_run_s = 1e5;          ///< a program that takes longer is refused
    LinuxcncWaits waits;
};

/// Of a controller file of kind linuxcnc; a parameter that is not given keeps its default.
/// Errors: CTRL0113 arc_blend_fallback_enable is on, which is not modelled.
Result<LinuxcncSettings> linuxcnc_settings(const motion::Controller& controller);

/// One servo period.
struct LinuxcncRow {
    double time_s = 0;                                 ///< 0: the row before the first motion of the planner
    Eigen::Vector3d tip_mm = Eigen::Vector3d::Zero();  ///< what the planner moves: with TCP on the tip in the
                                                       ///< workpiece, with TCP off the untransformed coordinates
    std::array<double, 3> rotary_rad{};                ///< A, B, C of the planner
    machine::AxisPosition axes;                        ///< commands of the joints, two periods later and smoothed
    double speed_mm_s = 0;                             ///< along the path; rad/s where only rotary axes move
    std::int32_t line = 0;                             ///< of the segment that moves
    bool moves = false;                                ///< the planner; the joints follow two periods later
    /// What holds the speed of the planner down; where it speeds up or brakes, the acceleration of an axis, and
    /// `slower_end` says what holds the slower end down.
    motion::Limit limit, slower_end;
};

/// When a block was carried out. Blocks that the control merged into one appear as the last of them; of those that an
/// arc blend swallowed begin and end are those of the blend.
struct LinuxcncBlock {
    std::int32_t line = 0;
    double begin_s = 0, end_s = 0;
};

struct LinuxcncRun {
    double cycle_time_s = 0;        ///< from the first to the last row in which a joint moves, waits between included
    double length_over_feed_s = 0;  ///< Σ length/F with rapids at the axes' limits and dwells: what one would reckon
    /// Of the cycle time standstill at words; what stands before the first and after the last motion does not count.
    double dwell_s = 0, tool_change_s = 0, other_stop_s = 0;
    double wait_s() const { return dwell_s + tool_change_s + other_stop_s; }
    std::array<std::size_t, linuxcnc_wait_count> waits{};  ///< how often it waited for each word between motions
    std::size_t standstills = 0;                           ///< of the planner
    std::size_t unset_directions = 0;  ///< segments begun by a direction that the control reads unset
    std::size_t rows = 0;
    std::size_t segments = 0;                     ///< that the planner got, after merging
    std::size_t arc_blends = 0;                   ///< that it added
    machine::AxisVelocity peak_velocity;          ///< of the joint commands, by differences from row to row
    machine::AxisAcceleration peak_acceleration;  ///< the same; both may be beyond the axes' limits
    std::vector<LinuxcncBlock> blocks;            ///< in the order of the motion
};

/// What LinuxCNC 2.9 makes of a program, servo period by servo period: merging of short blocks, one command a period,
/// look-ahead, parabolic and arc blends, the modes G61, G61.1 and G64, and the smoother behind the inverse kinematics.
/// The planner works on the coordinates of the program and its limits are those of the letters: what a joint has to do
/// for them it does not know, so joints may be driven beyond their limits.
///
/// Motion begins at Setup::start where it says anything (axes that it does not name stand at 0), else at moves[0]. Each
/// row goes to `each_row`, when given, as soon as it is known: nothing is kept of it.
///
/// Not modelled: spindle-synchronised moves, probing, cutter compensation, turned work offsets, in-position windows.
/// Rows and time are those of a control that gets its commands in time, one a period, but for `missed_periods`.
///
/// Errors: CTRL0101 an axis that is not one of X Y Z A B C, CTRL0102 rotary words of an axis that the machine has not,
/// CTRL0103 a move by tool vectors, CTRL0104 a turned work offset or workpiece, CTRL0105 a cutting move without feed,
/// CTRL0106 an arc without length or not about X, Y or Z, CTRL0107 a setting without meaning, CTRL0108 nothing moves,
/// CTRL0109 tool not in the setup, CTRL0110 work offset not in the setup, CTRL0111 a coordinate beyond 10 km or not
/// finite, CTRL0112 a run beyond the longest, and those of Kinematics::make. Cost: about 1 µs a row; memory of the
/// planner's queue and of `blocks`.
Result<LinuxcncRun> run_as_linuxcnc(const program::Program& program, const machine::Machine& machine,
                                    const machine::Setup& setup, const LinuxcncSettings& settings,
                                    const std::function<void(const LinuxcncRow&)>& each_row = {});

}  // namespace trunnion::controller
