#pragma once

#include <vector>

#include "detail/check.hpp"
#include "detail/start_profile.hpp"

namespace trunnion::feed {

struct WindowPlan {
    std::vector<motion::ProfilePiece> pieces;  ///< one per interval, times not set
    bool safe = false;                         ///< every limit held to `allowed_ratio`, x > 0
    bool fallback = false;                     ///< not the optimum: the solver failed or the plan had to be slowed down
    int iterations = 0, rounds = 0;
};

/// Plans one window: arcs, start profile, interior point, and rounds of tightening where the cubic breaks a limit
/// between rows. From rest the plan is always safe (in the worst case slow); from a moving start it may be not.
class WindowSolver {
  public:
    WindowPlan solve(const WindowProblem& window);
    /// After a solve: adds what more of each limit is worth to the first `count` intervals of it.
    void add_worth(const WindowProblem& window, std::size_t count, Worth& worth) const {
        if (count > window.first_core()) solver_->add_worth(count - window.first_core(), worth);
    }

  private:
    CoreProblem core_of(const WindowProblem& window) const;
    std::vector<motion::ProfilePiece> pieces_of(const WindowProblem& window, const Trajectory& core) const;
    WindowPlan improve(const WindowProblem& window);

    std::unique_ptr<InteriorPoint> solver_ = InteriorPoint::make();
    Trajectory start_;
    std::vector<Peaks> peaks_;
};

}  // namespace trunnion::feed
