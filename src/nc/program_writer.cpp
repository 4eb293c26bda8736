#include "detail/program_writer.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "trunnion/base/quantity.hpp"
#include "trunnion/geometry/great_circle.hpp"
#include "trunnion/geometry/helix.hpp"
#include "trunnion/nc/following.hpp"

#include "detail/curves.hpp"

namespace trunnion::nc {

using Eigen::Vector3d;
using program::FeedRule;
using program::Move;
using program::MoveKind;
using program::OrientationLaw;

namespace {

constexpr int most_parts = 100'000;  ///< of one move that is divided

std::int64_t steps_or_unsaid(const DecimalGrid& grid, double value) {
    return std::isnan(value) ? unsaid : grid.steps(value);
}

geometry::Helix helix_of(const program::Program& program, const Move& from, const Move& to) {
    const program::Arc& arc = program.arcs[static_cast<std::size_t>(to.arc)];
    return {from.position_mm, to.position_mm, arc.centre_mm, arc.normal, arc.angle_rad};
}

/// Into how many equal shares of its parameter a curve is cut so that its chords keep that error, by the chords of
/// half of them.
int parts_of_curve(const program::Curve& curve, const program::CurvePart& part, double error_mm) {
    const double length = part.to_u - part.from_u;
    for (int parts = 1; parts < most_parts; parts *= 2) {
        double worst = 0;
        for (int k = 0; k < parts; ++k) {
            const auto at = [&](double share) {
                return pose_at(curve, part.from_u + length * (k + share) / parts).position_mm;
            };
            const Vector3d begin = at(0), end = at(1);
            for (const double share : {0.25, 0.5, 0.75})
                worst = std::max(worst, (at(share) - (begin + share * (end - begin))).norm());
        }
        if (worst <= error_mm) return parts;
    }
    return most_parts;
}

/// At the ends of equal parts of a curve's parameter: the share of its way till there, by chords.
std::vector<double> shares_of_way(const program::Curve& curve, const program::CurvePart& part, int parts) {
    std::vector<double> out{0};
    Vector3d at = pose_at(curve, part.from_u).position_mm;
    for (int k = 1; k <= parts; ++k) {
        const Vector3d next = pose_at(curve, part.from_u + (part.to_u - part.from_u) * k / parts).position_mm;
        out.push_back(out.back() + (next - at).norm());
        at = next;
    }
    const double way = out.back();
    for (double& share : out) share = way > 0 ? share / way : 1;
    return out;
}

}  // namespace

ProgramWriter::ProgramWriter(const program::Program& program, const machine::Machine* machine,
                             const WriteOptions& options, const TextSink& sink)
    : program_(program),
      machine_(machine),
      options_(options),
      out_(sink),
      findings_(program.source),
      following_mm_(program.following_letters.size(), 0),
      followed_mm_(following_mm_),
      unit_mm_(options.units == Units::inch ? inch_mm : 1) {
    linear_grid_ = DecimalGrid::within(options.precision_mm / unit_mm_);
    rotary_grid_ = DecimalGrid::within(options.precision_deg);
    vector_grid_ = DecimalGrid::within(options.vector_precision);
    following_grid_ = DecimalGrid::within(options.precision_mm * finer_share / unit_mm_);
}

Result<WriteSummary> ProgramWriter::write() {
    if (!program_.following_letters.empty() && !takes_following()) {
        const std::string letters(program_.following_letters.begin(), program_.following_letters.end());
        refuse("NC0920", "axes that go along with the path, and this dialect has none", letters, "rs274 has them");
        return fail(findings_.take_error());
    }
    head();
    if (!everything()) return fail(findings_.take_error());
    tail();
    out_.flush();
    return WriteSummary{program_.moves.size(), out_.lines(), findings_.take_notices()};
}

bool ProgramWriter::everything() {
    for (std::size_t k = 0; k < program_.moves.size(); ++k)
        if (!events_before(k) || !write_move(k)) return false;
    return events_before(program_.moves.size());
}

bool ProgramWriter::events_before(std::size_t move) {
    const auto& controls = program_.path_controls;
    for (; event_ < program_.events.size() && program_.events[event_].before_move <= move; ++event_)
        if (!write_event(program_.events[event_])) return false;
    for (; path_control_ < controls.size() && controls[path_control_].before_move <= move; ++path_control_)
        if (!ended_) path_control(controls[path_control_]);
    return true;
}

bool ProgramWriter::write_event(const program::Event& event) {
    line_ = event.line;
    if (add_following_travel(program_, event, following_mm_)) {
        if (!holds_following()) return false;
        followed_mm_ = following_mm_;
    }
    if (takes_following() && following_event(event)) return true;
    const auto actions = actions_of(event);
    ended_ = ended_ || actions.front().kind == Action::Kind::end;
    const Action::Kind first = actions.front().kind;
    const bool counts = first == Action::Kind::dwell || first == Action::Kind::prepare_tool ||
                        first == Action::Kind::change_tool || first == Action::Kind::end;
    if (!counts && is_own(name_of(options_.dialect)) && own_word(event)) return true;
    for (const Action& what : actions) {
        if (what.kind != Action::Kind::unknown && action(what, event)) continue;
        comment(event.word);
        tell("NC0911", event.word, "no word for this event: it is a comment", "put in what the control needs");
    }
    return true;
}

bool ProgramWriter::write_move(std::size_t index) {
    const Move& to = program_.moves[index];
    line_ = to.line;
    index_ = index;
    if (index < curve_end_) return true;
    if (!enter(to)) return false;
    if (!follow(1) || !write_whole(to)) return false;
    followed_mm_ = following_mm_;
    return true;
}

bool ProgramWriter::follow(double share) {
    for (std::size_t i = 0; i < following_mm_.size(); ++i) {
        const double end_mm = following_at_end(program_, index_, i);
        following_mm_[i] = share < 1 ? followed_mm_[i] + share * (end_mm - followed_mm_[i]) : end_mm;
    }
    return holds_following();
}

bool ProgramWriter::holds_following() {
    for (const double at_mm : following_mm_)
        if (!following_grid_.holds(at_mm / unit_mm_))
            return refuse("NC0904", "a following axis too far away for the precision that is asked", {},
                          "ask for less digits");
    return true;
}

bool ProgramWriter::write_whole(const Move& to) {
    const std::size_t index = index_;
    if (index == 0) {
        Move start = to;
        start.kind = MoveKind::rapid;
        return aim(start) && (!moves_at_all() || straight(start));
    }
    const Move& from = program_.moves[index - 1];
    if (to.curve_part != program::no_curve_part) {
        const std::size_t written = curve(index);
        if (written == 0) return divide(from, to);
        curve_end_ = index + written;
        return true;
    }
    if (to.arc == program::no_arc) return write_straight(to);
    if (!aim(to)) return false;
    if (arc(to)) return true;
    return divide(from, to);
}

/// What moves less than the text can say is left out.
bool ProgramWriter::write_straight(const Move& to) {
    return aim(to) && (!moves_at_all() || straight(to));
}

bool ProgramWriter::aim(const Move& to) {
    const auto too_large = [&] {
        return refuse("NC0904", "a coordinate too large for the precision that is asked", {}, "ask for less digits");
    };
    for (std::size_t i = 0; i < 3; ++i) {
        const double linear = to.position_mm[static_cast<Eigen::Index>(i)] / unit_mm_;
        const double rotary = to.rotary_rad[i] / degree;
        if (std::isinf(linear) || std::isinf(rotary) || !(std::isnan(linear) || linear_grid_.holds(linear)))
            return too_large();
        goal_.linear[i] = steps_or_unsaid(linear_grid_, linear);
        const bool by_word = to.law == OrientationLaw::rotary && i < program_.rotary_letters.size();
        if (by_word && !std::isnan(rotary) && !rotary_grid_.holds(rotary)) return too_large();
        goal_.rotary[i] = by_word ? steps_or_unsaid(rotary_grid_, rotary) : unsaid;
    }
    goal_.axis.fill(unsaid);
    if (to.law != OrientationLaw::vector) return true;
    for (std::size_t i = 0; i < 3; ++i) goal_.axis[i] = vector_grid_.steps(to.axis[static_cast<Eigen::Index>(i)]);
    return true;
}

void ProgramWriter::arrive(const Move& to) {
    last_ = to;
    for (std::size_t i = 0; i < 3; ++i) {
        if (goal_.linear[i] != unsaid) said_.linear[i] = goal_.linear[i];
        if (goal_.rotary[i] != unsaid) said_.rotary[i] = goal_.rotary[i];
    }
    if (goal_.axis[0] != unsaid) {
        said_.axis = goal_.axis;
        forget_rotary();  // behind a vector nobody knows where the rotary axes stand
    } else if (turns_words()) {
        forget_axis();
    }
}

Vector3d ProgramWriter::said_mm() const {
    Vector3d out;
    for (std::size_t i = 0; i < 3; ++i)
        out[static_cast<Eigen::Index>(i)] = said_.linear[i] == unsaid ? std::numeric_limits<double>::quiet_NaN()
                                                                      : linear_grid_.value(said_.linear[i]) * unit_mm_;
    return out;
}

Vector3d ProgramWriter::goal_mm() const {
    Vector3d out = said_mm();
    for (std::size_t i = 0; i < 3; ++i)
        if (goal_.linear[i] != unsaid)
            out[static_cast<Eigen::Index>(i)] = linear_grid_.value(goal_.linear[i]) * unit_mm_;
    return out;
}

// ------------------------------------------------------------------------------------------------------------ feeds

std::optional<double> ProgramWriter::length_mm(const Move& to) const {
    const bool same_frame = last_.space == to.space && last_.offset == to.offset && last_.tool == to.tool;
    const double length = to.arc == program::no_arc ? (to.position_mm - last_.position_mm).norm()
                                                    : helix_of(program_, last_, to).length();
    if (!same_frame || std::isnan(length)) return {};
    return length;
}

/// How far the move turns as its feed rule counts it.
std::optional<double> ProgramWriter::turn_rad(const Move& to) const {
    if (last_.law != to.law) return {};
    if (to.law == OrientationLaw::vector) return geometry::angle_between(last_.axis, to.axis);
    double squares = 0;
    for (std::size_t i = 0; i < program_.rotary_letters.size(); ++i) {
        const double turn = to.rotary_rad[i] - last_.rotary_rad[i];
        if (!std::isnan(turn)) squares += turn * turn;
        if (std::isnan(last_.rotary_rad[i]) && !std::isnan(to.rotary_rad[i])) return {};
    }
    return std::sqrt(squares);
}

ProgramWriter::FeedWord ProgramWriter::feed_word(const Move& to, bool on_arc, bool has_inverse_time, double turn_mm) {
    using Kind = FeedWord::Kind;
    const double value = to.feed.value;
    if (to.kind == MoveKind::rapid || to.feed.rule == FeedRule::none || !(value > 0)) return {};
    const bool turns_only = !on_arc && !goes();
    switch (to.feed.rule) {
        case FeedRule::block_time:
            return as_speed_or_time(to, value, turns_only, has_inverse_time, turn_mm);
        case FeedRule::rotary_rate:
            if (const auto turn = turn_rad(to); turn && (!turns_only || options_.inverse_time))
                return as_speed_or_time(to, *turn / value, turns_only, has_inverse_time, turn_mm);
            if (turn_mm > 0) return {Kind::per_minute, value * turn_mm * 60 / unit_mm_};
            if (turn_mm < 0) {
                tell("NC0912", "F", "the feed of a move that only turns counts for nothing here: left out");
                return {};
            }
            return {Kind::per_minute, value / degree * 60};
        default:
            break;
    }
    if (turns_only && turn_mm >= 0) {
        tell("NC0912", "F", "the feed of a move that only turns counted for nothing: here 1 mm/min becomes 1 deg/min");
        return {Kind::per_minute, turn_mm > 0 ? value * 60 / unit_mm_ : value * 60};
    }
    if (const auto length = length_mm(to); options_.inverse_time && has_inverse_time && length)
        return {Kind::inverse_time, 60 * value / *length};
    return {Kind::per_minute, value * 60 / unit_mm_};
}

ProgramWriter::FeedWord ProgramWriter::as_speed_or_time(const Move& to, double time_s, bool turns_only,
                                                        bool has_inverse_time, double turn_mm) {
    using Kind = FeedWord::Kind;
    if (has_inverse_time) return {Kind::inverse_time, 60 / time_s};
    const auto way = turns_only ? turn_rad(to) : length_mm(to);
    tell("NC0913", "F", "the time of a block becomes a speed: the dialect has no G93");
    if (!way || !(*way > 0)) return {};
    if (!turns_only) return {Kind::per_minute, *way / time_s * 60 / unit_mm_};
    return {Kind::per_minute, turn_mm > 0 ? *way / time_s * turn_mm * 60 / unit_mm_ : *way / time_s / degree * 60};
}

// --------------------------------------------------------------------------------------------------------- division

bool ProgramWriter::goes_the_same_way(const program::Arc& read, const Move& to) const {
    const Move& from = program_.moves[index_ - 1];
    if ((from.position_mm + to.position_mm).hasNaN()) return true;
    const geometry::Helix written(said_mm(), goal_mm(), read.centre_mm, read.normal, read.angle_rad);
    const geometry::Helix programmed = helix_of(program_, from, to);
    for (const double share : {0.25, 0.5, 0.75})
        if (!((written.at(share) - programmed.at(share)).norm() <= 4 * options_.precision_mm)) return false;
    return true;
}

bool ProgramWriter::divide(const Move& from, const Move& to) {
    const bool by_curve = to.curve_part != program::no_curve_part;
    if ((from.position_mm + to.position_mm).hasNaN())
        return refuse("NC0907", "an arc from a place that the program does not say", {},
                      "say its coordinates in a straight move before it");
    const program::CurvePart part =
        by_curve ? program_.curve_parts[static_cast<std::size_t>(to.curve_part)] : program::CurvePart{};
    const program::Curve* const curve = by_curve ? &program_.curves[static_cast<std::size_t>(part.curve)] : nullptr;
    std::optional<geometry::Helix> helix;
    if (!by_curve) helix = helix_of(program_, from, to);
    int parts = 1;
    if (by_curve)
        parts = parts_of_curve(*curve, part, options_.precision_mm);
    else
        while (parts < most_parts && helix->chord_error(parts) > options_.precision_mm) parts += 1 + parts / 8;
    if (parts > 1) tell("NC0910", by_curve ? "curve" : "arc", "written as straight moves within the precision");
    std::vector<double> following_shares;
    if (by_curve && !following_mm_.empty()) following_shares = shares_of_way(*curve, part, parts);
    const bool by_vector = to.law == OrientationLaw::vector;
    const geometry::GreatCircle turn(by_vector ? from.axis : to.axis, to.axis);
    for (int k = 1; k <= parts; ++k) {
        Move piece = to;
        const double share = static_cast<double>(k) / parts;
        if (to.feed.rule == FeedRule::block_time) piece.feed.value /= parts;
        if (k < parts) {
            piece.exact_stop = false;
            for (std::size_t i = 0; i < piece.rotary_rad.size(); ++i)
                if (!std::isnan(from.rotary_rad[i]))
                    piece.rotary_rad[i] = from.rotary_rad[i] + share * (to.rotary_rad[i] - from.rotary_rad[i]);
            piece.axis = turn.at(share);
            piece.position_mm = by_curve ? Vector3d::Zero() : helix->at(share);
        }
        if (by_curve) {
            const CurvePose place = pose_at(*curve, part.from_u + share * (part.to_u - part.from_u));
            piece.position_mm = place.position_mm;
            if (!curve->axis.empty()) piece.axis = place.axis.normalized();
            if (!curve->rotary_rad.empty()) piece.rotary_rad = place.rotary_rad;
        }
        piece.arc = program::no_arc;
        piece.curve_part = program::no_curve_part;
        const double gone = following_shares.empty() ? share : following_shares[static_cast<std::size_t>(k)];
        if (!follow(gone) || !write_straight(piece)) return false;
    }
    return true;
}

}  // namespace trunnion::nc
