#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "trunnion/feed/plan_stretch.hpp"
#include "trunnion/interpolation/surface_curve.hpp"
#include "trunnion/interpolation/surface_path.hpp"
#include "trunnion/pipeline/surface_motion.hpp"

#include "detail/stretch.hpp"

namespace trunnion::pipeline {

/// A pass as it is moved. The axis path points to the way: they stay together.
struct SurfacePass {
    interpolation::SurfaceCurve curve;
    interpolation::SurfacePath way;
    std::optional<path::AxisPath> axes;
    double feed_mm_s = 0;
};

/// The next piece of the motion over a surface: of a stretch from rest to rest, a pass or a part of a link, as much as
/// the planner knows more of it.
struct PlannedSurfacePart {
    std::shared_ptr<const SurfacePass> pass;      ///< null: of a link
    std::shared_ptr<const Stretch> link;          ///< null: of a pass
    bool begins = false;                          ///< the stretch
    std::vector<motion::ProfilePiece> pieces;     ///< that follow those of the part before; they never change
    std::optional<feed::StretchPlan> plan;        ///< of the whole stretch, with its last part
    std::chrono::steady_clock::time_point ready;  ///< when it was planned
    double share = 0;                             ///< of the whole motion, behind it

    const path::AxisPath& axes() const { return pass ? *pass->axes : *link->axis_path; }
};

/// Where the rotary axes stand at the moves of a program; they may go through a pole where passes are led through it.
/// Errors: those of path::choose_rotary_stands.
Result<std::vector<program::RotaryStand>> surface_stands(const program::Program& program,
                                                         const machine::Machine& machine, const machine::Setup& setup,
                                                         const std::optional<machine::RotaryPosition>& standing = {});

/// The curve of a pass through places on a face. Errors: INTP0001 … INTP0005.
Result<interpolation::SurfaceCurve> curve_of(const surfacing::Face& face,
                                             std::span<const geometry::SurfacePlace> places,
                                             const interpolation::SurfaceTool& tool, double tolerance_mm);

/// Plans links and passes one after another, and hands them out as they are planned, window by window of the feed
/// planner. What it is made from must outlive it and what it hands out.
class SurfaceMotionPlanner {
  public:
    /// False: nothing more is wanted.
    using Sink = std::function<bool(PlannedSurfacePart)>;

    SurfaceMotionPlanner(const machine::Machine& machine, const machine::Setup& setup,
                         const machine::Kinematics& kinematics, const SurfaceMotionOptions& options, const Sink& sink)
        : machine_(machine), setup_(setup), kinematics_(kinematics), options_(options), sink_(sink) {}

    /// The moves of a program with their stands; its first pose is where the axes stand. Errors: those of path,
    /// smoothing and feed; PIPE0131; PIPE0002 nothing more is wanted.
    Result<void> link(const program::Program& program, std::vector<program::RotaryStand> stands);
    /// `near`: where the rotary axes begin, if nothing has moved so far. Errors: those of surface_path() and feed,
    /// PIPE0131; PIPE0002.
    Result<void> pass(const interpolation::SurfaceCurve& curve, double feed_mm_s, std::int32_t line,
                      const machine::RotaryPosition& near);

    void at_share(double share) { share_ = share; }
    /// Where the rotary axes stand; none while nothing has moved.
    std::optional<machine::RotaryPosition> standing() const;

  private:
    Result<void> check_joint(const path::AxisPath& next) const;
    Result<void> plan(PlannedSurfacePart stretch);
    Result<void> hand_out(PlannedSurfacePart part);

    const machine::Machine& machine_;
    const machine::Setup& setup_;
    const machine::Kinematics& kinematics_;
    const SurfaceMotionOptions& options_;
    const Sink& sink_;
    machine::AxisPosition at_;
    bool moved_ = false;
    double share_ = 0;
};

}  // namespace trunnion::pipeline
