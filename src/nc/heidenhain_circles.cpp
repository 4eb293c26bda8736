#include <algorithm>

#include <Eigen/Geometry>

#include "detail/heidenhain_reader.hpp"

namespace trunnion::nc::heidenhain {

using Eigen::Vector3d;
using program::Move;
using program::MoveKind;

namespace {

constexpr double straight_rad = 1e-9;   ///< what turns by less goes straight on
constexpr double same_plane_mm = 1e-4;  ///< half a last digit of posts in inches
constexpr double most_turns = 1000;
constexpr std::uint32_t position_words = Addresses::bits(Address::x, Address::rotary_3);
constexpr std::uint32_t polar_words = Addresses::bits(Address::polar_radius, Address::polar_angle);

bool alike(double a, double b, double c) {
    return std::abs(a - b) <= same_plane_mm && std::abs(a - c) <= same_plane_mm;
}

}  // namespace

/// CC: the centre of circles and the pole; alone it is where the tool stands.
bool HeidenhainReader::centre() {
    if (!numbers_alone(Addresses::bits(Address::x, Address::z))) return false;
    count_in(counting());
    Vector3d at = programmed_mm_;
    const bool here = !said_.has_any(Address::x, Address::z);
    if (!linear_words(at)) return false;
    for (Eigen::Index i = 0; i < 3; ++i)
        if (here || said_.has(static_cast<Address>(i))) centre_mm_[i] = at[i];
    centre_says_z_ = said_.has(Address::z);
    return true;
}

/// LP, C, CR, CT and CP.
bool HeidenhainReader::circle(BlockKind kind) {
    const bool polar = kind == BlockKind::polar_line || kind == BlockKind::polar_circle;
    const bool by_radius = kind == BlockKind::circle_by_radius, tangential = kind == BlockKind::tangential;
    const bool turns = kind != BlockKind::polar_line && !tangential;
    const std::uint32_t radius = Addresses::bits(Address::radius, Address::radius);
    if (!check_addresses(position_words | (polar ? polar_words : 0) | (by_radius ? radius : 0))) return false;
    if (turns != (turning_ != Turning::not_said))
        return refuse("NC0717", first_word_,
                      turns ? "which way round is missing" : "DR is of circles with a centre or radius", {},
                      turns ? "DR+ or DR-" : "");
    if (machine_datum_ || (frames_.plane && !modes_.transform && said_.has_any(Address::rotary_1, Address::rotary_3)))
        return refuse("NC0711", first_word_,
                      "a circle or polar place with M91, or with rotary words in a tilted plane");
    axis_words_ever_ = true;
    last_motion_ = spot_of_motion();
    count_in(counting());
    Vector3d from = programmed_mm_, to = from;
    Way way{.rapid = feed_word_ == FeedWord::rapid};
    if (!linear_words(to) || !orientation(false)) return false;
    if (kind == BlockKind::polar_line) {
        if (!polar_place(to, false) || !go(to, way)) return false;
        return !modal_call_ || says_call() || call_cycle(first_word_);
    }
    if (std::isnan(from.z()) || std::isnan(to.z())) from.z() = to.z() = 0;  // it does not matter in the plane
    if (from.hasNaN() || to.hasNaN())
        return refuse("NC0709", first_word_, "a circle from a position that is not known", {},
                      "say its coordinates in a straight move before it");
    bool good = true;
    if (tangential)
        good = tangential_circle(from, to, way);
    else if (kind == BlockKind::polar_circle)
        good = helix(from, to, way);
    else if (kind == BlockKind::circle)
        good = circle_about_centre(from, to, way);
    else if (!said_.has(Address::radius))
        good =
            refuse("NC0717", first_word_, "the radius is missing", {}, "R+ for the shorter way, R- for the longer one");
    else
        good = keep_circle(arc_by_radius(from, to, said_[Address::radius] * unit_mm(), Vector3d::UnitZ(),
                                         turning_ == Turning::clockwise, 0, sinumerik_arcs),
                           2, way);
    const bool z_known = !std::isnan(programmed_mm_.z()) || said_.has(Address::z);
    if (good && !z_known) to.z() = unknown;
    return good && go(to, way);
}

bool HeidenhainReader::keep_circle(const Result<program::Arc>& arc, int normal_axis, Way& way) {
    if (!arc) return findings_.refuse(spot_of_motion(), Diagnostic(arc.error()));
    const auto outer = frame_.arc(*arc, normal_axis);
    if (!outer) return refuse("NC0716", first_word_, "different scales in the plane of a circle");
    way.arc = outer;
    return true;
}

/// The place by PR and PA from the pole; what is not said stays.
bool HeidenhainReader::polar_place(Vector3d& to, bool keeps_radius) {
    if (std::isnan(centre_mm_.x()) || std::isnan(centre_mm_.y()))
        return refuse("NC0709", first_word_, "the pole is not known", {}, "CC before it");
    if (said_.has_any(Address::x, Address::y)) return refuse("NC0711", first_word_, "X and Y beside polar coordinates");
    if (keeps_radius && said_.has(Address::polar_radius))
        return refuse("NC0711", said_.place(Address::polar_radius), "the radius of CP is that of its start");
    const Eigen::Vector2d arm = (programmed_mm_ - centre_mm_).head<2>();
    double radius = arm.norm(), angle = std::atan2(arm.y(), arm.x());
    if (said_.has(Address::polar_radius))
        radius = said_[Address::polar_radius] * unit_mm() + (said_.is_incremental(Address::polar_radius) ? radius : 0);
    if (said_.has(Address::polar_angle))
        angle = said_[Address::polar_angle] * degree + (said_.is_incremental(Address::polar_angle) ? angle : 0);
    to.head<2>() = centre_mm_.head<2>() + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    if (std::isnan(to.x()) || std::isnan(to.y()))
        return refuse("NC0709", first_word_, "polar coordinates from a position that is not known");
    return true;
}

/// The plane in which C lies: that of X and Y, but for circles that say Z and lie in another one (0 … 2: its normal).
int HeidenhainReader::plane_of_circle(const Vector3d& from, const Vector3d& to) const {
    const bool may_lie_elsewhere =
        (centre_says_z_ || said_.has(Address::z)) && !std::isnan(centre_mm_.z()) && from.z() != to.z();
    if (!may_lie_elsewhere) return 2;
    if (alike(from.x(), to.x(), centre_mm_.x())) return 0;
    return alike(from.y(), to.y(), centre_mm_.y()) ? 1 : 2;
}

bool HeidenhainReader::circle_about_centre(const Vector3d& from, const Vector3d& to, Way& way) {
    if (std::isnan(centre_mm_.x()) || std::isnan(centre_mm_.y()))
        return refuse("NC0709", first_word_, "the centre of the circle is not known", {}, "CC before it");
    const int normal_axis = plane_of_circle(from, to);
    Vector3d centre = centre_mm_;
    centre[normal_axis] = from[normal_axis];
    return keep_circle(
        arc_by_centre(from, to, centre, Vector3d::Unit(normal_axis), turning_ == Turning::clockwise, 0, sinumerik_arcs),
        normal_axis, way);
}

/// CP: about the pole by IPA, several turns if need be, or to PA; with Z a helix.
bool HeidenhainReader::helix(const Vector3d& from, Vector3d& to, Way& way) {
    if (!said_.has(Address::polar_angle)) return refuse("NC0717", first_word_, "CP needs its angle: PA or IPA");
    if (!polar_place(to, true)) return false;
    const double sense = turning_ == Turning::clockwise ? -1 : 1;
    const double written = said_[Address::polar_angle] * degree;
    const Eigen::Vector2d arm = (from - centre_mm_).head<2>();
    double angle = written;
    if (said_.is_incremental(Address::polar_angle)) {
        if (!(angle * sense > 0) || !(std::abs(angle) <= most_turns * 2 * std::numbers::pi))
            return refuse("NC0717", said_.place(Address::polar_angle), "IPA and DR must have the same sign", {},
                          "and no more than 1000 turns");
    } else {
        constexpr double turn = 2 * std::numbers::pi;
        const double way_round = sense * (written - std::atan2(arm.y(), arm.x()));
        angle = way_round - turn * std::floor(way_round / turn);
        angle = sense * (angle < straight_rad ? angle + turn : angle);
        if (!std::isfinite(angle)) return refuse("NC0201", first_word_, "the position is not finite");
    }
    Vector3d middle = centre_mm_;
    middle.z() = from.z();
    // The ends lie on one radius by themselves; what is checked is its size.
    const auto checked = arc_by_centre(from, to, middle, Vector3d::UnitZ(), sense < 0, 0, sinumerik_arcs);
    if (!checked) return keep_circle(checked, 2, way);
    return keep_circle(program::Arc{middle, Vector3d::UnitZ(), angle}, 2, way);
}

/// CT: the circle in the plane that goes on from the block before without a corner.
bool HeidenhainReader::tangential_circle(const Vector3d& from, const Vector3d& to, Way& way) {
    Vector3d tangent = frame_.direction_inward(last_direction());
    Vector3d chord = to - from;
    tangent.z() = chord.z() = 0;
    if (!(tangent.norm() > 0) || !(chord.norm() > 0))
        return refuse("NC0718", first_word_, "CT needs a path block before it and an end elsewhere in the plane");
    tangent.normalize();
    const Vector3d left = Vector3d::UnitZ().cross(tangent);
    const double half = std::atan2(chord.dot(left), chord.dot(tangent));  // between tangent and chord
    if (std::abs(half) < straight_rad) return true;
    const double radius = chord.norm() / (2 * std::sin(half));  // positive: the centre lies to the left
    constexpr double largest_mm = 1e7;
    if (!(std::abs(radius) <= largest_mm))
        return refuse("NC0718", first_word_, "CT turns back, or its circle is too large");
    return keep_circle(program::Arc{from + radius * left, Vector3d::UnitZ(), 2 * half}, 2, way);
}

/// Along the path at the end of the last move, in the offset's frame; zero where it is not known.
Vector3d HeidenhainReader::last_direction() const {
    const auto& moves = program_.moves;
    if (moves.size() < 2) return Vector3d::Zero();
    const Move &start = moves[moves.size() - 2], &end = moves.back();
    const bool here = CountedIn{end.space, end.offset, end.tool} == counted_in_ && start.space == end.space &&
                      start.offset == end.offset && start.tool == end.tool;
    Vector3d way = end.position_mm - start.position_mm;
    if (!here || way.hasNaN()) return Vector3d::Zero();
    if (end.arc == program::no_arc) return way;
    const program::Arc& arc = program_.arcs[static_cast<std::size_t>(end.arc)];
    const Vector3d turning = std::copysign(1.0, arc.angle_rad) * arc.normal.cross(end.position_mm - arc.centre_mm);
    return turning + arc.normal * (arc.normal.dot(way) / std::abs(arc.angle_rad));
}

// ------------------------------------------------------------------------------------------------- RND

bool HeidenhainReader::refuse_rounding(std::string_view why, std::string_view value) {
    return findings_.refuse("NC0719", corner_->spot, fmt::format("this corner cannot be rounded: {}", why), value,
                            "RND stands between two lines in the plane of X and Y");
}

/// RND R, F of this block alone: the corner at which the tool stands.
bool HeidenhainReader::rounding() {
    if (corner_) return refuse_rounding("another corner follows at once");
    Corner corner{.spot = spot_of_motion(), .line = interpreter_.line()};
    if (cursor().name() != "R" || !values().value(corner.radius_mm))
        return refuse("NC0719", first_word_, "RND needs its radius", {}, "RND R5");
    corner.radius_mm *= unit_mm();
    if (!(corner.radius_mm > 0) || !std::isfinite(corner.radius_mm))
        return refuse("NC0719", first_word_, "the radius of a corner must be positive");
    if (cursor().front() == 'F') {
        cursor().skip(1);
        FeedWord kind = FeedWord::none;
        double feed = 0;
        if (!feed_words(kind, feed, first_word_)) return false;
        if (kind == FeedWord::value) {
            corner.speed_mm_s = feed * feed_unit_mm() / 60;
            if (!(*corner.speed_mm_s > 0) || !std::isfinite(*corner.speed_mm_s))
                return refuse("NC0206", first_word_, "a feed must be positive");
        }
    }
    corner_ = corner;
    return want_end();
}

/// Whether the last two moves and this one are lines of one kind that meet.
bool HeidenhainReader::is_corner_of_lines(const Move& move) const {
    const auto& moves = program_.moves;
    if (moves.size() < 2) return false;
    const auto same_angle = [](double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); };
    const auto fits = [&](const Move& other) {
        const bool turned_alike =
            other.law == move.law && (move.law == program::OrientationLaw::vector
                                          ? other.axis == move.axis
                                          : std::ranges::equal(other.rotary_rad, move.rotary_rad, same_angle));
        return other.space == move.space && other.offset == move.offset && other.tool == move.tool && turned_alike &&
               !other.position_mm.hasNaN();
    };
    const Move& last = moves.back();
    return fits(moves[moves.size() - 2]) && fits(last) && !move.position_mm.hasNaN() && last.arc == program::no_arc &&
           last.kind == MoveKind::feed && move.kind == MoveKind::feed && last.feed.rule == program::FeedRule::tip_speed;
}

