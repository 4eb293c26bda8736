#pragma once

#include <array>

#include <Eigen/Core>

#include "trunnion/deformation/reduce_rotary.hpp"

namespace trunnion::deformation::detail {

/// What an OrientationFreedom allows at the places of a path. Keeps references.
class OrientationLimits {
  public:
    OrientationLimits(const DualPath& path, const machine::Tool& tool, const OrientationFreedom& freedom)
        : path_(path), freedom_(freedom), height_mm_(tool.controlled_height_mm()) {}

    /// A place, with what does not depend on the new tool axis.
    struct At {
        double u = 0;
        Eigen::Vector3d axis, controlled_mm;
        Eigen::Vector3d normal, feed;
        bool leans = false;  ///< lead and tilt are asked and the feed has a direction
    };
    At at(double u) const;

    static constexpr std::size_t count = 6;
    /// Deviation, both ends of lead and of tilt, clearance: above 0 where the limit is broken; angles in shares of the
    /// orientation tolerance, the clearance in twentieths of a millimetre.
    std::array<double, count> excess(const At& at, const Eigen::Vector3d& axis) const;
    double clearance_mm(const At& at, const Eigen::Vector3d& axis) const;

  private:
    const DualPath& path_;
    const OrientationFreedom& freedom_;
    double height_mm_;
};

}  // namespace trunnion::deformation::detail
