#include <algorithm>

#include <Eigen/Geometry>

#include "detail/heidenhain_reader.hpp"
#include "detail/same_place.hpp"

namespace trunnion::nc::heidenhain {

using Eigen::Vector3d;
using program::FeedRule;
using program::Move;
using program::MoveKind;
using program::OrientationLaw;
using program::Space;

namespace {

constexpr double smallest_vector = 1e-12;
constexpr double whole_turn = 360;  ///< degrees, as words count
constexpr std::uint32_t position_words = Addresses::bits(Address::x, Address::rotary_3);

constexpr Address linear[] = {Address::x, Address::y, Address::z};

}  // namespace

CountedIn HeidenhainReader::counting() const {
    if (machine_datum_) return {Space::machine, 0, 0};
    const bool of_workpiece = modes_.transform || frames_.plane;
    return {of_workpiece ? Space::workpiece : Space::untransformed, modes_.offset, tool_};
}

/// Makes the linear words count in what is in force. What was known of the position in another frame is not kept: the
/// axes stand where they stand.
void HeidenhainReader::count_in(const CountedIn& now) {
    if (now == counted_in_) return;
    counted_in_ = now;
    rapid_left_out_ = false;
    frame_ = now.space == Space::machine ? CoordinateFrame{} : frames_.in_force();
    forget_position();
    centre_mm_.setConstant(unknown);
}

/// L, LN, and words alone.
bool HeidenhainReader::line(bool with_vector) {
    const std::uint32_t vectors = with_vector ? Addresses::bits(Address::nx, Address::tz) : 0;
    if (!check_addresses(position_words | vectors)) return false;
    if (turning_ != Turning::not_said) return refuse("NC0711", first_word_, "DR is of circles alone");
    const bool moves = said_.has_any(Address::x, Address::tz);
    if (!moves) return true;
    axis_words_ever_ = true;
    last_motion_ = spot_of_motion();
    if (machine_datum_ && modes_.transform)
        return refuse("NC0712", first_word_, "M91 while M128 or TCPM is on", {}, "M129 before it");
    const bool places = said_.has_any(Address::x, Address::z);
    const Way way{.rapid = feed_word_ == FeedWord::rapid};
    const bool turns = said_.has_any(Address::rotary_1, Address::rotary_3);
    if (to_plane_ != 0) return turn_to_plane();
    if (frames_.plane && !modes_.transform && !machine_datum_ && turns) return rotary_in_plane(way);
    count_in(counting());
    Vector3d to = programmed_mm_;
    if (!linear_words(to) || !orientation(with_vector) || !go(to, way)) return false;
    return !modal_call_ || !places || says_call() || call_cycle(first_word_);
}

bool HeidenhainReader::says_call() const {
    return std::ranges::any_of(m_words_, [](const MWord& word) { return word.number == 89 || word.number == 99; });
}

bool HeidenhainReader::linear_words(Vector3d& to) {
    for (Eigen::Index i = 0; i < 3; ++i) {
        const Address address = linear[i];
        if (!said_.has(address)) continue;
        const double way = said_[address] * unit_mm();
        to[i] = said_.is_incremental(address) ? to[i] + way : way;
        if (std::isnan(to[i]))
            return refuse("NC0709", said_.place(address), "an incremental word from a position that is not known", {},
                          "say the coordinate once as it is after changes of datum, tool, M128 or plane");
        if (!std::isfinite(to[i])) return refuse("NC0201", said_.place(address), "the position is not finite");
    }
    return true;
}

// ------------------------------------------------------------------------------------------------- orientation

bool HeidenhainReader::orientation(bool with_vector) {
    if (said_.has_any(Address::rotary_1, Address::rotary_3) &&
        !(modes_.spatial_angles && !machine_datum_ ? spatial_words() : rotary_words()))
        return false;
    return !with_vector || vector_words();
}

bool HeidenhainReader::rotary_words() {
    for (std::size_t axis = 0; axis < rotary_rad_.size(); ++axis)
        if (said_.has(static_cast<Address>(static_cast<std::size_t>(Address::rotary_1) + axis)) && !rotary_word(axis))
            return false;
    return true;
}

/// Literal degrees; by the shorter way under M126.
bool HeidenhainReader::rotary_word(std::size_t axis) {
    const auto address = static_cast<Address>(static_cast<std::size_t>(Address::rotary_1) + axis);
    const Spot spot = cursor().spot(said_.place(address));
    const double from = rotary_rad_[axis] / degree;
    double to = said_[address] + reduced_rad_[axis] / degree;
    if (said_.is_incremental(address)) {
        to = from + said_[address];
    } else if (modes_.shortest && std::isnan(from)) {
        findings_.count("NC0759", Severity::warning, spot, "M126",
                        "M126 from a position that is not known: the angle is taken as it is written");
    } else if (modes_.shortest) {
        to += whole_turn * std::round((from - to) / whole_turn);
    }
    if (std::isnan(to))
        return refuse("NC0709", spot, "an incremental word from a position that is not known", {},
                      "say the angle once as it is");
    if (!std::isfinite(to * degree)) return refuse("NC0201", spot, "the position is not finite");
    if (modes_.vectors && modes_.transform && feed_word_ != FeedWord::rapid && !(to * degree == rotary_rad_[axis]))
        return refuse("NC0714", spot, "PATHCTRL VECTOR with positions of rotary axes is not supported", {},
                      "PATHCTRL AXIS, or LN with TX TY TZ");
    rotary_rad_[axis] = to * degree;
    rotary_ever_ |= 1u << axis;
    law_ = OrientationLaw::rotary;
    return true;
}

/// AXIS SPAT: A B C turn the tool about X, Y and Z as PLANE SPATIAL does; the path of the vector is known in PATHCTRL
/// VECTOR alone.
bool HeidenhainReader::spatial_words() {
    std::array<double, 3> angles = spatial_deg_;
    for (std::size_t i = 0; i < angles.size(); ++i) {
        const auto address = static_cast<Address>(static_cast<std::size_t>(Address::rotary_1) + i);
        if (!said_.has(address)) continue;
        angles[i] = said_[address] + (said_.is_incremental(address) ? angles[i] : 0);
    }
    const Vector3d turned = Vector3d(angles[0], angles[1], angles[2]) * degree;
    if (!turned.allFinite()) return refuse("NC0201", first_word_, "the position is not finite");
    const bool is_known = law_ == OrientationLaw::vector;
    const bool turns = !is_known || angles != spatial_deg_;
    if (turns && !modes_.vectors && feed_word_ != FeedWord::rapid)
        return refuse("NC0714", first_word_,
                      "AXIS SPAT with PATHCTRL AXIS, where the rotary axes go straight, is not supported", {},
                      "PATHCTRL VECTOR");
    spatial_deg_ = angles;
    const auto axis = frame_.with(CoordinateFrame::turned_rpy(turned)).tool_axis(Vector3d::UnitZ());
    if (!axis) return refuse("NC0716", first_word_, "a tool vector under scales that differ");
    axis_ = *axis;
    law_ = OrientationLaw::vector;
    return true;
}

/// All three of a vector, or none.
bool HeidenhainReader::whole_vector(Address first, bool& said) {
    const auto last = static_cast<Address>(static_cast<int>(first) + 2);
    said = said_.has_any(first, last);
    if (!said || said_.has_all(first, last)) return true;
    return refuse("NC0713", first_word_, "a vector needs its three components");
}

/// LN under M128: the tool stands along T, else across the surface along N. Without M128 the control does not turn it.
bool HeidenhainReader::vector_words() {
    bool tool = false, normal = false;
    if (!whole_vector(Address::tx, tool) || !whole_vector(Address::nx, normal)) return false;
    const bool by_words = said_.has_any(Address::rotary_1, Address::rotary_3);
    if (tool && by_words) return refuse("NC0714", first_word_, "rotary words and a tool vector in one block");
    const bool turns = modes_.transform && !machine_datum_;
    if (tool && !turns) findings_.ignored(spot_of_motion(), "TX TY TZ without M128");
    if (normal && (tool || by_words || !turns)) findings_.ignored(spot_of_motion(), "NX NY NZ");
    if (!turns || by_words || (!tool && !normal)) return true;
    const Address first = tool ? Address::tx : Address::nx;
    const auto at = [&](int i) { return said_[static_cast<Address>(static_cast<int>(first) + i)]; };
    return tool_vector(first, {at(0), at(1), at(2)});
}

bool HeidenhainReader::tool_vector(Address first, Vector3d vector) {
    const double length = vector.stableNorm();
    if (!(length > smallest_vector) || !std::isfinite(length))
        return refuse("NC0713", said_.place(first), "a tool vector without direction");
    if (std::abs(length - 1) > 1e-3)
        findings_.count("NC0015", Severity::note, cursor().spot(said_.place(first)), "vector",
                        "tool vectors that are not unit vectors were made so");
    const auto axis = frame_.tool_axis(vector / length);
    if (!axis) return refuse("NC0716", said_.place(first), "a tool vector under scales that differ");
    axis_ = *axis;
    law_ = OrientationLaw::vector;
    return true;
}

/// In a tilted plane rotary words turn the tool and nothing else; from there on it stands as they say.
bool HeidenhainReader::rotary_in_plane(const Way& way) {
    if (said_.has_any(Address::x, Address::z) || said_.has_any(Address::nx, Address::tz))
        return refuse("NC0721", first_word_, "rotary words beside X Y Z in a tilted plane", {},
                      "turn the rotary axes in a block of their own, or PLANE … TURN");
    count_in({Space::untransformed, modes_.offset, tool_});
    if (!rotary_words()) return false;
    forget_position();
    whole_pose_needed_ = true;
    findings_.count("NC0760", Severity::note, spot_of_motion(), "PLANE",
                    "rotary words in a tilted plane: the tool is taken to stand as they say");
    return go(programmed_mm_, way);
}

/// The control's own positions for the plane, Q120 … Q122, as the value of all rotary words: the tool stands across it.
bool HeidenhainReader::turn_to_plane() {
    const bool all_of_plane = !said_.other_than(Addresses::bits(Address::rotary_1, Address::rotary_3));
    for (std::size_t i = 0; i < rotary_rad_.size(); ++i) {
        const auto address = static_cast<Address>(static_cast<std::size_t>(Address::rotary_1) + i);
        if (!all_of_plane || !frames_.plane || modes_.transform || machine_datum_ ||
            (said_.has(address) && ((to_plane_ & (1u << i)) == 0 || said_.is_incremental(address))))
            return refuse("NC0721", first_word_,
                          "Q120, Q121 and Q122 are known as the positions that reach a tilted plane alone", {},
                          "PLANE … STAY, then a block of L with A, B, C by them and nothing else");
    }
    align_tool();
    return true;
}

// ------------------------------------------------------------------------------------------------- moves

/// From where the tool stands to a place in the programmed frame. Coordinates that are not known stay as they are.
bool HeidenhainReader::go(const Vector3d& to, const Way& way) {
    const auto outer = frame_.outward(to);
    const bool whole_needed = program_.moves.empty() || (whole_pose_needed_ && counted_in_.space == Space::workpiece);
    programmed_mm_ = to;
    if (!outer || (whole_needed && to.hasNaN())) return leave_out(way);
    if (rapid_left_out_ && !way.rapid) return leave_out(way);
    if (outer->array().isInf().any()) return refuse("NC0201", first_word_, "the position is not finite");
    Move move;
    move.position_mm = *outer;
    move.kind = way.rapid ? MoveKind::rapid : MoveKind::feed;
    move.space = counted_in_.space;
    move.offset = counted_in_.offset;
    move.tool = tool_;
    move.line = interpreter_.line();
    move.law = move.space == Space::workpiece ? law_ : OrientationLaw::rotary;
    if (move.law == OrientationLaw::rotary) move.rotary_rad = rotary_rad_;
    if (move.law == OrientationLaw::vector) move.axis = axis_;
    if (!feed_of(move, way)) return false;
    if (corner_ && !(way.arc ? refuse_rounding("a circle follows") : round_corner(move))) return false;
    if (way.arc && !program_.moves.empty()) move.arc = add_arc(*way.arc);
    position_mm_ = *outer;
    rapid_left_out_ = false;
    if (counted_in_.space == Space::workpiece) whole_pose_needed_ = false;
    if (move.law == OrientationLaw::vector) rotary_rad_.fill(unknown);  // path building chooses where they stand
    keep(move);
    return true;
}

std::int32_t HeidenhainReader::add_arc(const program::Arc& arc) {
    program_.arcs.push_back(arc);
    return static_cast<std::int32_t>(program_.arcs.size() - 1);
}

void HeidenhainReader::keep(const Move& move) {
    append(program_, move);
}

/// A move to a place of which something is not known is left out if nothing was known before, or if it is a rapid.
bool HeidenhainReader::leave_out(const Way& way) {
    if (corner_) return refuse_rounding("its lines are not known");
    if (program_.moves.empty()) {
        findings_.count("NC0013", Severity::warning, spot_of_motion(), "start",
                        "moves before the first pose that is known whole are left out");
        return true;
    }
    if (!way.rapid)
        return refuse("NC0710", first_word_,
                      "X, Y and Z must all be known by a rapid before the tool cuts in a frame that is turned", {},
                      "say them in L … FMAX behind PLANE, M128 or a change of datum");
    rapid_left_out_ = true;
    findings_.count("NC0752", Severity::warning, spot_of_motion(), "rapid",
                    "rapids in a turned frame are left out until X, Y and Z are all known: one rapid goes there");
    return true;
}

// ------------------------------------------------------------------------------------------------- feed

/// F as a speed in mm/s; 0 where none was given and that is allowed.
bool HeidenhainReader::path_speed(double& speed_mm_s) {
    if (!(modes_.feed > 0) && !options_.feed_given_elsewhere)
        return refuse("NC0205", first_word_, "a cutting move without a feed", {}, "--feed gives one, or F before it");
    speed_mm_s = modes_.feed / 60;
    if (!modes_.feed_per_turn) return true;
    const bool turns = modes_.spindle_rpm > 0;
    if (!turns && !options_.feed_given_elsewhere)
        return refuse("NC0723", first_word_, "a feed per turn without the spindle's speed", {}, "S before it");
    speed_mm_s = turns ? speed_mm_s * modes_.spindle_rpm : 0;
    return std::isfinite(speed_mm_s) || refuse("NC0206", first_word_, "a feed must be finite");
}

bool HeidenhainReader::feed_of(Move& move, const Way& way) {
    if (way.rapid) return true;
    double speed = 0;
    if (way.speed_mm_s)
        speed = *way.speed_mm_s;
    else if (!path_speed(speed))
        return false;
    const bool turns_only = !way.arc && !goes(position_mm_, move.position_mm);
    if (turns_only && !modes_.rotary_in_mm) return feed_of_rotation(move, speed);
    move.feed = {FeedRule::tip_speed, speed};
    return !modes_.axes_in_feed || !modes_.transform || feed_of_axes(move, way, speed);
}

/// A block that only turns: F is degrees a minute.
bool HeidenhainReader::feed_of_rotation(Move& move, double speed_mm_s) {
    move.feed = {FeedRule::rotary_rate, speed_mm_s / feed_unit_mm() * degree};
    if (!program_.moves.empty())
        findings_.count("NC0751", Severity::note, spot_of_motion(), "F",
                        "F of blocks that only turn counts in degrees a minute", "M116: at the tool's tip");
    return true;
}

/// F CONT: F is the speed of all axes of the block together, a degree for a millimetre, here as time.
bool HeidenhainReader::feed_of_axes(Move& move, const Way& way, double speed_mm_s) {
    const Move* const last = program_.moves.empty() ? nullptr : &program_.moves.back();
    if (!last || speed_mm_s == 0 || move.law == OrientationLaw::vector) return true;
    const Vector3d step = move.position_mm - position_mm_;
    double squares = way.arc ? square_of_way(*way.arc, position_mm_, step) : step.squaredNorm();
    for (std::size_t i = 0; i < move.rotary_rad.size(); ++i)
        if (!same(move.rotary_rad[i], last->rotary_rad[i]))
            squares += std::pow((move.rotary_rad[i] - last->rotary_rad[i]) / degree, 2);
    if (last->law == OrientationLaw::vector || std::isnan(squares))
        return refuse("NC0723", first_word_, "F CONT from a position that is not known", {}, "F TCP");
    const double time_s = std::sqrt(squares) / speed_mm_s;
    if (!std::isfinite(time_s)) return refuse("NC0206", first_word_, "a feed must be finite");
    move.feed = {FeedRule::block_time, time_s};
    return true;
}

// ------------------------------------------------------------------------------------------------- M140

/// Back along the tool, where its direction is known.
bool HeidenhainReader::retract(const MWord& word) {
    Way way{.rapid = word.feed_word != FeedWord::value};
    if (word.feed_word == FeedWord::value) {
        way.speed_mm_s = word.feed * feed_unit_mm() / 60;
        if (!(*way.speed_mm_s > 0) || !std::isfinite(*way.speed_mm_s))
            return refuse("NC0206", word.place, "a feed must be positive");
    }
    if (word.to_limit) return retract_to_limit(way);
    count_in(counting());
    const bool by_vector = counted_in_.space == Space::workpiece && law_ == OrientationLaw::vector;
    const bool along_z = counted_in_.space == Space::untransformed &&
                         frame_.tool_axis(Vector3d::UnitZ()) == Vector3d::UnitZ() && !retracts_aslant();
    if (!by_vector && !along_z)
        return refuse("NC0724", word.place, "M140 by a length where the tool's direction is that of rotary words", {},
                      "M140 MB MAX, or the retract as L");
    const Vector3d back = by_vector ? axis_ : Vector3d::UnitZ();
    Vector3d to = frame_.inward(position_mm_ + word.distance * unit_mm() * back);
    if (along_z) to.head<2>() = programmed_mm_.head<2>();
    if (std::isnan(to.z()) || (by_vector && to.hasNaN()))
        return refuse("NC0709", word.place, "M140 from a position that is not known", {}, "say X, Y and Z before it");
    return go(to, way);
}

/// Whether Z is not along the tool at all positions of the rotary axes: without a machine there are none.
bool HeidenhainReader::retracts_aslant() const {
    const machine::Machine* const machine = options_.machine;
    if (!machine) return false;
    bool behind_z = false;
    for (int i = 0; i < machine->axis_count; ++i) {
        const machine::Axis& axis =
            machine->axes[static_cast<std::size_t>(machine->chain[static_cast<std::size_t>(i)])];
        behind_z = behind_z || axis.letter == 'Z';
        if (axis.rotary && behind_z) return true;
    }
    return false;
}

/// M140 MB MAX, with a Z along the tool: to the end of Z's range.
bool HeidenhainReader::retract_to_limit(const Way& way) {
    const machine::Machine* const machine = options_.machine;
    const int z = machine ? machine->index_of('Z') : -1;
    const double limit = z < 0 ? unknown : machine->axes[static_cast<std::size_t>(z)].range_max;
    if (!std::isfinite(limit) || retracts_aslant() || program_.moves.empty()) {
        findings_.count("NC0753", Severity::warning, spot_of_motion(), "MB MAX",
                        "a retract to the end of the axes' ranges is left out", "retract with M91 as well");
        return true;
    }
    count_in({Space::machine, 0, 0});
    return go({programmed_mm_.x(), programmed_mm_.y(), limit}, way);
}

// ------------------------------------------------------------------------------------------------- end

bool HeidenhainReader::never_started() {
    if (!axis_words_ever_ || !program_.moves.empty()) return refuse("NC0005", Spot{}, "the program makes no move");
    return refuse("NC0006", Spot{}, "no pose is ever known whole: X, Y and Z must all be said in one frame", {},
                  "say them at the start, like L X+0 Y+0 Z+10 FMAX");
}

/// What the text left open and was assumed.
void HeidenhainReader::tell_assumptions() {
    const Move& first = first_move();
    for (std::size_t i = 0; i < rotary_rad_.size(); ++i) {
        const char letter = rotary_letter(i);
        if (is_said(i) && first.law == OrientationLaw::rotary && std::isnan(first.rotary_rad[i]))
            findings_.count(
                "NC0755", Severity::note, {first.line, 1}, std::string_view(&letter, 1),
                "the program moves before it says where this axis stands: the setup's start counts, else 0");
    }
    if (!frames_.in_force().is_identity())
        findings_.count("NC0754", Severity::warning, last_motion_, "frame",
                        "a datum shift, mirror, rotation, scale or tilted plane is still in force at the end",
                        "PLANE RESET, CYCL DEF 7 with zeros take it away");
    report_units(stated_, options_.units, findings_);
}

bool HeidenhainReader::finish() {
    if (corner_) return refuse_rounding("no line follows");
    if (program_.moves.size() < 2) return never_started();
    tell_assumptions();
    return true;
}

}  // namespace trunnion::nc::heidenhain
