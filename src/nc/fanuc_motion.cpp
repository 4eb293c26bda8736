#include <algorithm>
#include <numbers>

#include "detail/fanuc_reader.hpp"
#include "detail/same_place.hpp"

namespace trunnion::nc::fanuc {

using Eigen::Vector3d;
using program::FeedRule;
using program::Move;
using program::MoveKind;
using program::OrientationLaw;
using program::Space;

namespace {

constexpr double whole_turn = 2 * std::numbers::pi;
constexpr double same_angle_rad = 1e-9;
constexpr double smallest_vector = 1e-12;
constexpr double pitch_tolerance = 0.1;  ///< turns: by how much the pitch of a helix may miss a whole number
constexpr std::string_view linear_letters = "XYZ", centre_letters = "IJK";

bool is_circle(Meaning motion) {
    return motion == Meaning::clockwise || motion == Meaning::counter_clockwise;
}

}  // namespace

Spot FanucReader::spot_of_motion() const {
    for (const Word& word : block_.words)
        if (is_axis(word.letter)) return block_.spot(word);
    return block_.place();
}

/// All rotary axes stand where a coordinate with TCP and one without mean the same.
bool FanucReader::upright() const {
    const int axes = options_.machine ? options_.machine->rotary_count : 0;
    for (std::size_t i = 0; i < static_cast<std::size_t>(axes); ++i)
        if (!(std::abs(std::remainder(rotary_rad_[i], whole_turn)) < same_angle_rad)) return false;
    return true;
}

/// Makes the linear words count in what is in force. Where offset or space change, what was known of the position is
/// not known any more; under another length X and Y are.
bool FanucReader::count_in(bool machine_position) {
    if (plane_said_ && !swivelled_ && !tcp() && !machine_position && plane_.turns())
        return refuse("NC0844", spot_of_motion(), "motion in a tilted plane to which the tool was not turned", {},
                      "G53.1 behind G68.2");
    const bool by_tip = tcp() || swivelled_ || dynamic_on_;
    const CountedIn now =
        machine_position ? CountedIn{Space::machine, 0, 0}
                         : CountedIn{by_tip ? Space::workpiece : Space::untransformed, modes_.offset, length_tool_};
    if (now == counted_in_) return true;
    const bool same_offset =
        !machine_position && counted_in_.space != Space::machine && now.offset == counted_in_.offset;
    const bool keeps = same_offset && (now.space == counted_in_.space || (upright() && !plane_said_));
    const bool same_length = now.tool == counted_in_.tool;
    counted_in_ = now;
    rapid_left_out_ = false;
    frame_ = frame_in_force();
    if (!keeps) programmed_mm_.setConstant(unknown);
    if (!same_length) programmed_mm_.z() = unknown;
    position_mm_ = frame_.outward(programmed_mm_).value_or(Vector3d::Constant(unknown));
    return true;
}

bool FanucReader::motion() {
    const Meaning asked_motion = asked(Group::motion);
    const bool asks_cycle = asked(Group::cycle) == Meaning::cycle;
    if (asked_motion != Meaning::unknown) {
        if (asks_cycle)
            return refuse("NC0823", code_of(Group::cycle), "a drilling cycle and another motion in one block");
        modes_.motion = asked_motion;
        cycle_ = {};
    }
    if (asks_cycle && !begin_cycle(static_cast<int>(code_of(Group::cycle).value))) return false;
    const bool axes = (said_.said() & control_.axis_letters()) != 0;
    if (cycle_.number != 0) return axes || said_.has('R') || asks_cycle ? drill() : true;
    if (modes_.motion == Meaning::nurbs) return axes || said_.has('K') ? nurbs_block() : true;
    const bool arc = is_circle(modes_.motion) && said_.has_any("IJKR");
    const bool vector = modes_.length == Meaning::tcp_vector && said_.has_any(centre_letters);
    if (!axes && !arc && !vector) return true;
    if (modes_.motion == Meaning::unknown)
        return refuse("NC0828", spot_of_motion(), "an axis word, but no motion is in force", {}, "G0 or G1 before it");
    const bool machine_position = asked(Group::once) == Meaning::machine_position;
    if (machine_position && !modes_.absolute) return machine_position_in_g91();
    axis_words_ever_ = true;
    last_motion_ = block_.place();
    if (!count_in(machine_position)) return false;
    Vector3d to = programmed_mm_;
    Way way{.rapid = modes_.motion == Meaning::rapid};
    if (!axis_words(to) || !said_since_reference(way)) return false;
    if (is_circle(modes_.motion) ? !circle(to, way) : !tool_vector()) return false;
    if (!go(to, way)) return false;
    interpreter_.moved();
    return true;
}

/// Where the block goes: `to` and rotary_rad_ from its words.
bool FanucReader::axis_words(Vector3d& to) {
    bool turns = false;
    at_reference_ &= ~said_.said();
    for (std::uint32_t letters = said_.said() & control_.axis_letters(); letters != 0; letters &= letters - 1) {
        const auto index = static_cast<std::size_t>(std::countr_zero(letters));
        const Word& word = said_.word(static_cast<char>('A' + index));
        const bool linear = control_.kind(index) == Control::Letter::linear;
        const std::size_t axis = control_.axis(index);
        double& coordinate = linear ? to[static_cast<Eigen::Index>(axis)] : rotary_rad_[axis];
        const double way = word.value * (linear ? modes_.unit_mm : degree);
        if (!linear && swivelled_ && !tcp())
            return refuse("NC0844", word, "rotary words in a tilted plane", "G69 leaves the plane");
        if (!modes_.absolute && std::isnan(coordinate))
            return refuse(
                "NC0830", word, "an incremental word from a position that is not known",
                "say the position once in G90 after changes of offset, tool length or tool-centre-point mode");
        coordinate = modes_.absolute ? way : coordinate + way;
        if (!std::isfinite(coordinate)) return refuse("NC0201", word, "the position is not finite");
        if (linear) continue;
        turns = true;
        rotary_ever_ |= 1u << axis;
    }
    said_.use_mask(control_.axis_letters());
    if (!turns) return true;
    if (modes_.length == Meaning::tcp_vector)
        return refuse("NC0847", spot_of_motion(), "rotary words under G43.5, which takes tool vectors", {}, "G43.4");
    if (!mirror_.is_identity() && counted_in_.space == Space::workpiece)
        return refuse("NC0845", spot_of_motion(), "rotary words under a mirror: the tool would not be mirrored");
    law_ = OrientationLaw::rotary;
    if (!dynamic_on_ || counted_in_.space == Space::machine) return true;
    if (!modes_.absolute) return refuse("NC0846", spot_of_motion(), "incremental words that turn a table under G254");
    for (Eigen::Index i = 0; i < 3; ++i)
        if (!said_.has(linear_letters[static_cast<std::size_t>(i)])) to[i] = unknown;
    return turn_dynamic_frame();
}

/// G43.5: I J K are the tool's vector, from the tip on; those not said are 0. Law vector from here on.
bool FanucReader::tool_vector() {
    if (modes_.length != Meaning::tcp_vector || !said_.has_any(centre_letters)) return true;
    said_.use(centre_letters);
    if (counted_in_.space != Space::workpiece)
        return refuse("NC0847", spot('I'), "a tool vector in a block of machine positions");
    const Vector3d vector(said_.get('I', 0), said_.get('J', 0), said_.get('K', 0));
    const double length = vector.stableNorm();
    if (!(length > smallest_vector) || !std::isfinite(length))
        return refuse("NC0847", spot_of_motion(), "a tool vector without direction");
    axis_ = *frame_.tool_axis(vector / length);  // no scale bends it
    law_ = OrientationLaw::vector;
    return true;
}

/// An axis that was sent to its reference point stands where only the control knows; it must be said before it cuts.
bool FanucReader::said_since_reference(const Way& way) {
    if (at_reference_ == 0 || way.rapid || program_.moves.empty()) return true;
    const char letter = static_cast<char>('A' + std::countr_zero(at_reference_));
    return refuse("NC0837", spot_of_motion(), "an axis was sent where only the control knows, and was not said since",
                  std::string_view(&letter, 1), "say the axis in a rapid behind G28, G53 in G91 or a return by G98");
}

// ------------------------------------------------------------------------------------------------------------- circles

/// R, or the centre from the start by the letters of the plane.
bool FanucReader::centre_words() {
    int given = 0;
    for (int i = 0; i < 3; ++i)
        if (i != modes_.normal_axis && said_.has(centre_letters[static_cast<std::size_t>(i)])) ++given;
    if (said_.has('R') == (given > 0))
        return refuse("NC0835", spot_of_motion(), "a circle needs its centre (I J K) or its radius (R), not both");
    return true;
}

bool FanucReader::circle(const Vector3d& to, Way& way) {
    if (!centre_words()) return false;
    const int along = modes_.normal_axis;
    Vector3d from = programmed_mm_, end = to, centre = programmed_mm_;
    if (std::isnan(from[along]) || std::isnan(end[along])) from[along] = end[along] = centre[along] = 0;
    if (from.hasNaN() || end.hasNaN())
        return refuse("NC0836", spot_of_motion(), "a circle from a position that is not known", {},
                      "say the coordinates of its plane in a straight move before it");
    for (Eigen::Index i = 0; i < 3; ++i)
        if (const char letter = centre_letters[static_cast<std::size_t>(i)]; i != along && said_.has(letter))
            centre[i] += length_of(letter);
    const bool clockwise = modes_.motion == Meaning::clockwise;
    const Vector3d normal = Vector3d::Unit(along);
    const auto with_turns = [&](double further) {
        return said_.has('R') ? arc_by_radius(from, end, length_of('R'), normal, clockwise, further, fanuc_arcs)
                              : arc_by_centre(from, end, centre, normal, clockwise, further, fanuc_arcs);
    };
    auto arc = with_turns(0);
    double further = 0;
    if (arc && !turns_of(end - from, std::abs(arc->angle_rad), further)) return false;
    if (arc && further > 0) arc = with_turns(further);
    if (!arc) return findings_.refuse(spot_of_motion(), std::move(arc.error()));
    said_.use("IJKRL");
    way.arc = frame_.arc(*arc, along);  // mirrors and rotations keep a circle
    return true;
}

/// Whole turns besides: by L, or by the letter of the axis across the plane, which is then the rise of a turn.
bool FanucReader::turns_of(const Vector3d& step, double angle_rad, double& further) {
    const char pitch_letter = centre_letters[static_cast<std::size_t>(modes_.normal_axis)];
    if (said_.has('L')) {
        if (!(said_['L'] >= 1 && said_['L'] == std::floor(said_['L'])))
            return refuse("NC0835", said_.word('L'), "the turns of a helix are a whole number, at least 1");
        further = said_['L'] - 1;
    } else if (said_.has(pitch_letter) && said_[pitch_letter] != 0) {
        const double turns = std::abs(step[modes_.normal_axis] / length_of(pitch_letter)) - angle_rad / whole_turn;
        further = std::max(0.0, std::round(turns));
        if (!(std::abs(turns - further) <= pitch_tolerance))
            return refuse("NC0835", said_.word(pitch_letter), "the rise of a turn does not fit the helix",
                          "the letter of the axis across the plane is the way along it of a whole turn");
    }
    return true;
}

// --------------------------------------------------------------------------------------------------------------- moves

Move FanucReader::move_to(const Vector3d& position_mm, MoveKind kind) const {
    Move move;
    move.position_mm = position_mm;
    move.kind = kind;
    move.space = counted_in_.space;
    move.offset = counted_in_.offset;
    move.tool = move.space == Space::machine ? in_spindle_ : counted_in_.tool;
    move.exact_stop = modes_.exact_stop || exact_stop_once_;
    move.line = block_.line;
    move.law = move.space == Space::workpiece ? law_ : OrientationLaw::rotary;
    if (move.law == OrientationLaw::rotary) move.rotary_rad = rotary_rad_;
    if (move.law == OrientationLaw::vector) move.axis = axis_;
    return move;
}

/// From where the tool stands to a place in the programmed frame. Coordinates that are not known stay as they are.
bool FanucReader::go(const Vector3d& to, const Way& way) {
    const auto outer = frame_.outward(to);
    const bool whole_needed = program_.moves.empty() || (whole_pose_needed_ && counted_in_.space == Space::workpiece);
    programmed_mm_ = to;
    if (!outer || (whole_needed && to.hasNaN()) || (rapid_left_out_ && !way.rapid)) return leave_out(way);
    if (outer->array().isInf().any()) return refuse("NC0201", spot_of_motion(), "the position is not finite");
    Move move = move_to(*outer, way.rapid ? MoveKind::rapid : MoveKind::feed);
    if (!feed_of(move, way)) return false;
    if (way.arc && !program_.moves.empty()) {
        move.arc = static_cast<std::int32_t>(program_.arcs.size());
        program_.arcs.push_back(*way.arc);
    }
    if (move.kind == MoveKind::feed && move.tool < program_.tools.size() && !tool_.empty() &&
        modes_.length == Meaning::no_length && move.space != Space::machine)
        findings_.count("NC0869", Severity::warning, spot_of_motion(), program_.tools[in_spindle_],
                        "cutting with a tool whose length does not count: G43 is not in force",
                        "G43 and H where the control has the length");
    position_mm_ = *outer;
    rapid_left_out_ = false;
    if (counted_in_.space == Space::workpiece) whole_pose_needed_ = false;
    if (move.law == OrientationLaw::vector) rotary_rad_.fill(unknown);  // path building chooses where they stand
    add(move);
    return true;
}

/// A move to a place of which something is not known is left out if nothing was known before, or if it is a rapid.
bool FanucReader::leave_out(const Way& way) {
    if (program_.moves.empty()) {
        findings_.count("NC0013", Severity::warning, spot_of_motion(), "start",
                        "moves before the first pose that is known whole are left out");
        return true;
    }
    if (!way.rapid)
        return refuse("NC0838", spot_of_motion(),
                      "X, Y and Z must all be known by a rapid before the tool cuts in a frame that is turned", {},
                      "say them in G0 behind G53.1, G254 or a change of offset");
    rapid_left_out_ = true;
    findings_.count("NC0863", Severity::warning, spot_of_motion(), "rapid",
                    "rapids in a turned frame are left out until X, Y and Z are all known: one rapid goes there");
    return true;
}

void FanucReader::add(const Move& move) {
    append(program_, move);
}

/// F as a speed in mm/s; 0 where none was given and that is allowed.
bool FanucReader::path_speed(double& speed_mm_s) {
    speed_mm_s = 0;
    if (!(modes_.feed > 0)) {
        if (options_.feed_given_elsewhere) return true;
        if (modes_.feed_kind == Meaning::inverse_time)
            return refuse("NC0832", spot_of_motion(), "G93 needs F in every block that cuts", {},
                          "--feed gives one instead");
        return refuse("NC0205", spot_of_motion(), "a cutting move without a feed", {},
                      "--feed gives one, or F before it");
    }
    double per_minute = modes_.feed * (modes_.feed_kind == Meaning::inverse_time ? 1 : modes_.feed_unit_mm);
    if (modes_.feed_kind == Meaning::per_revolution) {
        if (!(modes_.spindle_rpm > 0)) {
            if (options_.feed_given_elsewhere) return true;
            return refuse("NC0833", spot_of_motion(), "G95 without the spindle's speed", {}, "S before it");
        }
        per_minute *= modes_.spindle_rpm;
    }
    speed_mm_s = per_minute / 60;
    return true;
}

bool FanucReader::feed_of(Move& move, const Way& way) {
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
    if (way.arc || program_.moves.empty() || goes(position_mm_, move.position_mm))
        move.feed = {FeedRule::tip_speed, speed};
    else
        move.feed = {FeedRule::rotary_rate, speed / modes_.feed_unit_mm * degree};
    return true;
}

// ------------------------------------------------------------------------------------------------------ reference
// point

/// G28, G30: by way of the point that is said to the reference point. The point is gone to; the reference point is of
/// the control, so that the axes are left where they stand and count as not known.
bool FanucReader::reference() {
    said_.use("P");
    std::uint32_t letters = said_.said() & control_.axis_letters();
    const bool passes = std::ranges::any_of(
        block_.words, [&](const Word& word) { return is_axis(word.letter) && (modes_.absolute || word.value != 0); });
    if (letters == 0) letters = control_.axis_letters();
    if (passes) {
        axis_words_ever_ = true;
        if (!count_in(false)) return false;
        Vector3d to = programmed_mm_;
        const std::uint32_t known = at_reference_;
        if (!axis_words(to) || !go(to, {.rapid = true})) return false;
        at_reference_ = known;
    }
    said_.use_mask(control_.axis_letters());
    return send_home(letters);
}

/// FANUC passes it over, others go there.
bool FanucReader::machine_position_in_g91() {
    if (modes_.motion != Meaning::rapid)
        return refuse("NC0834", code_of(Group::once), "G53 needs G90 where it cuts", "G91 is in force");
    findings_.count("NC0873", Severity::warning, block_.place(), "G53",
                    "G53 under G91 is passed over by FANUC and gone to by others: left out", "G90 before it");
    const std::uint32_t letters = said_.said() & control_.axis_letters();
    said_.use_mask(letters);
    leave_unknown(letters);
    return true;
}

bool FanucReader::send_home(std::uint32_t letters) {
    leave_unknown(letters);
    findings_.count("NC0862", Severity::warning, block_.place(), "G28",
                    "the way to a reference point is left out: where it is is known to the control alone",
                    "G53 goes to positions of the machine");
    return true;
}

/// The axes stand where only the control knows; in the plan they stay.
void FanucReader::leave_unknown(std::uint32_t letters) {
    const bool straight = counted_in_.space == Space::untransformed || (upright() && !plane_said_ && !dynamic_on_);
    for (std::uint32_t rest = letters; rest != 0; rest &= rest - 1) {
        const auto index = static_cast<std::size_t>(std::countr_zero(rest));
        const std::size_t axis = control_.axis(index);
        if (control_.kind(index) == Control::Letter::rotary)
            rotary_rad_[axis] = unknown;
        else if (straight)
            programmed_mm_[static_cast<Eigen::Index>(axis)] = unknown;
        else
            programmed_mm_.setConstant(unknown);
    }
    position_mm_ = frame_.outward(programmed_mm_).value_or(Vector3d::Constant(unknown));
    at_reference_ |= letters;
}

// ----------------------------------------------------------------------------------------------------------------- end

bool FanucReader::never_started() {
    if (!axis_words_ever_ || !program_.moves.empty()) return refuse("NC0005", Spot{}, "the program makes no move");
    return refuse("NC0006", Spot{}, "no pose is ever known whole: X, Y and Z must all be said in one frame", {},
                  "say them at the start, like G0 X0 Y0 Z10");
}

/// What the text left open and was assumed.
void FanucReader::tell_assumptions() {
    const Move& first = first_move();
    for (std::size_t i = 0; i < rotary_rad_.size(); ++i) {
        const char letter = rotary_letter(i);
        if (is_said(i) && first.law == OrientationLaw::rotary && std::isnan(first.rotary_rad[i]))
            findings_.count(
                "NC0870", Severity::note, {first.line, 1}, std::string_view(&letter, 1),
                "the program moves before it says where this axis stands: the setup's start counts, else 0");
    }
    if (interpreter_.code_is_left())
        findings_.count("NC0014", Severity::note, {block_.line, 1}, "end",
                        "the text behind the end of the program is not read");
    report_units(stated_, options_.units, findings_);
}

bool FanucReader::finish() {
    if (!end_nurbs()) return false;
    if (program_.moves.size() < 2) return never_started();
    tell_assumptions();
    return true;
}

}  // namespace trunnion::nc::fanuc
