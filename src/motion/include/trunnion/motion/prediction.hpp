#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "trunnion/base/diagnostic.hpp"
#include "trunnion/machine/machine.hpp"

namespace trunnion::motion {

/// What holds the speed down at a place.
enum class LimitKind : std::uint8_t {
    feed,             ///< the programmed feed: nothing else does
    velocity,         ///< of an axis
    acceleration,     ///< of an axis, speeding up or braking
    jerk,             ///< of an axis, speeding up or braking
    curvature,        ///< acceleration of an axis across the path
    curvature_jump,   ///< of an axis
    transition,       ///< from block to block
    block_time,       ///< the interpolator's cycle
    preparation,      ///< blocks are not prepared fast enough
    look_ahead,       ///< it must be able to stop at the end of what it knows
    axis_set,         ///< other axes begin to move
    stop,             ///< a standstill that the program or the control asks for
    linear_velocity,  ///< the control's own limit of the tip
    command_rate,     ///< segments come later than they are carried out
    planner           ///< of a planner that does not say
};
struct Limit {
    LimitKind kind = LimitKind::feed;
    std::int8_t axis = -1;  ///< index in Machine::axes, where it is that of an axis
    bool operator==(const Limit&) const = default;
};
/// `A velocity`, `block time`, `look-ahead`, `transition`, …
std::string to_string(Limit limit, const machine::Machine& machine);

/// One instant of the predicted motion. Where velocities jump two rows have the same time.
struct PredictedRow {
    double time_s = 0;
    machine::AxisPosition position;
    machine::AxisVelocity velocity;
    std::int32_t line = 0;         ///< of the program
    double path_length_mm = 0;     ///< s, the tip's way
    double tip_feed_mm_s = 0;      ///< speed of the tip in the workpiece
    double contact_feed_mm_s = 0;  ///< speed of the tool against the part where it touches; NaN: the tool is not known
    Limit limit;
    bool rapid = false;
};

/// What one line of the program takes, each time that it comes.
struct LineTime {
    std::int32_t line = 0;
    double begin_s = 0, duration_s = 0;
};

/// A place where the feed falls under nine tenths of what is programmed.
struct PredictedDrop {
    std::int32_t line = 0;  ///< where it is slowest
    double s_from_mm = 0, s_to_mm = 0;
    double feed_min_mm_s = 0, programmed_feed_mm_s = 0;
    double lost_s = 0;  ///< against the programmed feed
    Limit cause;        ///< what costs most; of speeding up and braking what holds the slower end down
};

/// How hard one axis works.
struct PredictedLoad {
    char letter = 'X';
    double velocity_ratio = 0, acceleration_ratio = 0;  ///< peak / limit of the machine; acceleration along the path
    /// The same of the jerk; NaN: the control's model has none.
    double jerk_ratio = std::numeric_limits<double>::quiet_NaN();
    double limiting_share = 0;  ///< share of the cutting time in which this axis is what limits
};

/// What holds the speed down, and for how long while cutting.
struct LimitTime {
    Limit limit;
    double time_s = 0;
};

/// What not knowing one parameter means for the cycle time.
struct Doubt {
    std::string parameter;
    double low = 0, high = 0;                ///< values tried, mm, rad, s, or a plain number
    double time_low_s = 0, time_high_s = 0;  ///< cycle time with each
};

/// What a control makes of a program.
struct Prediction {
    std::string program, dialect, machine, setup, controller;
    double cycle_time_s = 0, cut_time_s = 0, rapid_time_s = 0, dwell_time_s = 0;
    double tool_change_time_s = 0, other_stop_time_s = 0;  ///< of T and M6; of M, S and other words that stop the axes
    double path_length_mm = 0;
    std::size_t blocks = 0;
    std::size_t standstills = 0;
    /// Half the width of the cycle time when every parameter that is not identified varies by its spread, on its own;
    /// the root of the sum of squares. Negative: not looked for.
    double uncertainty_s = -1;
    std::vector<Doubt> doubts;  ///< what weighs most first
    std::vector<PredictedLoad> axes;
    std::vector<LimitTime> limits;  ///< what takes longest first
    std::vector<PredictedDrop> feed_drops;
    std::vector<LineTime> lines;  ///< in the order of the motion; lines that follow each other with one number are one
    std::vector<Diagnostic> diagnostics;
};

}  // namespace trunnion::motion
