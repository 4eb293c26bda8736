#pragma once

#include <array>
#include <vector>

#include "trunnion/feed/plan_stretch.hpp"
#include "trunnion/pipeline/summary.hpp"

#include "detail/feed_drops.hpp"
#include "detail/stretch_table.hpp"
#include "detail/transition_use.hpp"

namespace trunnion::pipeline {

/// d(time)/d(ln limit) of the whole program, s.
struct LimitGradients {
    std::array<feed::LimitWorth, machine::max_axes> axes{};
    double feed_s = 0;
};

/// Running sums of what the summary says.
class PlanAccount {
  public:
    PlanAccount(const machine::Machine& machine, const PlanOptions& options);

    void add_blocks(std::size_t count) { summary_.blocks += count; }
    void add_dwell(double time_s);
    /// In the order of the motion.
    void add(const path::AxisPath& path, const feed::StretchPlan& plan, const StretchTable& table,
             const std::string& file);

    /// The summary so far, shares and medians worked out. Once, at the end.
    Summary take();
    const LimitGradients& gradients() const { return gradients_; }

  private:
    void count_stop(const path::ToolPath& next);
    void add_loads(const feed::StretchPlan& plan);
    void tell_of_slowness(const path::ToolPath& stretch, double time_s, double bound_s, const std::string& file);

    int axis_count_;
    Summary summary_;
    FeedDropCollector drops_;
    LimitGradients gradients_;
    std::array<double, machine::max_axes> jerk_square_s_{};
    TransitionUse transition_use_;
    bool moved_ = false, dwelt_ = false;
    path::StopCause last_stop_ = path::StopCause::end;
};

}  // namespace trunnion::pipeline
