#include "detail/g_code_writer.hpp"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <fmt/format.h>

namespace trunnion::nc {

using Eigen::Vector3d;

namespace {

constexpr std::string_view linear_letters[] = {"X", "Y", "Z"}, centre_letters[] = {"I", "J", "K"};
constexpr double whole_turn = 2 * std::numbers::pi;

}  // namespace

void GCodeWriter::begin_block() {
    if (!options_.block_numbers) return;
    out_.put('N');
    out_.integer(number_ += 10);
}

void GCodeWriter::line(std::string_view word) {
    begin_block();
    out_.gap();
    out_.put(word);
    out_.end_line();
}

void GCodeWriter::word(std::string_view address, const DecimalGrid& grid, std::int64_t steps) {
    out_.gap();
    out_.put(address);
    if (address.size() > 1) out_.put('=');
    out_.number(grid, steps, habits_.numbers);
}

void GCodeWriter::comment(std::string_view text) {
    out_.put(habits_.comment_begin);
    out_.put(' ');
    for (const char c : text) {
        const bool plain = c >= ' ' && c <= '~';
        const bool bracket = habits_.comment_end != 0 && (c == '(' || c == ')');
        out_.put(!plain ? '?' : bracket ? (c == '(' ? '[' : ']') : c);
    }
    if (habits_.comment_end != 0) out_.put(habits_.comment_end);
    out_.end_line();
}

void GCodeWriter::head_comments() {
    for (const std::string& text : options_.head) comment(text);
}

// ------------------------------------------------------------------------------------------------------------ motion

void GCodeWriter::motion_word(int code) {
    if (code == motion_) return;
    motion_ = code;
    out_.gap();
    out_.put('G');
    out_.integer(code);
}

void GCodeWriter::linear_words() {
    for (std::size_t i = 0; i < 3; ++i)
        if (says_linear(i)) word(linear_letters[i], linear_grid_, goal_.linear[i]);
}

void GCodeWriter::rotary_words() {
    for (std::size_t i = 0; i < program_.rotary_letters.size(); ++i)
        if (says_rotary(i)) word({&program_.rotary_letters[i], 1}, rotary_grid_, goal_.rotary[i]);
}

void GCodeWriter::orientation_words(const Move& to) {
    if (to.law == program::OrientationLaw::rotary) return rotary_words();
    if (turns_vector()) vector_words();
}

/// F where it changes; with G93 in every block.
void GCodeWriter::feed_words(const Move& to, bool on_arc) {
    put_feed(feed_word(to, on_arc, true, habits_.turn_mm));
}

void GCodeWriter::put_feed(const FeedWord& feed) {
    if (feed.kind == FeedWord::Kind::none) return;
    const bool inverse = feed.kind == FeedWord::Kind::inverse_time;
    if (!inverse && !inverse_time_ && feed.number == feed_) return;
    if (inverse != inverse_time_) {
        out_.gap();
        out_.put(inverse ? "G93" : "G94");
    }
    inverse_time_ = inverse;
    feed_ = feed.number;
    out_.gap();
    out_.put('F');
    out_.number_within(feed.number, options_.feed_precision, habits_.numbers);
}

bool GCodeWriter::straight(const Move& to) {
    begin_block();
    words_before_motion(to);
    motion_word(to.kind == program::MoveKind::rapid ? 0 : 1);
    linear_words();
    orientation_words(to);
    following_words();
    feed_words(to, false);
    out_.end_line();
    arrive(to);
    return true;
}

void GCodeWriter::set_plane(int normal_axis) {
    if (normal_axis == plane_) return;
    plane_ = normal_axis;
    out_.gap();
    out_.put('G');
    out_.integer(19 - normal_axis);
}

int GCodeWriter::plane_of(const program::Arc& arc) {
    constexpr double parallel = 1e-9;
    for (int i = 0; i < 3; ++i)
        if (std::abs(std::abs(arc.normal[i]) - 1) < parallel) return i;
    return -1;
}

int GCodeWriter::turns_to_say(const program::Arc& arc, const Vector3d& normal, const Vector3d& centre_mm,
                              const Vector3d& start_mm, const Vector3d& end_mm) const {
    const double angle = arc.angle_rad * (normal.dot(arc.normal) < 0 ? -1 : 1);
    const auto read = arc_by_centre(start_mm, end_mm, centre_mm, normal, angle < 0, 0, habits_.arcs);
    if (!read) return -1;
    const double turns = std::round((std::abs(angle) - std::abs(read->angle_rad)) / whole_turn);
    const double radius = (start_mm - centre_mm).cross(normal).norm();
    const double left_over = std::abs(angle) - std::abs(read->angle_rad) - whole_turn * turns;
    const bool same = std::abs(left_over) * radius <= 4 * options_.precision_mm;
    return same && turns >= 0 && turns <= 1000 ? static_cast<int>(turns) : -1;
}

bool GCodeWriter::arc(const Move& to) {
    const program::Arc& arc = program_.arcs[static_cast<std::size_t>(to.arc)];
    const int along = plane_of(arc);
    if (along < 0 || to.space == program::Space::machine || to.kind == program::MoveKind::rapid) return false;
    const Vector3d normal = Vector3d::Unit(along);
    Vector3d start = said_mm(), end = goal_mm();
    if (std::isnan(start[along]) || std::isnan(end[along])) start[along] = end[along] = 0;
    if ((start + end).hasNaN()) return false;
    const DecimalGrid grid = DecimalGrid::within(options_.precision_mm * finer_share / unit_mm());
    std::array<std::int64_t, 3> way{};
    Vector3d centre = start;
    for (int i = 0; i < 3; ++i) {
        if (i == along) continue;
        const double distance = (arc.centre_mm[i] - start[i]) / unit_mm();
        if (!grid.holds(distance)) return false;
        way[static_cast<std::size_t>(i)] = grid.steps(distance);
        centre[i] += grid.value(way[static_cast<std::size_t>(i)]) * unit_mm();
    }
    const int turns = turns_to_say(arc, normal, centre, start, end);
    if (turns < 0 || (turns > 0 && !takes_turns())) return false;
    begin_block();
    words_before_motion(to);
    set_plane(along);
    motion_word((arc.angle_rad < 0) != (arc.normal[along] < 0) ? 2 : 3);
    linear_words();
    orientation_words(to);
    for (std::size_t i = 0; i < 3; ++i)
        if (static_cast<int>(i) != along) word(centre_letters[i], grid, way[i]);
    if (turns > 0) turn_words(turns);
    following_words();
    feed_words(to, true);
    out_.end_line();
    arrive(to);
    return true;
}

// ------------------------------------------------------------------------------------------------------------ events

std::string_view GCodeWriter::word_of(Action::Kind kind) const {
    using Kind = Action::Kind;
    switch (kind) {
        case Kind::spindle_clockwise:
            return "M3";
        case Kind::spindle_counter_clockwise:
            return "M4";
        case Kind::spindle_off:
            return "M5";
        case Kind::mist:
            return "M7";
        case Kind::flood:
            return "M8";
        case Kind::coolant_off:
            return "M9";
        case Kind::pause:
            return "M0";
        case Kind::optional_pause:
            return "M1";
        case Kind::end:
            return "M30";
        default:
            return {};
    }
}

bool GCodeWriter::action(const Action& action, const program::Event& event) {
    using Kind = Action::Kind;
    switch (action.kind) {
        case Kind::dwell:
            dwell(action.number);
            return true;
        case Kind::spindle_speed:
            line(fmt::format("S{}", action.number));
            return true;
        case Kind::prepare_tool:
            return prepare_tool(action.name);
        case Kind::change_tool:
            return change_tool(action.name);
        case Kind::end:
            line(event.word == "M2" ? "M2" : word_of(Kind::end));
            return true;
        default:
            line(word_of(action.kind));
            return true;
    }
}

bool GCodeWriter::own_word(const program::Event& event) {
    line(event.word);
    return true;
}

}  // namespace trunnion::nc
