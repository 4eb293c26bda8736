#pragma once

#include "detail/check.hpp"

/// Arcs of constant path jerk j between standstill and motion: u = j t³/6 from the rest, so x = α u^(4/3) with
/// α = 6^(4/3)/4 · j^(2/3). Every limit on an arc is a bound of α:
///     jerk          j |q′ + 9u q″ + 9/2 u² q‴|,   acceleration  α u^(1/3) |q″u + 2/3 q′|,   velocity  √α u^(2/3) |q′|
/// with derivatives by u. Between samples q′ is a quintic, and Bernstein hulls bound the polynomials.
namespace trunnion::feed {

enum class RestSide { start, stop };

double arc_alpha(double jerk_mm_s3);
double arc_jerk_mm_s3(double alpha);

/// The largest α with which the whole interval holds its limits, and which limit makes it.
struct LargestAlpha {
    double alpha = 0;
    LimitName held_by;
};
LargestAlpha largest_alpha(const Interval& interval, RestSide side, const LimitSet& limits);

/// Bounds of load / limit over an arc of that α.
std::array<Peaks::OfCoordinate, coordinates> arc_loads(const Interval& interval, RestSide side, const LimitSet& limits,
                                                       double alpha);

/// The α that the jerk limits allow at the rest point itself.
double rest_alpha(const PathSample& rest, const LimitSet& limits);

/// Whether an arc of that α may be as long as this: its jerk still nearly allowed there, acceleration and speed far
/// from their limits.
bool is_jerk_phase(const PathSample& sample, double distance_mm, RestSide side, const LimitSet& limits, double alpha);

/// What the core sees of an interval that is an arc.
ArcJoint arc_joint(const Interval& interval, RestSide side, const LimitSet& limits);

}  // namespace trunnion::feed
