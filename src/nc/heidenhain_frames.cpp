#include "detail/heidenhain_frames.hpp"

#include <algorithm>

#include <Eigen/Geometry>

#include "detail/heidenhain_reader.hpp"

namespace trunnion::nc::heidenhain {

using Eigen::Vector3d;
using program::Move;
using program::OrientationLaw;
using program::Space;

CoordinateFrame Transformations::frame() const {
    CoordinateFrame frame;
    if (shifts()) frame = CoordinateFrame::shifted(shift_mm);
    if (mirrors())
        frame = frame.with(
            CoordinateFrame::stretched({mirrored[0] ? -1.0 : 1.0, mirrored[1] ? -1.0 : 1.0, mirrored[2] ? -1.0 : 1.0}));
    if (turns()) frame = frame.with(CoordinateFrame::turned(2, rotation_rad));
    if (scales())
        frame = frame.with(CoordinateFrame::shifted(scale_centre_mm))
                    .with(CoordinateFrame::stretched(scale * axis_scales))
                    .with(CoordinateFrame::shifted(-scale_centre_mm));
    return frame;
}

CoordinateFrame Frames::in_force() const {
    if (!plane) return before.frame();
    return before.frame().with(*plane).with(within.frame());
}

void Frames::leave_plane() {
    if (!plane) return;
    plane.reset();
    if (!within.is_identity()) before = within;
    within = {};
}

void HeidenhainReader::forget_position() {
    position_mm_.setConstant(unknown);
    programmed_mm_.setConstant(unknown);
}

void HeidenhainReader::frames_changed() {
    centre_mm_.setConstant(unknown);
    if (counted_in_.space == Space::machine) return;  // the frame comes back with the next block that counts in it
    frame_ = frames_.in_force();
    programmed_mm_ = frame_.inward(position_mm_);
}

// ------------------------------------------------------------------------------------------------- cycles 7 … 26

/// X, Y, Z behind CYCL DEF 7 or TRANS DATUM AXIS; those not said stay.
bool HeidenhainReader::shift_words() {
    const std::size_t place = cursor().next_index();
    if (cursor().front() == '#')
        return refuse("NC0715", place, "datum tables are not supported", {}, "the shift as X, Y and Z");
    if (!numbers_alone(Addresses::bits(Address::x, Address::z))) return false;
    Vector3d shift = frames_.said_now().shift_mm;
    for (Eigen::Index i = 0; i < 3; ++i) {
        const auto address = static_cast<Address>(i);
        if (!said_.has(address)) continue;
        const double value = said_[address] * unit_mm();
        shift[i] = said_.is_incremental(address) ? shift[i] + value : value;
    }
    if (!shift.allFinite()) return refuse("NC0201", place, "the position is not finite");
    return set_shift(shift, place);
}

bool HeidenhainReader::set_shift(const Vector3d& shift_mm, std::size_t place) {
    Transformations& now = frames_.said_now();
    if (shift_mm == now.shift_mm) return true;
    if (!shift_mm.isZero(0) && (now.mirrors() || now.turns() || now.scales()))
        return refuse("NC0715", place, "a datum shift while a mirror, rotation or scale is in force", {},
                      "the shift before them");
    if (frames_.plane && frames_.before.shifts())
        return refuse("NC0715", place, "a datum shift in a tilted plane on top of one before it", {},
                      "PLANE RESET before it, or one of the two");
    now.shift_mm = shift_mm;
    frames_changed();
    return true;
}

/// The axes that cycle 8 mirrors; none: no longer.
bool HeidenhainReader::mirror() {
    Transformations& now = frames_.said_now();
    const std::size_t place = cursor().next_index();
    now.mirrored = {};
    while (!cursor().at_end()) {
        const std::size_t at = cursor().index();
        const std::string_view name = cursor().name();
        if (name.size() != 1 || name[0] < 'X' || name[0] > 'Z')
            return refuse("NC0715", at, "only X, Y and Z are mirrored", name);
        now.mirrored[static_cast<std::size_t>(name[0] - 'X')] = true;
    }
    if (now.mirrors() && now.turns())
        return refuse("NC0715", place, "a mirror while a rotation is in force", {}, "the mirror before the rotation");
    frames_changed();
    return true;
}

bool HeidenhainReader::rotation() {
    Transformations& now = frames_.said_now();
    const std::size_t place = cursor().next_index();
    const bool incremental = cursor().take_word("IROT");
    double angle = 0;
    if ((!incremental && !cursor().take_word("ROT")) || !values().value(angle))
        return refuse("NC0715", place, "cycle 10 needs its angle", {}, "ROT+30");
    angle = angle * degree + (incremental ? now.rotation_rad : 0);
    if (!std::isfinite(angle)) return refuse("NC0201", place, "the position is not finite");
    if (angle != 0 && now.axis_scales != Vector3d::Ones())
        return refuse("NC0715", place, "a rotation while scales of single axes are in force");
    now.rotation_rad = angle;
    frames_changed();
    return want_end();
}

bool HeidenhainReader::scale() {
    Transformations& now = frames_.said_now();
    const std::size_t place = cursor().next_index();
    double factor = 0;
    if (!cursor().take_word("SCL") || !values().value(factor))
        return refuse("NC0715", place, "cycle 11 needs its factor", {}, "SCL 0.99");
    if (!(factor >= 1e-6 && factor < 100))
        return refuse("NC0715", place, "a scale lies between 0.000001 and 99.999999");
    now.scale = factor;
    frames_changed();
    return want_end();
}

/// X1.2 Y0.9 CCX+5 CCY+0 of cycle 26.
bool HeidenhainReader::axis_scale() {
    Transformations& now = frames_.said_now();
    while (!cursor().at_end()) {
        const std::size_t at = cursor().index();
        const std::string name(cursor().name());
        const bool of_centre = name.size() == 3 && name.starts_with("CC");
        const char letter = name.empty() ? ' ' : name.back();
        double value = 0;
        if ((name.size() != 1 && !of_centre) || letter < 'X' || letter > 'Z')
            return refuse("NC0715", at, "cycle 26 scales X, Y and Z about CCX, CCY and CCZ", name);
        if (!values().value(value)) return false;
        if (!of_centre && !(value >= 1e-6 && value < 100))
            return refuse("NC0715", at, "a scale lies between 0.000001 and 99.999999");
        (of_centre ? now.scale_centre_mm : now.axis_scales)[letter - 'X'] = of_centre ? value * unit_mm() : value;
        if (!now.scale_centre_mm.allFinite()) return refuse("NC0201", at, "the position is not finite");
    }
    if (now.turns() && now.axis_scales != Vector3d::Ones())
        return refuse("NC0715", first_word_, "scales of single axes while a rotation is in force");
    frames_changed();
    return true;
}

/// TRANS DATUM AXIS X+5, TRANS DATUM RESET.
bool HeidenhainReader::trans() {
    const std::size_t place = cursor().next_index();
    if (!cursor().take_word("DATUM")) return refuse("NC0715", place, "of TRANS, DATUM alone is supported");
    if (cursor().take_word("RESET")) return set_shift(Vector3d::Zero(), place) && want_end();
    if (cursor().take_word("AXIS")) return shift_words();
    return refuse("NC0715", place, "datum tables are not supported", {}, "TRANS DATUM AXIS X+0 Y+0 Z+0");
}

/// Cycle 247: of its datums, 1 … 6 are G54 … G59 of the setup.
bool HeidenhainReader::datum() {
    const std::size_t place = cursor().next_index();
    if (!cursor().take_word("Q")) return refuse("NC0715", place, "cycle 247 needs its datum: Q339");
    const auto parameter = cursor().number();
    double number = -1;
    if (parameter != 339.0 || !cursor().take('=') || !values().formula(number) || !cursor().at_end())
        return refuse("NC0715", place, "cycle 247 needs its datum: Q339", {}, "Q339=+1");
    if (!(number >= 0) || number != std::floor(number) || number > 1e6)
        return refuse("NC0715", place, "the number of a datum is a whole number");
    const bool work_offset = number >= 1 && number <= 6;
    const auto index =
        index_in(program_.offsets, work_offset ? fmt::format("G{}", 53 + number) : fmt::format("DATUM {}", number));
    if (!index) return refuse("NC0008", place, "more offsets than are read");
    if (*index == modes_.offset) return true;
    if (frames_.plane)
        whole_pose_needed_ = true;
    else
        law_ = OrientationLaw::rotary;  // vectors count in the datum
    modes_.offset = *index;
    return true;
}

// ------------------------------------------------------------------------------------------------- tilted planes

/// Cycle 19: A, B and C as SPA, SPB and SPC; with F the axes turn, else they stay. Empty: the plane ends.
bool HeidenhainReader::working_plane() {
    const std::size_t place = cursor().next_index();
    if (cursor().at_end()) return reset_plane();
    Vector3d angles = Vector3d::Zero();
    bool turns = false;
    while (!cursor().at_end()) {
        const std::size_t at = cursor().index();
        const std::string name(cursor().name());
        double value = 0;
        if (name == "FMAX") {
            turns = true;
            continue;
        }
        if (name == "F" && cursor().take_word("MAX")) {
            turns = true;
            continue;
        }
        if (!values().value(value)) return false;
        if (name == "F")
            turns = true;
        else if (name == "A" || name == "B" || name == "C")
            angles[name[0] - 'A'] = value * degree;
        else if (name != "ABST" && name != "DIST" && name != "SETUP")
            return refuse("NC0720", at, "cycle 19 takes A, B and C as angles in space", name);
    }
    if (!tilt(CoordinateFrame::turned_rpy(angles), place)) return false;
    if (turns) align_tool();
    return true;
}

bool HeidenhainReader::plane() {
    const std::size_t place = cursor().next_index();
    const std::string kind(cursor().name());
    Positioning how = Positioning::stay;
    Way way{.rapid = true};
    if (kind == "RESET") {
        if (!positioning(how, way) || !reset_plane()) return false;
        return how == Positioning::stay || turn_back(how, way);
    }
    CoordinateFrame frame;
    if (!plane_frame(kind, frame) || !positioning(how, way) || !tilt(frame, place)) return false;
    if (how == Positioning::stay) return true;
    if (how == Positioning::turn) forget_position();
    align_tool();
    return true;
}

bool HeidenhainReader::plane_frame(std::string_view kind, CoordinateFrame& frame) {
    std::array<double, 6> v{};
    if (kind == "SPATIAL") {
        if (!plane_numbers({"SPA", "SPB", "SPC"}, 3, v)) return false;
        frame = CoordinateFrame::turned_rpy(Vector3d(v[0], v[1], v[2]) * degree);
        return true;
    }
    if (kind == "EULER") {
        if (!plane_numbers({"EULPR", "EULNU", "EULROT"}, 3, v)) return false;
        frame = CoordinateFrame::turned(2, v[0] * degree)
                    .with(CoordinateFrame::turned(0, v[1] * degree))
                    .with(CoordinateFrame::turned(2, v[2] * degree));
        return true;
    }
    if (kind == "VECTOR") return plane_by_vectors(frame);
    if (kind == "RELATIV" || kind == "RELATIVE") return plane_relative(frame);
    return refuse("NC0720", first_word_, "this PLANE is not supported", kind,
                  "PLANE SPATIAL, VECTOR, EULER, RELATIV or RESET");
}

/// The numbers of a plane, which are all needed, in any order.
bool HeidenhainReader::plane_numbers(const std::array<std::string_view, 6>& names, std::size_t count,
                                     std::array<double, 6>& values_read) {
    std::array<bool, 6> said{};
    for (std::size_t n = 0; n < count; ++n) {
        const std::size_t place = cursor().next_index();
        const std::string_view name = cursor().name();
        const auto at = static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
        if (name.empty() || at >= count || said[at])
            return refuse("NC0720", place, "PLANE needs all of its numbers, each once",
                          name.empty() ? cursor().rest().substr(0, 12) : name);
        said[at] = true;
        if (!values().value(values_read[at])) return false;
        if (!(std::abs(values_read[at]) < 1e9)) return refuse("NC0201", place, "the angle is not finite");
    }
    return true;
}

/// X of the plane along B, as far as it lies across N; its normal along N.
bool HeidenhainReader::plane_by_vectors(CoordinateFrame& frame) {
    std::array<double, 6> v{};
    if (!plane_numbers({"BX", "BY", "BZ", "NX", "NY", "NZ"}, 6, v)) return false;
    const Vector3d normal = Vector3d(v[3], v[4], v[5]).normalized();
    const Vector3d base(v[0], v[1], v[2]);
    const Vector3d first = base - base.dot(normal) * normal;
    if (!normal.allFinite() || !(normal.norm() > 0.5) || !(first.norm() > 1e-6 * base.norm()))
        return refuse("NC0720", first_word_, "the vectors of the plane have no direction, or the same one");
    Eigen::Matrix3d axes;
    axes.col(0) = first.normalized();
    axes.col(1) = normal.cross(axes.col(0));
    axes.col(2) = normal;
    frame = CoordinateFrame(axes, Vector3d::Zero());
    return true;
}

/// One angle, on top of the plane in force.
bool HeidenhainReader::plane_relative(CoordinateFrame& frame) {
    const std::size_t place = cursor().next_index();
    const std::string name(cursor().name());
    double angle = 0;
    if (name != "SPA" && name != "SPB" && name != "SPC")
        return refuse("NC0720", place, "PLANE RELATIV turns by SPA, SPB or SPC", name);
    if (!values().value(angle)) return false;
    if (!(std::abs(angle) < 1e9)) return refuse("NC0201", place, "the angle is not finite");
    const CoordinateFrame turned = CoordinateFrame::turned(name[2] - 'A', angle * degree);
    frame = frames_.plane ? frames_.plane->with(turned) : turned;
    return true;
}

/// STAY, MOVE or TURN with what belongs to them.
bool HeidenhainReader::positioning(Positioning& how, Way& way) {
    while (!cursor().at_end()) {
        const std::size_t place = cursor().index();
        const std::string name(cursor().name());
        double value = 0;
        if (name == "STAY" || name == "MOVE" || name == "TURN") {
            how = name == "STAY" ? Positioning::stay : name == "MOVE" ? Positioning::move : Positioning::turn;
        } else if (name == "FMAX" || name == "FAUTO") {
            way.rapid = name == "FMAX" || !(modes_.tool_call_feed > 0);
        } else if (name == "F") {
            FeedWord kind = FeedWord::none;
            if (!feed_words(kind, value, place)) return false;
            if (kind == FeedWord::value && !(value > 0 && std::isfinite(60 / (value * feed_unit_mm()))))
                return refuse("NC0206", place, "a feed must be positive");
            way.rapid = kind != FeedWord::value;
            if (!way.rapid) way.speed_mm_s = value * feed_unit_mm() / 60;
        } else if (name == "SEQ" || name == "SYM") {
            if (!cursor().take('+') && !cursor().take('-'))
                return refuse("NC0720", place, "SEQ and SYM have a sign", name);
            findings_.count("NC0757", Severity::note, cursor().spot(place), name,
                            "of the rotary positions that reach the plane the nearer ones are taken");
        } else if ((name == "COORD" || name == "TABLE") && cursor().take_word("ROT")) {
            findings_.count("NC0757", Severity::note, cursor().spot(place), name + " ROT",
                            "the plane is the same whether the table turns or not: the nearer position is taken");
        } else if (name == "DIST" || name == "ABST" || name == "DISTANCE") {
            if (!values().value(value)) return false;
        } else if (name == "MB") {
            if (!cursor().take_word("MAX") && !values().value(value)) return false;
            findings_.count("NC0753", Severity::warning, cursor().spot(place), "PLANE MB",
                            "a retract of PLANE is left out", "M140 before it");
        } else {
            return refuse("NC0204", place, "unknown word: it might change motion",
                          name.empty() ? cursor().rest().substr(0, 1) : std::string_view(name));
        }
    }
    return true;
}

/// The plane takes the place of the one before; the tool stands as it stood.
bool HeidenhainReader::tilt(const CoordinateFrame& frame, std::size_t place) {
    if (!frames_.within.is_identity())
        return refuse("NC0715", place, "another plane while a shift or rotation said in the plane before is in force",
                      {}, "PLANE RESET and zeros before it");
    const Transformations& before = frames_.before;
    if (before.mirrors() || before.turns() || before.scales())
        return refuse("NC0715", place, "a tilted plane while a mirror, rotation or scale is in force", {},
                      "the plane before them");
    if (corner_) return refuse_rounding("a plane follows");
    frames_.plane = frame;
    whole_pose_needed_ = true;
    frames_changed();
    return true;
}

/// The tool stands across the plane, by whichever position of the rotary axes is nearer.
void HeidenhainReader::align_tool() {
    axis_ = *frames_.plane->tool_axis(Vector3d::UnitZ());
    law_ = OrientationLaw::vector;
    whole_pose_needed_ = true;
}

bool HeidenhainReader::reset_plane() {
    if (corner_) return refuse_rounding("a plane ends");
    if (frames_.plane && law_ == OrientationLaw::vector && !modes_.transform) law_ = OrientationLaw::rotary;
    frames_.leave_plane();
    whole_pose_needed_ = false;
    frames_changed();
    return true;
}

/// PLANE RESET TURN: the rotary axes go to 0 and the linear ones stand; MOVE: the tip stands.
bool HeidenhainReader::turn_back(Positioning how, const Way& way) {
    if (!options_.machine)
        return refuse("NC0707", first_word_, "PLANE RESET that turns axes needs a machine that has them", {},
                      "-m says which");
    const int axes = std::min(options_.machine->rotary_count, program::max_rotary_letters);
    for (std::size_t i = 0; i < static_cast<std::size_t>(axes); ++i) {
        rotary_rad_[i] = 0;
        rotary_ever_ |= 1u << i;
    }
    law_ = OrientationLaw::rotary;
    axis_words_ever_ = true;
    last_motion_ = spot_of_motion();
    count_in({how == Positioning::move ? Space::workpiece : Space::untransformed, modes_.offset, tool_});
    return go(programmed_mm_, way);
}

}  // namespace trunnion::nc::heidenhain
