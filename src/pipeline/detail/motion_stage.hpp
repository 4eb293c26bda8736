#pragma once

#include <optional>

#include "trunnion/interpolation/interpolator.hpp"
#include "trunnion/pipeline/plan.hpp"

#include "detail/element.hpp"
#include "detail/plan_account.hpp"

namespace trunnion::pipeline {

/// Takes the elements of an IntervalSource in order; plans the speed, and hands setpoints, path samples and events to
/// the observer as soon as a stretch is planned. Nothing of a stretch is kept after it.
class MotionStage {
  public:
    MotionStage(const machine::Machine& machine, const PlanOptions& options, PlanObserver& observer)
        : options_(options), observer_(observer), account_(machine, options) {}

    /// Errors: those of feed::StretchPlanner, with the line of the stretch.
    Result<void> take(const Element& element);

    /// Behind the last element: the last rows, and the summary.
    Summary finish();
    const LimitGradients& gradients() const { return account_.gradients(); }

  private:
    void begin(const RunBegin& run);
    void begin(const StretchBegin& stretch);
    Result<void> plan(const IntervalBatch& batch);
    void perform(const feed::StretchPlan& plan);
    void events_before_block(std::size_t block);
    void events_of_stretch(const motion::FeedProfile& profile, const StretchTable& table);
    SetpointLimit limit_at(const feed::StretchPlan& plan, const interpolation::Instant& now) const;
    void sample(const feed::StretchPlan& plan, const StretchTable& table);
    void hold_until(double time_s);
    void emit(const motion::Setpoint& row);
    const path::AxisPath& path() const { return *stretch_.stretch->axis_path; }

    const PlanOptions& options_;
    PlanObserver& observer_;
    PlanAccount account_;
    RunBegin run_;
    StretchBegin stretch_;
    std::optional<feed::StretchPlanner> planner_;
    std::size_t next_event_ = 0;  // of the run
    machine::AxisPosition at_;
    bool moved_ = false;
    double time_s_ = 0;  // of the start of the next stretch
    double s_mm_ = 0, p_mm_ = 0;
    std::size_t row_ = 0;
    std::int32_t line_ = 0;
    double plan_s_ = 0, sample_s_ = 0;
};

}  // namespace trunnion::pipeline
