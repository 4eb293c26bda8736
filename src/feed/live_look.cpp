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

/// The factor of a programmed tip speed that a pace comes to.
double LivePlanner::State::factor_of(const Pace& pace, std::size_t block) const {
    const auto& blocks = path_.tool_path().blocks;
    if (blocks.empty() || blocks[block].feed.rule != path::FeedRule::tip_speed) return pace.factor;
    return std::min(pace.factor, pace.largest_mm_s / blocks[block].feed.value);
}

/// The largest rate of the tip's way at the ends and in the middle of a cell.
double LivePlanner::State::fastest_tip(const Cell& cell) const {
    double out = 0;
    path::AxisSample at;
    for (const double part : {0.0, 0.5, 1.0}) {
        path_.evaluate({cell.begin.piece, cell.begin.offset_mm + part * cell.length_mm}, at);
        out = std::max(out, at.feed_rate);
    }
    return out;
}

/// The one place where a pace meets the samples: its factor scales the programmed feed, on a rapid the velocity limits;
/// a chord error is not scaled. The largest speed of the tip is a lower feed, or where no speed of the tip is
/// programmed a bound that is constant on the interval; moves that only turn have none.
void LivePlanner::State::apply(const Pace& pace, const Cell& cell, Interval& interval) const {
    const path::ToolPath& tool = path_.tool_path();
    const auto rule = tool.blocks.empty() ? path::FeedRule::none : tool.blocks[cell.block].feed.rule;
    const bool lowers_feed = rule == path::FeedRule::tip_speed && !tool.rapid && !interval.chord;
    const bool bounds = !lowers_feed && rule != path::FeedRule::rotary_rate && std::isfinite(pace.largest_mm_s);
    const double factor = lowers_feed ? factor_of(pace, cell.block) : pace.factor;
    double rate = bounds ? fastest_tip(cell) / pace.largest_mm_s : 0;
    if (tool.rapid && factor < 1) rate = std::max(rate, fastest_rate(interval, limits_) / factor);
    const auto each = [&interval](const auto& what) {
        for (PathSample& s : interval.samples) what(s);
        for (ArcSample& at : interval.arc) what(at.sample);
    };
    if (!interval.chord || factor < 1)
        each([factor](PathSample& s) {
            for (double* q : {&s.q1[programmed_feed], &s.q2[programmed_feed], &s.q3[programmed_feed]}) *q /= factor;
        });
    bool counts = false;
    const double bound = rate;
    each([&](const PathSample& s) {
        counts = counts || s.q1[programmed_feed] < bound;
        rate = std::max(rate, s.q1[programmed_feed]);
    });
    if (counts)
        each([rate](PathSample& s) {
            s.q1[programmed_feed] = rate;
            s.q2[programmed_feed] = s.q3[programmed_feed] = 0;
        });
}

Result<Interval> LivePlanner::State::sample(const Cell& cell, const Pace& pace) const {
    auto out = sample_cell(sampler_, cell);
    if (out) apply(pace, cell, *out);
    return out;
}

/// The way ahead, as far as a stop takes by the limits of this place, or so much farther that it is enough.
Result<LivePlanner::State::Look> LivePlanner::State::look_ahead(const Branch& branch, const Pace& pace) const {
    Look out;
    const auto first = survey(branch, pace, same_place_mm);
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
        auto intervals = survey(branch, pace, out.reach_mm);
        if (!intervals) return fail(intervals.error());
        out.intervals = std::move(*intervals);
        out.steep = shortest_stop(out.intervals, limits_, branch.start, Braking::hardest);
        if (out.steep || grid_.distance_mm(branch.place) + out.reach_mm >= end_mm()) break;
    }
    return out;
}

/// Samples the next `reach_mm` of the plan in hand.
Result<std::vector<Interval>> LivePlanner::State::survey(const Branch& branch, const Pace& pace,
                                                         double reach_mm) const {
    const double here = grid_.distance_mm(branch.place), reach = std::min(reach_mm, end_mm() - here);
    std::vector<Interval> out;
    for (const Cell& cell : grid_.even_cells(branch.place, grid_.place_at(here + reach), reach / look_cells)) {
        auto sampled = sample(cell, pace);
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
        const auto intervals = survey(branch, {}, reach);
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
