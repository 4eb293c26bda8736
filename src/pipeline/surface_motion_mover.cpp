#include "detail/surface_motion_mover.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/interpolation/interpolator.hpp"
#include "trunnion/interpolation/surface_fit.hpp"
#include "trunnion/interpolation/surface_interpolator.hpp"

#include "detail/stretch_source.hpp"

namespace trunnion::pipeline {

using interpolation::SurfaceCurve;
using interpolation::SurfacePath;

namespace {

constexpr double joint_slack = 1e-6;  // mm or rad, as between the stretches of a program
constexpr double constant_feed = 1e-3;

double tip_speed(const path::AxisPath& path, const motion::FeedProfile& profile,
                 const interpolation::SurfaceInstant& now) {
    const motion::ProfilePiece& piece = profile.pieces[now.profile_piece];
    path::AxisSample sample;
    path.evaluate({piece.path_piece, now.way_mm - path.tool_path().pieces[piece.path_piece].begin_mm}, sample);
    return now.contact_feed_mm_s * sample.feed_rate;
}

}  // namespace

Result<void> check_motion_options(const SurfaceMotionOptions& options) {
    for (const auto& [what, value] : {std::pair{"the period", options.plan.period_s},
                                      {"the tolerance of places", options.place_tolerance_mm},
                                      {"the tip tolerance", options.plan.smoothing.tip_tolerance_mm}})
        if (!(value > 0 && std::isfinite(value)))
            return fail({.code = "PIPE0001",
                         .text = fmt::format("{} must be more than 0", what),
                         .value = fmt::format("{}", value)});
    return {};
}

Result<SurfaceCurve> curve_of(const surfacing::Face& face, std::span<const geometry::SurfacePlace> places,
                              const interpolation::SurfaceTool& tool, double tolerance_mm) {
    const auto fitted = interpolation::fit_places(face.surface, places, tolerance_mm);
    if (!fitted) return fail(fitted.error());
    return SurfaceCurve::make(face.surface, face.side, *fitted, tool);
}

machine::RotaryPosition SurfaceMover::standing() const {
    machine::RotaryPosition out{};
    for (int a = 0; a < machine_.rotary_count; ++a) out[a] = at_[machine_.linear_count() + a];
    return out;
}

Result<void> SurfaceMover::link(const program::Program& program, std::vector<program::RotaryStand> stands) {
    WholeProgram whole(program, machine_, setup_, std::move(stands));
    StretchSource stretches(whole, machine_, options_.plan);
    for (;;) {
        const auto element = stretches.next();
        if (!element) return fail(element.error());
        if (!*element) return {};
        const auto* begin = std::get_if<StretchBegin>(&(*element)->content);
        if (!begin) continue;
        const path::AxisPath& path = *begin->stretch->axis_path;
        if (auto joined = check_joint(path); !joined) return joined;
        const auto plan = feed::plan_stretch(path, options_.plan.feed);
        if (!plan) return fail(located(plan.error(), program, path.tool_path().blocks.front().line));
        begin_stretch(path);
        const StretchTable table = StretchTable::of(path, plan->profile, way_mm_);
        sample(path, *plan, table);
        end_stretch(path, *plan, table);
    }
}

Result<void> SurfaceMover::pass(const SurfaceCurve& curve, double feed_mm_s, std::int32_t line,
                                const machine::RotaryPosition& near) {
    const auto way = interpolation::surface_path(
        curve, kinematics_, {.feed_mm_s = feed_mm_s, .feed_point = options_.feed_point, .line = line});
    if (!way) return fail(way.error());
    const auto path = path::AxisPath::make(way->tool_path, machine_, moved_ ? standing() : near);
    if (!path) return fail(path.error());
    if (auto joined = check_joint(*path); !joined) return joined;
    const auto plan = feed::plan_stretch(*path, options_.plan.feed);
    if (!plan) return fail(plan.error());
    begin_stretch(*path);
    const StretchTable table = StretchTable::of(*path, plan->profile, way_mm_);
    sample(curve, *way, *path, *plan, table, feed_mm_s);
    end_stretch(*path, *plan, table);
    ++out_.passes;
    out_.pass_time_s += plan->profile.duration_s();
    out_.pass_way_mm += way->tool_path.length_mm();
    out_.bridged_mm += way->bridged_mm;
    out_.fit_tip_mm = std::max(out_.fit_tip_mm, way->fit_tip_mm);
    out_.fit_axis_rad = std::max(out_.fit_axis_rad, way->fit_axis_rad);
    out_.bridge_tip_mm = std::max(out_.bridge_tip_mm, way->tool_path.bound.tip_mm);
    out_.bridge_axis_rad = std::max(out_.bridge_axis_rad, way->tool_path.bound.orientation_rad);
    return {};
}

/// The axes go on from where they stand.
Result<void> SurfaceMover::check_joint(const path::AxisPath& next) const {
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

void SurfaceMover::begin_stretch(const path::AxisPath& path) {
    const double now_s = std::chrono::duration<double>(Clock::now() - start_).count();
    if (!moved_) {
        out_.first_ready_s = now_s;
        out_.least_ahead_s = std::numeric_limits<double>::infinity();
        at_ = path.begin_position();
    } else {
        out_.least_ahead_s = std::min(out_.least_ahead_s, out_.first_ready_s + time_s_ - now_s);
    }
    moved_ = true;
    stand_until(time_s_);
}

void SurfaceMover::end_stretch(const path::AxisPath& path, const feed::StretchPlan& plan, const StretchTable& table) {
    account_.add(path, plan, table, {});
    account_.add_blocks(path.tool_path().blocks.size());
    at_ = path.end_position();
    line_ = path.tool_path().blocks.back().line;
    time_s_ += plan.profile.duration_s();
    way_mm_ = table.s_mm.back();
}

void SurfaceMover::emit(const motion::Setpoint& row) {
    observer_.setpoint(row);
    ++row_;
}

void SurfaceMover::stand_until(double time_s) {
    while (next_row_s() < time_s) emit({next_row_s(), at_, line_, way_mm_, 0});
}

void SurfaceMover::sample(const path::AxisPath& path, const feed::StretchPlan& plan, const StretchTable& table) {
    const double end_s = time_s_ + plan.profile.duration_s();
    interpolation::Interpolator interpolator(path, plan.profile);
    for (double t = next_row_s(); t < end_s; t = next_row_s()) {
        const interpolation::Instant now = interpolator.at(t - time_s_);
        const std::size_t piece = now.path_state.profile_piece;
        const double s = table.s_mm[piece] + (now.tip_in_workpiece_mm - table.tip_mm[piece]).norm();
        emit({t, now.position, path.tool_path().blocks[now.block].line, s, now.tip_speed_mm_s});
    }
}

void SurfaceMover::sample(const SurfaceCurve& curve, const SurfacePath& way, const path::AxisPath& path,
                          const feed::StretchPlan& plan, const StretchTable& table, double feed_mm_s) {
    const double end_s = time_s_ + plan.profile.duration_s();
    const interpolation::SurfaceProfile profile(plan.profile);
    interpolation::SurfaceInterpolator interpolator(curve, way, profile, standing(), options_.order);
    const std::int32_t line = way.tool_path.blocks.front().line;
    for (double t = next_row_s(); t < end_s; t = next_row_s()) {
        const interpolation::SurfaceInstant now = interpolator.at(t - time_s_);
        const std::size_t piece = now.profile_piece;
        const double s = table.s_mm[piece] + (now.pose.tip_in_workpiece_mm - table.tip_mm[piece]).norm();
        const double tip = tip_speed(path, plan.profile, now);
        const double counted = options_.feed_point == interpolation::FeedPoint::tip ? tip : now.contact_feed_mm_s;
        if (std::abs(counted - feed_mm_s) <= constant_feed * feed_mm_s) constant_s_ += options_.plan.period_s;
        emit({t, now.position, line, s, tip});
    }
}

SurfaceMotionSummary SurfaceMover::finish() {
    if (moved_) {
        stand_until(time_s_);
        emit({next_row_s(), at_, line_, way_mm_, 0});
    }
    out_.motion = account_.take();
    out_.motion.cycle_time_s = time_s_;
    out_.motion.path_length_mm = way_mm_;
    out_.motion.setpoints = row_;
    out_.motion.machine = machine_.name;
    out_.motion.setup = setup_.file;
    out_.motion.work.elapsed_s = std::chrono::duration<double>(Clock::now() - start_).count();
    out_.constant_feed_share = out_.pass_time_s > 0 ? std::min(constant_s_ / out_.pass_time_s, 1.0) : 0;
    return std::move(out_);
}

}  // namespace trunnion::pipeline
