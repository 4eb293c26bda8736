#pragma once

#include <limits>

#include "detail/interior_point.hpp"

namespace trunnion::feed {

/// A window: intervals of which the last one is an arc to rest and, when it starts from rest, the first one too.
struct WindowProblem {
    std::span<const Interval> intervals;  ///< at least 3 from rest, at least 2 else
    std::span<Tightening> tightening;     ///< as many; grows
    const LimitSet* limits = nullptr;
    double calm = 0;
    std::size_t far_from = static_cast<std::size_t>(-1);  ///< see CoreProblem; of `intervals`
    bool from_rest = true;
    double x0 = 0, d0 = 0;                                  ///< when not from_rest
    int most_iterations = std::numeric_limits<int>::max();  ///< budget of the solver, all rounds together
    std::span<const double> known_middle;  ///< of the plan in hand: x at the middles of the first intervals
    std::size_t first_core() const { return from_rest ? 1 : 0; }
    std::size_t core_count() const { return intervals.size() - 1 - first_core(); }
};

/// A profile over the core of a window that is almost feasible and about twice as slow as the optimum. Built in
/// y = x^(3/4), where a run of constant jerk from rest is a straight line: bound, Lipschitz passes, two averagings.
/// This is what lets the solver converge: starts with jumps in x′ do not. Cost about 0.4 µs an interval.
void make_start_profile(const WindowProblem& window, const CoreProblem& core, Trajectory& out);

}  // namespace trunnion::feed
