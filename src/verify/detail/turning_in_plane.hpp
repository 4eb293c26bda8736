#pragma once

#include <cmath>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace trunnion::verify {

/// Angle between two unit vectors, right for small and for large angles.
inline double angle_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    return 2 * std::atan2((to - from).norm(), (to + from).norm());
}

/// Whether no plane is given in which to turn from one to the other.
inline bool opposite(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    return (from + to).squaredNorm() < 1e-18;
}

/// Part of the way from one unit vector to another in their plane, in proportion to the angle.
inline Eigen::Vector3d turned_in_plane(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double share) {
    const double angle = angle_between(from, to);
    if (angle < 1e-12) return to;
    const Eigen::Vector3d across = (to - to.dot(from) * from).normalized();
    return std::cos(share * angle) * from + std::sin(share * angle) * across;
}

}  // namespace trunnion::verify
