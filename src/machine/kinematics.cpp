#include "trunnion/machine/kinematics.hpp"

#include <cmath>
#include <string_view>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <fmt/format.h>

#include "detail/vector.hpp"

namespace trunnion::machine {

using detail::Angle;
using detail::Vector;

namespace {

constexpr double least_tilt_rad = 1e-3;  ///< between directions: below it an axis does not tilt the other, or the tool
constexpr double least_volume = 1e-3;    ///< of the linear directions: below it they do not span space
const Eigen::Vector3d tool_at_zero = Eigen::Vector3d::UnitZ();

std::unexpected<Diagnostic> refuse(const Machine& machine, std::string code, std::string text, std::string hint) {
    return fail(
        {.code = std::move(code), .text = std::move(text), .place = {.file = machine.file}, .hint = std::move(hint)});
}

double sign_of(const Axis& axis) {
    return axis.reversed ? -1.0 : 1.0;
}

/// Why two rotary axes, from the workpiece to the tool, cannot set the tool's direction; empty if they can.
std::string_view idleness(const Eigen::Vector3d& first, const Eigen::Vector3d& second) {
    if (first.cross(second).norm() < least_tilt_rad) return "the two rotary axes are parallel to each other";
    if (second.cross(tool_at_zero).norm() < least_tilt_rad)
        return "the rotary axis next to the tool is parallel to the tool and does not tilt it";
    return {};
}

}  // namespace

template <class S>
struct Kinematics::Posture {
    std::array<Angle<S>, max_rotary_axes> turn;
};

Result<Kinematics> Kinematics::make(const Machine& machine, const Frame& workpiece, double tool_length_mm) {
    if (machine.rotary_count > max_rotary_axes)
        return refuse(machine, "MACH0102",
                      fmt::format("the chain has {} rotary axes, at most two are possible", machine.rotary_count),
                      "leave the axes that do not turn out of the chain");
    if (machine.linear_count() != 3)
        return refuse(machine, "MACH0101",
                      fmt::format("the chain has {} linear axes, exactly three are needed", machine.linear_count()),
                      "give the chain three linear axes, such as X Y Z");
    Kinematics out;
    out.axis_count_ = machine.axis_count;
    out.rotary_count_ = machine.rotary_count;
    out.workpiece_ = workpiece;
    out.tool_length_mm_ = tool_length_mm;
    Eigen::Matrix3d all = Eigen::Matrix3d::Zero();
    std::size_t turns = 0;
    for (int i = 0; i < machine.axis_count; ++i) {
        const int at = machine.chain[i];
        const Axis& axis = machine.axes[at];
        const Eigen::Vector3d direction = axis.direction.normalized();
        if (axis.rotary) {
            out.turns_[turns++] = {direction, axis.point_mm, sign_of(axis), static_cast<std::size_t>(at - 3)};
            continue;
        }
        all.col(at) = sign_of(axis) * direction;
        out.groups_[turns].directions.col(at) = all.col(at);
        out.groups_[turns].used = true;
        out.only_group_ = static_cast<int>(turns);
    }
    if (!(std::abs(all.determinant()) >= least_volume))
        return refuse(machine, "MACH0101", "the directions of the linear axes do not span space",
                      "give each its own direction");
    for (int k = 0; k < out.only_group_; ++k)
        if (out.groups_[k].used) out.only_group_ = -1;
    out.only_inverse_ = all.inverse();
    if (turns > 0) out.nearest_ = static_cast<int>(out.turns_[0].index);
    const auto idle = turns == 2 ? idleness(out.turns_[0].direction, out.turns_[1].direction) : std::string_view{};
    if (!idle.empty())
        return refuse(machine, "MACH0103", std::string(idle),
                      "give the chain from workpiece to tool, and an inclined axis its direction with all axes at 0");
    out.prepare_orientation();
    return out;
}

template <class S>
Kinematics::Posture<S> Kinematics::posture(const std::array<S, max_rotary_axes>& rotary) const noexcept {
    Posture<S> out;
    for (int k = 0; k < rotary_count_; ++k) out.turn[k] = detail::angle_of(turns_[k].sign * rotary[turns_[k].index]);
    return out;
}

template <class S>
std::array<S, 3> Kinematics::axis_of(const Posture<S>& posture) const noexcept {
    Vector<S> axis = detail::constant<S>(tool_at_zero);
    for (int k = rotary_count_; k-- > 0;) axis = detail::turned(axis, turns_[k].direction, posture.turn[k]);
    return detail::times(Eigen::Matrix3d(workpiece_.rotation.transpose()), axis);
}

/// From the tool to the workpiece, one element of the chain after the other.
template <class S>
std::array<S, 3> Kinematics::tip_of(const std::array<S, 3>& linear, const Posture<S>& posture) const noexcept {
    Vector<S> tip = detail::constant<S>(-tool_length_mm_ * tool_at_zero);
    for (int k = rotary_count_;; --k) {
        if (groups_[k].used) tip = detail::plus(tip, detail::times(groups_[k].directions, linear));
        if (k == 0) break;
        const Turn& turn = turns_[k - 1];
        const auto point = detail::constant<S>(turn.point_mm);
        tip = detail::plus(detail::turned(detail::minus(tip, point), turn.direction, posture.turn[k - 1]), point);
    }
    const auto from_zero = detail::minus(tip, detail::constant<S>(workpiece_.origin_mm));
    return detail::times(Eigen::Matrix3d(workpiece_.rotation.transpose()), from_zero);
}

/// The turns before the (first) linear group are undone on the tip, those behind it are done on the tool: what is
/// missing between the two is the linear axes' way.
template <class S>
std::array<S, 3> Kinematics::linear_of(const std::array<S, 3>& tip, const Posture<S>& posture) const noexcept {
    Vector<S> from_part =
        detail::plus(detail::times(workpiece_.rotation, tip), detail::constant<S>(workpiece_.origin_mm));
    int first = 0;
    for (; !groups_[first].used; ++first) {
        const auto point = detail::constant<S>(turns_[first].point_mm);
        from_part = detail::plus(
            detail::turned_back(detail::minus(from_part, point), turns_[first].direction, posture.turn[first]), point);
    }
    Vector<S> from_tool = detail::constant<S>(-tool_length_mm_ * tool_at_zero);
    for (int k = rotary_count_; k-- > first;) {
        const auto point = detail::constant<S>(turns_[k].point_mm);
        from_tool =
            detail::plus(detail::turned(detail::minus(from_tool, point), turns_[k].direction, posture.turn[k]), point);
    }
    const Vector<S> missing = detail::minus(from_part, from_tool);
    return only_group_ >= 0 ? detail::times(only_inverse_, missing) : solve_mixed(missing, first, posture);
}

/// Linear axes on both sides of a turn: their directions in the frame of group `first`, then Cramer's rule.
template <class S>
std::array<S, 3> Kinematics::solve_mixed(const std::array<S, 3>& sum, int first,
                                         const Posture<S>& posture) const noexcept {
    std::array<Vector<S>, 3> column;
    for (int axis = 0; axis < 3; ++axis) {
        column[axis] = detail::constant<S>(groups_[rotary_count_].directions.col(axis));
        for (int k = rotary_count_; k-- > first;) {
            column[axis] = detail::plus(detail::turned(column[axis], turns_[k].direction, posture.turn[k]),
                                        detail::constant<S>(groups_[k].directions.col(axis)));
        }
    }
    const S volume = detail::triple(column[0], column[1], column[2]);
    return {detail::triple(sum, column[1], column[2]) / volume, detail::triple(column[0], sum, column[2]) / volume,
            detail::triple(column[0], column[1], sum) / volume};
}

Pose Kinematics::forward(const AxisPosition& position) const noexcept {
    const RotaryPosition rotary{position[3], position[4]};
    const auto at = posture(rotary);
    const auto tip = tip_of({position[0], position[1], position[2]}, at);
    const auto axis = axis_of(at);
    return {{tip[0], tip[1], tip[2]}, {axis[0], axis[1], axis[2]}};
}

Eigen::Vector3d Kinematics::tool_axis(const RotaryPosition& rotary_rad) const noexcept {
    const auto axis = axis_of(posture(rotary_rad));
    return {axis[0], axis[1], axis[2]};
}

VectorSeries Kinematics::tool_axis(const RotarySeries& rotary) const noexcept {
    return axis_of(posture(rotary));
}

std::array<double, 3> Kinematics::linear_for(const Eigen::Vector3d& tip,
                                             const RotaryPosition& rotary_rad) const noexcept {
    return linear_of<double>({tip.x(), tip.y(), tip.z()}, posture(rotary_rad));
}

VectorSeries Kinematics::linear_for(const VectorSeries& tip, const RotarySeries& rotary) const noexcept {
    return linear_of(tip, posture(rotary));
}

VectorSeries Kinematics::tip_for(const VectorSeries& linear, const RotarySeries& rotary) const noexcept {
    return tip_of(linear, posture(rotary));
}

double Kinematics::lever(const RotaryPosition& rotary_rad) const noexcept {
    if (rotary_count_ < 2) return 1;
    const Turn& last = turns_[1];
    const Vector<double> tool{tool_at_zero.x(), tool_at_zero.y(), tool_at_zero.z()};
    const auto axis = detail::turned(tool, last.direction, detail::angle_of(last.sign * rotary_rad[last.index]));
    const auto side = detail::cross(turns_[0].direction, axis);
    return std::hypot(side[0], side[1], side[2]);
}

}  // namespace trunnion::machine
