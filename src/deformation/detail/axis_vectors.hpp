#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "trunnion/deformation/dual_path.hpp"

namespace trunnion::deformation::detail {

/// D_i = g_i − f_i of the control points: D(u) = Σ N_i(u) D_i points along the tool axis.
std::vector<Eigen::Vector3d> axis_vectors(const DualPath& path);

/// The path with other axis vectors. f stays where the tip is controlled; at the controlled height c the control points
/// of f move by −c/h·(D′_i − D_i), so that f + c/h·D stays. Control points whose axis vector is the same stay bit for
/// bit.
DualPath with_axis_vectors(const DualPath& path, std::span<const Eigen::Vector3d> vectors, double controlled_height_mm);

/// Averages of the knots at which the control points of a cubic have most of their influence (Greville).
std::vector<double> control_places(const DualPath& path);

/// The same curves over more knots: every one of `at` once more (Boehm's insertion). Precondition: `at` rises strictly
/// inside the domain and holds none of the path's knots.
DualPath with_knots(const DualPath& path, std::span<const double> at);

/// The poses of the path at u, moved along the axis so that the controlled point of each is where it is in `before`.
std::vector<Pose> poses_about(std::span<const Pose> before, std::span<const double> u, const DualPath& path,
                              double controlled_height_mm);

}  // namespace trunnion::deformation::detail
