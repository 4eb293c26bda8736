#include "trunnion/feed/plan_stretch.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "trunnion/feed/feed_planner.hpp"

#include "detail/check.hpp"
#include "detail/grid.hpp"

namespace trunnion::feed {
namespace {

constexpr double limiting_from = 0.97;  // of the limit

LimitSet limits_of(const path::AxisPath& path, double jerk_margin) {
    LimitSet out;
    out.count = path.axis_count();
    for (int a = 0; a < out.count; ++a) {
        const machine::Axis& axis = path.machine().axes[a];
        out.axes[a] = path.tool_path().rapid ? axis.rapid : axis.feed;
        out.axes[a].jerk *= 1 - jerk_margin;
    }
    return out;
}

Cause cause_of(const Peaks& peaks) {
    Cause cause;
    double most = limiting_from;
    const auto consider = [&](double ratio, Cause candidate) {
        if (ratio <= most) return;
        most = ratio;
        cause = candidate;
    };
    consider(peaks.feed, {Cause::Kind::feed, -1});
    for (int a = 0; a < machine::max_axes; ++a) {
        consider(peaks.velocity[a], {Cause::Kind::velocity, a});
        consider(peaks.acceleration[a], {Cause::Kind::acceleration, a});
        consider(peaks.jerk[a], {Cause::Kind::jerk, a});
    }
    return cause;
}

Diagnostic problem(std::string code, std::string text) {
    Diagnostic out;
    out.code = std::move(code);
    out.text = std::move(text);
    return out;
}

Result<void> check(const path::AxisPath& path, const FeedOptions& options) {
    const auto refuse = [](std::string text, double value) {
        Diagnostic out = problem("FEED0001", std::move(text));
        out.value = fmt::format("{}", value);
        return fail(out);
    };
    if (!(options.calm >= 0 && options.calm <= 100)) return refuse("calm must lie between 0 and 100", options.calm);
    if (!(options.jerk_margin >= 0 && options.jerk_margin < 1))
        return refuse("the jerk margin must be at least 0 and less than 1", options.jerk_margin);
    if (!(path.length_mm() > 0)) return fail(problem("FEED0005", "a stretch without length cannot be planned"));
    return {};
}

}  // namespace

std::string name_of(const Cause& cause, const machine::Machine& machine) {
    switch (cause.kind) {
        case Cause::Kind::none:
            return "none";
        case Cause::Kind::feed:
            return "feed";
        case Cause::Kind::velocity:
            return fmt::format("{} velocity", machine.axes[cause.axis].letter);
        case Cause::Kind::acceleration:
            return fmt::format("{} acceleration", machine.axes[cause.axis].letter);
        case Cause::Kind::jerk:
            break;
    }
    return fmt::format("{} jerk", machine.axes[cause.axis].letter);
}

double feed_speed_cap(const path::BlockSpan& block, const path::AxisSample& sample) {
    constexpr double unbounded = std::numeric_limits<double>::infinity();
    const auto per_rate = [&](double rate) { return rate > 0 ? block.feed.value / rate : unbounded; };
    switch (block.feed.rule) {
        case path::FeedRule::tip_speed:
            return per_rate(sample.feed_rate);
        case path::FeedRule::rotary_rate:
            return per_rate(sample.turn_rate);
        case path::FeedRule::block_time:
            return block.time_scale_mm / block.feed.value;
        case path::FeedRule::none:
            break;
    }
    return unbounded;
}

Result<StretchPlan> plan_stretch(const path::AxisPath& path, const FeedOptions& options) {
    if (auto checked = check(path, options); !checked) return fail(checked.error());
    const LimitSet limits = limits_of(path, options.jerk_margin);
    StretchPlan out;
    const auto take = [&](const Interval& interval, const motion::ProfilePiece& piece) {
        const Peaks peaks = peaks_of(interval, piece, limits);
        out.profile.pieces.push_back(piece);
        out.causes.push_back(cause_of(peaks));
        for (int a = 0; a < limits.count; ++a) {
            AxisPeaks& axis = out.peaks[a];
            axis.velocity = std::max(axis.velocity, peaks.velocity[a]);
            axis.acceleration = std::max(axis.acceleration, peaks.acceleration[a]);
            axis.jerk = std::max(axis.jerk, peaks.jerk[a] * (1 - options.jerk_margin));
        }
    };
    FeedPlanner planner(limits, {options.calm, options.window}, take);
    for (const Cell& cell : make_grid(path, limits)) {
        auto interval = sample_cell(path, cell);
        if (!interval) return fail(interval.error());
        planner.push(*interval);
    }
    if (auto done = planner.finish(); !done) return fail(done.error());
    const PlannerCounts& counts = planner.counts();
    out.jerk_free_bound_s = counts.jerk_free_bound_s;
    out.intervals = counts.intervals;
    out.windows = counts.windows;
    out.iterations = counts.iterations;
    out.tightening_rounds = counts.tightening_rounds;
    out.fallbacks = counts.fallbacks;
    return out;
}

}  // namespace trunnion::feed
