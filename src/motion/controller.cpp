#include "trunnion/motion/controller.hpp"

#include <algorithm>
#include <cmath>

namespace trunnion::motion {

namespace {

constexpr double unlimited = std::numeric_limits<double>::infinity();
constexpr double tiny = 1e-9;

constexpr std::array<ParameterFacts, parameter_count> all_facts{{
    {"interpolator_cycle", "a block takes at least so long", dimension::time, 0, 1, false, false, "ms", 1e-3},
    {"block_preparation", "time to prepare one block; 0: never short of blocks", dimension::time, 0, 10, false, false,
     "ms", 1e-3},
    {"block_buffer", "so many prepared blocks together make up for short ones among them", dimension::ratio, 1, 1e6,
     true, false, "", 1},
    {"look_ahead_blocks", "known beyond the block in work; it can stop at the end of what it knows", dimension::ratio,
     0, 1e6, true, true, "", 1},
    {"look_ahead_distance", "known ahead at most, as length in the space of the axes", dimension::length, tiny, 1e6,
     false, true, "mm", 1},
    {"reference_radius", "one radian of a rotary axis counts as so many mm where axes are taken together",
     dimension::length, 1e-3, 1e5, false, false, "mm", 1},
    {"rounding_tolerance", "corner to rounding arc, in the space of the axes", dimension::length, 0, 100, false, false,
     "mm", 1},
    {"centripetal_share",
     "share of every axis' acceleration for going round curves, the rest is for speeding up and braking there; 0: both "
     "have all of it",
     dimension::ratio, 0, 0.99, false, false, "", 1},
    {"velocity_step", "a linear axis may change its velocity at once by so much", dimension::velocity, 0, 1e4, false,
     false, "mm/s", 1},
    {"rotary_velocity_step", "a rotary axis may change its velocity at once by so much", dimension::angular_velocity, 0,
     1e3, false, false, "deg/s", degree},
    {"curvature_jump_share", "share of every axis' acceleration that may come at once where curvature jumps",
     dimension::ratio, tiny, 100, false, true, "", 1},
    {"velocity_share", "of the machine's limits that the control uses", dimension::ratio, tiny, 10, false, false, "",
     1},
    {"acceleration_share", "of the machine's limits that the control uses", dimension::ratio, tiny, 10, false, false,
     "", 1},
    {"jerk_share", "of the machine's limits that the control uses", dimension::ratio, tiny, 10, false, false, "", 1},
    {"rapid_share", "of the rapid velocities that rapids use", dimension::ratio, tiny, 10, false, false, "", 1},
    {"setpoint_filter", "length of the moving average over setpoints: so much later at every standstill",
     dimension::time, 0, 10, false, false, "ms", 1e-3},
    {"in_position_time", "wait at every standstill until the axes are in position", dimension::time, 0, 10, false,
     false, "ms", 1e-3},
    {"tool_change_time", "a T or M6 at a standstill takes", dimension::time, 0, 1e4, false, false, "s", 1},
    {"spindle_time", "an S, M3, M4 or M5 at a standstill takes", dimension::time, 0, 1e3, false, false, "s", 1},
    {"other_stop_time", "any other word that stops the axes takes", dimension::time, 0, 1e3, false, false, "s", 1},
    {"servo_period", "[EMCMOT]SERVO_PERIOD", dimension::time, 1e-5, 0.1, false, false, "ms", 1e-3},
    {"max_linear_velocity", "[TRAJ]MAX_LINEAR_VELOCITY: of the tip in the workpiece, where not only rotary axes move",
     dimension::velocity, tiny, 1e6, false, true, "mm/s", 1},
    {"max_feed_override", "[DISPLAY]MAX_FEED_OVERRIDE: how segments meet is planned for it", dimension::ratio, tiny,
     100, false, false, "", 1},
    {"arc_blend_optimization_depth", "[TRAJ]ARC_BLEND_OPTIMIZATION_DEPTH: segments looked back over; < 2: no tangents",
     dimension::ratio, 0, 1e6, true, false, "", 1},
    {"arc_blend_gap_cycles", "[TRAJ]ARC_BLEND_GAP_CYCLES: a shorter rest before an arc becomes a part of it",
     dimension::ratio, 0, 1e6, false, false, "", 1},
    {"arc_blend_ramp_freq", "[TRAJ]ARC_BLEND_RAMP_FREQ: segments of less than its period have one acceleration",
     frequency, tiny, 1e6, false, false, "Hz", 1},
    {"arc_blend_kink_ratio", "[TRAJ]ARC_BLEND_KINK_RATIO: share of the acceleration that a tangent joint may jump by",
     dimension::ratio, 0.001, 0.7071, false, false, "", 1},
    {"missed_command_periods", "share of the servo periods in which no segment comes though one is due",
     dimension::ratio, 0, 0.9, false, false, "", 1},
    {"dwell_excess", "a dwell takes so much longer", dimension::time, 0, 10, false, false, "ms", 1e-3},
    {"coolant_time", "an M7, M8 or M9 takes", dimension::time, 0, 1e3, false, false, "s", 1},
    {"tool_preparation_time", "a T in the block of its M6 takes so much more", dimension::time, 0, 1e4, false, false,
     "s", 1},
}};

constexpr std::string_view of_velocity = "[AXIS_*]MAX_VELOCITY, in place of the machine's";
constexpr std::string_view of_acceleration = "[AXIS_*]MAX_ACCELERATION, in place of the machine's";
constexpr std::array<std::array<ParameterFacts, 2>, axis_limit_count> all_axis_limits{
    {{{{"max_velocity", of_velocity, dimension::velocity, tiny, 1e6, false, false, "mm/s", 1},
       {"max_velocity", of_velocity, dimension::angular_velocity, tiny, 1e6, false, false, "deg/s", degree}}},
     {{{"max_acceleration", of_acceleration, dimension::acceleration, tiny, 1e8, false, false, "mm/s^2", 1},
       {"max_acceleration", of_acceleration, dimension::angular_acceleration, tiny, 1e8, false, false, "deg/s^2",
        degree}}}}};

constexpr std::array<std::string_view, 2> profiles{"jerk-limited", "trapezoidal"};
constexpr std::array<std::string_view, 3> transitions{"arc", "velocity step", "exact stop"};
constexpr std::array<std::string_view, 2> axis_set_changes{"none", "stop"};
constexpr std::array<std::string_view, 3> branches{"least turning", "nearest", "positive"};
constexpr std::array<std::string_view, 2> feeds{"tip", "tip and rotary"};
constexpr std::array<std::string_view, 2> switches{"off", "on"};

constexpr std::array<ChoiceFacts, choice_count> all_choices{{
    {"profile", "how speed changes", profiles},
    {"transition", "how it goes from block to block", transitions},
    {"axis_set_change", "what it does where other axes begin to move, or cease to", axis_set_changes},
    {"branch", "which of the solutions of the rotary axes it takes", branches},
    {"feed_counts", "what F is the speed of", feeds},
    {"arc_blend_enable", "[TRAJ]ARC_BLEND_ENABLE: arcs between segments without rotary motion", switches},
    {"arc_blend_fallback_enable", "[TRAJ]ARC_BLEND_FALLBACK_ENABLE: not modelled when on", switches},
}};

}  // namespace

std::string_view to_string(ControllerKind kind) {
    constexpr std::array<std::string_view, 4> names{"blocks", "linuxcnc", "ideal", "length-over-feed"};
    return names[static_cast<std::size_t>(kind)];
}

std::string_view to_string(Source source) {
    constexpr std::array<std::string_view, 3> names{"identified", "documented", "guessed"};
    return names[static_cast<std::size_t>(source)];
}

double default_spread(Source source) {
    constexpr std::array<double, 3> shares{0, 0.1, 0.3};
    return shares[static_cast<std::size_t>(source)];
}

const ParameterFacts& facts_of(ParameterId id) {
    return all_facts[static_cast<std::size_t>(id)];
}

const ChoiceFacts& facts_of(ChoiceId id) {
    return all_choices[static_cast<std::size_t>(id)];
}

ChoiceValue choice_of(const Controller& controller, ChoiceId id) {
    const auto value = [](const auto& choice) { return ChoiceValue{static_cast<int>(choice.way), choice.source}; };
    switch (id) {
        case ChoiceId::profile:
            return value(controller.profile);
        case ChoiceId::transition:
            return value(controller.transition);
        case ChoiceId::axis_set_change:
            return value(controller.axis_set_change);
        case ChoiceId::branch:
            return value(controller.branch);
        case ChoiceId::feed_counts:
            return value(controller.feed_counts);
        case ChoiceId::arc_blend_enable:
            return value(controller.arc_blend_enable);
        case ChoiceId::arc_blend_fallback_enable:
            return value(controller.arc_blend_fallback_enable);
    }
    return {};
}

void set_choice(Controller& controller, ChoiceId id, ChoiceValue value) {
    const auto set = [&](auto& choice) {
        choice.way = static_cast<decltype(choice.way)>(value.way);
        choice.source = value.source;
    };
    switch (id) {
        case ChoiceId::profile:
            return set(controller.profile);
        case ChoiceId::transition:
            return set(controller.transition);
        case ChoiceId::axis_set_change:
            return set(controller.axis_set_change);
        case ChoiceId::branch:
            return set(controller.branch);
        case ChoiceId::feed_counts:
            return set(controller.feed_counts);
        case ChoiceId::arc_blend_enable:
            return set(controller.arc_blend_enable);
        case ChoiceId::arc_blend_fallback_enable:
            return set(controller.arc_blend_fallback_enable);
    }
}

Span truth_of(const Parameter& parameter, const ParameterFacts& facts) {
    const double value = parameter.value;
    if (!(parameter.spread > 0) || !std::isfinite(value)) return {value, value};
    const double low = std::clamp(value - parameter.spread, facts.least, facts.most);
    const double high = std::clamp(value + parameter.spread, facts.least, facts.most);
    return facts.whole ? Span{std::floor(low), std::ceil(high)} : Span{low, high};
}

const ParameterFacts& facts_of(AxisLimitId id, bool rotary) {
    return all_axis_limits[static_cast<std::size_t>(id)][rotary ? 1 : 0];
}

bool is_used(const Controller& controller, ChoiceId id) {
    const bool of_linuxcnc = id >= ChoiceId::arc_blend_enable;
    return controller.kind == (of_linuxcnc ? ControllerKind::linuxcnc : ControllerKind::blocks);
}

bool belongs_to(ControllerKind kind, ParameterId id) {
    const bool of_words =
        id == ParameterId::tool_change_time || id == ParameterId::spindle_time || id == ParameterId::other_stop_time;
    const bool of_linuxcnc = id >= ParameterId::servo_period;
    return (kind == ControllerKind::blocks && !of_linuxcnc) ||
           (kind == ControllerKind::linuxcnc && (of_linuxcnc || of_words));
}

bool is_used(const Controller& controller, ParameterId id) {
    if (!belongs_to(controller.kind, id)) return false;
    switch (id) {
        case ParameterId::rounding_tolerance:
            return controller.transition.way == Transition::rounding_arc;
        case ParameterId::velocity_step:
        case ParameterId::rotary_velocity_step:
            return controller.transition.way == Transition::velocity_step;
        case ParameterId::jerk_share:
            return controller.profile.way == Profile::jerk_limited;
        case ParameterId::arc_blend_gap_cycles:
            return controller.arc_blend_enable.way == Switch::on;
        default:
            return true;
    }
}

std::vector<NamedParameter> used_parameters(Controller& controller) {
    std::vector<NamedParameter> out;
    for (std::size_t i = 0; i < parameter_count; ++i) {
        const auto id = static_cast<ParameterId>(i);
        if (is_used(controller, id))
            out.push_back({std::string(facts_of(id).key), &facts_of(id), &controller.parameters[i]});
    }
    if (controller.kind != ControllerKind::linuxcnc) return out;
    for (auto& [letter, limits] : controller.axis_limits)
        for (std::size_t i = 0; i < axis_limit_count; ++i) {
            const ParameterFacts& facts = facts_of(static_cast<AxisLimitId>(i), turns(letter));
            if (limits[i].given) out.push_back({std::string{letter, ' '}.append(facts.key), &facts, &limits[i]});
        }
    return out;
}

}  // namespace trunnion::motion
