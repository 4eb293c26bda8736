#pragma once

#include <vector>

#include <Eigen/Core>

#include "trunnion/interpolation/surface_curve.hpp"
#include "trunnion/machine/kinematics.hpp"

namespace trunnion::interpolation::detail {

/// Where the tool axis along a curve passes a pole (path/pole_passage.hpp) most closely.
struct PoleOnCurve {
    double w = 0;
    Eigen::Vector3d pole;
};

/// The places inside the curve where the axis passes a pole of the machine within an angle, ascending. `breaks`: the
/// begin, the knots and rough places, the end, ascending; between neighbours eight places are looked at. Allocates.
std::vector<PoleOnCurve> poles_on(const SurfaceCurve& curve, const machine::Kinematics& kinematics,
                                  const std::vector<double>& breaks, double within_rad);

}  // namespace trunnion::interpolation::detail
