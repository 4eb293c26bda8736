#include <algorithm>
#include <cmath>
#include <limits>

#include "detail/heidenhain_drilling.hpp"
#include "detail/heidenhain_reader.hpp"

namespace trunnion::nc::heidenhain {

using Eigen::Vector3d;
using program::EventKind;

namespace {

/// Cycles that call() carries out.
constexpr int drilling_cycles[] = {1, 200, 201, 203, 205, 206, 207, 240};

/// Old cycles of several blocks that set something or are told; the others are machining.
constexpr int several_blocks[] = {1, 7, 8, 9, 10, 11, 13, 19, 26, 32};

}  // namespace

// ------------------------------------------------------------------------------------------------- definitions

bool HeidenhainReader::cycle() {
    const std::size_t start = cursor().next_index();
    if (cursor().take_word("CALL")) return cycle_call();
    if (!cursor().take_word("DEF")) return refuse("NC0204", start, "unknown block: it might change motion", "CYCL");
    const std::size_t place = cursor().next_index();
    const auto digits = [&] {
        int number = 0;
        for (; is_digit(cursor().rest().substr(0, 1).empty() ? ' ' : cursor().rest().front()); cursor().skip(1))
            number = std::min(number * 10 + (cursor().rest().front() - '0'), 100'000);
        return number;
    };
    const bool numbered = is_digit(cursor().front());
    const int number = numbered ? digits() : 0;
    if (!numbered) return refuse("NC0704", place, "the definition of a cycle needs its number");
    if (cursor().rest().starts_with('.')) {
        cursor().skip(1);
        return cycle_part(number, digits(), place);
    }
    return define_cycle(number, place);
}

/// CYCL DEF 7.1 and the like; the part 0 has the name alone.
bool HeidenhainReader::cycle_part(int number, int part, std::size_t place) {
    if (std::ranges::find(several_blocks, number) == std::end(several_blocks))
        return refuse("NC0704", place, "this cycle is not carried out", fmt::format("cycle {}", number),
                      "post the path that it makes");
    if (part == 0) {
        if (number != 1) return true;
        pecking_.fill(unknown);
        cycle_ = 1;
        modal_call_ = false;
        return true;
    }
    switch (number) {
        case 1:
            return old_pecking(part);
        case 7:
            return shift_words();
        case 8:
            return mirror();
        case 9:
            return old_dwell();
        case 10:
            return rotation();
        case 11:
            return scale();
        case 19:
            return working_plane();
        case 26:
            return axis_scale();
        case 13:
            return event(EventKind::spindle, true, "CYCL DEF 13");
        default:
            findings_.count("NC0758", Severity::note, cursor().spot(place), "CYCL DEF 32",
                            "of the tolerances of cycle 32 those of the plan are taken",
                            "--tip-tolerance and --orientation-tolerance");
            return true;
    }
}

/// The number behind the words of a part, whatever language they are in.
bool HeidenhainReader::number_behind_words(double& value) {
    while (!cursor().at_end() && is_letter(cursor().front()) && cursor().front() != 'Q') cursor().name();
    return values().value(value);
}

bool HeidenhainReader::old_pecking(int part) {
    if (part >= static_cast<int>(pecking_.size())) return refuse("NC0705", first_word_, "cycle 1 has five parts");
    return number_behind_words(pecking_[static_cast<std::size_t>(part)]) && want_end();
}

/// Cycle 9 is carried out where it is defined.
bool HeidenhainReader::old_dwell() {
    double time_s = 0;
    cursor().take_word("V.ZEIT");
    if (!number_behind_words(time_s)) return false;
    if (!(time_s >= 0 && time_s < 1e6)) return refuse("NC0711", first_word_, "a time is not negative");
    return event(EventKind::dwell, true, fmt::format("CYCL DEF 9 {}", time_s), time_s) && want_end();
}

/// Behind the name of a cycle, Q200=2 and so on: they are parameters like others.
bool HeidenhainReader::parameters_of_cycle() {
    while (!cursor().at_end()) {
        const std::size_t place = cursor().index();
        const bool is_parameter = cursor().front() == 'Q' && is_digit(cursor().behind_front());
        if (!is_parameter) {
            cursor().skip(1);
            continue;
        }
        ParameterName name;
        double value = 0;
        if (!values().parameter_name(name)) return false;
        if (!cursor().take('=')) return refuse("NC0731", place, "= is missing behind the parameter");
        if (!values().feed_or_formula(value)) return false;
        values().parameters().set(name, value);
    }
    return true;
}

bool HeidenhainReader::define_cycle(int number, std::size_t place) {
    if (number == 247) {
        while (!cursor().at_end() && !(cursor().front() == 'Q' && is_digit(cursor().behind_front()))) cursor().skip(1);
        return datum();
    }
    if (std::ranges::find(drilling_cycles, number) == std::end(drilling_cycles) || number < 200)
        return refuse("NC0704", place, "this cycle is not carried out", fmt::format("cycle {}", number),
                      "post the path that it makes");
    cycle_ = number;
    modal_call_ = false;
    values().set_automatic_feed(modes_.tool_call_feed / feed_unit_mm());
    return parameters_of_cycle();
}

// ------------------------------------------------------------------------------------------------- calls

/// CYCL CALL, with M words; CYCL CALL POS X Y Z, from which the levels of the cycle count.
bool HeidenhainReader::cycle_call() {
    const std::size_t place = cursor().next_index();
    const bool at_position = cursor().take_word("POS");
    if (!at_position && cursor().take_word("PAT"))
        return refuse("NC0704", place, "patterns are not supported", "CYCL CALL PAT", "post the holes");
    if (!path_words() || !check_addresses(at_position ? Addresses::bits(Address::x, Address::z) : 0)) return false;
    if (!start_functions() || !keep_feed()) return false;
    if (!at_position) return call_cycle(place) && end_functions();
    count_in(counting());
    Vector3d to = programmed_mm_;
    if (!linear_words(to)) return false;
    const double raised = said_.has(Address::z) ? to.z() : 0;
    to.z() = programmed_mm_.z();
    if (cycle_ < 200) return refuse("NC0705", place, "CYCL CALL POS needs a cycle from 200 on");
    DrillingCycle drilling(*this, place, raised);
    if (!drilling.levels()) return false;
    // Below the level of the start it goes up first.
    if (!(to.z() >= drilling.start_mm())) {
        Vector3d up = programmed_mm_;
        up.z() = to.z() = drilling.start_mm();
        if (!go(up, {.rapid = true})) return false;
    }
    axis_words_ever_ = true;
    last_motion_ = spot_of_motion();
    return go(to, {.rapid = true}) && drilling.run() && end_functions();
}

bool HeidenhainReader::call_cycle(std::size_t place) {
    if (cycle_ == 0) return refuse("NC0705", place, "no cycle is defined", {}, "CYCL DEF before the call");
    if (machine_datum_) return refuse("NC0705", place, "a cycle at a place in machine coordinates");
    axis_words_ever_ = true;
    last_motion_ = spot_of_motion();
    count_in(counting());
    return DrillingCycle(*this, place, 0).run();
}

}  // namespace trunnion::nc::heidenhain
