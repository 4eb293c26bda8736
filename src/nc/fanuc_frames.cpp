#include <algorithm>

#include <Eigen/Geometry>

#include "detail/fanuc_reader.hpp"

namespace trunnion::nc::fanuc {

using Eigen::Vector3d;
using program::OrientationLaw;
using program::Space;

CoordinateFrame FanucReader::frame_in_force() const {
    if (counted_in_.space == Space::machine) return {};
    const auto of_data = offset_shift_mm_.find(modes_.offset);
    const Vector3d shift =
        preset_mm_ + local_mm_ + (of_data == offset_shift_mm_.end() ? Vector3d::Zero() : Vector3d(of_data->second));
    CoordinateFrame frame = shift.isZero(0) ? CoordinateFrame{} : CoordinateFrame::shifted(shift);
    return dynamic_.with(frame).with(plane_).with(mirror_).with(rotation_);
}

/// The axes stand where they stand; what they are in the changed frame is worked out.
void FanucReader::frames_changed() {
    if (counted_in_.space == Space::machine) return;  // the frame comes back with the next block that counts in it
    frame_ = frame_in_force();
    programmed_mm_ = frame_.inward(position_mm_);
}

/// X Y Z of a statement that does not move.
bool FanucReader::linear_words(Vector3d& values, double otherwise) {
    for (Eigen::Index i = 0; i < 3; ++i) {
        const char letter = "XYZ"[i];
        values[i] = said_.has(letter) ? length_of(letter) : otherwise;
        if (!std::isnan(values[i]) && !std::isfinite(values[i]))
            return refuse("NC0201", said_.word(letter), "the position is not finite");
    }
    said_.use("XYZ");
    return true;
}

/// Shifts of rotary axes are taken where they are none.
bool FanucReader::no_rotary_words() {
    for (std::size_t i = 0; i < 26; ++i) {
        const char letter = static_cast<char>('A' + i);
        if (control_.kind(i) != Control::Letter::rotary || !said_.has(letter)) continue;
        said_.use(std::string_view(&letter, 1));
        if (said_[letter] != 0)
            return refuse("NC0841", said_.word(letter), "shifts and mirrors of rotary axes are not supported",
                          "write the angles with the shift worked in");
    }
    return true;
}

/// G52: a shift in the work offset; the words that are not said keep theirs.
bool FanucReader::local_shift() {
    if (turned()) return refuse("NC0841", code_of(Group::once), "G52 in a turned frame", "G69 before it");
    Vector3d values;
    if (!no_rotary_words() || !linear_words(values, unknown)) return false;
    for (Eigen::Index i = 0; i < 3; ++i)
        if (!std::isnan(values[i])) local_mm_[i] = values[i];
    frames_changed();
    return true;
}

/// G92: where the tool stands is the place that is said, in all work offsets. With S alone it limits the spindle.
bool FanucReader::preset() {
    Vector3d values;
    if (!no_rotary_words() || !linear_words(values, unknown)) return false;
    if (values.array().isNaN().all()) return true;
    if (turned() || !mirror_.is_identity() || dynamic_on_)
        return refuse("NC0841", code_of(Group::once), "G92 in a turned or mirrored frame", "G69 before it");
    if (!count_in(false)) return false;
    for (Eigen::Index i = 0; i < 3; ++i) {
        if (std::isnan(values[i])) continue;
        if (std::isnan(programmed_mm_[i]))
            return refuse("NC0841", said_.word("XYZ"[i]), "G92 at a position that is not known",
                          "a work offset (G54) says where the part lies");
        preset_mm_[i] += programmed_mm_[i] - values[i];
    }
    frames_changed();
    return true;
}

/// G51.1 at the coordinates that are said; G50.1 ends it for the axes that are said, without words for all.
bool FanucReader::mirror(bool on) {
    const Word& word = code_of(Group::mirror);
    if (turned()) return refuse("NC0845", word, "a mirror inside a rotation", "the mirror first, then G68");
    Vector3d values;
    if (!no_rotary_words() || !linear_words(values, unknown)) return false;
    const bool all = values.array().isNaN().all();
    if (on && all) return refuse("NC0845", word, "G51.1 without an axis");
    for (Eigen::Index i = 0; i < 3; ++i) {
        if (std::isnan(values[i]) && !all) continue;
        mirrored_[static_cast<std::size_t>(i)] = on;
        mirror_at_[i] = on ? values[i] : 0;
    }
    Vector3d factors = Vector3d::Ones();
    for (Eigen::Index i = 0; i < 3; ++i)
        if (mirrored_[static_cast<std::size_t>(i)]) factors[i] = -1;
    mirror_ = CoordinateFrame(factors.asDiagonal(), 2 * mirror_at_);
    frames_changed();
    return true;
}

/// G68: about a point of the plane, by R.
bool FanucReader::rotation() {
    const Word& word = code_of(Group::turned);
    if (said_.has_any("IJK"))
        return refuse("NC0842", word, "G68 about an axis in space (I J K) is not supported", "G68.2");
    if (!said_.has('R') || !std::isfinite(said_['R']))
        return refuse("NC0842", word, "G68 without its angle", "R in degrees");
    if (!modes_.absolute) return refuse("NC0842", word, "G68 in G91: a parameter says what R means then", "G90");
    rotation_ = {};
    frames_changed();
    Vector3d values, centre = Vector3d::Zero();
    if (!count_in(false) || !linear_words(values, unknown)) return false;
    said_.use("R");
    const int along = modes_.normal_axis;
    for (Eigen::Index i = 0; i < 3; ++i) {
        if (i == along) continue;
        centre[i] = std::isnan(values[i]) ? programmed_mm_[i] : values[i];
        if (std::isnan(centre[i]))
            return refuse("NC0842", word, "G68 about a position that is not known", "say its centre in the plane");
    }
    if (!std::isnan(values[along]))
        return refuse("NC0842", said_.word("XYZ"[along]), "the centre of G68 lies in the plane in force");
    rotation_ = CoordinateFrame::shifted(centre)
                    .with(CoordinateFrame::turned(along, said_['R'] * degree))
                    .with(CoordinateFrame::shifted(-centre));
    frames_changed();
    return true;
}

/// G69 ends G68 and G68.2; the rotary axes stay.
bool FanucReader::no_rotation() {
    rotation_ = plane_ = {};
    if (swivelled_) law_ = OrientationLaw::rotary;
    plane_said_ = swivelled_ = whole_pose_needed_ = false;
    frames_changed();
    return true;
}

// -------------------------------------------------------------------------------------------------------- tilted plane

/// G68.2: the origin, then Euler angles (I about Z, J about the new X, K about the new Z), or with P1 angles about the
/// offset's X, Y and Z in the order that Q gives.
bool FanucReader::tilted_plane() {
    const Word& word = code_of(Group::turned);
    if (dynamic_on_) return refuse("NC0843", word, "G68.2 under G254");
    Vector3d origin;
    if (!linear_words(origin, 0)) return false;
    const Vector3d angles = Vector3d(said_.get('I', 0), said_.get('J', 0), said_.get('K', 0)) * degree;
    if (!angles.allFinite()) return refuse("NC0843", word, "an angle is not finite");
    const double kind = said_.get('P', 0);
    said_.use("IJKPQ");
    CoordinateFrame turn;
    if (kind == 0) {
        turn = CoordinateFrame::turned(2, angles.x())
                   .with(CoordinateFrame::turned(0, angles.y()))
                   .with(CoordinateFrame::turned(2, angles.z()));
    } else if (kind != 1) {
        return refuse("NC0843", word, "a tilted plane by points, vectors or projected angles is not supported",
                      "G68.2 by Euler angles, or P1 with Q");
    } else {
        const int several = static_cast<int>((angles.array() != 0).count());
        int order = static_cast<int>(std::clamp(said_.get('Q', several > 1 ? 0 : 123), 0.0, 999.0));
        constexpr std::array orders{123, 132, 213, 231, 312, 321};
        if (std::ranges::find(orders, order) == orders.end())
            return refuse("NC0843", word, "G68.2 P1 needs the order of its rotations", "Q123: about X, then Y, then Z");
        for (; order > 0; order /= 10)  // the last rotation stands outermost
            turn = turn.with(CoordinateFrame::turned(order % 10 - 1, angles[order % 10 - 1]));
    }
    if (swivelled_) law_ = OrientationLaw::rotary;
    rotation_ = {};
    plane_ = CoordinateFrame::shifted(origin).with(turn);
    plane_said_ = true;
    swivelled_ = false;
    frames_changed();
    return true;
}

/// G53.1: the tool across the plane. From here on the coordinates are the tip's.
bool FanucReader::swivel() {
    const Word& word = code_of(Group::once);
    if (!plane_said_) return refuse("NC0844", word, "G53.1 without a tilted plane", "G68.2 before it");
    if (said_.has('P') && said_['P'] != 0)
        findings_.count("NC0871", Severity::note, block_.spot(word), "P",
                        "G53.1 P: of the rotary positions that reach the plane the nearer ones are taken");
    said_.use("P");
    const Vector3d axis = *plane_.tool_axis(Vector3d::UnitZ());
    whole_pose_needed_ = whole_pose_needed_ || law_ != OrientationLaw::vector || axis != axis_;
    axis_ = axis;
    law_ = OrientationLaw::vector;
    swivelled_ = true;
    at_reference_ &= ~rotary_mask();
    return true;
}

std::uint32_t FanucReader::rotary_mask() const {
    std::uint32_t mask = 0;
    for (std::size_t i = 0; i < 26; ++i)
        if (control_.kind(i) == Control::Letter::rotary) mask |= 1u << i;
    return mask;
}

// ------------------------------------------------------------------------------------------------------ dynamic offset

/// G254: X Y Z are the tip's as counted along the machine's axes from the part's zero, wherever the tables have turned
/// it. That is the tip in the workpiece, turned back by the tables.
bool FanucReader::dynamic_offset(bool on) {
    const Word& word = code_of(Group::dynamic);
    if (!on) {
        dynamic_ = {};
        dynamic_on_ = false;
        frames_changed();
        return true;
    }
    if (tcp() || turned() || !options_.machine)
        return refuse("NC0846", word, "G254 under G234, G43.4, G68 or G68.2, or without a machine");
    dynamic_on_ = true;
    return turn_dynamic_frame();
}

bool FanucReader::turn_dynamic_frame() {
    const machine::Machine& machine = *options_.machine;
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
    bool behind_linear = false;
    for (std::size_t place = 0; place < static_cast<std::size_t>(machine.axis_count); ++place) {
        const auto index = static_cast<std::size_t>(machine.chain[place]);
        const machine::Axis& axis = machine.axes[index];
        behind_linear = behind_linear || !axis.rotary;
        if (!axis.rotary) continue;
        const double angle = rotary_rad_[index - static_cast<std::size_t>(machine.linear_count())];
        if (behind_linear || std::isnan(angle))
            return refuse("NC0846", block_.place(), "G254 needs tables alone, and their positions known",
                          std::string_view(&axis.letter, 1), "say the rotary axes before G254");
        turn = turn * Eigen::AngleAxisd(axis.reversed ? -angle : angle, axis.direction).toRotationMatrix();
    }
    if (modes_.motion != Meaning::rapid && asked(Group::dynamic) == Meaning::unknown)
        return refuse("NC0846", spot_of_motion(), "a table turns while it cuts under G254", {}, "G234");
    dynamic_ = CoordinateFrame(turn, Vector3d::Zero());
    position_mm_.setConstant(unknown);
    frames_changed();
    return true;
}

}  // namespace trunnion::nc::fanuc
