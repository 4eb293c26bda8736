#include "detail/linuxcnc_doubts.hpp"

#include <algorithm>

#include "detail/doubts.hpp"

namespace trunnion::controller {

using motion::ParameterId;

namespace {

/// The same limits of every axis with another last digit of the accelerations.
LinuxcncSettings with_acceleration_factor(LinuxcncSettings settings, const machine::Machine& machine, double factor) {
    for (int i = 0; i < machine.axis_count; ++i) {
        const machine::Axis& axis = machine.axes[static_cast<std::size_t>(i)];
        auto& given = settings.axis_limits[axis.letter];
        given.acceleration = factor * given.acceleration.value_or(axis.feed.acceleration);
    }
    return settings;
}

}  // namespace

/// A run that is refused, as one beyond the longest, says nothing new.
double LinuxcncDoubts::time_with(const LinuxcncSettings& settings) const {
    const auto run = run_as_linuxcnc(program_, machine_, setup_, settings);
    return run ? run->cycle_time_s : run_.cycle_time_s;
}

double LinuxcncDoubts::time_with(std::size_t parameter, double value) const {
    motion::Controller other = controller_;
    motion::used_parameters(other)[parameter].parameter->value = value;
    auto settings = linuxcnc_settings(other);
    if (!settings) return run_.cycle_time_s;
    settings->feed_override = std::min(settings_.feed_override, settings->max_feed_override);
    return time_with(*settings);
}

/// How often the program waits as long as a parameter says; negative: it is no such parameter.
double LinuxcncDoubts::waits_with(std::size_t parameter) const {
    motion::Controller copy = controller_;
    const motion::Parameter* const asked = motion::used_parameters(copy)[parameter].parameter;
    const auto waits = [&](LinuxcncWait word) {
        return static_cast<double>(run_.waits[static_cast<std::size_t>(word)]);
    };
    if (asked == &copy[ParameterId::spindle_time]) return waits(LinuxcncWait::spindle);
    if (asked == &copy[ParameterId::other_stop_time]) return waits(LinuxcncWait::other);
    if (asked == &copy[ParameterId::dwell_excess]) return waits(LinuxcncWait::dwell);
    if (asked == &copy[ParameterId::coolant_time]) return waits(LinuxcncWait::coolant);
    if (asked == &copy[ParameterId::tool_preparation_time]) return waits(LinuxcncWait::tool_preparation);
    if (asked == &copy[ParameterId::tool_change_time])
        return waits(LinuxcncWait::tool_change) + waits(LinuxcncWait::tool_preparation);
    return -1;
}

void LinuxcncDoubts::vary_parameters(motion::Prediction& prediction) const {
    motion::Controller copy = controller_;
    const auto parameters = motion::used_parameters(copy);
    for (std::size_t i = 0; i < parameters.size(); ++i) {
        const double value = parameters[i].parameter->value;
        const auto [low, high] = motion::truth_of(*parameters[i].parameter, *parameters[i].facts);
        if (!parameters[i].parameter->given || !(low < high)) continue;
        const double waits = waits_with(i);
        const auto time = [&](double other) {
            if (other == value) return run_.cycle_time_s;
            return waits >= 0 ? run_.cycle_time_s + waits * (other - value) : time_with(i, other);
        };
        prediction.doubts.push_back({parameters[i].name, low, high, time(low), time(high)});
    }
}

/// Rounding differences grow tenfold every 150 periods or so in a program of short segments with arcs between them.
void LinuxcncDoubts::vary_last_digits(motion::Prediction& prediction) const {
    constexpr double digit = 1e-13;
    motion::Doubt doubt{"last digits", -5 * digit, 5 * digit, run_.cycle_time_s, run_.cycle_time_s};
    for (const double digits : {-5.0, -2.0, 1.0, 5.0}) {
        const double time = time_with(with_acceleration_factor(settings_, machine_, 1 + digits * digit));
        doubt.time_low_s = std::min(doubt.time_low_s, time);
        doubt.time_high_s = std::max(doubt.time_high_s, time);
    }
    prediction.doubts.push_back(std::move(doubt));
}

void LinuxcncDoubts::vary_unset_direction(motion::Prediction& prediction) const {
    motion::Doubt doubt{"unset direction", -1, 1, 0, 0};
    LinuxcncSettings other = settings_;
    other.unset_direction_cosine = doubt.low;
    doubt.time_low_s = time_with(other);
    other.unset_direction_cosine = doubt.high;
    doubt.time_high_s = time_with(other);
    prediction.doubts.push_back(std::move(doubt));
}

void LinuxcncDoubts::find(motion::Prediction& prediction) const {
    vary_parameters(prediction);
    if (run_.arc_blends > 0) vary_last_digits(prediction);
    if (run_.unset_directions > 0) vary_unset_direction(prediction);
    sum_up_doubts(prediction);
}

}  // namespace trunnion::controller
