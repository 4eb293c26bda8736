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

  private:
    CoreProblem core_of(const WindowProblem& window) const;
    std::vector<motion::ProfilePiece> pieces_of(const WindowProblem& window, const Trajectory& core) const;
    WindowPlan improve(const WindowProblem& window);

    InteriorPoint solver_;
    Trajectory start_;
    std::vector<Peaks> peaks_;
};

}  // namespace trunnion::feed
