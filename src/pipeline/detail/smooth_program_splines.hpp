#pragma once

#include <vector>

#include "trunnion/base/result.hpp"

#include "detail/smooth_program_path.hpp"

namespace trunnion::pipeline {

/// A clamped cubic B-spline of poses over p; vectors are not of length 1 between its knots.
struct FittedSpline {
    std::vector<double> knots;
    std::vector<StretchCurve::Pose> control;
};

/// The C² cubic spline through a stretch at stations, with the stretch's slopes at both ends. Stations are put in until
/// it keeps the tolerance; every break is one. Errors: PIPE0017 it does not settle.
Result<FittedSpline> fit_spline(const StretchCurve& curve, double from_mm, double to_mm,
                                const std::vector<double>& breaks, const FitTolerance& tolerance,
                                FitDeviation& deviation);

}  // namespace trunnion::pipeline
