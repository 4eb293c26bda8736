#include "trunnion/geometry/great_circle.hpp"

#include <cmath>

#include <Eigen/Geometry>

namespace trunnion::geometry {

double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) noexcept {
    return std::atan2(a.cross(b).norm(), a.dot(b));
}

GreatCircle::GreatCircle(const Eigen::Vector3d& from, const Eigen::Vector3d& to) noexcept
    : from_(from), start_direction_(Eigen::Vector3d::Zero()), angle_rad_(angle_between(from, to)) {
    const Eigen::Vector3d way = to - from;  // exact for near vectors, where to − from·cos θ would cancel
    const Eigen::Vector3d across = way - from * from.dot(way);
    if (const double length = across.stableNorm(); length > 0) start_direction_ = across / length;
}

Eigen::Vector3d GreatCircle::at(double w) const noexcept {
    return std::cos(w * angle_rad_) * from_ + std::sin(w * angle_rad_) * start_direction_;
}

std::array<Taylor3, 3> GreatCircle::at(const Taylor3& w) const noexcept {
    const SinCos turn = sin_cos(angle_rad_ * w);
    std::array<Taylor3, 3> out;
    for (int i = 0; i < 3; ++i) out[i] = from_[i] * turn.cos + start_direction_[i] * turn.sin;
    return out;
}

Eigen::Vector3d slerp(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double w) noexcept {
    return GreatCircle(from, to).at(w);
}

}  // namespace trunnion::geometry
