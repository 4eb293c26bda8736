#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

namespace trunnion::surfacing {

/// Error that is made when the part from one parameter to a later one is gone in one straight step; grows with the
/// part.
using StepError = std::function<double(double from, double to)>;

/// From `begin` to `end` in steps as long as the tolerance lets them, one after the other: the parameters, both ends
/// included. Every step's error is at most `tolerance`, and of all but the last and those held by `longest` above 0.99
/// of it. The last two are levelled to equal lengths where the last one would be a stub below a quarter of its
/// neighbour and both then keep the tolerance. Steps shorter than 1e-6 of the way are taken as they are. Cost: some
/// five errors a step.
std::vector<double> chord_steps(const StepError& error, double begin, double end, double tolerance, double longest);

/// Largest distance of a curve from its chord between two parameters, mm.
double chord_error_mm(const std::function<Eigen::Vector3d(double)>& curve, double from, double to);

}  // namespace trunnion::surfacing
