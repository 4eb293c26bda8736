#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "trunnion/base/quantity.hpp"

namespace trunnion::motion {

/// How the motion that a control makes of a program is found.
enum class ControllerKind : std::uint8_t {
    blocks,           ///< the model of blocks, limits and transitions of docs/theory/prediction.md
    linuxcnc,         ///< LinuxCNC's planner, servo cycle by servo cycle
    ideal,            ///< our own planner
    length_over_feed  ///< what CAM systems print: length over feed, rapids at the axes' rapid velocity
};
std::string_view to_string(ControllerKind kind);

/// Where a value comes from. That says how far the truth may be from it, where the file gives no spread of its own.
enum class Source : std::uint8_t {
    identified,  ///< measured on the control at hand: trusted
    documented,  ///< from its maker, a paper or a manual: ± 10 %
    guessed      ///< ± 30 %
};
std::string_view to_string(Source source);
/// The share of the value that stands for its uncertainty.
double default_spread(Source source);

/// The numbers of the models. Keys, meanings and units: facts_of(); which model uses which: is_used(). The times of
/// words that stop the axes are both models'.
enum class ParameterId : std::uint8_t {
    interpolator_cycle,
    block_preparation,
    block_buffer,
    look_ahead_blocks,
    look_ahead_distance,
    reference_radius,
    rounding_tolerance,
    centripetal_share,
    velocity_step,
    rotary_velocity_step,
    curvature_jump_share,
    velocity_share,
    acceleration_share,
    jerk_share,
    rapid_share,
    setpoint_filter,
    in_position_time,
    tool_change_time,
    spindle_time,
    other_stop_time,
    servo_period,  // from here on of LinuxCNC
    max_linear_velocity,
    max_feed_override,
    arc_blend_optimization_depth,
    arc_blend_gap_cycles,
    arc_blend_ramp_freq,
    arc_blend_kink_ratio,
    missed_command_periods,
    dwell_excess,
    coolant_time,
    tool_preparation_time
};
inline constexpr std::size_t parameter_count = 31;

struct ParameterFacts {
    std::string_view key, meaning;
    Dimension dimension;
    double least, most;     ///< what the file may say
    bool whole;             ///< a count
    bool may_be_unlimited;  ///< "unlimited" is a value too: infinite
    std::string_view unit;  ///< to show it in
    double unit_value;      ///< that unit in mm, rad, s
};
const ParameterFacts& facts_of(ParameterId id);
/// Hz
inline constexpr Dimension frequency{0, 0, -1};

struct Parameter {
    double value = 0;  ///< mm, rad, s or a plain number; infinite = unlimited
    Source source = Source::guessed;
    double spread = 0;   ///< the truth is within value ± spread; same unit
    bool given = false;  ///< a parameter that the controller's choices do not need may be absent
};
/// The ends of what a parameter may be in truth, whole where it is a count: equal where nothing is left open.
struct Span {
    double low = 0, high = 0;
};
Span truth_of(const Parameter& parameter, const ParameterFacts& facts);

/// A limit of one axis that the control's own file says in place of the machine's.
enum class AxisLimitId : std::uint8_t { max_velocity, max_acceleration };
inline constexpr std::size_t axis_limit_count = 2;
using AxisLimitParameters = std::array<Parameter, axis_limit_count>;
const ParameterFacts& facts_of(AxisLimitId id, bool rotary);
/// Letters whose limits may be given, and whether they turn.
inline constexpr std::string_view limited_letters = "XYZABC";
constexpr bool turns(char letter) {
    return letter >= 'A' && letter <= 'C';
}

/// What a control does in one of several ways.
enum class Profile : std::uint8_t { jerk_limited, trapezoidal };
enum class Transition : std::uint8_t {
    rounding_arc,   ///< an arc within the rounding tolerance, passed with the centripetal acceleration allowed
    velocity_step,  ///< every axis may change its velocity at once by a permitted step
    exact_stop      ///< standstill at the end of every block
};
enum class AxisSetChange : std::uint8_t { none, stop };
enum class BranchRule : std::uint8_t {
    least_turning,  ///< the least rotary motion over the whole program, within the ranges
    nearest,        ///< from block to block the solution nearest to where the axes stand, whatever their ranges
    positive        ///< the solution whose tilting axis is not negative wherever its range has it
};
enum class FeedCounts : std::uint8_t {
    tip,            ///< F is the tip's speed; of a pure rotation deg/min
    tip_and_rotary  ///< F is of tip and rotary axes together, these at the reference radius
};

enum class Switch : std::uint8_t { off, on };

template <class Way>
struct Choice {
    Way way{};
    Source source = Source::guessed;
};

/// A control as its file says.
struct Controller {
    std::string name, file;
    ControllerKind kind = ControllerKind::blocks;
    std::string description;
    std::array<Parameter, parameter_count> parameters{};
    Choice<Profile> profile;
    Choice<Transition> transition;
    Choice<AxisSetChange> axis_set_change;
    Choice<BranchRule> branch;
    Choice<FeedCounts> feed_counts;
    Choice<Switch> arc_blend_enable{.way = Switch::on}, arc_blend_fallback_enable;
    std::map<char, AxisLimitParameters> axis_limits;  ///< by letter; what is not given is the machine's

    Parameter& operator[](ParameterId id) { return parameters[static_cast<std::size_t>(id)]; }
    const Parameter& operator[](ParameterId id) const { return parameters[static_cast<std::size_t>(id)]; }
};

/// The words of a choice in its file, by their number in the enumeration, and what it decides.
struct ChoiceFacts {
    std::string_view key, meaning;
    std::span<const std::string_view> words;
};
enum class ChoiceId : std::uint8_t {
    profile,
    transition,
    axis_set_change,
    branch,
    feed_counts,
    arc_blend_enable,
    arc_blend_fallback_enable
};
inline constexpr std::size_t choice_count = 7;
const ChoiceFacts& facts_of(ChoiceId id);

/// Number in the enumeration and source of a choice, whichever it is.
struct ChoiceValue {
    int way = 0;
    Source source = Source::guessed;
};
ChoiceValue choice_of(const Controller& controller, ChoiceId id);
void set_choice(Controller& controller, ChoiceId id, ChoiceValue value);

/// Whether the controller's model uses a choice, or a parameter under the choices made: the rounding tolerance only
/// where transitions are arcs, velocity steps only where they are steps, jerk only where it is limited, gap cycles only
/// where arcs blend. Kinds `ideal` and `length-over-feed` use none.
bool is_used(const Controller& controller, ChoiceId id);
bool is_used(const Controller& controller, ParameterId id);
/// Whether controllers of this kind use a parameter with any choices.
bool belongs_to(ControllerKind kind, ParameterId id);

/// A number of a controller by the name that diagnostics and reports say: its key, of an axis `X max_velocity`.
struct NamedParameter {
    std::string name;
    const ParameterFacts* facts = nullptr;
    Parameter* parameter = nullptr;  ///< in the controller that was asked
};
/// All that the controller's model uses, those of axes last and where they are given. Two copies of one controller have
/// the same list in the same order.
std::vector<NamedParameter> used_parameters(Controller& controller);

}  // namespace trunnion::motion
