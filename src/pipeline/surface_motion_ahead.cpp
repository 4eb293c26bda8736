#include <algorithm>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "trunnion/pipeline/surface_motion.hpp"
#include "trunnion/surfacing/leave_out.hpp"
#include "trunnion/surfacing/part_body.hpp"

#include "detail/part_looks.hpp"
#include "detail/surface_motion_layer.hpp"
#include "detail/surface_motion_mover.hpp"

namespace trunnion::pipeline {

using interpolation::SurfaceCurve;
using interpolation::SurfaceTool;
using program::Program;

namespace {

constexpr int most_passes = 20000;
constexpr std::size_t window_ahead =
    100;  ///< intervals: a pass begins when so many are planned, not four times as many

Result<void> check_surface_options(const surfacing::SurfaceOptions& options, const surfacing::Cutter& cutter) {
    struct Bound {
        const char* name;
        double value, above, below;
    };
    constexpr double infinite = 1e9;
    for (const auto& [name, value, above, below] :
         {Bound{"scallop_mm", options.scallop_mm, 0, 0.5 * cutter.radius_mm()},
          Bound{"lift_mm", options.lift_mm, 0, infinite},
          Bound{"retract_mm", options.retract_mm, options.lift_mm, infinite},
          Bound{"feed_mm_s", options.feed_mm_s, 0, infinite},
          Bound{"approach_mm_s", options.approach_mm_s, 0, infinite}})
        if (!(value > above && value < below))
            return fail({.code = "SURF0202",
                         .text = fmt::format("{} is out of its range", name),
                         .value = fmt::format("{}", value),
                         .limit = fmt::format("above {:.6g}, below {:.6g}", above, below)});
    return {};
}

bool is_whole(const surfacing::Face& face) {
    const auto box = surfacing::parameter_box(face);
    const auto &u = face.surface.u(), &v = face.surface.v();
    return face.loops.size() == 1 && face.loops.front().size() == 4 && box.low.x() == u.begin() &&
           box.high.x() == u.end() && box.low.y() == v.begin() && box.high.y() == v.end();
}

/// An end of a pass, as links know passes.
surfacing::Pass end_of(const machine::Pose& pose, int index) {
    return {.contacts = {{.pose = {pose.tip_in_workpiece_mm, pose.axis_in_workpiece}}}, .index = index};
}

/// The pass as moves, for the choice of rotary stands.
void add_moves_along(const SurfaceCurve& curve, double feed_mm_s, Program& program) {
    constexpr int chords = 60;
    for (int k = 1; k <= chords; ++k) {
        const machine::Pose to = curve.pose(curve.contact(curve.begin() + (curve.end() - curve.begin()) * k / chords));
        program.moves.push_back({.position_mm = to.tip_in_workpiece_mm,
                                 .axis = to.axis_in_workpiece,
                                 .feed = {program::FeedRule::tip_speed, feed_mm_s},
                                 .kind = program::MoveKind::feed});
    }
}

/// What links keep clear of. Without anything beside the face the body waits until the first pass is planned: the way
/// down to that is one along the tool axis, and the first setpoints are there sooner.
class PartAhead {
  public:
    PartAhead(const surfacing::Face& face, std::span<const surfacing::Face> others, const surfacing::Holder& holder,
              const surfacing::Cutter& cutter, double gouge_tolerance_mm)
        : part_{face}, cutter_(cutter), holder_(holder), gouge_tolerance_mm_(gouge_tolerance_mm) {
        part_.insert(part_.end(), others.begin(), others.end());
    }

    /// Null: links go as the options say, as of a part that is too fine to be looked at.
    const surfacing::PartBeside* beside(bool first_link) {
        if (first_link && part_.size() == 1 && holder_.radius_mm == 0) return nullptr;
        if (!tried_) make();
        return beside_ ? &*beside_ : nullptr;
    }

  private:
    void make() {
        tried_ = true;
        auto body = surfacing::PartBody::make(part_, part_tolerance_mm(gouge_tolerance_mm_));
        if (!body) return;
        body_ = std::move(*body);
        beside_.emplace(surfacing::PartBeside{
            cutter_, *body_, {.tolerance_mm = passing_depth_mm(gouge_tolerance_mm_), .holder = holder_}});
    }

    std::vector<surfacing::Face> part_;
    const surfacing::Cutter& cutter_;
    surfacing::Holder holder_;
    double gouge_tolerance_mm_;
    bool tried_ = false;
    std::optional<surfacing::PartBody> body_;
    std::optional<surfacing::PartBeside> beside_;
};

/// Lays and plans pass after pass.
class AheadPlanner {
  public:
    AheadPlanner(const surfacing::Face& face, const surfacing::Cutter& cutter, const surfacing::SurfaceOptions& surface,
                 PartAhead& part, const machine::Machine& machine, const machine::Setup& setup, double tolerance_mm,
                 SurfaceMotionPlanner& planner)
        : face_(face),
          cutter_(cutter),
          surface_(surface),
          part_(part),
          machine_(machine),
          setup_(setup),
          tolerance_mm_(tolerance_mm),
          planner_(planner) {}

