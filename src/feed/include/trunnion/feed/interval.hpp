#pragma once

#include <array>
#include <limits>
#include <vector>

#include "trunnion/machine/machine.hpp"
#include "trunnion/path/axis_path.hpp"

namespace trunnion::feed {

/// Samples of an interval, evenly spaced, both ends included. The solver's rows stand at the first, the middle and the
/// last one; a plan is checked at all of them.
inline constexpr int samples_per_interval = 9;

/// Derivatives of the axes by p (mm, rad per mm^k) and the programmed feed at one place. At an interval's ends they are
/// one-sided, from inside.
struct PathSample {
    std::array<double, machine::max_axes> q1{}, q2{}, q3{};
    double feed_cap = std::numeric_limits<double>::infinity();  ///< bound of x = ṗ², mm²/s²
};

/// A place of an arc at rest, so far from the standstill. Beside the pole the axes bend within a tiny part of the arc,
/// and time is long there: these places come ever nearer to the standstill, in steps of 1.25.
struct NearRest {
    double from_rest_mm = 0;  ///< > 0
    PathSample sample;
};

/// A bit of a stretch on which the speed is one cubic x(p). Never straddles path pieces or a change of the feed.
struct Interval {
    path::PathPlace begin;
    double length_mm = 0;  ///< > 0
    std::array<PathSample, samples_per_interval> samples;
    std::vector<NearRest> near_rest;  ///< of the arcs at rest alone
};

/// What the axes can do: the first `count` of `axes` count.
struct LimitSet {
    std::array<machine::AxisLimits, machine::max_axes> axes;
    int count = 0;
};

}  // namespace trunnion::feed
