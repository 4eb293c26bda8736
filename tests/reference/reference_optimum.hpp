#pragma once

#include "trunnion/path/axis_path.hpp"

/// The minimum time of a stretch by a method that shares nothing with the planner: its own samples and nodes, and a
/// sequence of linear programmes (CLP).
///
/// x = ṗ² is a C¹ quadratic spline; its B-spline coefficients are the unknowns, one an interval. Every row stands where
/// it is a compact difference of neighbouring coefficients and of second order: the speed's on the coefficient itself,
/// acceleration at the nodes (first difference), jerk at the middles (second difference). Elsewhere a quadratic spline
/// could zigzag. So the time found is neither above nor below the optimum, but within O(nodes⁻²) of it.
///
/// The jerk rows |L(x)| ≤ x^(−½) are replaced by the tangent of x^(−½), which lies below it, so every iterate is
/// feasible; the objective ∫ x^(−½) dp by its tangent within a trust region. Standstill at both ends is by an arc of
/// constant path jerk. A coarse solution starts the next finer one.
namespace trunnion::reference {

struct Options {
    int nodes = 800;
    int max_rounds = 60;          ///< linear programmes a level
    double relative_gain = 2e-6;  ///< stop when this little was gained with a small trust region
    double jerk_factor = 1;       ///< on all jerk limits
};

struct Optimum {
    double time_s = 0;
    double coarse_time_s = 0;  ///< with half the nodes: how far the time has converged
    double worst_use = 0;      ///< of any row's limit: 1 to rounding
    int rounds = 0;
    bool converged = false;
};

/// Cost: some seconds for 1000 nodes.
Optimum reference_optimum(const path::AxisPath& path, const Options& options = {});

}  // namespace trunnion::reference
