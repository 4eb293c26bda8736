#include <algorithm>

#include <Eigen/Geometry>

#include "detail/arcs.hpp"
#include "detail/same_place.hpp"
#include "detail/sinumerik_reader.hpp"

namespace trunnion::nc::sinumerik {

using Eigen::Vector3d;
using program::FeedRule;
using program::Move;
using program::MoveKind;
using program::OrientationLaw;
using program::Space;

namespace {

constexpr double straight_rad = 1e-9;  ///< a tangential circle that leaves its tangent by less is a line

bool is_circle(Meaning motion) {
    return motion == Meaning::clockwise || motion == Meaning::counter_clockwise;
}

constexpr Address linear[] = {Address::x, Address::y, Address::z};
constexpr Address rotary[] = {Address::rotary_1, Address::rotary_2, Address::rotary_3};
constexpr Address centres[] = {Address::i, Address::j, Address::k};
constexpr Address vias[] = {Address::i1, Address::j1, Address::k1};

}  // namespace

bool SinumerikReader::asks_motion() const {
    return said_.has_any(Address::x, Address::rotary_3) || said_.has_any(Address::a2, Address::zh) ||
           (is_circle(modes_.motion) && said_.has_any(Address::i, Address::turn)) || !polynomials_.empty();
}

Spot SinumerikReader::spot_of_motion() const {
    for (const Word& word : block_.words) {
        const bool mode = word.name == "G" || word.name == "N" || rule_of_name(word.name).meaning == Meaning::suppress;
        if (word.has_value && !mode) return block_.spot(word);
    }
    return block_.place;
}

/// Makes the linear words count in what is in force. What was known of the position in another frame is not kept: the
/// axes stand where they stand.
bool SinumerikReader::count_in(bool suppressed) {
    if (suppressed && modes_.transform)
        return refuse("NC0615", block_.place, "SUPA, G53 and G153 under TRAORI count the tip, not the axes", {},
                      "TRAFOOF before it");
    if (suppressed && said_.has(Address::z) && !program_.tools[tool_.index].ends_with(" D0"))
        return refuse("NC0616", spot(Address::z),
                      "Z counts with the tool's length here, which the program does not say", {},
                      "D0 in the block, or before it");
    if (!suppressed && swivelled_ && !modes_.transform && !tool_as_swivelled_)
        return refuse("NC0624", block_.place, "the tool was turned elsewhere after CYCLE800", {},
                      "CYCLE800 again, or CYCLE800() to leave the swivelled plane");
    const Space space = modes_.transform || swivelled_ ? Space::workpiece : Space::untransformed;
    const CountedIn now = suppressed ? CountedIn{Space::machine, 0, 0} : CountedIn{space, modes_.offset, tool_.index};
    if (now == counted_in_) return true;
    counted_in_ = now;
    rapid_left_out_ = false;
    frame_ = suppressed ? CoordinateFrame{} : frame_in_force();
    position_mm_.setConstant(unknown);
    programmed_mm_.setConstant(unknown);
    return true;
}

bool SinumerikReader::motion() {
    if (!asks_motion()) return true;
    axis_words_ever_ = true;
    last_motion_ = block_.place;
    if (modes_.motion == Meaning::unknown)
        return refuse("NC0610", spot_of_motion(), "an axis word, but no motion is in force", {}, "G0 or G1 before it");
    if (!count_in(groups_[static_cast<std::size_t>(Group::suppression)] == Meaning::suppress)) return false;
    Vector3d to = programmed_mm_;
    rotary_from_rad_ = rotary_rad_;
    second_from_mm_ = second_mm_;
    for (const Address address : linear)
        if (said_.has(address) && !linear_word(address, to)) return false;
    for (const Address address : rotary)
        if (said_.has(address) && !rotary_word(address)) return false;
    said_.use(Address::x, Address::rotary_3);
    Way way;
    way.rapid = modes_.motion == Meaning::rapid;
    if (!orientation() || !second_point(to)) return false;
    if (modes_.motion == Meaning::spline) return add_spline_point(to);
    if (modes_.motion == Meaning::polynomial) return go_along_polynomial(to);
    if (modes_.motion != Meaning::rapid && modes_.motion != Meaning::line && !circle(to, way)) return false;
    if (!go(to, way)) return false;
    return !modal_cycle_ || run_cycle(*modal_cycle_);
}

bool SinumerikReader::linear_word(Address address, Vector3d& to) {
    double& coordinate = to[static_cast<Eigen::Index>(address) - static_cast<Eigen::Index>(Address::x)];
    const double way = said_[address] * modes_.unit_mm;
    switch (said_.counting(address)) {
        case Counting::modal:
            coordinate = modes_.absolute ? way : coordinate + way;
            break;
        case Counting::absolute:
            coordinate = way;
            break;
        case Counting::incremental:
            coordinate += way;
            break;
        default:
            return refuse("NC0614", spot(address), "DC, ACP and ACN are for rotary axes");
    }
    if (std::isnan(coordinate))
        return refuse("NC0611", spot(address), "an incremental word from a position that is not known", {},
                      "say the coordinate once in G90 after changes of offset, tool, TRAORI or frame");
    if (!std::isfinite(coordinate)) return refuse("NC0201", spot(address), "the position is not finite");
    return true;
}

// ---------------------------------------------------------------------------------------------------------- circles

/// By its angle and centre a circle says its end too: then `to` becomes that.
bool SinumerikReader::circle(Vector3d& to, Way& way) {
    Vector3d from = programmed_mm_;
    if (goes_by_angle() && !turn_to_angle(from, to)) return false;
    Vector3d end = to;
    if (modes_.motion != Meaning::via_point &&
        (std::isnan(from[modes_.normal_axis]) || std::isnan(end[modes_.normal_axis])))
        from[modes_.normal_axis] = end[modes_.normal_axis] = 0;  // it does not matter to the circle in its plane
    if (from.hasNaN() || end.hasNaN())
        return refuse("NC0611", spot_of_motion(), "a circle from a position that is not known", {},
                      "say its coordinates in a straight move before it");
    if (modes_.motion == Meaning::via_point) return circle_through(from, end, way);
    if (modes_.motion == Meaning::tangential) return tangential_circle(from, end, way);
    return circle_in_plane(from, end, way);
}

bool SinumerikReader::keep_circle(const Result<program::Arc>& arc, Way& way) {
    if (!arc) return findings_.refuse(spot_of_motion(), Diagnostic(arc.error()));
    const auto outer = frame_.arc(*arc, modes_.normal_axis);
    if (!outer)
        return refuse("NC0620", spot_of_motion(), "different scales in the plane of a circle", {},
                      "SCALE with one factor for the plane's axes");
    way.arc = outer;
    return true;
}

Vector3d SinumerikReader::centre(const Vector3d& from) {
    Vector3d centre = from;
    for (Eigen::Index i = 0; i < 3; ++i) {
        const Address address = centres[i];
        if (i == modes_.normal_axis || !said_.has(address)) continue;
        const double value = said_[address] * modes_.unit_mm;
        centre[i] = said_.counting(address) == Counting::absolute ? value : from[i] + value;
        said_.use(address);
    }
    return centre;
}

bool SinumerikReader::goes_by_angle() const {
    return is_circle(modes_.motion) && said_.has(Address::angle) && said_.has_any(Address::i, Address::k);
}

/// The end of a circle that says its centre and AR.
bool SinumerikReader::turn_to_angle(const Vector3d& from, Vector3d& to) {
    for (Eigen::Index i = 0; i < 3; ++i)
        if (i != modes_.normal_axis && said_.has(linear[i]))
            return refuse("NC0621", spot(Address::angle), "a circle by its centre and angle says its end already");
    const double sense = modes_.motion == Meaning::clockwise ? -1 : 1;
    const Vector3d middle = centre(from);
    const Vector3d end =
        middle +
        Eigen::AngleAxisd(sense * said_[Address::angle] * degree, Vector3d::Unit(modes_.normal_axis)) * (from - middle);
    for (Eigen::Index i = 0; i < 3; ++i)
        if (i != modes_.normal_axis) to[i] = end[i];
    return true;
}

bool SinumerikReader::circle_in_plane(const Vector3d& from, const Vector3d& to, Way& way) {
    const bool clockwise = modes_.motion == Meaning::clockwise;
    const Vector3d normal = Vector3d::Unit(modes_.normal_axis);
    const bool by_centre = said_.has_any(Address::i, Address::k);
    const bool by_radius = said_.has(Address::radius), by_angle = said_.has(Address::angle);
    if (by_radius ? by_centre || by_angle : !by_centre && !by_angle)
        return refuse("NC0621", spot_of_motion(),
                      "a circle needs its centre (I J K), its radius (CR) or its angle (AR)", {},
                      "and no more than the angle beside the centre");
    if (by_angle && !(said_[Address::angle] > 0 && said_[Address::angle] < 360))
        return refuse("NC0621", spot(Address::angle), "the angle of a circle lies between 0 and 360 degrees");
    said_.use(Address::radius, Address::turn);
    const double turns = said_.get(Address::turn, 0);
    if (by_centre)
        return keep_circle(arc_by_centre(from, to, centre(from), normal, clockwise, turns, sinumerik_arcs), way);
    const double radius = by_radius ? said_[Address::radius] * modes_.unit_mm : radius_of_angle(from, to);
    return keep_circle(arc_by_radius(from, to, radius, normal, clockwise, turns, sinumerik_arcs), way);
}

/// CR as arc_by_radius takes it, from the chord and AR in degrees.
double SinumerikReader::radius_of_angle(const Vector3d& from, const Vector3d& to) const {
    Vector3d chord = to - from;
    chord[modes_.normal_axis] = 0;
    const double angle = said_[Address::angle] * degree;
    const double radius = chord.norm() / (2 * std::sin(angle / 2));
    return angle > std::numbers::pi ? -radius : radius;
}

/// CIP: the circle through a point between, anywhere in space.
bool SinumerikReader::circle_through(const Vector3d& from, const Vector3d& to, Way& way) {
    Vector3d via = from;
    for (Eigen::Index i = 0; i < 3; ++i) {
        const Address address = vias[i];
        if (!said_.has(address)) continue;
        const double value = said_[address] * modes_.unit_mm;
        const Counting counting = said_.counting(address);
        const bool absolute = counting == Counting::modal ? modes_.absolute : counting == Counting::absolute;
        via[i] = absolute ? value : from[i] + value;
    }
    said_.use(Address::i1, Address::k1);
    const auto start = frame_.outward(from), between = frame_.outward(via), end = frame_.outward(to);
    auto arc = arc_through(*start, *between, *end);
    if (!arc) return findings_.refuse(spot_of_motion(), std::move(arc.error()));
    if (!frame_.tool_axis(Vector3d::UnitZ()))
        return refuse("NC0620", spot_of_motion(), "different scales in the plane of a circle");
    way.arc = *arc;
    return true;
}

/// CT: the circle in the plane that goes on from the block before without a corner.
bool SinumerikReader::tangential_circle(const Vector3d& from, const Vector3d& to, Way& way) {
    Vector3d tangent = frame_.direction_inward(last_direction());
    Vector3d chord = to - from;
    tangent[modes_.normal_axis] = chord[modes_.normal_axis] = 0;
    if (!(tangent.norm() > 0) || !(chord.norm() > 0))
        return refuse("NC0622", spot_of_motion(), "CT needs a path block before it and an end elsewhere in the plane");
    tangent.normalize();
    const Vector3d normal = Vector3d::Unit(modes_.normal_axis);
    const Vector3d left = normal.cross(tangent);
    const double half = std::atan2(chord.dot(left), chord.dot(tangent));  // between tangent and chord
    if (std::abs(half) < straight_rad) return true;
    const double radius = chord.norm() / (2 * std::sin(half));  // positive: the centre lies to the left
    return keep_circle(program::Arc{from + radius * left, normal, 2 * half}, way);
}

/// Along the path at the end of the last move, in the work offset's frame; zero where it is not known.
Vector3d SinumerikReader::last_direction() const {
    const auto& moves = program_.moves;
    if (moves.size() < 2) return Vector3d::Zero();
    const Move &start = moves[moves.size() - 2], &end = moves.back();
    const bool here = CountedIn{end.space, end.offset, end.tool} == counted_in_ && start.space == end.space &&
                      start.offset == end.offset && start.tool == end.tool;
    Vector3d way = end.position_mm - start.position_mm;
    if (!here || way.hasNaN()) return Vector3d::Zero();
    if (end.curve_part != program::no_curve_part) {
        const auto& part = program_.curve_parts[static_cast<std::size_t>(end.curve_part)];
        const auto& points = program_.curves[static_cast<std::size_t>(part.curve)].position_mm;
        return points.back() - points[points.size() - 2];
    }
    if (end.arc == program::no_arc) return way;
    const program::Arc& arc = program_.arcs[static_cast<std::size_t>(end.arc)];
    const Vector3d turning = std::copysign(1.0, arc.angle_rad) * arc.normal.cross(end.position_mm - arc.centre_mm);
    return turning + arc.normal * (arc.normal.dot(way) / std::abs(arc.angle_rad));
}

// ------------------------------------------------------------------------------------------------------------ moves

/// From where the tool stands to a place in the programmed frame. Coordinates that are not known stay as they are.
bool SinumerikReader::go(const Vector3d& to, const Way& way) {
    if (!end_spline()) return false;
    const auto outer = frame_.outward(to);
    const bool whole_needed = program_.moves.empty() || (whole_pose_needed_ && counted_in_.space == Space::workpiece);
    programmed_mm_ = to;
    if (!outer || (whole_needed && to.hasNaN())) return leave_out(way);
    if (rapid_left_out_ && !way.rapid) return leave_out(way);
    if (outer->array().isInf().any()) return refuse("NC0201", spot_of_motion(), "the position is not finite");
    Move move;
    move.position_mm = *outer;
    move.kind = way.rapid ? MoveKind::rapid : MoveKind::feed;
    move.space = counted_in_.space;
    move.offset = counted_in_.offset;
    move.tool = move.space == Space::machine ? tool_.in_spindle : tool_.index;
    move.exact_stop = modes_.exact_stop || exact_stop_once_;
    move.line = block_.line;
    move.law = move.space == Space::workpiece ? law_ : OrientationLaw::rotary;
    if (move.law == OrientationLaw::rotary) move.rotary_rad = rotary_rad_;
    if (move.law == OrientationLaw::vector) move.axis = axis_;
    if (!feed_of(move, way)) return false;
    if (way.arc && !program_.moves.empty()) {
        move.arc = static_cast<std::int32_t>(program_.arcs.size());
        program_.arcs.push_back(*way.arc);
    }
    if (way.curve) {
        const program::CurvePart whole{static_cast<std::int32_t>(program_.curves.size()), way.curve->knots.front(),
                                       way.curve->knots.back()};
        program_.curves.push_back(*way.curve);
        follow_curve(program_, move, whole);
    }
    position_mm_ = *outer;
    rapid_left_out_ = false;
    if (counted_in_.space == Space::workpiece) whole_pose_needed_ = false;
    if (move.law == OrientationLaw::vector) rotary_rad_.fill(unknown);  // path building chooses where they stand
    return add(move);
}

/// A move to a place of which something is not known is left out if nothing was known before, or if it is a rapid.
bool SinumerikReader::leave_out(const Way& way) {
    if (program_.moves.empty()) {
        findings_.count("NC0013", Severity::warning, spot_of_motion(), "start",
                        "moves before the first pose that is known whole are left out");
        return true;
    }
    if (!way.rapid)
        return refuse("NC0612", spot_of_motion(),
                      "X, Y and Z must all be known by a rapid before the tool cuts in a frame that is turned", {},
                      "say them in G0 behind TRAORI, CYCLE800 or a change of offset");
    rapid_left_out_ = true;
    findings_.count("NC0652", Severity::warning, spot_of_motion(), "rapid",
                    "rapids in a turned frame are left out until X, Y and Z are all known: one rapid goes there");
    return true;
}

bool SinumerikReader::add(Move& move) {
    append(program_, move);
    return true;
}

/// F as a speed in mm/s; 0 where none was given and that is allowed.
bool SinumerikReader::path_speed(double& speed_mm_s) {
    double feed = modes_.feed;
    if (said_.has(Address::feed_once)) feed = said_[Address::feed_once] * modes_.feed_unit_mm;
    said_.use(Address::feed_once);
    if (!(feed > 0) && !options_.feed_given_elsewhere)
        return refuse("NC0205", spot_of_motion(), "a cutting move without a feed", {},
                      "--feed gives one, or F before it");
    if (modes_.feed_kind == Meaning::per_revolution && !(modes_.spindle_rpm > 0)) {
        if (!options_.feed_given_elsewhere)
            return refuse("NC0626", spot_of_motion(), "G95 without the spindle's speed", {}, "S before it");
        feed = 0;
    }
    if (modes_.feed_kind == Meaning::per_revolution && feed > 0) feed *= modes_.spindle_rpm;
    speed_mm_s = feed / 60;
    return true;
}

bool SinumerikReader::feed_of(Move& move, const Way& way) {
    if (way.rapid) return true;
    double speed = 0;
    if (way.speed_mm_s)
        speed = *way.speed_mm_s;
    else if (!path_speed(speed))
        return false;
    if (modes_.feed_kind == Meaning::inverse_time && !way.speed_mm_s) {
        move.feed = speed > 0 ? program::Feed{FeedRule::block_time, 1 / speed} : program::Feed{FeedRule::tip_speed, 0};
        return true;
    }
    if (!way.arc && !way.curved && !goes(position_mm_, move.position_mm)) return feed_of_rotation(move, speed);
    move.feed = {FeedRule::tip_speed, speed};
    return !modes_.rotary_in_feed || feed_of_group(move, way, speed);
}

/// A block that only turns: F is the speed at FGREF's radius, as delivered 1 mm for 1 degree.
bool SinumerikReader::feed_of_rotation(Move& move, double speed_mm_s) {
    const Move* const last = program_.moves.empty() ? nullptr : &program_.moves.back();
    const bool by_words = last && move.law == OrientationLaw::rotary && last->law == OrientationLaw::rotary;
    const int axes = options_.machine ? options_.machine->rotary_count : 0;
    std::optional<double> reference;
    for (std::size_t i = 0; i < static_cast<std::size_t>(axes); ++i) {
        if (by_words && same(move.rotary_rad[i], last->rotary_rad[i])) continue;
        if (reference && *reference != modes_.reference_mm[i])
            return refuse("NC0627", spot_of_motion(), "F of a rotation of axes with different FGREF", {},
                          "one FGREF for all rotary axes, or G93");
        reference = modes_.reference_mm[i];
    }
    move.feed = {FeedRule::rotary_rate, speed_mm_s / reference.value_or(default_reference_mm)};
    if (reference)
        findings_.count("NC0651", Severity::note, spot_of_motion(), "F",
                        fmt::format("F of blocks that only turn counts at the radius of FGREF, {:.5g} mm", *reference));
    return true;
}

/// FGROUP with rotary axes: F is the speed in the space of the tip's way and the ways at FGREF's radii, here as time.
bool SinumerikReader::feed_of_group(Move& move, const Way& way, double speed_mm_s) {
    const Move* const last = program_.moves.empty() ? nullptr : &program_.moves.back();
    const Vector3d step = move.position_mm - position_mm_;
    if (!last || speed_mm_s == 0) return true;
    if (way.curved)
        return refuse("NC0627", spot_of_motion(), "F by FGROUP with rotary axes along a curve is not supported", {},
                      "FGROUP(X,Y,Z)");
    double squares = way.arc ? square_of_way(*way.arc, position_mm_, step) : step.squaredNorm();
    for (std::size_t i = 0; i < move.rotary_rad.size(); ++i)
        if (!same(move.rotary_rad[i], last->rotary_rad[i]))
            squares += std::pow((move.rotary_rad[i] - last->rotary_rad[i]) * modes_.reference_mm[i], 2);
    const bool by_words = move.law == OrientationLaw::rotary && last->law == OrientationLaw::rotary;
    if (!by_words || std::isnan(squares))
        return refuse("NC0627", spot_of_motion(), "F by FGROUP with rotary axes from a position that is not known", {},
                      "FGROUP(X,Y,Z)");
    move.feed = {FeedRule::block_time, std::sqrt(squares) / speed_mm_s};
    return true;
}

// ------------------------------------------------------------------------------------------------------------- end

bool SinumerikReader::never_started() {
    if (!axis_words_ever_ || !program_.moves.empty()) return refuse("NC0005", Spot{}, "the program makes no move");
    return refuse("NC0006", Spot{}, "no pose is ever known whole: X, Y and Z must all be said in one frame", {},
                  "say them at the start, like G0 X0 Y0 Z10");
}

/// What the text left open and was assumed.
void SinumerikReader::tell_assumptions() {
    const Move& first = first_move();
    for (std::size_t i = 0; i < rotary_rad_.size(); ++i) {
        const char letter = rotary_letter(i);
        if (is_said(i) && first.law == OrientationLaw::rotary && std::isnan(first.rotary_rad[i]))
            findings_.count(
                "NC0655", Severity::note, {first.line, 1}, std::string_view(&letter, 1),
                "the program moves before it says where this axis stands: the setup's start counts, else 0");
    }
    if (!exact_stop_said_)
        findings_.count("NC0657", Severity::note, {first.line, 1}, "G64",
                        "neither exact stop (G60) nor continuous path (G64) is said: continuous path is assumed");
    if (!frame_in_force().is_identity())
        findings_.count("NC0654", Severity::warning, last_motion_, "frame",
                        "a frame of TRANS, ROT, SCALE, MIRROR or CYCLE800 is still in force at the end",
                        "TRANS without words, CYCLE800() take it away");
    report_units(stated_, options_.units, findings_);
}

bool SinumerikReader::finish() {
    if (!end_spline()) return false;
    if (program_.moves.size() < 2) return never_started();
    tell_assumptions();
    return true;
}

}  // namespace trunnion::nc::sinumerik
