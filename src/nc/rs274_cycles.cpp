#include "detail/rs274_reader.hpp"

namespace trunnion::nc {

using Eigen::Vector3d;
using program::EventKind;
using program::MoveKind;

namespace {

constexpr double above_the_bottom_mm = 0.010 * inch_mm;  ///< to where pecking comes back
constexpr double most_strokes = 10'000;                  ///< of one block

enum class Bottom : std::uint8_t { rapid, feed, peck, chip_break, tap, stop_spindle };

/// How the cycle with this G word gets to the bottom and back.
Bottom bottom_of(int tenths) {
    switch (tenths) {
        case 730:
            return Bottom::chip_break;
        case 830:
            return Bottom::peck;
        case 740:
        case 840:
            return Bottom::tap;
        case 850:
        case 890:
            return Bottom::feed;
        case 860:
            return Bottom::stop_spindle;
        default:
            return Bottom::rapid;
    }
}

bool dwells(int tenths) {
    return tenths == 820 || tenths == 860 || tenths == 890;
}

}  // namespace

/// The canned cycle in force, at the place that the block says and L − 1 times more.
bool Rs274Reader::cycle() {
    CycleWords words;
    if (!cycle_can_run() || !cycle_words(words)) return false;
    if (!modal_.retract)
        findings_.count("NC0352", Severity::warning, spot_of_motion(), "R",
                        "a cycle before G98 or G99: back to R, as LinuxCNC starts", "G98 or G99 says which");

    enter(frame_in_force());
    const int along = modal_.plane_normal;
    const Vector3d before_mm = position_mm_;
    axes_ &= ~Block::bit("XYZ"[along]);
    if (!target()) return false;
    if (position_mm_.hasNaN() || std::isnan(before_mm[along]))
        return refuse("NC0344", spot_of_motion(), "a cycle from a position that is not known in this frame", {},
                      "say X, Y and Z by G0 before it");
    const Vector3d place_mm = position_mm_;
    CycleLevels levels{.start_mm = before_mm[along]};
    double times = 1;
    if (!cycle_levels(words, levels) || !cycle_times(words, levels, times)) return false;
    position_mm_ = before_mm;

    const bool blends = !modal_.exact_stop;  // LinuxCNC stays on the path in cycles
    if (blends)
        program_.path_controls.push_back(
            {.kind = program::PathControlKind::exact, .before_move = program_.moves.size()});
    if (!bore_in_a_row(words, levels, place_mm, times)) return false;
    if (blends) {
        program_.path_controls.push_back(modal_.path_control);
        program_.path_controls.back().before_move = program_.moves.size();
    }
    cycle_ = words;
    return true;
}

bool Rs274Reader::cycle_can_run() {
    const auto refused = [&](std::string text, std::string_view hint = {}) {
        return refuse("NC0345", spot_of_motion(), std::move(text), name_of(modal_.motion_code), hint);
    };
    if (axes_ == 0) return refused("a canned cycle needs an axis word");
    if (request_.asks(Group::once, Meaning::machine_position)) return refused("a canned cycle in machine positions");
    if (modal_.feed_mode == FeedMode::inverse_time) return refused("a canned cycle needs G94 or G95");
    const std::uint32_t linear = Block::bit('X') | Block::bit('Y') | Block::bit('Z');
    return (axes_ & ~linear) == 0 || refused("a canned cycle turns no rotary axis", "turn it in a block before");
}

/// Where the cycle turns round, along its axis, from where it starts.
bool Rs274Reader::cycle_levels(const CycleWords& words, CycleLevels& levels) {
    const double shift_mm = word_shift_.mm[modal_.plane_normal];
    levels.retract_mm = words.retract_mm + (modal_.absolute ? shift_mm : levels.start_mm);
    levels.depth_mm = words.depth_mm + (modal_.absolute ? shift_mm : levels.retract_mm);
    if (!(levels.retract_mm >= levels.depth_mm))
        return refuse("NC0346", spot_of_motion(), "a cycle whose R lies below its depth",
                      fmt::format("R at {:g} mm, depth {:g} mm", levels.retract_mm, levels.depth_mm));
    const bool to_start = modal_.retract == Meaning::initial_level;
    const double series_mm = cycle_level_mm_.value_or(levels.start_mm);
    levels.across_mm = std::max(to_start ? series_mm : levels.start_mm, levels.retract_mm);
    levels.clear_mm = to_start ? levels.across_mm : levels.retract_mm;
    return true;
}

/// L.
bool Rs274Reader::cycle_times(const CycleWords& words, const CycleLevels& levels, double& times) {
    times = block_.has('L') ? block_['L'] : 1;
    if (times != std::floor(times) || times < 1)
        return refuse("NC0314", block_.spot('L'), "a cycle runs a whole number of times", fmt::format("L{}", times));
    const double strokes = words.step_mm > 0 ? std::ceil((levels.retract_mm - levels.depth_mm) / words.step_mm) : 1;
    return times * std::max(1.0, strokes) <= most_strokes ||
           refuse("NC0346", spot_of_motion(), "too many strokes in one block", fmt::format("{:g}", times * strokes),
                  "a larger Q");
}

/// Each hole as far from the one before as the first one from where the tool is, in G91; else all at one place.
bool Rs274Reader::bore_in_a_row(const CycleWords& words, const CycleLevels& levels, const Vector3d& first_mm,
                                double times) {
    const int along = modal_.plane_normal;
    const Vector3d step_mm = modal_.absolute ? Vector3d(Vector3d::Zero()) : Vector3d(first_mm - position_mm_);
    if (!cycle_level_mm_) cycle_level_mm_ = levels.start_mm;
    Vector3d place_mm = first_mm;
    place_mm[along] = levels.across_mm;
    if (levels.start_mm < levels.retract_mm && !cycle_move(levels.retract_mm, MoveKind::rapid)) return false;
    for (double turn = 0; turn < times; ++turn) {
        if (!cycle_move_across(place_mm) || !cycle_move(levels.retract_mm, MoveKind::rapid) || !bore(words, levels))
            return false;
        place_mm += step_mm;
        place_mm[along] = levels.clear_mm;
    }
    return true;
}

/// Of the block, else of the block before, where that had the same cycle.
bool Rs274Reader::cycle_words(CycleWords& words) {
    const int tenths = modal_.motion_code.tenths;
    const bool goes_on = cycle_.tenths == tenths;
    words = goes_on ? cycle_ : CycleWords{.tenths = tenths};
    const char depth = "XYZ"[modal_.plane_normal];
    const Bottom bottom = bottom_of(tenths);
    const bool pecks = bottom == Bottom::peck || bottom == Bottom::chip_break;
    const auto missing = [&](std::string_view letter) {
        return refuse("NC0345", spot_of_motion(), "a word of the cycle is missing", letter,
                      fmt::format("{} needs it the first time", name_of(modal_.motion_code)));
    };
    if (!goes_on && !block_.has('R')) return missing("R");
    if (!goes_on && !block_.has(depth)) return missing({&depth, 1});
    if (!goes_on && pecks && !block_.has('Q')) return missing("Q");
    if (!goes_on && dwells(tenths) && !block_.has('P')) return missing("P");
    if (block_.has('R')) words.retract_mm = block_['R'] * modal_.unit_mm;
    if (block_.has(depth)) words.depth_mm = block_[depth] * modal_.unit_mm;
    if (block_.has('Q')) words.step_mm = block_['Q'] * modal_.unit_mm;
    if (block_.has('P')) words.dwell_s = block_['P'];
    if (pecks && !(words.step_mm > 0))
        return refuse("NC0345", block_.spot('Q'), "the step of a cycle must be positive",
                      fmt::format("Q{}", block_['Q']));
    if (words.dwell_s < 0)
        return refuse("NC0312", block_.spot('P'), "a dwell is not negative", fmt::format("P{}", block_['P']));
    return true;
}

/// From R to the bottom and to where the tool is clear.
bool Rs274Reader::bore(const CycleWords& words, const CycleLevels& levels) {
    const Bottom bottom = bottom_of(words.tenths);
    if (bottom == Bottom::tap) return tap(words, levels.depth_mm, levels.clear_mm);
    if (bottom == Bottom::stop_spindle && modal_.spindle_word.empty())
        return refuse("NC0345", spot_of_motion(), "the spindle does not turn", name_of(modal_.motion_code),
                      "M3 before it");
    if (words.step_mm > 0 && !peck(words, levels.retract_mm, levels.depth_mm)) return false;
    if (!cycle_move(levels.depth_mm, MoveKind::feed)) return false;
    cycle_dwell(words.dwell_s);
    if (bottom == Bottom::stop_spindle) event(EventKind::spindle, true, "M5");
    if (bottom == Bottom::feed &&
        !cycle_move(words.tenths == 850 ? levels.retract_mm : levels.clear_mm, MoveKind::feed))
        return false;
    if (!cycle_move(levels.clear_mm, MoveKind::rapid)) return false;
    if (bottom == Bottom::stop_spindle) event(EventKind::spindle, true, modal_.spindle_word);
    return true;
}

/// The strokes above the bottom. G83 goes out to R after each, G73 only lifts.
bool Rs274Reader::peck(const CycleWords& words, double retract_mm, double depth_mm) {
    const bool out = bottom_of(words.tenths) == Bottom::peck;
    for (double at_mm = retract_mm - words.step_mm; at_mm > depth_mm; at_mm -= words.step_mm) {
        if (!cycle_move(at_mm, MoveKind::feed)) return false;
        if (out && !cycle_move(retract_mm, MoveKind::rapid)) return false;
        if (!cycle_move(at_mm + above_the_bottom_mm, MoveKind::rapid)) return false;
    }
    return true;
}

/// G84 with M3, G74 with M4; the spindle turns the other way on the way out.
bool Rs274Reader::tap(const CycleWords& words, double depth_mm, double clear_mm) {
    const bool right_hand = words.tenths == 840;
    const std::string_view in = right_hand ? "M3" : "M4", out = right_hand ? "M4" : "M3";
    if (modal_.spindle_word != in)
        return refuse("NC0345", spot_of_motion(), "the spindle does not turn, or the other way",
                      name_of(modal_.motion_code), fmt::format("{} before it", in));
    if (!cycle_move(depth_mm, MoveKind::feed)) return false;
    event(EventKind::spindle, true, std::string(out));
    cycle_dwell(words.dwell_s);
    if (!cycle_move(clear_mm, MoveKind::feed)) return false;
    event(EventKind::spindle, true, std::string(in));
    return true;
}

bool Rs274Reader::cycle_move(double along_mm, MoveKind kind) {
    position_mm_[modal_.plane_normal] = along_mm;
    if (!position_mm_.allFinite())
        return refuse("NC0201", spot_of_motion(), "the position is not finite", name_of(modal_.motion_code));
    program::Move move = move_here();
    move.kind = kind;
    move.exact_stop = true;
    return feed_of(move) && add(move);
}

bool Rs274Reader::cycle_move_across(const Vector3d& place_mm) {
    position_mm_ = place_mm;
    return cycle_move(place_mm[modal_.plane_normal], MoveKind::rapid);
}

void Rs274Reader::cycle_dwell(double seconds) {
    if (seconds > 0) event(EventKind::dwell, true, fmt::format("P{}", seconds), seconds);
}

}  // namespace trunnion::nc
