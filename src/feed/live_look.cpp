#include <algorithm>
#include <cmath>

#include "detail/live_state.hpp"

namespace trunnion::feed {
namespace {

constexpr std::size_t smallest_window = 16;
constexpr double look_cells = 64, look_margin = 1.3;
constexpr int most_looks = 5;
constexpr std::size_t most_departures = 32;

LimitSet limits_of(const path::AxisPath& path, const FeedOptions& options, double kept_back) {
    LimitSet out;
    out.count = path.axis_count();
    for (int a = 0; a < out.count; ++a) {
        const machine::Axis& axis = path.machine().axes[a];
        out.axes[a] = path.tool_path().rapid ? axis.rapid : axis.feed;
        out.axes[a].velocity *= options.factors[a].velocity * kept_back;
        out.axes[a].acceleration *= options.factors[a].acceleration * kept_back;
        out.axes[a].jerk *= options.factors[a].jerk * (1 - options.jerk_margin);
    }
    return out;
}

/// Largest x that the velocity limits allow.
double velocity_cap(const PathSample& s, const LimitSet& limits) {
    double inverse = 0;
    for (int a = 0; a < limits.count; ++a) inverse = std::max(inverse, std::abs(s.q1[a]) / limits.axes[a].velocity);
    return 1 / (inverse * inverse);
}

}  // namespace

LivePlanner::State::State(const path::AxisPath& path, const FeedOptions& options, double period_s)
    : path_(path),
      limits_(limits_of(path, options, kept_back)),
      calm_(options.calm),
      period_s_(period_s),
      base_(std::max(options.window, smallest_window)),
      window_(base_),
      grid_(path, limits_) {}

/// The one place where an override meets the samples: it scales the programmed feed, on a rapid the velocity limits.
void LivePlanner::State::apply_override(double factor, PathSample& sample) const {
    const double cap =
        path_.tool_path().rapid ? velocity_cap(sample, limits_) : kept_back * kept_back * sample.feed_cap;
    sample.feed_cap = factor * factor * cap;
}

Result<Interval> LivePlanner::State::sample(const Cell& cell, double factor) const {
    auto out = sample_cell(path_, cell);
    if (!out) return out;
    for (PathSample& at : out->samples) apply_override(factor, at);
    for (NearRest& near : out->near_rest) apply_override(factor, near.sample);
    return out;
}

/// The way ahead, as far as a stop takes by the limits of this place, or so much farther that it is enough.
Result<LivePlanner::State::Look> LivePlanner::State::look_ahead(const Branch& branch, double factor) const {
    Look out;
    const auto first = survey(branch, factor, same_place_mm);
    if (!first) return fail(first.error());
    double acceleration = std::numeric_limits<double>::max(), jerk = acceleration;
    for (int a = 0; a < limits_.count; ++a) {
        const double q = std::abs(first->front().samples.front().q1[a]);
        if (q == 0) continue;
        acceleration = std::min(acceleration, limits_.axes[a].acceleration / q);
        jerk = std::min(jerk, limits_.axes[a].jerk / q);
    }
    out.path_jerk_mm_s3 = jerk;
    out.stop_mm = stopping_distance_mm(std::sqrt(branch.start.x), branch.start.d / 2, acceleration, jerk);
    out.reach_mm = look_margin * out.stop_mm;
    for (int k = 0; k < most_looks; ++k, out.reach_mm *= 2) {
        auto intervals = survey(branch, factor, out.reach_mm);
        if (!intervals) return fail(intervals.error());
        out.intervals = std::move(*intervals);
        out.steep = shortest_stop(out.intervals, limits_, branch.start, Braking::hardest);
        if (out.steep || grid_.distance_mm(branch.place) + out.reach_mm >= end_mm()) break;
    }
    return out;
}

/// Samples the next `reach_mm` of the plan in hand.
Result<std::vector<Interval>> LivePlanner::State::survey(const Branch& branch, double factor, double reach_mm) const {
    const double here = grid_.distance_mm(branch.place), reach = std::min(reach_mm, end_mm() - here);
    std::vector<Interval> out;
    for (const Cell& cell : grid_.even_cells(branch.place, grid_.place_at(here + reach), reach / look_cells)) {
        auto sampled = sample(cell, factor);
        if (!sampled) return fail(sampled.error());
        out.push_back(std::move(*sampled));
    }
    return out;
}

/// A stop that does not lead to a dead end: braking with care, or following the plan in hand for a while.
Result<std::optional<Descent>> LivePlanner::State::first_stop(const Branch& branch, const Look& look) const {
    auto stop = shortest_stop(look.intervals, limits_, branch.start, Braking::careful);
    if (stop && stop->worst <= dead_end) return stop;
    const double here = grid_.distance_mm(branch.place);
    double reach = look.reach_mm;
    for (int k = 0; k < most_looks; ++k, reach *= 2) {
        const auto intervals = survey(branch, 1, reach);
        if (!intervals) return fail(intervals.error());
        if (auto later = later_stop(*intervals, branch)) return later;
        if (here + reach >= end_mm()) break;
    }
    return std::nullopt;
}

std::optional<Descent> LivePlanner::State::later_stop(std::span<const Interval> intervals, const Branch& branch) const {
    const double here = grid_.distance_mm(branch.place);
    const std::size_t stride = std::max<std::size_t>(1, intervals.size() / most_departures);
    Descent followed;
    double way = 0;
    for (std::size_t k = 0; k < intervals.size(); way += intervals[k].length_mm, ++k) {
        const MovingStart start = state_in_hand(here + way);
        if (!(start.x > 0)) break;
        if (k % stride == 0) {
            auto stop = shortest_stop(intervals.subspan(k), limits_, start, Braking::hardest);
            if (stop && stop->worst <= dead_end) {
                for (double& at : stop->way_mm) at += way;
                stop->length_mm += way;
                stop->way_mm.insert(stop->way_mm.begin(), followed.way_mm.begin(), followed.way_mm.end());
                stop->x.insert(stop->x.begin(), followed.x.begin(), followed.x.end());
                return stop;
            }
        }
        followed.way_mm.push_back(way);
        followed.x.push_back(start.x);
    }
    return std::nullopt;
}

}  // namespace trunnion::feed
