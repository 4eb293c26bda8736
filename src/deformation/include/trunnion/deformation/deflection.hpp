#pragma once

#include <functional>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "trunnion/base/result.hpp"
#include "trunnion/deformation/dual_path.hpp"

namespace trunnion::deformation {

/// How far the tip is bent away where it is at the way s along the tip's curve, mm, in the workpiece's frame, as a
/// function of s and of the pose wanted there. Smooth (C²): a kink costs knots.
using Deflection = std::function<Eigen::Vector3d(double s_mm, const Pose& wanted)>;

/// What was measured or computed at one place.
struct DeflectionSample {
    double s_mm = 0;
    Eigen::Vector3d deflection_mm = Eigen::Vector3d::Zero();
};

/// The field through samples: natural cubic spline over s. Errors: DEFO0116 fewer than 2 samples, s does not rise, or a
/// number is not finite.
Result<Deflection> deflection_through(const std::vector<DeflectionSample>& samples);

struct CompensatedPath {
    DualPath path;
    double largest_deflection_mm = 0;
    double residual_mm = 0;  ///< largest |tip + deflection − tip wanted| where it was looked at
};

/// Length of the tip's curve, mm, within 1e-9 of it.
double tip_length_mm(const DualPath& path);

/// The path whose tip, bent by the deflection, runs on the tip of the path given: q(u) = f(u) − δ(s(u)), the axis as it
/// was. The same fit as of poses, with knots added until the residual is within the tolerance, and the axis within
/// tolerance / h; C².
///
/// The deflection is that at the place wanted: where it changes over its own size, apply again with the field of the
/// new path. Errors: DEFO0105 the tolerance is not above 0, DEFO0106 it cannot be kept (says what could), DEFO0116 the
/// field is not finite somewhere; those of fit_dual_path(). `covered_to_mm`: the s up to which the field is known;
/// DEFO0117 the path is longer.
Result<CompensatedPath> compensate_deflection(const DualPath& path, const Deflection& deflection, double tolerance_mm,
                                              std::optional<double> covered_to_mm = {});

}  // namespace trunnion::deformation
