#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <memory>

#include "trunnion/base/result.hpp"
#include "trunnion/feed/interval.hpp"
#include "trunnion/motion/feed_profile.hpp"

namespace trunnion::feed {

struct PlannerOptions {
    /// Weight of the smoothness term: the objective is T + calm · Σ ∫ (jerk/limit)² dt (up to 0.002 only over
    /// coordinates that can be what limits). 0 = off; 0.001 removes chatter for nothing.
    double calm = 0.001;
    /// Intervals that are planned at once; at least 16. A stretch that is shorter is planned as a whole. A window
    /// grows, up to eight times, where it is shorter than two stopping distances.
    std::size_t window = 400;
    /// How many iterations of the solver the window of that number (from 0) may take; 0 leaves it out. Empty: as many
    /// as it needs. What is not finished in time is continued by the plan in hand, which ends in standstill.
    std::function<int(int window)> budget;
    /// The motion comes with this speed and acceleration ṗ, p̈ instead of from rest.
    double start_speed_mm_s = 0, start_acceleration_mm_s2 = 0;
};

/// What a little more of each limit of a coordinate is worth, from the multipliers: d(time)/d(ln limit), s, ≤ 0. Of the
/// fastest motion: with more calm than the usual trace the time follows the limits less.
struct LimitWorth {
    double velocity_s = 0, acceleration_s = 0, jerk_s = 0;
};
using Worth = std::array<LimitWorth, coordinates>;

/// What planning took.
struct PlannerCounts {
    std::size_t intervals = 0;
    int windows = 0;
    int iterations = 0;         ///< of the interior point, all windows
    int tightening_rounds = 0;  ///< solves repeated because a cubic broke a limit between rows
    int fallbacks = 0;          ///< windows whose plan was not the optimum: slowed down, or the old plan kept
    double jerk_free_bound_s = 0;
    Worth worth;
};

/// Minimum-time speed over a stretch, streaming: intervals in, committed profile pieces out.
///
/// Minimises ∫ x^(−½) dp with x(p) = ṗ² a C¹ cubic spline with free x″ at knots, subject for every coordinate to
///     |q′|²x ≤ V²,  |q″x + ½q′x′| ≤ A,  |q‴x + 3/2 q″x′ + ½q′x″|·√x ≤ J
/// (the programmed feed is the velocity of a coordinate). Every plan made ends in standstill, is bounded to 1.0004 of
/// every limit over the whole of every interval and has x > 0; a plan is replaced only by one that passed the same
/// check, and what was committed is never revised. So a window that fails costs time, never a limit. What comes out
/// depends on the intervals alone, not on when they come.
///
/// Cost 10-20 µs an interval, linear in their number; memory for eight windows at most (3 kB an interval).
class FeedPlanner {
  public:
    /// Receives intervals and their pieces in order; times are set from the start of the stretch.
    using Sink = std::function<void(const Interval&, const motion::ProfilePiece&)>;

    FeedPlanner(const LimitSet& limits, const PlannerOptions& options, Sink sink);
    ~FeedPlanner();
    FeedPlanner(FeedPlanner&&) noexcept;
    FeedPlanner& operator=(FeedPlanner&&) noexcept;

    /// Adds the next interval; plans and commits when a window is full.
    void push(const Interval& interval);
    /// The stretch ends behind the last interval: plans and commits the rest. The last interval becomes an arc of
    /// constant jerk and so does, from rest, the first one. Errors: FEED0001 a start speed or acceleration without
    /// meaning, FEED0002 derivatives are not finite, FEED0003 fewer than 3 intervals, FEED0004 no plan even from
    /// standstill, FEED0006 a limit is not more than 0, FEED0007 the start speed cannot be stopped in what is left.
    Result<void> finish();

    const PlannerCounts& counts() const;

  private:
    class State;
    std::unique_ptr<State> state_;
};

/// Errors: FEED0006 a limit of the first `axes` coordinates is 0, negative, missing or not finite, or another one is
/// not more than 0.
Result<void> check_limits(const LimitSet& limits, int axes);

}  // namespace trunnion::feed
