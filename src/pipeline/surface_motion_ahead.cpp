#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include "trunnion/pipeline/surface_motion.hpp"

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

machine::Pose raised(const machine::Pose& pose, double height_mm) {
    return {pose.tip_in_workpiece_mm + height_mm * pose.axis_in_workpiece, pose.axis_in_workpiece};
}

/// Moves from one pass to the next and along it.
class LinkWriter {
  public:
    explicit LinkWriter(const surfacing::SurfaceOptions& options) : options_(options) {}

    /// From where a pass ended, if there was one, down to where the next begins: the last move of the program.
    Program link(const std::optional<machine::Pose>& from, const machine::Pose& to) {
        if (from) start_at(*from);
        if (from && options_.zigzag) {
            feed(raised(*from, options_.lift_mm), options_.feed_mm_s);
            feed(raised(to, options_.lift_mm), options_.feed_mm_s);
        } else {
            if (from) rapid(raised(*from, options_.retract_mm));
            rapid(raised(to, options_.retract_mm));
            rapid(raised(to, options_.lift_mm));
        }
        feed(to, options_.approach_mm_s);
        return std::move(program_);
    }
    Program last(const machine::Pose& from) {
        start_at(from);
        rapid(raised(from, options_.retract_mm));
        return std::move(program_);
    }
    static void along(const SurfaceCurve& curve, double feed_mm_s, Program& program) {
        constexpr int chords = 60;
        for (int k = 1; k <= chords; ++k) {
            const auto at = curve.contact(curve.begin() + (curve.end() - curve.begin()) * k / chords);
            program.moves.push_back(move(curve.pose(at), program::MoveKind::feed, feed_mm_s));
        }
    }

  private:
    static program::Move move(const machine::Pose& to, program::MoveKind kind, double feed_mm_s) {
        program::Move out{.position_mm = to.tip_in_workpiece_mm, .axis = to.axis_in_workpiece, .kind = kind};
        if (kind == program::MoveKind::feed) out.feed = {program::FeedRule::tip_speed, feed_mm_s};
        return out;
    }
    void feed(const machine::Pose& to, double mm_s) {
        program_.moves.push_back(move(to, program::MoveKind::feed, mm_s));
    }
    void rapid(const machine::Pose& to) { program_.moves.push_back(move(to, program::MoveKind::rapid, 0)); }
    /// moves[0] is where motion starts, not a motion.
    void start_at(const machine::Pose& pose) { rapid(pose); }

    const surfacing::SurfaceOptions& options_;
    Program program_{.name = "surface", .dialect = "apt"};
};

/// Lays and plans pass after pass.
class AheadPlanner {
  public:
    AheadPlanner(const surfacing::Face& face, const surfacing::Cutter& cutter, const surfacing::SurfaceOptions& surface,
                 const machine::Machine& machine, const machine::Setup& setup, double tolerance_mm,
                 SurfaceMotionPlanner& planner)
        : face_(face),
          cutter_(cutter),
          surface_(surface),
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
        Program program = LinkWriter(surface_).link(end_, curve->pose(curve->contact(curve->begin())));
        const std::size_t links = program.moves.size();
        LinkWriter::along(*curve, surface_.feed_mm_s, program);
        const auto stands = surface_stands(program, machine_, setup_, planner_.standing());
        if (!stands) return fail(stands.error());
        program.moves.resize(links);
        const auto linked =
            planner_.link(program, {stands->begin(), stands->begin() + static_cast<std::ptrdiff_t>(links)});
        if (!linked) return linked;
        const auto line = static_cast<std::int32_t>(++count_);
        if (auto planned = planner_.pass(*curve, surface_.feed_mm_s, line, {}); !planned) return planned;
        end_ = curve->pose(curve->contact(curve->end()));
        return {};
    }

    Result<void> finish() {
        const Program program = LinkWriter(surface_).last(*end_);
        auto stands = surface_stands(program, machine_, setup_, planner_.standing());
        return stands ? planner_.link(program, std::move(*stands)) : fail(stands.error());
    }

  private:
    const surfacing::Face& face_;
    const surfacing::Cutter& cutter_;
    const surfacing::SurfaceOptions& surface_;
    const machine::Machine& machine_;
    const machine::Setup& setup_;
    double tolerance_mm_;
    SurfaceMotionPlanner& planner_;
    std::optional<machine::Pose> end_;
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
                                                const SurfaceMotionOptions& options, PlanObserver& observer) {
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
        AheadPlanner ahead(face, cutter, surface, machine, setup, options.place_tolerance_mm, planner);
        return plan_all(layer, ahead, planner);
    };
    SurfaceMover mover(machine, setup, options, observer);
    constexpr int threads = 2;
    if (auto moved = move_as_planned(plan, mover, observer, threads); !moved) return fail(moved.error());
    return mover.finish();
}

}  // namespace trunnion::pipeline
