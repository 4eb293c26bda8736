#include "trunnion/geometry/helix.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace trunnion::geometry {

Helix::Helix(const Eigen::Vector3d& start, const Eigen::Vector3d& end, const Eigen::Vector3d& on_line,
             const Eigen::Vector3d& normal, double angle_rad) noexcept
    : angle_rad_(angle_rad) {
    const Eigen::Vector3d arm = start - on_line;
    foot_ = on_line + arm.dot(normal) * normal;
    const Eigen::Vector3d spoke = start - foot_;
    radius_ = spoke.norm();
    out_ = spoke / radius_;
    ahead_ = normal.cross(out_);
    const Eigen::Vector3d last = end - foot_;
    widening_ = (last - last.dot(normal) * normal).norm() - radius_;
    along_ = last - (radius_ + widening_) * (std::cos(angle_rad) * out_ + std::sin(angle_rad) * ahead_);
}

double Helix::length() const noexcept {
    return std::hypot(angle_rad_ * (radius_ + 0.5 * widening_), along_.norm(), widening_);
}

double Helix::chord_error(int parts) const noexcept {
    return std::max(radius_, radius_at_end()) * (1 - std::cos(std::min(0.5 * std::abs(angle_rad_) / parts, 1.57)));
}

Eigen::Vector3d Helix::at(double w) const noexcept {
    const double turn = w * angle_rad_;
    return foot_ + (radius_ + w * widening_) * (std::cos(turn) * out_ + std::sin(turn) * ahead_) + w * along_;
}

std::array<Taylor3, 3> Helix::at(const Taylor3& w) const noexcept {
    const SinCos turn = sin_cos(angle_rad_ * w);
    const Taylor3 radius = radius_ + widening_ * w;
    const Taylor3 x = radius * turn.cos, y = radius * turn.sin;
    std::array<Taylor3, 3> out;
    for (int i = 0; i < 3; ++i) out[i] = foot_[i] + out_[i] * x + ahead_[i] * y + along_[i] * w;
    return out;
}

}  // namespace trunnion::geometry
