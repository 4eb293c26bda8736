#include "detail/chain.hpp"

#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace trunnion::verify {

namespace {

/// Rodrigues' formula.
Eigen::Vector3d turned(const Eigen::Vector3d& x, const Eigen::Vector3d& about, double sine, double cosine) {
    return cosine * x + sine * about.cross(x) + (1 - cosine) * about.dot(x) * about;
}

}  // namespace

Chain::Chain(const machine::Machine& machine, const machine::Frame& workpiece)
    : count_(machine.axis_count), linear_count_(machine.linear_count()), workpiece_(workpiece) {
    for (int i = 0; i < count_; ++i) {
        const int index = machine.chain[i];
        const machine::Axis& axis = machine.axes[index];
        joints_[i] = {index, axis.rotary, axis.reversed ? -1.0 : 1.0, axis.direction.normalized(), axis.point_mm};
    }
}

Gauge Chain::gauge(const machine::AxisPosition& position) const {
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
    Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
    for (int i = count_ - 1; i >= 0; --i) {
        const Joint& joint = joints_[i];
        const double value = joint.sign * position[joint.axis];
        if (!joint.rotary) {
            point += value * joint.direction;
            continue;
        }
        const double sine = std::sin(value), cosine = std::cos(value);
        point = joint.point_mm + turned(point - joint.point_mm, joint.direction, sine, cosine);
        axis = turned(axis, joint.direction, sine, cosine);
    }
    return {workpiece_.rotation.transpose() * (point - workpiece_.origin_mm), workpiece_.rotation.transpose() * axis};
}

Chain::Turning Chain::turning(const machine::AxisPosition& position, const machine::AxisPosition& rate) const {
    Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
    Eigen::Vector3d change = Eigen::Vector3d::Zero();
    for (int i = count_ - 1; i >= 0; --i) {
        const Joint& joint = joints_[i];
        if (!joint.rotary) continue;
        const double value = joint.sign * position[joint.axis];
        const double sine = std::sin(value), cosine = std::cos(value);
        axis = turned(axis, joint.direction, sine, cosine);
        change =
            turned(change, joint.direction, sine, cosine) + joint.sign * rate[joint.axis] * joint.direction.cross(axis);
    }
    return {workpiece_.rotation.transpose() * axis, workpiece_.rotation.transpose() * change};
}

std::optional<machine::AxisPosition> Chain::with_gauge_at(const Eigen::Vector3d& point_mm,
                                                          const machine::AxisPosition& rotary) const {
    machine::AxisPosition out = rotary;
    for (int i = 0; i < linear_count_; ++i) out[i] = 0;
    if (linear_count_ != 3) return {};
    const Eigen::Vector3d at_zero = gauge(out).point_mm;
    Eigen::Matrix3d lines;
    for (int i = 0; i < 3; ++i) {
        out[i] = 1;
        lines.col(i) = gauge(out).point_mm - at_zero;
        out[i] = 0;
    }
    if (std::abs(lines.determinant()) < 1e-6) return {};
    const Eigen::Vector3d linear = lines.partialPivLu().solve(point_mm - at_zero);
    for (int i = 0; i < 3; ++i) out[i] = linear[i];
    return out;
}

}  // namespace trunnion::verify
