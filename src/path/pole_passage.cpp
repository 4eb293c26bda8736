#include "trunnion/path/pole_passage.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "trunnion/geometry/great_circle.hpp"

namespace trunnion::path {

double shift_share(double t) noexcept {
    if (t <= level_share) return 1;
    if (t >= 1) return 0;
    const double s = (t - level_share) / (1 - level_share);
    return 1 - s * s * s * s * (35 + s * (-84 + s * (70 - 20 * s)));
}

/// Turned evenly about the axis nearest to the workpiece, a tool axis has that axis as its mean.
std::vector<Eigen::Vector3d> poles_of(const machine::Kinematics& kinematics) {
    if (kinematics.rotary_count() < 2) return {};
    const std::size_t nearest = static_cast<std::size_t>(kinematics.rotary_nearest_workpiece());
    constexpr double third_of_turn = 2 * std::numbers::pi / 3;
    Eigen::Vector3d axis = Eigen::Vector3d::Zero();
    for (const double other : {0.0, 1.0, 2.0}) {
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (int k = 0; k < 3; ++k) {
            machine::RotaryPosition at{other, other};
            at[nearest] = k * third_of_turn;
            sum += kinematics.tool_axis(at);
        }
        if (sum.norm() > axis.norm()) axis = sum;
    }
    axis.normalize();
    std::vector<Eigen::Vector3d> out;
    for (const Eigen::Vector3d& pole : {axis, Eigen::Vector3d(-axis)}) {
        const auto there = kinematics.rotary_for(pole);
        if (there.count > 0 && there.degenerate) out.push_back(pole);
    }
    return out;
}

NearestToPole nearest_to_pole(const Eigen::Vector3d& from, const Eigen::Vector3d& to, const Eigen::Vector3d& pole) {
    const geometry::GreatCircle circle(from, to);
    NearestToPole out;
    const Eigen::Vector3d ahead = to - to.dot(from) * from;
    if (circle.angle_rad() > 0 && ahead.norm() > 0) {
        const double angle = std::atan2(ahead.normalized().dot(pole), from.dot(pole));
        out.share = std::clamp(angle / circle.angle_rad(), 0.0, 1.0);
    }
    const Eigen::Vector3d there = out.share == 1 ? to : circle.at(out.share);
    out.beside = beside_pole(there, pole);
    out.height = there.dot(pole);
    return out;
}

}  // namespace trunnion::path
