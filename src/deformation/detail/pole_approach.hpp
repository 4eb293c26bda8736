#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "trunnion/deformation/dual_path.hpp"

namespace trunnion::deformation::detail {

/// Nearer than this the tool goes through the pole.
inline constexpr double through_pole_rad = 1e-12;

/// Where a path comes nearest to a pole: a least distance between its ends, or at one of them.
struct PoleApproach {
    double u = 0;
    Eigen::Vector3d pole = Eigen::Vector3d::UnitZ();
    double distance_rad = 0;
    bool at_end = false;
};

/// All of them in the hemisphere of each pole, by u; looked for at eight places a knot interval, to rounding in u.
std::vector<PoleApproach> pole_approaches(const DualPath& path, std::span<const Eigen::Vector3d> poles);

}  // namespace trunnion::deformation::detail
