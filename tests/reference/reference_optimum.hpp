#pragma once

#include "trunnion/path/axis_path.hpp"

/// The minimum time of a stretch by a method that shares nothing with the planner: its own samples, finite differences
/// of x = ṗ² at the nodes, and a sequence of linear programmes (CLP). The jerk rows |L(x)| ≤ x^(−½) are replaced by the
/// tangent of x^(−½), which lies below it, so every iterate is feasible; the objective ∫ x^(−½) dp by its tangent
/// within a trust region. Standstill at both ends by an arc of constant path jerk.
namespace trunnion::reference {

struct Options {
    int nodes = 800;
    int max_rounds = 120;
    double relative_gain = 2e-6;  ///< stop when this little was gained with a small trust region
    double jerk_factor = 1;       ///< on all jerk limits
};

struct Optimum {
    double time_s = 0;
    int rounds = 0;
    bool converged = false;
};

/// Cost: some seconds for 1000 nodes.
Optimum reference_optimum(const path::AxisPath& path, const Options& options = {});

}  // namespace trunnion::reference
