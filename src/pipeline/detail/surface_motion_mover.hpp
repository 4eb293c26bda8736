#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>

#include "trunnion/interpolation/interpolator.hpp"
#include "trunnion/interpolation/surface_interpolator.hpp"
#include "trunnion/pipeline/surface_motion.hpp"

#include "detail/plan_account.hpp"
#include "detail/stretch_table.hpp"
#include "detail/surface_motion_planner.hpp"

namespace trunnion::pipeline {

/// Errors: PIPE0001 a period or tolerance that is not above 0, or neither 1 nor 2 threads.
Result<void> check_motion_options(const SurfaceMotionOptions& options);

/// Moves what is planned, part after part, and hands out its setpoints. What it is made from must outlive it.
class SurfaceMover {
  public:
    SurfaceMover(const machine::Machine& machine, const machine::Setup& setup, const SurfaceMotionOptions& options,
                 PlanObserver& observer)
        : machine_(machine), setup_(setup), options_(options), observer_(observer), account_(machine, options.plan) {}

    void take(const PlannedSurfacePart& part);
    SurfaceMotionSummary finish();

  private:
    using Clock = std::chrono::steady_clock;

    /// The stretch at hand, as far as it is planned: what follows it points to what it follows.
    struct Following {
        PlannedSurfacePart begin;  ///< keeps its path
        motion::FeedProfile profile;
        interpolation::SurfaceProfile on_surface;
        StretchTable table;
        std::optional<interpolation::Interpolator> link;
        std::optional<interpolation::SurfaceInterpolator> pass;
    };

    void note_when_ready(const PlannedSurfacePart& part);
    void begin(const PlannedSurfacePart& part);
    void end(const feed::StretchPlan& plan);
    void add(const SurfacePass& pass, double time_s);
    void sample_link();
    void sample_pass();
    void emit(const motion::Setpoint& row);
    void stand_until(double time_s);
    double next_row_s() const { return static_cast<double>(row_) * options_.plan.period_s; }

    const machine::Machine& machine_;
    const machine::Setup& setup_;
    const SurfaceMotionOptions& options_;
    PlanObserver& observer_;
    PlanAccount account_;
    SurfaceMotionSummary out_;
    machine::AxisPosition at_;
    bool moved_ = false;
    double time_s_ = 0, way_mm_ = 0, constant_s_ = 0;
    std::size_t row_ = 0;
    std::int32_t line_ = 0;
    std::unique_ptr<Following> following_;
    Clock::time_point start_ = Clock::now();
};

/// Plans all of a motion, handing it to a sink.
using PlanSurfaceMotion = std::function<Result<void>(const SurfaceMotionPlanner::Sink&)>;

/// Moves it while it is planned. With two threads planning goes on, on a thread of its own, some parts ahead; the
/// mover and the observer stay on the caller's. The same setpoints, and the same error, either way: the first in the
/// order of the motion, behind the setpoints before it. Errors: those of `plan`, PIPE0002.
Result<void> move_as_planned(const PlanSurfaceMotion& plan, SurfaceMover& mover, PlanObserver& observer, int threads);

}  // namespace trunnion::pipeline
