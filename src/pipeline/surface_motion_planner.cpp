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
        auto plan = feed::plan_stretch(path, options_.plan.feed);
        if (!plan) return fail(located(plan.error(), program, path.tool_path().blocks.front().line));
        if (auto out = hand_out({.link = begin->stretch, .plan = *std::move(plan)}); !out) return out;
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
    auto plan = feed::plan_stretch(*pass->axes, options_.plan.feed);
    if (!plan) return fail(plan.error());
    return hand_out({.pass = pass, .plan = *std::move(plan)});
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

Result<void> SurfaceMotionPlanner::hand_out(PlannedSurfaceStretch stretch) {
    const path::AxisPath& axes = stretch.axes();
    stretch.table = StretchTable::of(axes, stretch.plan.profile, way_mm_);
    stretch.share = share_;
    moved_ = true;
    at_ = axes.end_position();
    way_mm_ = stretch.table.s_mm.back();
    stretch.ready = std::chrono::steady_clock::now();
    if (!sink_(std::move(stretch))) return fail({.code = "PIPE0002", .text = "cancelled"});
    return {};
}

}  // namespace trunnion::pipeline
