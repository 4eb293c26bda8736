#pragma once

#include <array>
#include <limits>
#include <vector>

#include "trunnion/machine/machine.hpp"
#include "trunnion/path/axis_path.hpp"

namespace trunnion::feed {

/// What limits are held along: the machine's axes in the order of AxisVector, then the way of the tip, the turn of the
/// tool (as AxisSample::feed_rate and turn_rate count them), and the programmed feed as a share of itself.
inline constexpr int tip_way = machine::max_axes, tool_turn = tip_way + 1, programmed_feed = tip_way + 2;
inline constexpr int coordinates = programmed_feed + 1;

/// Samples of an interval: both ends and the middle. The solver's rows stand there; between them every coordinate's q′
/// is the quintic through values and two derivatives at both ends of a half.
inline constexpr int samples_per_interval = 3;

/// Derivatives of the coordinates by p at one place (mm, rad or 1 per mm^k). At an interval's ends they are one-sided,
/// from inside. 0 in coordinates that have no limit here.
struct PathSample {
    std::array<double, coordinates> q1{}, q2{}, q3{};
};

/// A place of an arc at rest, so far from the standstill.
struct ArcSample {
    double from_rest_mm = 0;
    PathSample sample;
};

/// A bit of a stretch on which the speed is one cubic x(p). Never straddles path pieces or a change of the feed.
struct Interval {
    path::PathPlace begin;
    double length_mm = 0;  ///< > 0
    std::array<PathSample, samples_per_interval> samples;
    bool chord = false;          ///< whether the chord error bounds the speed more than the programmed feed does
    std::vector<ArcSample> arc;  ///< of the arcs at rest alone: places from the standstill (0) to the other end,
                                 ///< ever closer to the standstill, since beside the pole the axes bend there
};

/// What the coordinates can do; infinite where nothing bounds.
struct LimitSet {
    static constexpr double unbounded = std::numeric_limits<double>::infinity();
    LimitSet() {
        of.fill({unbounded, unbounded, unbounded});
        of[programmed_feed].velocity = 1;
    }
    std::array<machine::AxisLimits, coordinates> of;
};

}  // namespace trunnion::feed