    Result<void> pass(SurfacePlaces places) {
        const bool backwards = surface_.zigzag && count_ % 2 == 1;
        if (backwards) std::ranges::reverse(places);
        const SurfaceTool tool{cutter_.radius_mm(), cutter_.corner_mm(), surface_.lead_rad,
                               backwards ? -surface_.tilt_rad : surface_.tilt_rad};
        const auto curve = curve_of(face_, places, tool, tolerance_mm_);
        if (!curve) return fail(curve.error());
        const surfacing::Pass next = end_of(curve->pose(curve->contact(curve->begin())), count_);
        Program program =
            surfacing::link_between(before_ ? &*before_ : nullptr, &next, surface_, part_.beside(!before_));
        const std::size_t links = program.moves.size();
        add_moves_along(*curve, surface_.feed_mm_s, program);
        const auto stands = surface_stands(program, machine_, setup_, planner_.standing());
        if (!stands) return fail(stands.error());
        program.moves.resize(links);
        const auto linked =
            planner_.link(program, {stands->begin(), stands->begin() + static_cast<std::ptrdiff_t>(links)});
        if (!linked) return linked;
        before_ = end_of(curve->pose(curve->contact(curve->end())), count_);
        const auto line = static_cast<std::int32_t>(++count_);
        return planner_.pass(*curve, surface_.feed_mm_s, line, {});
    }

    Result<void> finish() {
        const Program program = surfacing::link_between(&*before_, nullptr, surface_, part_.beside(false));
        auto stands = surface_stands(program, machine_, setup_, planner_.standing());
        return stands ? planner_.link(program, std::move(*stands)) : fail(stands.error());
    }

  private:
    const surfacing::Face& face_;
    const surfacing::Cutter& cutter_;
    const surfacing::SurfaceOptions& surface_;
    PartAhead& part_;
    const machine::Machine& machine_;
    const machine::Setup& setup_;
    double tolerance_mm_;
    SurfaceMotionPlanner& planner_;
    std::optional<surfacing::Pass> before_;
    int count_ = 0;
};

Result<void> plan_all(SurfacePassLayer& layer, AheadPlanner& ahead, SurfaceMotionPlanner& planner) {
    for (int count = 0; count < most_passes; ++count) {
        const auto parts = layer.next();
        if (!parts) return fail(parts.error());
        if (parts->empty()) return ahead.finish();
        for (const SurfacePlaces& places : *parts)
            if (auto planned = ahead.pass(places); !planned) return planned;
        planner.at_share(layer.share());
    }
    return fail({.code = "PIPE0133", .text = fmt::format("more than {} passes", most_passes)});
}

}  // namespace

Result<SurfaceMotionSummary> move_surface_ahead(const surfacing::Face& face, const surfacing::Cutter& cutter,
                                                const surfacing::SurfaceOptions& surface,
                                                const machine::Machine& machine, const machine::Setup& setup,
                                                const SurfaceMotionOptions& options, PlanObserver& observer,
                                                std::span<const surfacing::Face> others,
                                                const surfacing::Holder& holder) {
    if (auto sound = check_motion_options(options); !sound) return fail(sound.error());
    if (auto sound = check_surface_options(surface, cutter); !sound) return fail(sound.error());
    if (!is_whole(face))
        return fail({.code = "PIPE0133",
                     .text = "passes are laid while others are moved on whole faces alone",
                     .hint = "plan the face first"});
    const auto kinematics = machine::Kinematics::make(machine, setup.workpiece, setup.tool.length_mm);
    if (!kinematics) return fail(kinematics.error());
    SurfaceMotionOptions early = options;
    early.plan.feed.window = std::min(options.plan.feed.window, window_ahead);
    const auto plan = [&](const SurfaceMotionPlanner::Sink& sink) {
        SurfaceMotionPlanner planner(machine, setup, *kinematics, early, sink);
        SurfacePassLayer layer(face, cutter, surface);
        PartAhead part(face, others, holder, cutter, surface.gouge_tolerance_mm);
        AheadPlanner ahead(face, cutter, surface, part, machine, setup, options.place_tolerance_mm, planner);
        return plan_all(layer, ahead, planner);
    };
    SurfaceMover mover(machine, setup, options, observer);
    constexpr int threads = 2;
    if (auto moved = move_as_planned(plan, mover, observer, threads); !moved) return fail(moved.error());
    return mover.finish();
}

}  // namespace trunnion::pipeline
