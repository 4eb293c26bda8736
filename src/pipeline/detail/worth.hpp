#pragma once

#include <functional>
#include <span>

#include "trunnion/pipeline/summary.hpp"

#include "detail/plan_account.hpp"
#include "detail/stretch_source.hpp"

namespace trunnion::pipeline {

/// What was planned, and from what.
struct PlannedJob {
    const program::Program& program;
    const machine::Machine& machine;
    const machine::Setup& setup;
    const PlanOptions& options;
    std::span<const program::RotaryStand> stands;
};

/// How many times the program will be planned again, at most: nothing where neither worth is asked for nor calm has a
/// price worth looking for.
int most_replans(const PlannedJob& job);

/// Finds the price of calm and, where asked for, what more of each limit is worth, and writes them into the summary of
/// the plan at hand. Cost: the path is smoothed once for all limits and once for each tolerance; the speed is planned
/// once for each. `go_on` as in motion_times. Errors: PIPE0002. What cannot be planned becomes PIPE0103 in the summary.
Result<void> find_worth(const PlannedJob& job, const LimitGradients& gradients,
                        const std::function<bool(double)>& go_on, Summary& summary);

}  // namespace trunnion::pipeline
