#pragma once

#include <functional>
#include <span>
#include <vector>

#include "trunnion/feed/plan_stretch.hpp"
#include "trunnion/pipeline/plan_options.hpp"

#include "detail/stretch_source.hpp"

namespace trunnion::pipeline {

/// One change of the limits of the speed, the path staying what it is.
struct LimitChange {
    feed::FeedOptions feed;
    double feed_factor = 1;  ///< on the programmed feeds
};

/// The time in motion (without dwells) under each change, s, or why there is no plan. The path is made once for all
/// changes; each of them costs what planning costs, setpoints left out; nothing is kept of a stretch. With two threads
/// they plan half of the changes each.
/// `go_on` is called on the caller's thread with the share done; false cancels. Errors: those of StretchSource;
/// PIPE0002.
Result<std::vector<Result<double>>> motion_times(StretchSource& stretches, const machine::Machine& machine,
                                                 std::span<const LimitChange> changes, int threads,
                                                 const std::function<bool(double)>& go_on);

}  // namespace trunnion::pipeline
