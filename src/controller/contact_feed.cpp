#include "trunnion/controller/contact_feed.hpp"

#include <cmath>

#include <Eigen/Geometry>

namespace trunnion::controller {

Eigen::Vector3d contact_from_tip_mm(const machine::Tool& tool, const Eigen::Vector3d& tool_axis,
                                    const Eigen::Vector3d& feed, double lead_rad) {
    constexpr double upright = 1e-9;
    const Eigen::Vector3d across = feed - feed.dot(tool_axis) * tool_axis;
    if (!(across.norm() > upright * feed.norm())) return Eigen::Vector3d::Zero();
    const Eigen::Vector3d ahead = across.normalized();
    const Eigen::Vector3d normal = std::cos(lead_rad) * tool_axis - std::sin(lead_rad) * ahead;
    const double corner = tool.corner_radius_mm, inner = tool.diameter_mm / 2 - corner;
    const double side = std::abs(lead_rad) > upright ? std::copysign(1.0, lead_rad) : 0;
    return corner * (tool_axis - normal) + side * inner * ahead;
}

Eigen::Vector3d tool_turning_rad_s(const machine::Machine& machine, const machine::Frame& workpiece,
                                   const machine::AxisPosition& position, const machine::AxisVelocity& velocity) {
    Eigen::Vector3d turning = Eigen::Vector3d::Zero();
    Eigen::Matrix3d so_far = Eigen::Matrix3d::Identity();
    for (int i = 0; i < machine.axis_count; ++i) {
        const auto at = static_cast<std::size_t>(machine.chain[static_cast<std::size_t>(i)]);
        const machine::Axis& axis = machine.axes[at];
        if (!axis.rotary) continue;
        const double sign = axis.reversed ? -1 : 1;
        turning += so_far * (sign * velocity[at] * axis.direction);
        so_far = so_far * Eigen::AngleAxisd(sign * position[at], axis.direction).toRotationMatrix();
    }
    return workpiece.rotation.transpose() * turning;
}

}  // namespace trunnion::controller
