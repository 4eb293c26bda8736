#pragma once

#include <chrono>
#include <span>
#include <vector>

#include "trunnion/feed/plan_stretch.hpp"
#include "trunnion/interpolation/surface_curve.hpp"
#include "trunnion/pipeline/surface_motion.hpp"

#include "detail/plan_account.hpp"
#include "detail/stretch_table.hpp"

namespace trunnion::pipeline {

/// Errors: PIPE0001 a period or tolerance that is not above 0.
Result<void> check_motion_options(const SurfaceMotionOptions& options);

/// The curve of a pass through places on a face. Errors: INTP0001 … INTP0005.
Result<interpolation::SurfaceCurve> curve_of(const surfacing::Face& face,
                                             std::span<const geometry::SurfacePlace> places,
                                             const interpolation::SurfaceTool& tool, double tolerance_mm);

/// Moves links and passes one after another and hands out their setpoints. What it is made from must outlive it.
class SurfaceMover {
  public:
    SurfaceMover(const machine::Machine& machine, const machine::Setup& setup, const machine::Kinematics& kinematics,
                 const SurfaceMotionOptions& options, PlanObserver& observer)
        : machine_(machine),
          setup_(setup),
          kinematics_(kinematics),
          options_(options),
          observer_(observer),
          account_(machine, options.plan) {}

    /// The moves of a program with their stands; its first pose is where the axes stand.
    Result<void> link(const program::Program& program, std::vector<program::RotaryStand> stands);
    /// `near`: where the rotary axes begin, if nothing has moved so far.
    Result<void> pass(const interpolation::SurfaceCurve& curve, double feed_mm_s, std::int32_t line,
                      const machine::RotaryPosition& near);

    /// Where the rotary axes stand. Precondition: something has moved.
    machine::RotaryPosition standing() const;

    SurfaceMotionSummary finish();

  private:
    using Clock = std::chrono::steady_clock;
    void begin_stretch(const path::AxisPath& path);
    void end_stretch(const path::AxisPath& path, const feed::StretchPlan& plan, const StretchTable& table);
    Result<void> check_joint(const path::AxisPath& next) const;
    void sample(const path::AxisPath& path, const feed::StretchPlan& plan, const StretchTable& table);
    void sample(const interpolation::SurfaceCurve& curve, const interpolation::SurfacePath& way,
                const path::AxisPath& path, const feed::StretchPlan& plan, const StretchTable& table, double feed_mm_s);
    void emit(const motion::Setpoint& row);
    void stand_until(double time_s);
    double next_row_s() const { return static_cast<double>(row_) * options_.plan.period_s; }

    const machine::Machine& machine_;
    const machine::Setup& setup_;
    const machine::Kinematics& kinematics_;
    const SurfaceMotionOptions& options_;
    PlanObserver& observer_;
    PlanAccount account_;
    SurfaceMotionSummary out_;
    machine::AxisPosition at_;
    bool moved_ = false;
    double time_s_ = 0, way_mm_ = 0, constant_s_ = 0;
    std::size_t row_ = 0;
    std::int32_t line_ = 0;
    Clock::time_point start_ = Clock::now();
};

}  // namespace trunnion::pipeline
