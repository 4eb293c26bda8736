#include <algorithm>

#include "detail/rs274_reader.hpp"

namespace trunnion::nc {

using program::FeedRule;
using program::Move;
using program::Space;

namespace {

constexpr double still_mm = 1e-7;  ///< linear words that change less make a block a pure rotation, as on LinuxCNC

bool same(double a, double b) {
    return a == b || (std::isnan(a) && std::isnan(b));
}

Frame frame_of(const Move& move) {
    if (move.space == Space::machine) return {Space::machine};
    return {move.space, move.offset, move.tool};
}

bool same_place(const Move& a, const Move& b) {
    if (frame_of(a) != frame_of(b)) return false;
    for (int i = 0; i < 3; ++i)
        if (!same(a.position_mm[i], b.position_mm[i])) return false;
    for (std::size_t i = 0; i < a.rotary_rad.size(); ++i)
        if (!same(a.rotary_rad[i], b.rotary_rad[i])) return false;
    return true;
}

}  // namespace

Meaning Rs274Reader::motion_in_force() const {
    const Meaning asked = request_.of(Group::motion);
    return asked != Meaning::unknown ? asked : modal_.motion;
}

/// A block without axis words is a whole turn where it says the centre.
bool Rs274Reader::moves_on_arc() const {
    constexpr std::uint32_t centre = Block::bit('I') | Block::bit('J') | Block::bit('K');
    return is_arc(motion_in_force()) &&
           (axes_ != 0 || (block_.present & centre) != 0 || is_arc(request_.of(Group::motion)));
}

bool Rs274Reader::motion() {
    if (request_.takes_axes) return true;
    if (follows_ == 0) return move_along_path();
    const std::size_t moves = program_.moves.size();
    if (!follow_words() || !move_along_path()) return false;
    const bool left_out = moves == 0 && axes_ != 0;
    return left_out || program_.moves.size() > moves || stand_while_following();
}

bool Rs274Reader::move_along_path() {
    if (request_.asks(Group::motion, Meaning::surface_machining)) return machine_surface();
    const bool on_arc = moves_on_arc();
    const bool own_block = request_.of(Group::motion) >= Meaning::cubic_curve;
    if (axes_ == 0 && !on_arc && !own_block && !nurbs_) return true;
    if (modal_.motion >= Meaning::cubic_curve) {
        if (is_curve(modal_.motion)) return curve();
        if (modal_.motion == Meaning::cycle) return cycle();
        if (axes_ == 0) return true;
        return refuse("NC0308", spot_of_motion(), "an axis word, but no motion is in force", {}, "G0 or G1 before it");
    }
    return move_to_target(on_arc);
}

bool Rs274Reader::move_to_target(bool on_arc) {
    const bool machine_position = request_.asks(Group::once, Meaning::machine_position);
    if (machine_position && !modal_.absolute)
        return refuse("NC0315", spot_of(Group::once), "G53 needs G90", "G91 is in force");
    enter(machine_position ? Frame{Space::machine} : frame_in_force());
    const Eigen::Vector3d start_mm = position_mm_;
    if (!target()) return false;
    Move move = move_here();
    if (modal_.motion == Meaning::rapid) move.kind = program::MoveKind::rapid;
    return feed_of(move) && (!on_arc || arc_from(start_mm, move)) && add(move);
}

Frame Rs274Reader::frame_in_force() const {
    return {modal_.tcp ? Space::workpiece : Space::untransformed, modal_.offset,
            modal_.length_tool.value_or(modal_.tool)};
}

/// A cutting move of this block to where position_mm_ and rotary_rad_ are.
Move Rs274Reader::move_here() const {
    const std::uint16_t tool = modal_.length_tool.value_or(modal_.tool);
    Move move;
    move.position_mm = position_mm_;
    move.rotary_rad = rotary_rad_;
    move.space = frame_.space;
    move.law = program::OrientationLaw::rotary;
    move.exact_stop = modal_.exact_stop;
    move.tool = frame_.space == Space::machine && program_.tools[tool].ends_with(" D0") ? modal_.tool : tool;
    move.offset = frame_.offset;
    move.line = block_.program_line;
    return move;
}

/// Where coordinates count in another frame the axes stand as they do, but none of the coordinates is known.
void Rs274Reader::enter(const Frame& frame) {
    if (frame == frame_) return;
    position_mm_.setConstant(unknown_word);
    end_tangent_mm_.reset();
    cycle_level_mm_.reset();
    frame_ = frame;
    use_shift();
}

/// Where the block goes: position_mm_ and rotary_rad_ from its words.
bool Rs274Reader::target() {
    for (std::uint32_t letters = axes_; letters != 0; letters &= letters - 1)
        if (!axis_word(static_cast<char>('A' + std::countr_zero(letters)))) return false;
    return true;
}

bool Rs274Reader::axis_word(char letter) {
    const std::size_t index = Block::index(letter);
    const bool linear = control_.kind(index) == Control::Letter::linear;
    const std::size_t axis = control_.axis(index);
    double& coordinate = linear ? position_mm_[static_cast<Eigen::Index>(axis)] : rotary_rad_[axis];
    const double way = block_.value[index] * (linear ? modal_.unit_mm : degree);
    if (!modal_.absolute && std::isnan(coordinate))
        return refuse("NC0309", block_.spot(letter), "an incremental word from a position that is not known",
                      {&letter, 1}, "say the position once in G90");
    if (!linear && !program_.surface_jobs.empty() && !is_said(axis))
        return refuse("NC0067", block_.spot(letter), "a rotary axis is first said behind a surface", {&letter, 1},
                      "say every rotary axis that the program uses before the first G324");
    const double shift = linear ? word_shift_.mm[static_cast<Eigen::Index>(axis)] : word_shift_.rad[axis];
    coordinate = modal_.absolute ? way + shift : coordinate + way;
    if (!std::isfinite(coordinate))
        return refuse("NC0201", block_.spot(letter), "the position is not finite", {&letter, 1});
    return true;
}

/// Whether no linear axis is asked to move. A coordinate that is unknown stays where it stands.
bool Rs274Reader::turns_only(const Move& move) const {
    if (program_.moves.empty() || moves_on_arc() || move.curve_part != program::no_curve_part) return false;
    const Move& last = program_.moves.back();
    const bool same_frame = frame_of(last) == frame_of(move);
    for (int i = 0; i < 3; ++i) {
        if (std::isnan(move.position_mm[i])) continue;
        if (!same_frame || !(std::abs(move.position_mm[i] - last.position_mm[i]) <= still_mm)) return false;
    }
    return true;
}

bool Rs274Reader::has_feed() {
    if (modal_.feed_per_s != 0 || options_.feed_given_elsewhere) return true;
    if (modal_.feed_mode == FeedMode::per_turn && modal_.feed_per_turn > 0)
        return refuse("NC0348", spot_of_motion(), "G95 needs the speed of the spindle", {}, "S before it");
    if (modal_.feed_mode == FeedMode::inverse_time)
        return refuse("NC0310", spot_of_motion(), "G93 needs F in every block with G1", {}, "--feed gives one instead");
    return refuse("NC0205", spot_of_motion(), "a cutting move without a feed", {}, "--feed gives one, or F before it");
}

bool Rs274Reader::feed_of(Move& move) {
    if (move.kind == program::MoveKind::rapid) return true;
    if (!has_feed()) return false;
    if (modal_.feed_mode == FeedMode::inverse_time && modal_.feed_per_s > 0)
        move.feed = {FeedRule::block_time, 1 / modal_.feed_per_s};
    else if (turns_only(move))
        move.feed = {FeedRule::rotary_rate, modal_.feed_per_s * degree};
    else
        move.feed = {FeedRule::tip_speed, modal_.feed_per_s * modal_.feed_unit_mm};
    return true;
}

bool Rs274Reader::add(Move& move) {
    auto& moves = program_.moves;
    if (moves.empty() && move.position_mm.hasNaN()) {
        findings_.count("NC0013", Severity::warning, spot_of_motion(), "start",
                        "moves before the first pose that is known whole are left out");
        return true;
    }
    if (left_out_home_)
        return refuse("NC0302", *left_out_home_, "the way home leads to a place that is not known here", "G28",
                      "G53 and positions instead, or nothing behind it");
    end_tangent_mm_.reset();
    const bool bent = move.arc != program::no_arc || move.curve_part != program::no_curve_part;
    if (!moves.empty() && !bent && same_place(moves.back(), move)) return true;
    moves.push_back(move);
    if (!program_.following_letters.empty()) add_following_row();
    return true;
}

/// Why there is nothing to move.
bool Rs274Reader::never_started() {
    if (axes_ever_ == 0 || !program_.moves.empty()) return refuse("NC0005", {}, "the program makes no move");
    std::string missing;
    for (const char letter : {'X', 'Y', 'Z'})
        if ((axes_ever_ & Block::bit(letter)) == 0) missing += letter;
    return refuse("NC0006", {}, "no pose is ever known whole: X, Y and Z must all be said in one frame", missing,
                  "say them at the start, like G0 X0 Y0 Z10");
}

/// Whether every coordinate and every rotary letter that has been said so far is known at its end.
bool Rs274Reader::is_whole(const Move& move) const {
    if (move.position_mm.hasNaN()) return false;
    for (std::size_t i = 0; i < move.rotary_rad.size(); ++i)
        if (std::isnan(move.rotary_rad[i]) && is_said(i)) return false;
    return true;
}

/// Leaves out the moves before the first pose of which every coordinate and every rotary letter that the program uses
/// is known; a letter stays known.
void Rs274Reader::drop_undetermined() {
    auto& moves = program_.moves;
    std::size_t first = 0;
    while (first < moves.size() && !is_whole(moves[first])) ++first;
    if (first == 0) return;
    findings_.count("NC0013", Severity::warning, {moves.front().line, 1}, "start",
                    "moves before the first pose that is known whole are left out", {}, static_cast<int>(first));
    moves.erase(moves.begin(), moves.begin() + static_cast<std::ptrdiff_t>(first));
    auto& rows = program_.following;
    rows.erase(rows.begin(), rows.begin() + static_cast<std::ptrdiff_t>(first * program_.following_letters.size()));
    if (!moves.empty()) {
        moves.front().arc = program::no_arc;
        moves.front().curve_part = program::no_curve_part;
    }
    for (program::Event& event : program_.events) event.before_move -= std::min(event.before_move, first);
    for (program::PathControl& control : program_.path_controls)
        control.before_move -= std::min(control.before_move, first);
    for (program::SurfaceJob& job : program_.surface_jobs) job.before_move -= std::min(job.before_move, first);
}

}  // namespace trunnion::nc
