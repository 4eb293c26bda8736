#pragma once

#include <Eigen/Geometry>

#include "trunnion/geometry/great_circle.hpp"

namespace trunnion::smoothing {

/// The constant-rate turn of the tool axis within a block. Opposite vectors, whose plane is undefined, turn in some
/// plane and arrive to 1e-9 rad.
inline geometry::GreatCircle turn_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    if ((from + to).norm() > 1e-9) return {from, to};
    return {from, (to + 1e-9 * from.unitOrthogonal()).normalized()};
}

}  // namespace trunnion::smoothing
