#include <algorithm>
#include <numbers>

#include "detail/sinumerik_reader.hpp"

namespace trunnion::nc::sinumerik {

using Eigen::Vector3d;
using program::EventKind;

namespace {

constexpr double chip_break_mm = 1;  ///< CYCLE83 draws back so far where _VRT is 0
constexpr int most_strokes = 10000;  ///< of one hole
constexpr double same_depth_mm = 1e-9;

struct MetricThread {
    double diameter_mm, pitch_mm;
};

/// ISO 261, coarse pitches: what MPIT means.
constexpr MetricThread metric_threads[] = {{3, 0.5},  {4, 0.7},  {5, 0.8},  {6, 1},     {7, 1},    {8, 1.25},
                                           {9, 1.25}, {10, 1.5}, {11, 1.5}, {12, 1.75}, {14, 2},   {16, 2},
                                           {18, 2.5}, {20, 2.5}, {22, 2.5}, {24, 3},    {27, 3},   {30, 3.5},
                                           {33, 3.5}, {36, 4},   {39, 4},   {42, 4.5},  {45, 4.5}, {48, 5}};

/// How far before the depth reached the rapid ends that brings the drill back, CYCLE83: 0.6 mm to 30 mm of depth, then
/// a fiftieth, at most 7 mm.
double limit_distance(double depth_mm) {
    return depth_mm <= 30 ? 0.6 : std::min(depth_mm / 50, 7.0);
}

int digit(double number, int place) {
    return static_cast<int>(std::fmod(std::floor(std::abs(number) / std::pow(10, place)), 10));
}

}  // namespace

/// One drilling cycle at the place where the tool stands: as the motion that the control's manual describes. Levels are
/// coordinates along the axis across the plane; parameters that are left out are 0.
class DrillingCycle {
  public:
    DrillingCycle(SinumerikReader& reader, const Word& call)
        : reader_(reader), call_(call), unit_mm_(reader.modes_.unit_mm), axis_(reader.modes_.normal_axis) {}

    bool run();

  private:
    bool given(std::size_t i) const {
        return i < call_.arguments.size() && call_.arguments[i].kind != Argument::Kind::empty;
    }
    double number(std::size_t i) const { return given(i) ? call_.arguments[i].number : 0; }
    double length(std::size_t i) const { return number(i) * unit_mm_; }
    bool refuse(std::string text, std::string_view hint = {}) {
        return reader_.refuse("NC0605", reader_.block_.place, fmt::format("{}: {}", call_.name, text), {}, hint);
    }
    bool levels(std::size_t amode);
    bool no_more(std::size_t first);
    bool modes_at(std::size_t gmode);
    bool rapid(double level);
    bool feed(double level, std::optional<double> speed_mm_s = {});
    bool dwell(double time);
    bool spindle(std::string word) { return reader_.event(EventKind::spindle, true, std::move(word)); }
    bool direction(std::size_t at);
    bool feed_parameter(std::size_t at, double& speed_mm_s);
    bool pitch(std::size_t metric, std::size_t value, int unit, double& pitch_mm);
    bool thread_depth(double down_mm_s, double up_mm_s);

    bool drill();
    bool deep_hole();
    bool strokes(std::vector<double>& depths_mm);
    bool next_stroke(double& stroke_mm, double rest_mm, std::size_t count);
    bool rigid_tapping();
    bool floating_tapping();
    bool ream();
    bool bore();
    bool bore_with_stop(bool dwells);

