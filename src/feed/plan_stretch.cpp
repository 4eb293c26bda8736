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
constexpr double shortest_mm = 1e-3;

Cause cause_of(const Peaks& peaks, bool chord) {
    Cause cause;
    double most = limiting_from;
    const auto consider = [&](double ratio, Cause candidate) {
        if (ratio <= most) return;
        most = ratio;
        cause = candidate;
    };
    const Cause::Kind feed = chord ? Cause::Kind::chord : Cause::Kind::feed;
    consider(peaks.of(programmed_feed).velocity, {feed, -1});
    for (int c = 0; c < programmed_feed; ++c) {
        const Peaks::OfCoordinate peak = peaks.of(c);
        consider(peak.velocity, {Cause::Kind::velocity, c});
        consider(peak.acceleration, {Cause::Kind::acceleration, c});
        consider(peak.jerk, {Cause::Kind::jerk, c});
    }
    return cause;
}

Diagnostic problem(std::string code, std::string text) {
    Diagnostic out;
    out.code = std::move(code);
    out.text = std::move(text);
    return out;
}

/// ∫ (d³q/dt³)² dt over a piece, by Simpson's rule in p.
double jerk_square(const Interval& interval, const motion::ProfilePiece& piece, int axis) {
    constexpr std::array<double, samples_per_interval> weight{1.0 / 6, 4.0 / 6, 1.0 / 6};
    double sum = 0;
    for (int i = 0; i < samples_per_interval; ++i) {
        const motion::PathState s = motion::state_at(piece, piece.length_mm * i / (samples_per_interval - 1));
        const PathSample& q = interval.samples[i];
        const double v = s.speed_mm_s, a = s.acceleration_mm_s2;
        const double jerk = q.q3[axis] * v * v * v + 3 * q.q2[axis] * v * a + q.q1[axis] * s.jerk_mm_s3;
        if (piece.kind != motion::ProfilePiece::Kind::cubic)
            sum += weight[i] * jerk * jerk * piece.duration_s;  // p is a poor measure of time at rest
        else
            sum += weight[i] * jerk * jerk * piece.length_mm / v;
    }
    return sum;
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
    const auto positive = [&](const char* what, double value) -> Result<void> {
        if (value > 0) return {};
        return refuse(fmt::format("{} must be more than 0", what), value);
    };
    for (const auto& [what, value] : {std::pair{"the chord error", options.chord_error_mm},
                                      {"the period", options.period_s},
                                      {"the tip's acceleration", options.tip_acceleration_mm_s2},
                                      {"the tip's jerk", options.tip_jerk_mm_s3},
                                      {"the tool's angular speed", options.turn_velocity_rad_s}})
        if (auto good = positive(what, value); !good) return good;
    if (auto good = check_limits(limits_of(path, options), path.axis_count()); !good) return good;
    if (!(path.length_mm() >= shortest_mm)) {
        Diagnostic out = problem("FEED0005", "a stretch this short cannot be planned");
        out.value = fmt::format("{} mm", path.length_mm());
        out.limit = fmt::format("{} mm", shortest_mm);
        return fail(out);
    }
    for (const path::BlockSpan& block : path.tool_path().blocks)
        if (block.feed.rule != path::FeedRule::none && !(block.feed.value > 0)) {
            Diagnostic out = problem("FEED0008", "the programmed feed must be more than 0");
            out.place.line = block.line;
            return fail(out);
        }
    return {};
}

}  // namespace

