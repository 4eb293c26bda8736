#include <cmath>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "trunnion/base/number.hpp"

#include "detail/apt_reader.hpp"

namespace trunnion::nc {

using Eigen::Vector3d;
using program::Move;

namespace {

constexpr double smallest_vector = 1e-9;     ///< a vector shorter than this has no direction
constexpr double usual_vector_error = 1e-3;  ///< of its length; more is worth a warning
constexpr double system_slack = 1e-4;        ///< of the axes of MSYS, which have few decimals
constexpr double opposite_sine = 1e-6;       ///< two vectors this near to opposite span no plane

}  // namespace

std::optional<double> number_of(std::string_view item) {
    const auto value = take_number(item, Exponent::allowed);
    return item.empty() ? value : std::nullopt;
}

/// The arguments as numbers, with a comma between (or a blank, in bare lists).
bool AptReader::numbers(Numbers& out, bool blanks_separate) {
    std::string_view list = scanner_.arguments();
    for (;;) {
        list = skip_blanks(list);
        const auto value = take_number(list, Exponent::allowed);
        if (!value)
            return findings_.refuse("NC0201", scanner_.spot(list), "no finite number where one is expected",
                                    list.substr(0, 20));
        if (out.count == out.value.size()) return refuse("NC0401", "too many numbers");
        out.value[out.count++] = *value;
        const std::string_view behind = skip_blanks(list);
        if (behind.empty()) return true;
        const bool blank = behind.size() < list.size();
        list = behind;
        if (list.front() == ',')
            list.remove_prefix(1);
        else if (!blanks_separate || !blank)
            return findings_.refuse("NC0202", scanner_.spot(list), "not expected behind a number", list.substr(0, 1));
    }
}

bool AptReader::go_to() {
    Numbers pose;
    return numbers(pose, false) && add_pose(pose);
}

bool AptReader::bare_pose() {
    if (words_seen_)
        return refuse("NC0413", "numbers without a statement", "is a $ missing at the end of the line before?");
    Numbers pose;
    return numbers(pose, true) && add_pose(pose);
}

/// Behind a motion FROM may say once more where the tool is.
bool AptReader::from() {
    const bool rapid_waits = rapid_next_;
    const std::size_t moves = program_.moves.size();
    if (moves > 0) rapid_next_ = true;  // no feed is needed to stay
    const bool good = go_to();
    rapid_next_ = rapid_waits;
    if (good && moves > 0 && program_.moves.size() > moves)
        return refuse("NC0408", "FROM behind a motion and elsewhere would be a jump", "write it as a GOTO");
    return good;
}

/// GODLTA/dx,dy,dz, and GODLTA/d along the tool.
bool AptReader::go_by() {
    Numbers step;
    if (!numbers(step, false)) return false;
    if (step.count != 1 && step.count != 3)
        return refuse("NC0401", fmt::format("{} numbers, a step has 3, or 1 along the tool", step.count));
    if (program_.moves.empty()) return refuse("NC0423", "a step from a place that is not known", "FROM before it");
    const Vector3d way_mm =
        step.count == 3 ? Vector3d(direction(step.triple(0)) * unit_mm_) : Vector3d(axis_ * step.value[0] * unit_mm_);
    const Vector3d position_mm = program_.moves.back().position_mm + way_mm;
    if (circle_) return add_on_circle(position_mm);
    return add_move(position_mm, std::exchange(rapid_next_, false));
}

bool AptReader::add_pose(const Numbers& pose) {
    if (pose.count != 3 && pose.count != 6)
        return refuse("NC0401", fmt::format("{} numbers, a pose has 3 or 6", pose.count),
                      "x, y, z or x, y, z, i, j, k");
    if (pose.count == 6 && !set_axis(pose.triple(3))) return false;
    const Vector3d position_mm = point_mm(pose.triple(0));
    if (circle_) return add_on_circle(position_mm);
    return add_move(position_mm, std::exchange(rapid_next_, false));
}

bool AptReader::set_axis(const Vector3d& vector) {
    const double length = vector.norm();
    if (!(length > smallest_vector) || !std::isfinite(length)) return refuse("NC0402", "a tool axis without direction");
    if (std::abs(length - 1) > usual_vector_error)
        findings_.count("NC0015", Severity::warning, scanner_.spot(), "vector",
                        "tool axis not of length 1: normalised");
    const Vector3d unit = direction(vector / length);
    if (axis_held_ && (unit - axis_).cwiseAbs().maxCoeff() > opposite_sine)
        return refuse("NC0409", "the tool axis changes though MULTAX is off", "MULTAX/ON before it");
    if (!axis_held_) axis_ = unit;
    return true;
}

bool AptReader::add_move(const Vector3d& position_mm, bool is_rapid, const program::Arc* arc) {
    if (!position_mm.allFinite()) return refuse("NC0201", "the coordinates are not finite in mm");
    Move move;
    move.position_mm = position_mm;
    move.axis = axis_;
    move.tool = tool_;
    move.line = scanner_.spot().line;
    if (!program_.moves.empty()) {
        const Move& last = program_.moves.back();
        if (!arc && last.position_mm == position_mm && last.axis == axis_) return true;
        if (last.axis.dot(axis_) < 0 && last.axis.cross(axis_).norm() < opposite_sine)
            return refuse("NC0403", "the tool axis turns to the opposite: in which plane is not defined",
                          "put a pose between that says the way");
        if (!is_rapid && !cutting_feed(move.feed)) return false;
    }
    if (is_rapid) move.kind = program::MoveKind::rapid;
    if (arc) {
        move.arc = static_cast<std::int32_t>(program_.arcs.size());
        program_.arcs.push_back(*arc);
    }
    program_.moves.push_back(move);
    return true;
}

bool AptReader::cutting_feed(program::Feed& feed) {
    if (!feed_mm_s_ && !options_.feed_given_elsewhere)
        return refuse("NC0205", "a cutting move without a feed", "--feed gives one, or FEDRAT before it");
    double speed_mm_s = feed_mm_s_.value_or(0);
    if (feed_is_per_turn_ && !turns_per_s_ && !options_.feed_given_elsewhere)
        return refuse("NC0406", "a feed per revolution without the spindle's speed", "SPINDL/…,RPM before it");
    if (feed_is_per_turn_) speed_mm_s *= turns_per_s_.value_or(0);
    feed = {program::FeedRule::tip_speed, speed_mm_s};
    return true;
}

bool AptReader::rapid() {
    rapid_next_ = true;
    return true;
}

/// What scales a feed with this unit word to mm/s, or to mm a turn.
bool AptReader::feed_unit(std::string_view word, double& scale) {
    feed_is_per_turn_ = is_word(word, {"MMPR", "IPR", "PERREV"});
    if (feed_is_per_turn_) {
        scale = is_word(word, {"IPR"}) ? inch_mm : is_word(word, {"MMPR"}) ? 1 : unit_mm_;
        return true;
    }
    if (is_word(word, {"MMPM"})) return scale = 1.0 / 60, true;
    if (is_word(word, {"IPM"})) return scale = inch_mm / 60, true;
    if (is_word(word, {"PERMIN"})) return scale = unit_mm_ / 60, true;
    return findings_.refuse("NC0407", scanner_.spot(), "not a unit of feed", word, "MMPM, IPM, PERMIN or MMPR");
}

bool AptReader::feed_rate() {
    std::string_view list = scanner_.arguments();
    std::optional<double> value;
    double scale = unit_mm_ / 60;
    bool unit_given = false;
    feed_is_per_turn_ = false;
    while (!list.empty()) {
        const std::string_view item = take_item(list);
        if (!item.empty() && starts_number(item.front())) {
            const bool second = value.has_value();
            value = number_of(item);
            if (second || !value)
                return findings_.refuse("NC0201", scanner_.spot(), "no single finite number as feed", item);
        } else {
            if (unit_given) return findings_.refuse("NC0412", scanner_.spot(), "not understood in FEDRAT", item);
            if (!feed_unit(item, scale)) return false;
            unit_given = true;
        }
    }
    if (!value) return refuse("NC0201", "FEDRAT without a number");
    if (!(*value > 0))
        return findings_.refuse("NC0206", scanner_.spot(), "a feed must be positive", fmt::format("{}", *value));
    feed_mm_s_ = *value * scale;
    return true;
}

bool AptReader::tool_axis() {
    Numbers vector;
    if (!numbers(vector, false)) return false;
    if (vector.count != 3) return refuse("NC0401", fmt::format("{} numbers, a tool axis has 3", vector.count));
    return set_axis(vector.triple(0));
}

bool AptReader::multax() {
    const std::string_view state = scanner_.arguments();
    const bool off = is_word(state, {"OFF"});
    if (!off && !state.empty() && !is_word(state, {"ON"}))
        return findings_.refuse("NC0412", scanner_.spot(), "MULTAX is ON or OFF", state);
    axis_held_ = off;
    return true;
}

/// MSYS/origin,X,Y[,Z]: the coordinates that follow count in this system. The first one is the program's own frame,
/// later ones lie in it.
bool AptReader::machine_system() {
    Numbers given;
    if (!numbers(given, false)) return false;
    if (given.count != 9 && given.count != 12)
        return refuse("NC0401", fmt::format("{} numbers, MSYS has an origin, X and Y", given.count));
    const Vector3d x = given.triple(3), y = given.triple(6), z = x.cross(y);
    const Vector3d third = given.count == 12 ? given.triple(9) : z;
    const bool orthonormal = std::abs(x.norm() - 1) < system_slack && std::abs(y.norm() - 1) < system_slack &&
                             std::abs(x.dot(y)) < system_slack && (z - third).norm() < system_slack;
    if (!orthonormal) return refuse("NC0410", "the axes of MSYS are not unit vectors at right angles");
    PoseFrame system;
    system.origin_mm = given.triple(0) * unit_mm_;
    system.axes.col(2) = z.normalized();
    system.axes.col(0) = x.normalized();
    system.axes.col(1) = system.axes.col(2).cross(system.axes.col(0));
    if (!system.origin_mm.allFinite()) return refuse("NC0201", "the origin is not finite in mm");
    if (!first_system_ && !program_.moves.empty())
        return refuse("NC0410", "the first MSYS stands behind a motion: in which system did that count?");
    if (!first_system_) {
        first_system_ = system;
        return true;
    }
    const Eigen::Matrix3d back = first_system_->axes.transpose();
    frame_ = PoseFrame{back * system.axes, back * (system.origin_mm - first_system_->origin_mm)};
    if (frame_->axes.isIdentity(0) && frame_->origin_mm.isZero(0)) {
        frame_.reset();
        return true;
    }
    findings_.count("NC0424", Severity::note, scanner_.spot(), "MSYS",
                    "another coordinate system than at the start: its poses are taken over into the first one");
    return true;
}

}  // namespace trunnion::nc
