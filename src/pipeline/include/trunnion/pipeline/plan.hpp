#pragma once

#include <array>

#include <Eigen/Core>

#include "trunnion/base/result.hpp"
#include "trunnion/machine/machine.hpp"
#include "trunnion/motion/setpoint.hpp"
#include "trunnion/path/axis_path.hpp"
#include "trunnion/pipeline/plan_options.hpp"
#include "trunnion/pipeline/summary.hpp"
#include "trunnion/program/program_parts.hpp"

namespace trunnion::pipeline {

/// One row of `--path`: geometry and speed at one place.
struct PathSample {
    double p_mm = 0, s_mm = 0;
    Eigen::Vector3d tip_mm, axis;
    double speed_limit_mm_s = 0;  ///< ṗ that programmed feed and axis velocities allow here
    double speed_mm_s = 0;        ///< ṗ
    double feed_top_mm_s = 0;     ///< speed of the point at the flank height
    std::array<Taylor3, machine::max_axes> axes;
};

/// An event of the program at its place in the motion.
struct EventRow {
    double time_s = 0, s_mm = 0;
    const program::Event* event = nullptr;  ///< for the time of the call
};

/// What holds the speed down at a setpoint.
struct SetpointLimit {
    double programmed_feed_mm_s = 0;  ///< of the tip in the workpiece, overrides counted; infinite: nothing programmed
    feed::Cause cause;
    bool rapid = false;
};

/// Takes the results as they come, on the thread that called plan(). Every function may be left as it is.
struct PlanObserver {
    virtual ~PlanObserver() = default;
    /// Comes right before its setpoint, where PlanOptions::setpoint_limits asks for it; not for rows of standstill.
    virtual void setpoint_limit(const SetpointLimit&) {}
    virtual void setpoint(const motion::Setpoint&) {}
    virtual void path_sample(const PathSample&) {}
    virtual void event(const EventRow&) {}
    /// Called now and then with the share of the work done, ascending; false cancels (PIPE0002).
    virtual bool progress(double) { return true; }
};

/// Program → smoothed path → jerk-limited feed profile → setpoints, stretch by stretch: the setpoints of a stretch
/// come as soon as its speed is planned.
///
/// With two threads the path and its intervals are made ahead of the planner, at most some 8000 intervals (10 MB), so
/// that memory does not grow. Setpoints, events, path samples, diagnostics and the summary but for Work are the same
/// bits as with one; so is the error where there is one: the first in the program's order.
///
/// The price of calm is found by planning once more without it, where it is asked for (`worth`) or the weight is above
/// 0.001. That and `worth` come behind the last setpoint.
///
/// Errors: those of the rooms it chains; PIPE0001 bad option, PIPE0002 cancelled, PIPE0003 a fault of ours, PIPE0005
/// rounding led the tool past the pole on the other side than rotary words behind it count from.
/// Warnings in the summary: PIPE0102 a stretch far slower than it needs to be, PIPE0103 a worth that could not be
/// found.
Result<Summary> plan(const program::Program& program, const machine::Machine& machine, const machine::Setup& setup,
                     const PlanOptions& options, PlanObserver& observer);

/// The same for a program that is read meanwhile: memory follows its parts, not the program. Each part begins with the
/// rotary axes as the one before left them: their branch and winding are chosen part by part. A program in one part is
/// planned as above. Errors: also those of the reader, at its place behind the setpoints of what came before.
/// Warnings: also PIPE0106 no worth in parts.
Result<Summary> plan(program::ProgramParts& parts, const machine::Machine& machine, const machine::Setup& setup,
                     const PlanOptions& options, PlanObserver& observer);

}  // namespace trunnion::pipeline
