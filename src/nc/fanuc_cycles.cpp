#include <algorithm>

#include "detail/fanuc_reader.hpp"

namespace trunnion::nc::fanuc {

using Eigen::Vector3d;
using program::EventKind;

namespace {

constexpr double retract_mm = 1;      ///< d of G73 and G83, which is a parameter of the control
constexpr double most_pecks = 10000;  ///< of one hole
constexpr double most_repeats = 9999;
constexpr double same_depth_mm = 1e-9;
constexpr double dwell_unit_s = 0.001;  ///< of P without a point

}  // namespace

/// A cycle that follows another keeps its levels, and the level from which the first one began.
bool FanucReader::begin_cycle(int number) {
    if (cycle_.number == 0) cycle_ = {.initial = unknown};
    if (modes_.feed_kind == Meaning::inverse_time)
        return refuse("NC0849", code_of(Group::cycle), "a drilling cycle has no feed under G93", "G94");
    const bool first = cycle_.number == 0;
    cycle_.number = number;
    if (!count_in(false)) return false;
    if (first) cycle_.initial = programmed_mm_[modes_.normal_axis];
    return true;
}

/// A depth of a stroke, a time, a shift.
bool FanucReader::cycle_lengths() {
    for (const char letter : {'Q', 'P', 'I', 'J'})
        if (said_.has(letter) && !std::isfinite(length_of(letter)))
            return refuse("NC0849", said_.word(letter), "a value of the cycle is not finite");
    if (said_.has('Q')) cycle_.peck_mm = std::abs(length_of('Q'));
    if (said_.has('P')) cycle_.dwell_s = said_['P'] * (said_.word('P').has_point ? 1 : dwell_unit_s);
    if (!(cycle_.dwell_s >= 0)) return refuse("NC0849", said_.word('P'), "a time is not negative");
    if (said_.has('I')) cycle_.shift_first_mm = length_of('I');
    if (said_.has('J')) cycle_.shift_second_mm = length_of('J');
    said_.use("QPIJ");
    return true;
}

/// R and the depth: coordinates under G90, from the initial level and from R under G91.
bool FanucReader::cycle_words() {
    const char depth_letter = "XYZ"[modes_.normal_axis];
    if (said_.has('R')) cycle_.r = length_of('R') + (modes_.absolute ? 0 : cycle_.initial);
    if (said_.has(depth_letter)) cycle_.bottom = length_of(depth_letter) + (modes_.absolute ? 0 : cycle_.r);
    said_.use("RKL");
    if (!std::isfinite(cycle_.r) || !std::isfinite(cycle_.bottom))
        return refuse("NC0849", block_.place(), "a drilling cycle needs its levels R and Z, known ones", {},
                      "under G91 they count from where the tool stands");
    return cycle_lengths();
}

/// The holes of a block: at its place, and by K or L further on under G91.
bool FanucReader::drill() {
    axis_words_ever_ = true;
    last_motion_ = block_.place();
    if (asked(Group::once) == Meaning::machine_position)
        return refuse("NC0849", block_.place(), "a drilling cycle at a place in machine coordinates");
    if (!count_in(false) || !cycle_words()) return false;
    const char count_letter = said_.has('L') ? 'L' : 'K';
    const double count = said_.get(count_letter, 1);
    if (!(count >= 0 && count <= most_repeats && count == std::floor(count)))
        return refuse("NC0849", said_.word(count_letter), "the repeats of a cycle are a whole number");
    Vector3d at = programmed_mm_;
    for (int i = 0; i < static_cast<int>(count); ++i) {
        const double level = programmed_mm_[modes_.normal_axis];
        if (!axis_words(at)) return false;
        at[modes_.normal_axis] = level;
        if (!hole(at)) return false;
    }
    said_.use_mask(control_.axis_letters());
    interpreter_.moved();
    return true;
}

bool FanucReader::hole(const Vector3d& at) {
    if (cycle_.return_left_out)
        return refuse("NC0849", block_.place(), "between two holes the tool returns to a level that is not known (G98)",
                      {}, "say Z before the cycle, or G99");
    if (!go(at, {.rapid = true})) return false;
    at_reference_ &= ~Letters::bit("XYZ"[modes_.normal_axis]);
    if (!said_since_reference({})) return false;
    return carry_out_cycle();
}

bool FanucReader::to_level(double level, bool rapid, std::optional<double> speed_mm_s) {
    Vector3d to = programmed_mm_;
    to[modes_.normal_axis] = level;
    return go(to, {.rapid = rapid, .speed_mm_s = speed_mm_s});
}

bool FanucReader::cycle_dwell() {
    if (cycle_.dwell_s > 0) event(EventKind::dwell, true, fmt::format("G{} P", cycle_.number), cycle_.dwell_s);
    return true;
}

/// At rapid to R, under G98 to the initial level. Where that is known to the control alone, as behind a change of the
/// work offset, the tool stays where it is.
bool FanucReader::back_out() {
    if (modes_.return_to_r || !std::isnan(cycle_.initial))
        return to_level(modes_.return_to_r ? cycle_.r : cycle_.initial, true);
    findings_.count("NC0872", Severity::warning, block_.place(), "G98",
                    "the return to a level that is not known is left out, to R is gone",
                    "say Z before the cycle, or G99");
    cycle_.return_left_out = true;
    if (!to_level(cycle_.r, true)) return false;
    programmed_mm_[modes_.normal_axis] = unknown;
    position_mm_ = frame_.outward(programmed_mm_).value_or(Vector3d::Constant(unknown));
    at_reference_ |= Letters::bit("XYZ"[modes_.normal_axis]);
    return true;
}

bool FanucReader::carry_out_cycle() {
    if (cycle_.number == 87) return back_bore();
    if (!to_level(cycle_.r, true)) return false;
    switch (cycle_.number) {
        case 73:
        case 83:
            return pecks() && cycle_dwell() && back_out();
        case 74:
        case 84:
            return tap();
        case 76:
            return drill_down(cycle_.bottom) && cycle_dwell() && cycle_spindle("M19") && aside(1) && back_out() &&
                   aside(-1) && cycle_spindle("M3");
        case 81:
            return drill_down(cycle_.bottom) && back_out();
        case 82:
            return drill_down(cycle_.bottom) && cycle_dwell() && back_out();
        case 86:
            return drill_down(cycle_.bottom) && cycle_dwell() && cycle_spindle("M5") && back_out() &&
                   cycle_spindle("M3");
        case 88:
            return drill_down(cycle_.bottom) && cycle_dwell() && cycle_spindle("M5") &&
                   event(EventKind::stop, true, "M0") && back_out() && cycle_spindle("M3");
        default:
            break;
    }
    const bool dwells = cycle_.number == 89;
    return drill_down(cycle_.bottom) && (!dwells || cycle_dwell()) && drill_down(cycle_.r) && back_out();
}

/// G73 draws back by d after every stroke; G83 comes out to R and goes down again at rapid to d before the depth.
bool FanucReader::pecks() {
    const double whole = cycle_.r - cycle_.bottom, down = std::copysign(1.0, whole);
    if (!(cycle_.peck_mm > 0)) return drill_down(cycle_.bottom);
    if (!(std::abs(whole) / cycle_.peck_mm <= most_pecks))
        return refuse("NC0849", block_.place(), "too many strokes in a hole", fmt::format("Q{}", cycle_.peck_mm));
    findings_.count(
        "NC0868", Severity::note, block_.place(), fmt::format("G{}", cycle_.number),
        fmt::format("how far the drill draws back between strokes is a parameter of the control: {} mm taken",
                    retract_mm));
    for (double depth = cycle_.peck_mm; std::abs(whole) - depth > same_depth_mm; depth += cycle_.peck_mm) {
        const double reached = cycle_.r - down * depth, back = reached + down * std::min(retract_mm, depth);
        if (!drill_down(reached)) return false;
        if (cycle_.number == 83 && !to_level(cycle_.r, true)) return false;
        if (!to_level(back, true)) return false;
    }
    return drill_down(cycle_.bottom);
}

/// G84 turns the spindle back at the depth, G74 the other way round. Under G95 F is the pitch.
bool FanucReader::tap() {
    const bool left = cycle_.number == 74;
    return drill_down(cycle_.bottom) && cycle_dwell() && cycle_spindle(left ? "M3" : "M4") && drill_down(cycle_.r) &&
           cycle_dwell() && cycle_spindle(left ? "M4" : "M3") && (modes_.return_to_r || back_out());
}

/// The tool's edge off the wall: by I and J. By Q the direction is a parameter of the control.
bool FanucReader::aside(double sense) {
    const bool said = cycle_.shift_first_mm != 0 || cycle_.shift_second_mm != 0;
    if (!said && cycle_.peck_mm != 0)
        return refuse("NC0848", block_.place(),
                      fmt::format("G{}: the direction of the shift Q is a parameter of the control", cycle_.number), {},
                      "I and J instead of Q");
    if (!said) return true;
    Vector3d to = programmed_mm_;
    to[(modes_.normal_axis + 1) % 3] += sense * cycle_.shift_first_mm;
    to[(modes_.normal_axis + 2) % 3] += sense * cycle_.shift_second_mm;
    if (to.hasNaN()) return refuse("NC0849", block_.place(), "it lifts off from a position that is not known");
    return go(to, {.rapid = true});
}

/// G87: down beside the hole to R, to the middle, at feed to Z, beside it out to the initial level.
bool FanucReader::back_bore() {
    if (std::isnan(cycle_.initial))
        return refuse("NC0849", block_.place(), "G87 returns to the initial level, which is not known", {},
                      "say Z before it");
    return cycle_spindle("M19") && aside(1) && to_level(cycle_.r, true) && aside(-1) && cycle_spindle("M3") &&
           drill_down(cycle_.bottom) && cycle_spindle("M19") && aside(1) && to_level(cycle_.initial, true) &&
           aside(-1) && cycle_spindle("M3");
}

}  // namespace trunnion::nc::fanuc
