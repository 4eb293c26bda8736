#pragma once

#include <span>
#include <vector>

#include "trunnion/feed/interval.hpp"

namespace trunnion::feed {

/// Minimum time with velocity, acceleration and feed limits only, window by window: a backward pass of the largest
/// controllable x on the samples, then a forward pass. What lies behind a window is taken as free, so the sum is a
/// lower bound of the jerk-limited time, up to the error of the grid. About 0.3 µs a sample.
class JerkFreeScan {
  public:
    explicit JerkFreeScan(const LimitSet& limits) : limits_(limits) {}
    /// Scans the window and returns the time over its first `commit` intervals; `last`: it ends in standstill.
    double advance(std::span<const Interval> window, std::size_t commit, bool last);

  private:
    LimitSet limits_;
    double x_ = 0;  // at the window's begin
    std::vector<double> ceiling_;
};

}  // namespace trunnion::feed
