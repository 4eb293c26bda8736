#pragma once

#include <optional>
#include <string>

#include "trunnion/base/result.hpp"
#include "trunnion/feed/plan_stretch.hpp"
#include "trunnion/machine/machine.hpp"
#include "trunnion/motion/setpoint.hpp"
#include "trunnion/path/axis_path.hpp"
#include "trunnion/pipeline/summary.hpp"
#include "trunnion/program/program.hpp"
#include "trunnion/smoothing/smoothing.hpp"

namespace trunnion::pipeline {

struct PlanOptions {
    smoothing::SmoothingOptions smoothing;  ///< its controlled height comes from the tool in use
    feed::FeedOptions feed;
    double period_s = 1e-3;
    double feed_override = 1;         ///< any value > 0
    std::optional<double> feed_mm_s;  ///< replaces the programmed feeds
    bool path_samples = false;        ///< whether the observer wants them
};

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
    const program::Event* event = nullptr;
};

/// Takes the results as they come. Every function may be left as it is.
struct PlanObserver {
    virtual ~PlanObserver() = default;
    virtual void setpoint(const motion::Setpoint&) {}
    virtual void path_sample(const PathSample&) {}
    virtual void event(const EventRow&) {}
    /// Called now and then with the share of moves done; false cancels (PIPE0002).
    virtual bool progress(double) { return true; }
};

/// Program → smoothed path → jerk-limited feed profile → setpoints, stretch by stretch.
/// Errors: those of the rooms it chains; PIPE0001 bad option, PIPE0002 cancelled, PIPE0003 a fault of ours, PIPE0005
/// rounding led the tool past the pole on the other side than rotary words behind it count from.
Result<Summary> plan(const program::Program& program, const machine::Machine& machine, const machine::Setup& setup,
                     const PlanOptions& options, PlanObserver& observer);

}  // namespace trunnion::pipeline
