#include "serve_orders.hpp"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"

namespace trunnion::app {

namespace {

constexpr double nothing_mm = 1e-7;
constexpr double whole_turn_rad = 1e-12;  // an end angle so near to the begin's is a whole turn

/// The angle about the normal from one place to the other as LinuxCNC counts turns.
double angle_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to, const Eigen::Vector3d& normal, int turn) {
    const double angle = std::atan2(from.cross(to).dot(normal), from.dot(to) - from.dot(normal) * to.dot(normal));
    const double whole = 2 * std::numbers::pi;
    if (turn >= 0) return (angle <= whole_turn_rad ? angle + whole : angle) + whole * turn;
    return (angle >= -whole_turn_rad ? angle - whole : angle) + whole * (turn + 1);
}

program::Feed feed_of(const trunnion_order& order, const pipeline::QueuedPose& begin, const pipeline::QueuedPose& end) {
    if (order.rapid) return {};
    const bool turns_only = order.kind == trunnion_order_line && (end.tip_mm - begin.tip_mm).norm() < nothing_mm;
    if (turns_only) return {program::FeedRule::rotary_rate, order.speed * degree};
    return {program::FeedRule::tip_speed, order.speed};
}

}  // namespace

Result<WorldPoses> WorldPoses::make(const machine::Machine& machine, double tool_length_mm) {
    for (int i = 0; i < machine.axis_count; ++i) {
        const char letter = machine.axes[i].letter;
        const bool known = machine.axes[i].rotary ? letter >= 'A' && letter <= 'C' : letter >= 'X' && letter <= 'Z';
        if (!known)
            return fail({.code = "RT0101",
                         .text = fmt::format("LinuxCNC's poses have no axis {} of this kind", letter),
                         .limit = "linear X, Y, Z; rotary A, B, C"});
    }
    auto kinematics = machine::Kinematics::make(machine, {}, tool_length_mm);
    if (!kinematics) return fail(kinematics.error());
    return WorldPoses(machine, *kinematics, tool_length_mm);
}

pipeline::QueuedPose WorldPoses::pose_of(const double (&world)[9]) const {
    pipeline::QueuedPose out;
    out.tip_mm = {world[0], world[1], world[2] - tool_length_mm_};
    for (int i = 0; i < machine_->rotary_count; ++i)
        out.rotary_rad[i] = world[3 + machine_->axes[machine_->linear_count() + i].letter - 'A'] * degree;
    return out;
}

trunnion_row WorldPoses::row_of(const pipeline::LiveRow& row) const {
    trunnion_row out{};
    const Eigen::Vector3d tip = kinematics_.forward(row.position).tip_in_workpiece_mm;
    for (int i = 0; i < 3; ++i) out.position[i] = tip[i];
    out.position[2] += tool_length_mm_;
    for (int i = machine_->linear_count(); i < machine_->axis_count; ++i)
        out.position[3 + machine_->axes[i].letter - 'A'] = row.position[i] / degree;
    out.line = row.line;
    return out;
}

pipeline::QueuedMove move_of(const trunnion_order& order, const pipeline::QueuedPose& begin, const WorldPoses& poses) {
    pipeline::QueuedMove out;
    out.number = static_cast<std::int32_t>(order.number);
    out.end = poses.pose_of(order.end);
    out.feed = feed_of(order, begin, out.end);
    out.rapid = order.rapid != 0;
    out.exact_stop = order.joint != trunnion_joint_blend;
    out.stop_first = order.stop_first != 0;
    out.tip_tolerance_mm = order.tolerance;
    if (order.kind != trunnion_order_arc) return out;
    program::Arc arc;
    arc.centre_mm = {order.centre[0], order.centre[1], order.centre[2] - poses.tool_length_mm()};
    arc.normal = Eigen::Vector3d(order.normal[0], order.normal[1], order.normal[2]).normalized();
    arc.angle_rad = angle_between(begin.tip_mm - arc.centre_mm, out.end.tip_mm - arc.centre_mm, arc.normal, order.turn);
    out.arc = arc;
    return out;
}

}  // namespace trunnion::app