    SinumerikReader& reader_;
    const Word& call_;
    double unit_mm_;
    int axis_;
    double retract_ = 0, reference_ = 0, start_ = 0, depth_ = 0, up_ = 1;  ///< RTP, RFP, RFP + SDIS, DP
};

bool DrillingCycle::run() {
    for (const Argument& argument : call_.arguments)
        if (argument.kind == Argument::Kind::name) return refuse("an argument is no number");
    if (reader_.modes_.feed_kind == Meaning::inverse_time) return refuse("under G93 it has no feed", "G94");
    switch (rule_of_name(call_.name).which) {
        case 81:
        case 82:
            return modes_at(6) && levels(8) && no_more(9) && drill();
        case 83:
            return modes_at(17) && levels(19) && no_more(20) && deep_hole();
        case 84:
            return modes_at(21) && levels(23) && no_more(24) && rigid_tapping();
        case 840:
            return levels(99) && no_more(12) && floating_tapping();
        case 85:
            return modes_at(8) && levels(10) && no_more(11) && ream();
        case 86:
            return modes_at(11) && levels(13) && no_more(14) && bore();
        case 87:
            return levels(99) && no_more(6) && bore_with_stop(false);
        case 88:
            return levels(99) && no_more(7) && bore_with_stop(true);
        default:
            break;
    }
    return modes_at(6) && levels(8) && no_more(9) && rapid(start_) && feed(depth_) && dwell(number(5)) &&
           feed(start_) && rapid(retract_);  // CYCLE89
}

/// The planes and the depth: DPR, from the reference plane, before DP. In AMODE the last digit says which: 1 DPR, 2 DP.
bool DrillingCycle::levels(std::size_t amode) {
    const int kind = digit(number(amode), 0);
    retract_ = length(0);
    reference_ = length(1);
    const double clearance = length(2);
    const bool relative = kind == 0 ? given(4) && number(4) != 0 : kind == 1;
    if (!(clearance >= 0) || number(4) < 0) return refuse("SDIS and DPR are not negative");
    if (relative ? !given(4) : !given(3)) return refuse("the depth is missing", "DP or DPR");
    if (relative && retract_ == reference_)
        return refuse("RTP and RFP are the same and the depth is relative: to which side?", "DP, or RTP elsewhere");
    up_ = relative ? (retract_ > reference_ ? 1 : -1) : (reference_ > length(3) ? 1 : -1);
    depth_ = relative ? reference_ - up_ * length(4) : length(3);
    start_ = reference_ + up_ * clearance;
    if (depth_ == reference_) return refuse("the depth is 0");
    if ((retract_ - reference_) * up_ < 0)
        return refuse(
            fmt::format("the retraction plane RTP ({:.6g} mm) lies behind the reference plane RFP ({:.6g} mm)",
                        retract_, reference_),
            "RTP on the side that the tool comes from, no nearer to the depth than RFP");
    return true;
}

bool DrillingCycle::no_more(std::size_t first) {
    for (std::size_t i = first; i < call_.arguments.size(); ++i)
        if (number(i) != 0 || !call_.arguments[i].text.empty())
            return refuse(fmt::format("argument {} is not supported", i + 1));
    return true;
}

/// GMODE, DMODE and AMODE of younger controls: only what means the same as without them.
bool DrillingCycle::modes_at(std::size_t gmode) {
    const int plane = digit(number(gmode + 1), 0);
    const double amode = number(gmode + 2);
    if (number(gmode) != 0) return refuse("_GMODE is not supported");
    if (plane != 0 && plane != 3 - axis_) return refuse("_DMODE names another plane than the one in force");
    if (digit(amode, 0) > 2 || digit(amode, 1) > 1 || std::abs(amode) >= 100) return refuse("_AMODE is not supported");
    return true;
}

bool DrillingCycle::rapid(double level) {
    Vector3d to = reader_.programmed_mm_;
    to[axis_] = level;
    return reader_.go(to, {.rapid = true});
}

bool DrillingCycle::feed(double level, std::optional<double> speed_mm_s) {
    Vector3d to = reader_.programmed_mm_;
    to[axis_] = level;
    return reader_.go(to, {.speed_mm_s = speed_mm_s});
}

/// Seconds; turns of the spindle where negative.
bool DrillingCycle::dwell(double time) {
    if (time == 0) return true;
    if (time < 0 && !(reader_.modes_.spindle_rpm > 0))
        return refuse("a dwell in turns of a spindle whose speed is not known");
    reader_.event(EventKind::dwell, true, fmt::format("{} dwell", call_.name),
                  time > 0 ? time : -time * 60 / reader_.modes_.spindle_rpm);
    return true;
}

/// M3, M4 or M5 by its number.
bool DrillingCycle::direction(std::size_t at) {
    const double number_of_m = number(at);
    if (number_of_m == 0) return true;
    if (number_of_m != 3 && number_of_m != 4 && number_of_m != 5) return refuse("a spindle direction is 3, 4 or 5");
    return spindle(fmt::format("M{}", number_of_m));
}

/// CYCLE81 and CYCLE82.
bool DrillingCycle::drill() {
    return rapid(start_) && feed(depth_) && dwell(number(5)) && rapid(retract_);
}

// ------------------------------------------------------------------------------------------------- CYCLE83: deep hole

/// Stroke by stroke; VARI 0 breaks the chip by drawing back a little, 1 brings it out.
bool DrillingCycle::deep_hole() {
    constexpr std::size_t dwell_at = 8, dwell_out_at = 9, factor_at = 10, kind_at = 11, axis_at = 12, back_at = 14,
                          last_dwell_at = 15, limit_at = 16;
    const bool brings_out = number(kind_at) == 1;
    const double factor = number(factor_at) == 0 ? 1 : number(factor_at);
    if (number(kind_at) != 0 && !brings_out) return refuse("VARI is 0 or 1");
    if (!(factor > 0 && factor <= 1)) return refuse("FRF is a share of the feed, up to 1");
    if (number(axis_at) != 0 && number(axis_at) != 3) return refuse("_AXN other than the tool's axis is not supported");
    std::vector<double> depths;
    if (!strokes(depths) || !rapid(start_)) return false;
    const double back = number(back_at) > 0 ? length(back_at) : chip_break_mm;
    const double before = number(limit_at) > 0 ? length(limit_at) : limit_distance(depths.back());
    for (std::size_t i = 0; i < depths.size(); ++i) {
        const double level = reference_ - up_ * depths[i];
        const bool last = i + 1 == depths.size();
        std::optional<double> speed;
        if (i == 0 && factor != 1) {
            double feed_in_force = 0;
            if (!reader_.path_speed(feed_in_force)) return false;
            speed = feed_in_force * factor;
        }
        if (!feed(level, speed) ||
            !dwell(last && number(last_dwell_at) != 0 ? number(last_dwell_at) : number(dwell_at)))
            return false;
        if (last) break;
        if (!brings_out && !feed(level + up_ * back)) return false;
        if (brings_out && !(rapid(start_) && dwell(number(dwell_out_at)) && rapid(level + up_ * before))) return false;
    }
    return rapid(retract_);
}

/// Depths below the reference plane at which strokes end. FDPR, or FDEP, is the first; the next are less by DAM each,
/// but not less than DAM; a rest of less than two strokes is halved.
bool DrillingCycle::strokes(std::vector<double>& depths_mm) {
    constexpr std::size_t first_level_at = 5, first_at = 6;
    const double whole = (reference_ - depth_) * up_;
    if (!given(first_at) && !given(first_level_at)) return refuse("the first depth is missing", "FDEP or FDPR");
    double stroke =
        given(first_at) && number(first_at) != 0 ? length(first_at) : (reference_ - length(first_level_at)) * up_;
    if (!(stroke > 0) || stroke > whole + same_depth_mm)
        return refuse("the first depth does not lie between the reference plane and the depth",
                      "a control stops here with alarm 61107");
    double reached = std::min(stroke, whole);
    depths_mm.push_back(reached);
    while (whole - reached > same_depth_mm) {
        if (!next_stroke(stroke, whole - reached, depths_mm.size())) return false;
        reached = std::min(reached + stroke, whole);
        if (whole - reached <= same_depth_mm) reached = whole;
        depths_mm.push_back(reached);
    }
    return true;
}

bool DrillingCycle::next_stroke(double& stroke_mm, double rest_mm, std::size_t count) {
    constexpr std::size_t decrease_at = 7, least_at = 13;
    const double decrease = number(decrease_at);
    if (decrease > 0)
        stroke_mm = std::max(stroke_mm - length(decrease_at), length(decrease_at));
    else if (decrease < 0)
        stroke_mm = std::max(stroke_mm * -decrease, length(least_at));
    if (count >= most_strokes || !(stroke_mm > 0) || decrease < -1) return refuse("DAM makes too many strokes");
    if (rest_mm > stroke_mm && rest_mm < 2 * stroke_mm) stroke_mm = rest_mm / 2;
    return true;
}

// ------------------------------------------------------------------------------------------------- tapping

bool DrillingCycle::pitch(std::size_t metric, std::size_t value, int unit, double& pitch_mm) {
    const double size = std::abs(number(metric));
    const auto* const thread = std::ranges::find(metric_threads, size, &MetricThread::diameter_mm);
    const double by_value = unit == 2 ? inch_mm / number(value)
                                      : number(value) * (unit == 3   ? inch_mm
                                                         : unit == 1 ? 1
                                                                     : unit_mm_);
    const bool has_size = size != 0, has_value = number(value) != 0;
    if (!has_size && !has_value)
        return refuse("the pitch is missing", "MPIT or PIT; a control stops here with alarm 61001");
    if (has_size && thread == std::end(metric_threads)) return refuse("MPIT is no metric thread with a coarse pitch");
    if (unit < 0 || unit > 3) return refuse("this unit of the pitch is not supported", "PIT in mm");
    if (has_size && has_value && std::abs(thread->pitch_mm - std::abs(by_value)) > same_depth_mm)
        return refuse("MPIT and PIT contradict each other");
    pitch_mm = has_value ? std::abs(by_value) : thread->pitch_mm;
    return true;
}

/// In and out at the speeds of the thread; the spindle turns back at the bottom.
bool DrillingCycle::thread_depth(double down_mm_s, double up_mm_s) {
    return rapid(start_) && feed(depth_, down_mm_s) && dwell(number(5)) && feed(start_, up_mm_s) && rapid(retract_);
}

/// CYCLE84: the spindle stands at POSS, then thread and axis go together at SST and back at SST1.
bool DrillingCycle::rigid_tapping() {
    constexpr std::size_t after_at = 6, metric_at = 7, pitch_at = 8, position_at = 9, speed_at = 10, speed_back_at = 11,
                          axis_at = 12, unit_at = 13, kind_at = 15;
    double pitch_mm = 0;
    if (number(kind_at) != 0) return refuse("VARI: tapping in several strokes is not supported");
    if (number(axis_at) != 0 && number(axis_at) != 3) return refuse("_AXN other than the tool's axis is not supported");
    for (std::size_t i = 18; i <= 20; ++i)
        if (given(i) && !call_.arguments[i].text.empty())
            return refuse("thread tables are not supported", "MPIT or PIT");
    if (!(number(speed_at) > 0) || number(speed_back_at) < 0) return refuse("the spindle's speed SST is missing");
    if (!pitch(metric_at, pitch_at, static_cast<int>(number(unit_at)), pitch_mm)) return false;
    const double down = number(speed_at) * pitch_mm / 60;
    const double up = number(speed_back_at) > 0 ? number(speed_back_at) * pitch_mm / 60 : down;
    return spindle(fmt::format("SPOS={}", number(position_at))) && thread_depth(down, up) && direction(after_at);
}

/// CYCLE840, with a floating tap holder: S and the pitch, or without a pitch F, give the speed.
bool DrillingCycle::floating_tapping() {
    constexpr std::size_t back_at = 6, after_at = 7, encoder_at = 8, metric_at = 9, pitch_at = 10, axis_at = 11;
    if (number(axis_at) != 0 && number(axis_at) != 3) return refuse("_AXN other than the tool's axis is not supported");
    if (number(encoder_at) != 0 && number(encoder_at) != 1) return refuse("ENC is 0 or 1");
    double speed = 0, pitch_mm = 0;
    if (number(encoder_at) == 1 && number(metric_at) == 0 && number(pitch_at) == 0) {
        if (!reader_.path_speed(speed)) return false;
    } else {
        if (!pitch(metric_at, pitch_at, 0, pitch_mm)) return false;
        if (!(reader_.modes_.spindle_rpm > 0)) return refuse("the spindle's speed is not known", "S before it");
        speed = reader_.modes_.spindle_rpm * pitch_mm / 60;
    }
    return rapid(start_) && feed(depth_, speed) && dwell(number(5)) && direction(back_at) && feed(start_, speed) &&
           rapid(retract_) && (number(back_at) == 0 || direction(after_at));
}

// ------------------------------------------------------------------------------------------------- boring

bool DrillingCycle::feed_parameter(std::size_t at, double& speed_mm_s) {
    if (!(number(at) > 0)) return refuse("a feed is missing", "FFR and RFF");
    speed_mm_s = number(at) * reader_.modes_.feed_unit_mm / 60;
    if (reader_.modes_.feed_kind == Meaning::per_revolution) speed_mm_s *= reader_.modes_.spindle_rpm;
    return std::isfinite(speed_mm_s) || refuse("the spindle's speed is not known", "S before it");
}

/// CYCLE85: in with FFR, out with RFF.
bool DrillingCycle::ream() {
    double in = 0, out = 0;
    return feed_parameter(6, in) && feed_parameter(7, out) && rapid(start_) && feed(depth_, in) && dwell(number(5)) &&
           feed(start_, out) && rapid(retract_);
}

/// CYCLE86: at the depth the spindle stops at POSS and the tool lifts off by RPA, RPO, RPAP; up, then back over the
/// hole.
bool DrillingCycle::bore() {
    constexpr std::size_t direction_at = 6, first_at = 7, second_at = 8, along_at = 9, position_at = 10;
    if (!direction(direction_at) || !rapid(start_) || !feed(depth_) || !dwell(number(5))) return false;
    spindle(fmt::format("SPOS={}", number(position_at)));
    const Vector3d hole = reader_.programmed_mm_;
    Vector3d off = hole;
    off[(axis_ + 1) % 3] += length(first_at);
    off[(axis_ + 2) % 3] += length(second_at);
    off[axis_] += length(along_at);
    if ((length(first_at) != 0 && std::isnan(off[(axis_ + 1) % 3])) ||
        (length(second_at) != 0 && std::isnan(off[(axis_ + 2) % 3])))
        return refuse("it lifts off from a position that is not known", "say X, Y and Z before it");
    if (!reader_.go(off, {.rapid = true}) || !rapid(start_)) return false;
    Vector3d above = hole;
    above[axis_] = retract_;
    return reader_.go(above, {.rapid = true});
}

/// CYCLE87 and, with a dwell, CYCLE88: at the depth the spindle stops and the program waits for the operator.
bool DrillingCycle::bore_with_stop(bool dwells) {
    if (!direction(dwells ? 6 : 5) || !rapid(start_) || !feed(depth_) || (dwells && !dwell(number(5)))) return false;
    spindle("M5");
    reader_.event(EventKind::stop, true, "M0");
    return rapid(retract_);
}

// ------------------------------------------------------------------------------------------------- calls

bool SinumerikReader::call(const Word& word) {
    switch (rule_of_name(word.name).meaning) {
        case Meaning::swivel:
            return swivel(word);
        case Meaning::pattern:
            return pattern(word);
        default:
            return run_cycle(word);
    }
}

/// MCALL with a cycle: after each block with axis words from here on; alone: no longer.
bool SinumerikReader::modal_call() {
    modal_cycle_.reset();
    if (!call_) return true;
    if (rule_of_name(call_->name).meaning != Meaning::drilling)
        return refuse("NC0628", *call_, "only drilling cycles can be called by MCALL");
    modal_cycle_ = *call_;
    modal_cycle_->name = modal_cycle_name_ = call_->name;  // its own would go with the line
    return true;
}

bool SinumerikReader::run_cycle(const Word& cycle) {
    axis_words_ever_ = true;
    last_motion_ = block_.place;
    if (counted_in_.space == program::Space::machine && call_ == nullptr)
        return refuse("NC0605", block_.place, "a drilling cycle at a place in machine coordinates");
    return count_in(false) && DrillingCycle(*this, cycle).run();
}

/// HOLES1(SPCA, SPCO, STA1, FDIS, DBH, NUM): a row, begun at the nearer end. HOLES2(CPA, CPO, RAD, STA1, INDA, NUM): a
/// circle. Rapids to each hole, and the modal cycle there.
bool SinumerikReader::pattern(const Word& word) {
    std::array<double, 6> p{};
    for (std::size_t i = 0; i < word.arguments.size(); ++i) {
        const Argument& argument = word.arguments[i];
        if (argument.kind == Argument::Kind::empty || (argument.number == 0 && argument.text.empty())) continue;
        if (i >= p.size() || argument.kind != Argument::Kind::number)
            return refuse("NC0605", word, fmt::format("argument {} is not supported", i + 1));
        p[i] = argument.number;
    }
    const int holes = static_cast<int>(std::clamp(p[5], 0.0, 1e6));
    if (holes < 1 || holes != p[5]) return refuse("NC0605", word, "the number of holes is a whole number above 0");
    if (!count_in(false)) return false;
    const int first = (modes_.normal_axis + 1) % 3, second = (modes_.normal_axis + 2) % 3;
    const bool row = rule_of_name(word.name).which == 1;
    const Eigen::Vector2d centre = Eigen::Vector2d(p[0], p[1]) * modes_.unit_mm;
    const auto place = [&](int i) -> Eigen::Vector2d {
        const double step = p[4] != 0 ? p[4] : 360.0 / holes;
        const double angle = (row ? p[2] : p[3] + i * step) * degree;
        const double radius = (row ? p[3] + i * p[4] : p[2]) * modes_.unit_mm;
        return centre + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    };
    const Eigen::Vector2d here(programmed_mm_[first], programmed_mm_[second]);
    const bool backwards = row && (place(holes - 1) - here).norm() < (place(0) - here).norm();
    axis_words_ever_ = true;
    for (int i = 0; i < holes; ++i) {
        const Eigen::Vector2d at = place(backwards ? holes - 1 - i : i);
        Vector3d to = programmed_mm_;
        to[first] = at.x();
        to[second] = at.y();
        if (!go(to, {.rapid = true})) return false;
        if (modal_cycle_ && !DrillingCycle(*this, *modal_cycle_).run()) return false;
    }
    return true;
}

}  // namespace trunnion::nc::sinumerik
