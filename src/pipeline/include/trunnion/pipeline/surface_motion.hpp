#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "trunnion/base/result.hpp"
#include "trunnion/interpolation/surface_path.hpp"
#include "trunnion/interpolation/surface_step.hpp"
#include "trunnion/pipeline/plan.hpp"
#include "trunnion/pipeline/surface.hpp"
#include "trunnion/surfacing/plan_surface.hpp"
#include "trunnion/verify/programmed_path.hpp"

namespace trunnion::pipeline {

struct SurfaceMotionOptions {
    /// Period, limits, threads, and how links are rounded; its feeds, overrides and worth are not used.
    PlanOptions plan;
    interpolation::StepOrder order = interpolation::StepOrder::corrected;
    interpolation::FeedPoint feed_point = interpolation::FeedPoint::contact;
    /// How far a pass may be moved sideways on the surface so that it is a C⁴ curve of few pieces.
    double place_tolerance_mm = 0.002;
};

/// What a motion over a surface came to.
struct SurfaceMotionSummary {
    Summary motion;  ///< of passes and links together, as plan() counts
    std::size_t passes = 0;
    double pass_time_s = 0, pass_way_mm = 0;  ///< of the passes; way of the contact
    double constant_feed_share = 0;           ///< of the passes' time within 0.1 % of the programmed feed
    double fit_tip_mm = 0, fit_axis_rad = 0;  ///< polynomials that the feed was planned on, from the true poses
    double bridge_tip_mm = 0, bridge_axis_rad = 0, bridged_mm = 0;  ///< over knots of the surface and poles
    /// Seconds of work: from the call until the first setpoints were ready; and by how much, had the motion begun then,
    /// every part of it was planned before it was due, the least of all.
    double first_ready_s = 0, least_ahead_s = 0;
    std::optional<SurfacePartCheck> part;  ///< none: not looked at; whoever moves sets it (MotionInPart)
    std::optional<FreedAccount> freed;     ///< of the plan; whoever made it sets it

    bool usable() const { return motion.usable() && !(part && part->in_part); }
    std::string report() const;
};
std::string to_json(const SurfaceMotionSummary& summary);

/// Moves a tool over a surface plan: every pass on the surface itself, by interpolation::SurfaceInterpolator, from rest
/// to rest; the links between as the moves of the plan's program, rounded and planned as plan() does. The feed is
/// lowered ahead of places where velocity, acceleration or jerk of an axis would exceed its limit. Where the tool axis
/// passes a pole within 1e-5 rad, it is led through it (interpolation::surface_path). A pass that stands on an
/// orientation surface (freed of gouges) takes its axis from there, every period.
///
/// `faces`: those that were planned (Contact::face). The setup's [tool] is the tool. Setpoints come as
/// soon as a window of the feed planner is planned (FeedOptions::window); memory follows the longest pass; with two
/// threads planning runs at most 64 windows ahead on one of its own, and all that comes out is the same but for times.
///
/// Errors: PIPE0001 a period or tolerance that is not above 0, threads neither 1 nor 2; PIPE0130 the program of the
/// plan does not go through the poses of its passes; PIPE0131 an axis would have to turn where a pass begins (at the
/// pole); PIPE0132 the poses of a pass have not the lead and tilt of the options, or the axes of its orientation
/// surface; PIPE0002 cancelled; those of
/// interpolation (INTP), path and feed.
Result<SurfaceMotionSummary> move_surface(const surfacing::SurfacePlan& plan, std::span<const surfacing::Face> faces,
                                          const surfacing::SurfaceOptions& surface, const machine::Machine& machine,
                                          const machine::Setup& setup, const SurfaceMotionOptions& options,
                                          PlanObserver& observer);

/// The poses of a surface plan as the truth that its motion is checked against: branch and winding as move_surface()
/// chooses them. Errors: those of path::choose_rotary_stands and verify::programmed_poses.
Result<std::vector<verify::ProgrammedPose>> programmed_poses(const surfacing::SurfacePlan& plan,
                                                             const machine::Machine& machine,
                                                             const machine::Setup& setup);

/// Lin & Koren's system end to end: passes from the border of least v on, each laid only when the motion over the one
/// before is planned, offset from it by the least interval that Eq. 2 gives along it (normal radii). One whole face;
/// strategy, feed angle and borders of the options are not used; the last pass is the border of largest v.
///
/// Passes are laid and planned on a thread of its own, at most 64 windows ahead, while the caller's thread
/// interpolates: an observer that takes its time over every setpoint, as a control does, has the next ones ready
/// (`least_ahead_s`). The tool is held against the face where it touches it; what it does beside its contact on passes
/// MotionInPart tells afterwards. Links keep clear of the face and of `others`, the rest of the part, as those of
/// make_surface_program(). Ridges are not measured.
///
/// Branch and winding of the rotary axes are chosen pass by pass. Errors: as above; PIPE0133 not a whole face, or more
/// than 20 000 passes; SURF0202, SURF0203 as surfacing::plan_surface.
Result<SurfaceMotionSummary> move_surface_ahead(const surfacing::Face& face, const surfacing::Cutter& cutter,
                                                const surfacing::SurfaceOptions& surface,
                                                const machine::Machine& machine, const machine::Setup& setup,
                                                const SurfaceMotionOptions& options, PlanObserver& observer,
                                                std::span<const surfacing::Face> others = {},
                                                const surfacing::Holder& holder = {});

}  // namespace trunnion::pipeline
