#include "trunnion/geometry/rotation.hpp"

#include <Eigen/Geometry>

namespace trunnion::geometry {

Eigen::Matrix3d rotation_about(const Eigen::Vector3d& axis, double angle_rad) {
    return Eigen::AngleAxisd(angle_rad, axis.stableNormalized()).toRotationMatrix();
}

}  // namespace trunnion::geometry
