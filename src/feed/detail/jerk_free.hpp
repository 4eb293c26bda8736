#pragma once

#include <array>
#include <span>
#include <vector>

#include "trunnion/feed/interval.hpp"

namespace trunnion::feed {

/// Minimum time with velocity, acceleration and feed limits only, window by window: a backward pass of the largest
/// controllable x at four places an interval, then a forward pass. What lies behind a window is taken as free, so the
/// sum is a lower bound of the jerk-limited time, up to the error of the grid. About 0.1 µs a place.
class JerkFreeScan {
  public:
    static constexpr std::size_t steps_per_interval = 4;
    /// −1 ≤ b x + c d ≤ 1 for every coordinate that has a limit, c ≥ 0, of acceleration q″x + ½q′d; x ≤ cap of
    /// velocities.
    struct Rows {
        std::array<double, coordinates> b, c;
        int count = 0;
        double cap = 0;
    };

    explicit JerkFreeScan(const LimitSet& limits) : limits_(limits) {}
    /// Scans the window and returns the time over its first `commit` intervals; `last`: it ends in standstill.
    double advance(std::span<const Interval> window, std::size_t commit, bool last);

  private:
    LimitSet limits_;
    double x_ = 0;  // at the window's begin
    std::vector<double> ceiling_;
    std::vector<Rows> rows_;
};

}  // namespace trunnion::feed
