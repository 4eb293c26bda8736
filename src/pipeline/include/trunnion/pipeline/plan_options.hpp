#pragma once

#include <optional>

#include "trunnion/feed/plan_stretch.hpp"
#include "trunnion/smoothing/smoothing.hpp"

namespace trunnion::pipeline {

struct PlanOptions {
    smoothing::SmoothingOptions smoothing;  ///< its controlled height comes from the tool in use
    feed::FeedOptions feed;                 ///< its period is `period_s`
    double period_s = 1e-3;
    double feed_override = 1;         ///< any value > 0
    std::optional<double> feed_mm_s;  ///< replaces the programmed feeds
    bool path_samples = false;        ///< whether the observer wants them
    bool setpoint_limits = false;     ///< whether the observer wants them
    /// 1, or 2: the geometry is made on a second thread, ahead of the speed. The results are the same bits.
    int threads = 1;
    /// Whether to find out what more of each limit would be worth (Summary::worth): plans again without setpoints, once
    /// for each velocity, acceleration and jerk of the axes that move, for the feed, for calm and for each tolerance.
    bool worth = false;
};

}  // namespace trunnion::pipeline
