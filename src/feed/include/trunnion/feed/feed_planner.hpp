#pragma once

#include <cstddef>
#include <functional>
#include <memory>

#include "trunnion/base/result.hpp"
#include "trunnion/feed/interval.hpp"
#include "trunnion/motion/feed_profile.hpp"

namespace trunnion::feed {

struct PlannerOptions {
    /// Weight of the smoothness term: the objective is T + calm · Σ ∫ (jerk/limit)² dt. 0 = off; 0.001 removes chatter
    /// for nothing.
    double calm = 0.001;
    /// Intervals that are planned at once; at least 16. A stretch that is shorter is planned as a whole. A window
    /// grows, up to eight times, where it is shorter than two stopping distances.
    std::size_t window = 300;
};

/// What planning took.
struct PlannerCounts {
    std::size_t intervals = 0;
    int windows = 0;
    int iterations = 0;         ///< of the interior point, all windows
    int tightening_rounds = 0;  ///< solves repeated because a cubic broke a limit between rows
    int fallbacks = 0;          ///< windows whose plan was not the optimum: slowed down, or the old plan kept
    double jerk_free_bound_s = 0;
};

/// Minimum-time speed over a stretch from rest to rest, streaming: intervals in, committed profile pieces out.
///
/// Minimises ∫ x^(−½) dp with x(p) = ṗ² a C¹ cubic spline with free x″ at knots, subject for every axis to
///     |q′|²x ≤ V²,  |q″x + ½q′x′| ≤ A,  |q‴x + 3/2 q″x′ + ½q′x″|·√x ≤ J,
/// and to the programmed feed. Every plan made ends in standstill, was checked at all samples (peaks between them by a
/// parabola) to 1.0004 of every limit and has x > 0; a plan is replaced only by one that passed the same check, and
/// what was committed is never revised. So a window that fails costs time, never a limit.
///
/// Cost 20-60 µs an interval, linear in their number; memory for eight windows at most (4 kB an interval).
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
    /// The stretch ends behind the last interval: plans and commits the rest. The first and the last interval become
    /// arcs of constant jerk. Errors: FEED0003 fewer than 3 intervals, FEED0004 no plan even from standstill
    /// (derivatives that are not finite).
    Result<void> finish();

    const PlannerCounts& counts() const;

  private:
    class State;
    std::unique_ptr<State> state_;
};

}  // namespace trunnion::feed
