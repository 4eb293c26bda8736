#include <algorithm>

#include <Eigen/Geometry>

#include "detail/sinumerik_reader.hpp"

namespace trunnion::nc::sinumerik {

using Eigen::Vector3d;
using program::OrientationLaw;
using program::Space;

namespace {

constexpr double smallest_vector = 1e-12;
constexpr double whole_turn = 360;  ///< degrees, as words count

/// Where a rotary word leads, in degrees.
double rotary_target(double value, double from, Counting counting, bool absolute) {
    switch (counting) {
        case Counting::modal:
            return absolute ? value : from + value;
        case Counting::absolute:
            return value;
        case Counting::incremental:
            return from + value;
        case Counting::shortest:
            return value + whole_turn * std::round((from - value) / whole_turn);
        case Counting::positive:
            return value + whole_turn * std::ceil((from - value) / whole_turn);
        case Counting::negative:
            return value + whole_turn * std::floor((from - value) / whole_turn);
    }
    return unknown;
}

/// Numbers among the arguments of a call, with a value for those that are left out.
double argument(const Word& call, std::size_t index, double otherwise = 0) {
    const bool given = index < call.arguments.size() && call.arguments[index].kind == Argument::Kind::number;
    return given ? call.arguments[index].number : otherwise;
}

// The arguments of CYCLE800 by their place.
constexpr std::size_t retract_at = 0, data_at = 1, state_at = 2, mode_at = 3, before_at = 4, angles_at = 7,
                      after_at = 10, direction_at = 13;

int digit(double number, int place) {
    return static_cast<int>(std::fmod(std::floor(std::abs(number) / std::pow(10, place)), 10));
}

/// Nothing but `CYCLE800()`, or the swivel data record `0`: leave the swivelled plane.
bool leaves_plane(const Word& call) {
    const bool no_arguments =
        std::ranges::all_of(call.arguments, [](const Argument& a) { return a.kind == Argument::Kind::empty; });
    return no_arguments || (call.arguments.size() > data_at && call.arguments[data_at].text == "0");
}

}  // namespace

bool SinumerikReader::rotary_word(Address address) {
    const std::size_t axis = static_cast<std::size_t>(address) - static_cast<std::size_t>(Address::rotary_1);
    if (swivelled_ && !modes_.transform)
        return refuse("NC0624", spot(address), "rotary words in a swivelled plane", {},
                      "CYCLE800() leaves the plane; CYCLE800 turns the tool");
    const double from = rotary_rad_[axis] / degree;
    double to = rotary_target(said_[address], from, said_.counting(address), modes_.absolute);
    if (std::isnan(from) && said_.counting(address) == Counting::shortest) {
        to = said_[address];
        findings_.count("NC0660", Severity::warning, spot(address), "DC",
                        "DC from a position that is not known: the angle is taken as it is written",
                        "say the angle once in G90");
    }
    if (std::isnan(to))
        return refuse("NC0611", spot(address), "IC, ACP or ACN from a position that is not known", {},
                      "say the angle once in G90");
    if (!std::isfinite(to * degree)) return refuse("NC0201", spot(address), "the position is not finite");
    rotary_rad_[axis] = to * degree;
    rotary_ever_ |= 1u << axis;
    law_ = OrientationLaw::rotary;
    tool_as_swivelled_ = false;
    return true;
}

/// Whether one of the machine's rotary axes is not known.
bool SinumerikReader::has_free_rotary(const RotaryWords& words) const {
    const auto axes = static_cast<std::ptrdiff_t>(options_.machine ? options_.machine->rotary_count : 0);
    return std::any_of(words.begin(), words.begin() + axes, [](double word) { return std::isnan(word); });
}

/// Vectors and angles that say the tool's axis: law vector from here on.
bool SinumerikReader::orientation() {
    if (!said_.has_any(Address::a2, Address::c3)) return true;
    said_.use(Address::a2, Address::c3);
    if (!modes_.transform || counted_in_.space != Space::workpiece)
        return refuse("NC0617", spot_of_motion(), "tool vectors and angles need TRAORI", {}, "TRAORI before them");
    if (said_.has_any(Address::rotary_1, Address::rotary_3))
        return refuse("NC0617", spot_of_motion(), "rotary words and a tool vector in one block");
    Vector3d vector;
    if (said_.has_any(Address::a3, Address::c3) ? !vector_words(vector) : !angle_words(vector)) return false;
    const auto axis = frame_.tool_axis(vector);
    if (!axis) return refuse("NC0620", spot_of_motion(), "a tool vector under SCALE with different factors");
    const bool turns = law_ != OrientationLaw::vector || *axis != axis_;
    if (turns && (modes_.axes_linear || modes_.in_machine))
        return refuse("NC0617", spot_of_motion(),
                      "tool vectors with ORIAXES or ORIMKS, where the rotary axes go straight, are not supported", {},
                      "ORIVECT and ORIWKS, or rotary words");
    axis_ = *axis;
    law_ = OrientationLaw::vector;
    tool_as_swivelled_ = false;
    return true;
}

/// A3 B3 C3: those that are not said are 0.
bool SinumerikReader::vector_words(Vector3d& vector) {
    if (said_.has_any(Address::a2, Address::c2))
        return refuse("NC0617", spot_of_motion(), "a tool vector and angles in one block");
    vector = {said_.get(Address::a3, 0), said_.get(Address::b3, 0), said_.get(Address::c3, 0)};
    const double length = vector.stableNorm();
    if (!(length > smallest_vector) || !std::isfinite(length))
        return refuse("NC0618", spot_of_motion(), "a tool vector without direction");
    vector /= length;
    return true;
}

/// A2 B2 C2 turn a vector along Z: ORIEULER by A2 about Z, then B2 about the new X; ORIRPY by C2 about Z, then B2 about
/// the new Y, then A2 about the new X.
bool SinumerikReader::angle_words(Vector3d& vector) {
    if (!modes_.angles)
        return refuse("NC0617", spot_of_motion(), "angles of the tool, but not said which", {}, "ORIEULER or ORIRPY");
    const bool euler = modes_.angles == Meaning::euler_angles;
    if (!said_.has(Address::a2) || !said_.has(Address::b2) || (!euler && !said_.has(Address::c2)))
        return refuse("NC0617", spot_of_motion(), "an angle of the tool is missing", {},
                      euler ? "A2 and B2" : "A2, B2 and C2");
    const double a = said_[Address::a2] * degree, b = said_[Address::b2] * degree;
    const auto about = [](int axis, double angle) { return Eigen::AngleAxisd(angle, Vector3d::Unit(axis)); };
    if (euler)
        vector = about(2, a) * about(0, b) * Vector3d::UnitZ();
    else
        vector = about(2, said_[Address::c2] * degree) * about(1, b) * about(0, a) * Vector3d::UnitZ();
    return true;
}

// ----------------------------------------------------------------------------------------------------------- frames

void SinumerikReader::frames_changed() {
    if (counted_in_.space == Space::machine) return;  // the frame comes back with the next block that counts in it
    frame_ = frame_in_force();
    programmed_mm_ = frame_.inward(position_mm_);
}

/// X Y Z behind TRANS and the like.
bool SinumerikReader::frame_values(double otherwise, double unit, Vector3d& values) {
    for (const Address address : {Address::rotary_1, Address::rotary_2, Address::rotary_3})
        if (said_.has(address))
            return refuse("NC0619", spot(address), "frames of rotary axes are not supported", {},
                          "write the angles with the offset worked in");
    for (Eigen::Index i = 0; i < 3; ++i) {
        const auto address = static_cast<Address>(static_cast<Eigen::Index>(Address::x) + i);
        values[i] = said_.has(address) ? said_[address] * unit : otherwise;
        if (said_.has(address) && said_.counting(address) != Counting::modal)
            return refuse("NC0619", spot(address), "AC, IC and DC have no meaning here");
    }
    said_.use(Address::x, Address::z);
    return true;
}

/// TRANS, ROT, SCALE, MIRROR take the place of all of them; with A in front they come on top; alone they end all.
bool SinumerikReader::frame_statement() {
    const WordRule rule = rule_of_name(frame_word_->name);
    CoordinateFrame change;
    Vector3d values;
    if (call_ || modal_call_) return refuse("NC0606", *frame_word_, "two instructions in a block that need their own");
    if (rule.meaning == Meaning::translate) {
        if (!frame_values(0, modes_.unit_mm, values)) return false;
        change = CoordinateFrame::shifted(values);
    } else if (rule.meaning == Meaning::rotate) {
        if (!rotation(change)) return false;
    } else {
        const bool mirrors = rule.meaning == Meaning::mirror;
        if (!frame_values(1, mirrors ? 0 : 1, values)) return false;
        if (mirrors) values = (values.array() == 0).select(-Vector3d::Ones(), Vector3d::Ones());
        if (!mirrors && !(values.minCoeff() > 0 && values.maxCoeff() < 1e6))
            return refuse("NC0619", *frame_word_, "a scale must be positive");
        change = CoordinateFrame::stretched(values);
    }
    programmable_ = rule.which == 1 ? programmable_.with(change) : change;
    frames_changed();
    return true;
}

/// ROT: X Y Z about these axes in the order Z, Y, X, each time the new ones; RPL about the axis across the plane.
bool SinumerikReader::rotation(CoordinateFrame& turned) {
    Vector3d angles;
    const bool in_space = said_.has_any(Address::x, Address::z);
    if (!frame_values(0, degree, angles)) return false;
    turned = CoordinateFrame::turned_rpy(angles);
    if (!said_.has(Address::plane_angle)) return true;
    if (in_space) return refuse("NC0619", spot(Address::plane_angle), "RPL beside X Y Z");
    said_.use(Address::plane_angle);
    turned = CoordinateFrame::turned(modes_.normal_axis, said_[Address::plane_angle] * degree);
    return true;
}

// --------------------------------------------------------------------------------------------------------- CYCLE800

/// From here on the coordinates are the tip's in the new plane and the tool stands across it.
bool SinumerikReader::swivel(const Word& call) {
    if (leaves_plane(call)) {
        swivel_frame_ = programmable_ = CoordinateFrame{};
        leave_plane();
        return true;
    }
    CoordinateFrame frame;
    if (!swivel_frame(call, frame)) return false;
    if (argument(call, retract_at) != 0)
        findings_.count("NC0653", Severity::warning, block_.spot(call), "_FR",
                        "the retract of CYCLE800 goes where the control's swivel data say: left out",
                        "retract with SUPA before it");
    if (argument(call, direction_at, -1) != 0)
        findings_.count("NC0658", Severity::note, block_.spot(call), "_DIR",
                        "CYCLE800: of the rotary positions that reach the plane the nearer ones are taken");
    swivel_frame_ = frame;
    programmable_ = CoordinateFrame{};
    if (argument(call, direction_at, -1) == 0) {  // a shift alone
        leave_plane();
        return true;
    }
    const Vector3d axis = *frame.tool_axis(Vector3d::UnitZ());
    whole_pose_needed_ = whole_pose_needed_ || law_ != OrientationLaw::vector || axis != axis_;
    axis_ = axis;
    law_ = OrientationLaw::vector;
    swivelled_ = tool_as_swivelled_ = true;
    frames_changed();
    return true;
}

void SinumerikReader::leave_plane() {
    if (swivelled_) law_ = OrientationLaw::rotary;
    swivelled_ = whole_pose_needed_ = false;
    frames_changed();
}

bool SinumerikReader::swivel_frame(const Word& call, CoordinateFrame& frame) {
    const double state = argument(call, state_at);
    const bool additive = digit(state, 0) == 1;
    if (digit(state, 0) > 1 || digit(state, 2) != 0 || digit(state, 3) != 0)
        return refuse("NC0623", call, "CYCLE800: this state (_ST) is not supported",
                      "0 or 1: a new plane, or one on top");
    const Vector3d angles =
        Vector3d(argument(call, angles_at), argument(call, angles_at + 1), argument(call, angles_at + 2)) * degree;
    const bool shifts_alone = angles.isZero(0) && !additive && !swivelled_;
    if ((argument(call, direction_at, -1) == 0 && !shifts_alone) || digit(state, 4) != 0)
        return refuse("NC0623", call, "CYCLE800 that does not turn the tool is not supported", "_DIR -1 or 1");
    if (modes_.normal_axis != 2) return refuse("NC0623", call, "CYCLE800 needs G17");
    if (additive && !programmable_.is_identity())
        return refuse("NC0623", call, "CYCLE800 on top of TRANS, ROT, SCALE or MIRROR",
                      "TRANS without words before it");
    const auto lengths = [&](std::size_t first) -> Vector3d {
        return Vector3d(argument(call, first), argument(call, first + 1), argument(call, first + 2)) * modes_.unit_mm;
    };
    const double mode = argument(call, mode_at, 57);
    if (!(mode >= 0 && mode < 128) || mode != std::floor(mode))
        return refuse("NC0623", call, "CYCLE800 by projected angles or by rotary axes is not supported",
                      "_MODE axis by axis (57) or by solid angle (64)");
    const int bits = static_cast<int>(mode);
    frame = CoordinateFrame::shifted(lengths(before_at));
    if ((bits & 64) != 0) {
        if (angles.z() != 0) return refuse("NC0623", call, "CYCLE800 by solid angle has two angles");
        frame = frame.with(CoordinateFrame::turned(2, angles.x())).with(CoordinateFrame::turned(1, angles.y()));
    }
    for (int i = 0; i < 3 && (bits & 64) == 0; ++i) {
        const int axis = (bits >> (2 * i) & 3) - 1;
        if (axis < 0 && angles[i] != 0) return refuse("NC0623", call, "CYCLE800: _MODE names no axis for an angle");
        if (axis >= 0) frame = frame.with(CoordinateFrame::turned(axis, angles[i]));
    }
    frame = frame.with(CoordinateFrame::shifted(lengths(after_at)));
    if (additive) frame = swivel_frame_.with(frame);
    return true;
}

}  // namespace trunnion::nc::sinumerik