/// Ends the last move where its circle begins, and goes round the corner; `move` goes on from there.
bool HeidenhainReader::round_corner(const Move& move) {
    if (!is_corner_of_lines(move)) return refuse_rounding("it is not between two lines of known ends at feed");
    if (frames_.before.scales() || frames_.within.scales()) return refuse_rounding("a scale is in force");
    Move& last = program_.moves.back();
    const Vector3d start = program_.moves[program_.moves.size() - 2].position_mm, tip = last.position_mm;
    const Vector3d in = tip - start, out = move.position_mm - tip;
    const double in_length = in.norm(), out_length = out.norm();
    if (!(in_length > 0) || !(out_length > 0)) return refuse_rounding("one of its lines has no length");
    const Vector3d before = in / in_length, after = out / out_length;
    const Vector3d turning = before.cross(after);
    const double angle = std::atan2(turning.norm(), before.dot(after));
    const Corner corner = *corner_;
    if (angle >= straight_rad) {
        const double back = corner.radius_mm * std::tan(angle / 2);
        const auto across = frame_.tool_axis(Vector3d::UnitZ());
        if (!across || turning.cross(*across).norm() > 1e-6 * turning.norm())
            return refuse_rounding("it does not lie in the plane");
        if (!(back <= std::min(in_length, out_length)))
            return refuse_rounding("the radius does not fit its lines", fmt::format("{:.6g} mm", corner.radius_mm));
        Move round = last;
        last.position_mm = tip - back * before;
        round.position_mm = tip + back * after;
        const Vector3d normal = turning.normalized();
        round.arc = add_arc({last.position_mm + corner.radius_mm * normal.cross(before), normal, angle});
        if (corner.speed_mm_s) round.feed.value = *corner.speed_mm_s;
        round.line = corner.line;
        program_.moves.push_back(round);
    }
    corner_.reset();
    return true;
}

}  // namespace trunnion::nc::heidenhain
