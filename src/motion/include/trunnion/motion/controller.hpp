#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>

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

/// The numbers of the block model. Keys, meanings and units: parameter_facts().
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
    other_stop_time
};
inline constexpr std::size_t parameter_count = 20;

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

struct Parameter {
    double value = 0;  ///< mm, rad, s or a plain number; infinite = unlimited
    Source source = Source::guessed;
    double spread = 0;   ///< the truth is within value ± spread; same unit
    bool given = false;  ///< a parameter that the controller's choices do not need may be absent
};

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

    Parameter& operator[](ParameterId id) { return parameters[static_cast<std::size_t>(id)]; }
    const Parameter& operator[](ParameterId id) const { return parameters[static_cast<std::size_t>(id)]; }
};

/// The words of a choice in its file, by their number in the enumeration, and what it decides.
struct ChoiceFacts {
    std::string_view key, meaning;
    std::span<const std::string_view> words;
};
enum class ChoiceId : std::uint8_t { profile, transition, axis_set_change, branch, feed_counts };
inline constexpr std::size_t choice_count = 5;
const ChoiceFacts& facts_of(ChoiceId id);

/// Number in the enumeration and source of a choice, whichever it is.
struct ChoiceValue {
    int way = 0;
    Source source = Source::guessed;
};
ChoiceValue choice_of(const Controller& controller, ChoiceId id);
void set_choice(Controller& controller, ChoiceId id, ChoiceValue value);

/// Whether the block model uses a parameter under the choices made: the rounding tolerance only where transitions are
/// arcs, velocity steps only where they are steps, jerk only where it is limited.
bool is_used(const Controller& controller, ParameterId id);

}  // namespace trunnion::motion