std::string name_of(const Cause& cause, const machine::Machine& machine) {
    const auto of_axis = [&](const char* what) {
        if (cause.axis == tip_way) return fmt::format("tip {}", what);
        if (cause.axis == tool_turn) return fmt::format("tool {}", what);
        return fmt::format("{} {}", machine.axes[cause.axis].letter, what);
    };
    switch (cause.kind) {
        case Cause::Kind::none:
            return "none";
        case Cause::Kind::feed:
            return "feed";
        case Cause::Kind::chord:
            return "chord";
        case Cause::Kind::velocity:
            return of_axis("velocity");
        case Cause::Kind::acceleration:
            return of_axis("acceleration");
        case Cause::Kind::jerk:
            break;
    }
    return of_axis("jerk");
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

class IntervalStream::State {
  public:
    State(const path::AxisPath& path, const FeedOptions& options)
        : sampler_(path, options), grid_(sampler_), cells_(sampler_) {}

    Result<bool> next(Interval& interval) {
        while (ready_.empty()) {
            const std::optional<Cell> cell = grid_.next();
            if (!cell) return false;
            if (auto sampled = cells_.sample(*cell, ready_); !sampled) return fail(sampled.error());
        }
        interval = std::move(ready_.front().interval);
        ready_.pop_front();
        return true;
    }

  private:
    Sampler sampler_;
    Grid grid_;
    CellSampler cells_;
    std::deque<SampledCell> ready_;
};

IntervalStream::IntervalStream(std::unique_ptr<State> state) : state_(std::move(state)) {}
IntervalStream::~IntervalStream() = default;
IntervalStream::IntervalStream(IntervalStream&&) noexcept = default;
IntervalStream& IntervalStream::operator=(IntervalStream&&) noexcept = default;

Result<IntervalStream> IntervalStream::make(const path::AxisPath& path, const FeedOptions& options) {
    if (auto checked = check(path, options); !checked) return fail(checked.error());
    return IntervalStream(std::make_unique<State>(path, options));
}
Result<bool> IntervalStream::next(Interval& interval) {
    return state_->next(interval);
}

class StretchPlanner::State {
  public:
    State(const path::AxisPath& path, const FeedOptions& options)
        : limits_(limits_of(path, options)),
          check_(limits_),
          axes_(path.axis_count()),
          jerk_share_(1 - options.jerk_margin),
          planner_(limits_, {.calm = options.calm, .window = options.window, .budget = options.budget},
                   [this](const Interval& interval, const motion::ProfilePiece& piece) { take(interval, piece); }) {}

    void push(const Interval& interval) { planner_.push(interval); }
    const motion::FeedProfile& planned() const noexcept { return out_.profile; }
    Result<StretchPlan> finish();

  private:
    void take(const Interval& interval, const motion::ProfilePiece& piece);
    Interest interest() const;

    LimitSet limits_;
    LoadCheck check_;
    int axes_;
    double jerk_share_;
    StretchPlan out_;
    FeedPlanner planner_;
};

/// Loads are looked at closely where they may be what limits, or be larger than any before.
Interest StretchPlanner::State::interest() const {
    Interest out = interest_from(limiting_from);
    for (int a = 0; a < axes_; ++a) {
        const AxisPeaks& peak = out_.peaks[a];
        out[a] = {std::min(out[a].velocity, peak.velocity), std::min(out[a].acceleration, peak.acceleration),
                  std::min(out[a].jerk, peak.jerk / jerk_share_)};
    }
    return out;
}

void StretchPlanner::State::take(const Interval& interval, const motion::ProfilePiece& piece) {
    const Peaks peaks = check_.peaks(interval, piece, interest());
    out_.profile.pieces.push_back(piece);
    out_.causes.push_back(cause_of(peaks, interval.chord));
    for (int a = 0; a < axes_; ++a) {
        const Peaks::OfCoordinate own = peaks.of(a);
        AxisPeaks& axis = out_.peaks[a];
        axis.velocity = std::max(axis.velocity, own.velocity);
        axis.acceleration = std::max(axis.acceleration, own.acceleration);
        axis.jerk = std::max(axis.jerk, own.jerk * jerk_share_);
        out_.jerk_square_s[a] += jerk_square(interval, piece, a) * std::pow(jerk_share_ / limits_.of[a].jerk, 2);
    }
}

Result<StretchPlan> StretchPlanner::State::finish() {
    if (auto done = planner_.finish(); !done) return fail(done.error());
    const PlannerCounts& counts = planner_.counts();
    out_.jerk_free_bound_s = counts.jerk_free_bound_s;
    out_.intervals = counts.intervals;
    out_.windows = counts.windows;
    out_.iterations = counts.iterations;
    out_.tightening_rounds = counts.tightening_rounds;
    out_.fallbacks = counts.fallbacks;
    std::copy_n(counts.worth.begin(), axes_, out_.worth.begin());
    out_.feed_worth_s = counts.worth[programmed_feed].velocity_s;
    return std::move(out_);
}

StretchPlanner::StretchPlanner(const path::AxisPath& path, const FeedOptions& options)
    : state_(std::make_unique<State>(path, options)) {}
StretchPlanner::~StretchPlanner() = default;
StretchPlanner::StretchPlanner(StretchPlanner&&) noexcept = default;
StretchPlanner& StretchPlanner::operator=(StretchPlanner&&) noexcept = default;

void StretchPlanner::push(const Interval& interval) {
    state_->push(interval);
}
const motion::FeedProfile& StretchPlanner::planned() const noexcept {
    return state_->planned();
}
Result<StretchPlan> StretchPlanner::finish() {
    return state_->finish();
}

Result<StretchPlan> plan_stretch(const path::AxisPath& path, const FeedOptions& options) {
    auto stream = IntervalStream::make(path, options);
    if (!stream) return fail(stream.error());
    StretchPlanner planner(path, options);
    Interval interval;
    for (;;) {
        const auto more = stream->next(interval);
        if (!more) return fail(more.error());
        if (!*more) return planner.finish();
        planner.push(interval);
    }
}

}  // namespace trunnion::feed
