#include "detail/plan_account.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace trunnion::pipeline {

namespace {

constexpr std::size_t most_feed_drops = 200;
constexpr double far_slower = 20;  // than without jerk limits, after a fallback of the planner

void widen(AxisLoad& load, const feed::AxisPeaks& peaks) {
    load.velocity_ratio = std::max(load.velocity_ratio, peaks.velocity);
    load.acceleration_ratio = std::max(load.acceleration_ratio, peaks.acceleration);
    load.jerk_ratio = std::max(load.jerk_ratio, peaks.jerk);
}

}  // namespace

PlanAccount::PlanAccount(const machine::Machine& machine, const PlanOptions& options)
    : axis_count_(machine.axis_count), drops_(options.smoothing.tip_tolerance_mm, most_feed_drops) {
    summary_.options = options;
    summary_.calm.weight = options.feed.calm;
    summary_.axes.resize(static_cast<std::size_t>(machine.axis_count));
    for (int i = 0; i < machine.axis_count; ++i) summary_.axes[i].letter = machine.axes[i].letter;
}

void PlanAccount::add_dwell(double time_s) {
    dwelt_ = true;
    summary_.dwell_time_s += time_s;
}

void PlanAccount::add(const path::AxisPath& path, const feed::StretchPlan& plan, const StretchTable& table,
                      const std::string& file) {
    const path::ToolPath& stretch = path.tool_path();
    const double time_s = plan.profile.duration_s();
    if (plan.fallbacks > 0 && time_s > far_slower * plan.jerk_free_bound_s)
        tell_of_slowness(stretch, time_s, plan.jerk_free_bound_s, file);
    if (moved_) count_stop(stretch);
    moved_ = true;
    dwelt_ = false;
    last_stop_ = stretch.stop;
    (stretch.rapid ? summary_.rapid_time_s : summary_.cut_time_s) += time_s;
    summary_.jerk_free_bound_s += plan.jerk_free_bound_s;
    summary_.intervals += plan.profile.pieces.size();
    summary_.windows += static_cast<std::size_t>(plan.windows);
    summary_.fallbacks += static_cast<std::size_t>(plan.fallbacks);
    add_loads(plan);
    summary_.tip_deviation_mm = std::max(summary_.tip_deviation_mm, stretch.bound.tip_mm);
    summary_.orientation_deviation_rad = std::max(summary_.orientation_deviation_rad, stretch.bound.orientation_rad);
    summary_.height_deviation_mm = std::max(summary_.height_deviation_mm, stretch.bound.height_mm);
    for (const float use : stretch.transition_use) transition_use_.add(use);
    drops_.add(path, plan, table);
}

void PlanAccount::add_loads(const feed::StretchPlan& plan) {
    gradients_.feed_s += plan.feed_worth_s;
    for (int i = 0; i < axis_count_; ++i) {
        widen(summary_.axes[i], plan.peaks[i]);
        jerk_square_s_[i] += plan.jerk_square_s[i];
        gradients_.axes[i].velocity_s += plan.worth[i].velocity_s;
        gradients_.axes[i].acceleration_s += plan.worth[i].acceleration_s;
        gradients_.axes[i].jerk_s += plan.worth[i].jerk_s;
    }
}

void PlanAccount::tell_of_slowness(const path::ToolPath& stretch, double time_s, double bound_s,
                                   const std::string& file) {
    summary_.diagnostics.push_back({.code = "PIPE0102",
                                    .severity = Severity::warning,
                                    .text = "the feed planner found no good plan here: far slower than it needs to be",
                                    .place = {.file = file, .line = stretch.blocks.front().line},
                                    .value = fmt::format("{:.3g} s", time_s),
                                    .limit = fmt::format("{:.3g} s without jerk limits", bound_s),
                                    .hint = "lead the tool axis farther from the pole"});
}

void PlanAccount::count_stop(const path::ToolPath& next) {
    using path::StopCause;
    ExactStops& stops = summary_.exact_stops;
    if (last_stop_ == path::StopCause::turn) return;
    ++stops.total;
    if (dwelt_) {
        ++stops.dwells;
        return;
    }
    switch (last_stop_) {
        case StopCause::reversal:
            ++stops.reversals;
            break;
        case StopCause::rapid:
            ++stops.rapids;
            break;
        case StopCause::corner:
            ++stops.corners;
            break;
        case StopCause::exact_stop:
            ++stops.words;
            break;
        case StopCause::event:
        case StopCause::tool:
        case StopCause::space:
        case StopCause::law:
            ++stops.events;
            break;
        case StopCause::turn:
        case StopCause::end:
            break;
    }
    if (last_stop_ == StopCause::end && next.rapid) ++stops.rapids;
}

Summary PlanAccount::take() {
    const double motion_s = summary_.cut_time_s + summary_.rapid_time_s;
    summary_.jerk_free_bound_s += summary_.dwell_time_s;
    for (int i = 0; i < axis_count_; ++i) {
        AxisLoad& load = summary_.axes[i];
        load.limiting_share = summary_.cut_time_s > 0 ? drops_.limiting_s(i) / summary_.cut_time_s : 0;
        load.jerk_rms = motion_s > 0 ? std::sqrt(jerk_square_s_[i] / motion_s) : 0;
    }
    summary_.feed_drops = drops_.take();
    summary_.tolerance_used = transition_use_.median();
    return std::move(summary_);
}

}  // namespace trunnion::pipeline
