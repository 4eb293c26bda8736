#include "detail/surface_motion_planner.hpp"

#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/interpolation/surface_fit.hpp"
#include "trunnion/path/rotary_stands.hpp"

#include "detail/stretch_source.hpp"

namespace trunnion::pipeline {

using interpolation::SurfaceCurve;

namespace {

constexpr double joint_slack = 1e-6;  // mm or rad, as between the stretches of a program

}  // namespace

Result<std::vector<program::RotaryStand>> surface_stands(const program::Program& program,
                                                         const machine::Machine& machine, const machine::Setup& setup,
                                                         const std::optional<machine::RotaryPosition>& standing) {
    return path::choose_rotary_stands(program, machine, setup, interpolation::SurfacePathOptions{}.pole_rad, standing);
}

Result<SurfaceCurve> curve_of(const surfacing::Face& face, std::span<const geometry::SurfacePlace> places,
                              const interpolation::SurfaceTool& tool, double tolerance_mm) {
    const auto fitted = interpolation::fit_places(face.surface, places, tolerance_mm);
    if (!fitted) return fail(fitted.error());
    return SurfaceCurve::make(face.surface, face.side, *fitted, tool);
}

std::optional<machine::RotaryPosition> SurfaceMotionPlanner::standing() const {
    if (!moved_) return std::nullopt;
    machine::RotaryPosition out{};
    for (int a = 0; a < machine_.rotary_count; ++a) out[a] = at_[machine_.linear_count() + a];
    return out;
}

Result<void> SurfaceMotionPlanner::link(const program::Program& program, std::vector<program::RotaryStand> stands) {
    WholeProgram whole(program, machine_, setup_, std::move(stands));
    StretchSource stretches(whole, machine_, options_.plan);
    for (;;) {
        auto element = stretches.next();
        if (!element) return fail(element.error());
        if (!*element) return {};
        const auto* begin = std::get_if<StretchBegin>(&(*element)->content);
        if (!begin) continue;
        const path::AxisPath& path = *begin->stretch->axis_path;
        if (auto joined = check_joint(path); !joined) return joined;
        if (auto planned = plan({.link = begin->stretch}); !planned)
            return fail(located(planned.error(), program, path.tool_path().blocks.front().line));
    }
}

Result<void> SurfaceMotionPlanner::pass(const SurfaceCurve& curve, double feed_mm_s, std::int32_t line,
                                        const machine::RotaryPosition& near) {
    auto way = interpolation::surface_path(curve, kinematics_,
                                           {.feed_mm_s = feed_mm_s, .feed_point = options_.feed_point, .line = line});
    if (!way) return fail(way.error());
    const auto pass = std::make_shared<SurfacePass>(SurfacePass{curve, *std::move(way), {}, feed_mm_s});
    auto axes = path::AxisPath::make(pass->way.tool_path, machine_, standing().value_or(near));
    if (!axes) return fail(axes.error());
    pass->axes = *std::move(axes);
    if (auto joined = check_joint(*pass->axes); !joined) return joined;
    return plan({.pass = pass});
}

/// The axes go on from where they stand.
Result<void> SurfaceMotionPlanner::check_joint(const path::AxisPath& next) const {
    const machine::AxisPosition begin = next.begin_position();
    for (int i = 0; moved_ && i < machine_.axis_count; ++i) {
        if (std::abs(begin[i] - at_[i]) <= joint_slack) continue;
        const machine::Axis& axis = machine_.axes[i];
        const double unit = axis.rotary ? degree : 1;
        return fail({.code = "PIPE0131",
                     .text = fmt::format("axis {} would have to move where a pass begins or ends", axis.letter),
                     .place = {.line = next.tool_path().blocks.front().line},
                     .value = fmt::format("{:.6f} {}", begin[i] / unit, axis.rotary ? "deg" : "mm"),
                     .limit = fmt::format("{:.6f} {}", at_[i] / unit, axis.rotary ? "deg" : "mm"),
                     .hint = "give lead or tilt, so that passes do not end with the tool along a rotary axis"});
    }
    return {};
}

/// A stretch as feed::plan_stretch() plans it, handed out while it is planned.
Result<void> SurfaceMotionPlanner::plan(PlannedSurfacePart stretch) {
    const path::AxisPath& axes = stretch.axes();
    auto intervals = feed::IntervalStream::make(axes, options_.plan.feed);
    if (!intervals) return fail(intervals.error());
    feed::StretchPlanner planner(axes, options_.plan.feed);
    std::size_t handed = 0;
    stretch.begins = true;
    stretch.share = share_;
    const auto take_new = [&](const motion::FeedProfile& planned) {
        stretch.pieces.assign(planned.pieces.begin() + static_cast<std::ptrdiff_t>(handed), planned.pieces.end());
        handed = planned.pieces.size();
    };
    for (feed::Interval interval;;) {
        const auto more = intervals->next(interval);
        if (!more) return fail(more.error());
        if (!*more) break;
        planner.push(interval);
        if (planner.planned().pieces.size() == handed) continue;
        take_new(planner.planned());
        if (auto out = hand_out(stretch); !out) return out;
        stretch.begins = false;
    }
    auto plan = planner.finish();
    if (!plan) return fail(plan.error());
    take_new(plan->profile);
    stretch.plan = *std::move(plan);
    moved_ = true;
    at_ = axes.end_position();
    return hand_out(std::move(stretch));
}

Result<void> SurfaceMotionPlanner::hand_out(PlannedSurfacePart part) {
    part.ready = std::chrono::steady_clock::now();
    if (!sink_(std::move(part))) return fail({.code = "PIPE0002", .text = "cancelled"});
    return {};
}

}  // namespace trunnion::pipeline
