#include <algorithm>
#include <cmath>

#include "detail/live_state.hpp"

namespace trunnion::feed {
namespace {

constexpr std::size_t smallest_window = 16;
constexpr double look_cells = 64, look_margin = 1.3;
constexpr int most_looks = 5;
constexpr std::size_t most_departures = 32;

LimitSet kept_back_from(LimitSet limits, double share) {
    for (machine::AxisLimits& limit : limits.of) {
        limit.velocity *= share;
        limit.acceleration *= share;
    }
    return limits;
}

/// The largest of the velocities' rates q′/V at the samples.
double fastest_rate(const Interval& interval, const LimitSet& limits) {
    double out = 0;
    for (const PathSample& s : interval.samples)
        for (int c = 0; c < programmed_feed; ++c) out = std::max(out, std::abs(s.q1[c]) / limits.of[c].velocity);
    return out;
}

}  // namespace

LivePlanner::State::State(const path::AxisPath& path, const FeedOptions& options, double period_s,
                          double longest_plan_s)
    : path_(path),
      sampler_(path, options),
      limits_(kept_back_from(sampler_.limits(), kept_back)),
      calm_(options.calm),
      period_s_(period_s),
      longest_plan_s_(longest_plan_s),
      base_(std::max(options.window, smallest_window)),
      window_(base_),
      grid_(sampler_) {}

/// The one place where an override meets the samples: it scales the programmed feed, on a rapid the velocity limits. A
/// chord error is not scaled.
void LivePlanner::State::apply_override(double factor, Interval& interval) const {
    const auto scale = [factor](PathSample& s) {
        for (double* rate : {&s.q1[programmed_feed], &s.q2[programmed_feed], &s.q3[programmed_feed]}) *rate /= factor;
    };
    const auto hold_to = [](double rate, PathSample& s) {
        s.q1[programmed_feed] = rate;
        s.q2[programmed_feed] = s.q3[programmed_feed] = 0;
    };
    const double rapid_rate = path_.tool_path().rapid && factor < 1 ? fastest_rate(interval, limits_) / factor : 0;
    const auto apply = [&](PathSample& s) {
        if (rapid_rate > 0) return hold_to(rapid_rate, s);
        if (!interval.chord || factor < 1) scale(s);
    };
    for (PathSample& s : interval.samples) apply(s);
    for (ArcSample& at : interval.arc) apply(at.sample);
}

Result<Interval> LivePlanner::State::sample(const Cell& cell, double factor) const {
    auto out = sample_cell(sampler_, cell);
    if (out) apply_override(factor, *out);
    return out;
}

/// The way ahead, as far as a stop takes by the limits of this place, or so much farther that it is enough.
Result<LivePlanner::State::Look> LivePlanner::State::look_ahead(const Branch& branch, double factor) const {
    Look out;
    const auto first = survey(branch, factor, same_place_mm);
    if (!first) return fail(first.error());
    double acceleration = std::numeric_limits<double>::max(), jerk = acceleration;
    for (int c = 0; c < coordinates; ++c) {
        const double q = std::abs(first->front().samples.front().q1[c]);
        if (q == 0) continue;
        acceleration = std::min(acceleration, limits_.of[c].acceleration / q);
        jerk = std::min(jerk, limits_.of[c].jerk / q);
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
