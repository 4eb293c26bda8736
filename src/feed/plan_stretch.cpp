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

LimitSet limits_of(const path::AxisPath& path, const FeedOptions& options) {
    LimitSet out;
    out.count = path.axis_count();
    for (int a = 0; a < out.count; ++a) {
        const machine::Axis& axis = path.machine().axes[a];
        out.axes[a] = path.tool_path().rapid ? axis.rapid : axis.feed;
        out.axes[a].velocity *= options.factors[a].velocity;
        out.axes[a].acceleration *= options.factors[a].acceleration;
        out.axes[a].jerk *= options.factors[a].jerk * (1 - options.jerk_margin);
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
    State(const path::AxisPath& path, const LimitSet& limits) : path_(path), cells_(make_grid(path, limits)) {}

    Result<bool> next(Interval& interval) {
        if (next_ == cells_.size()) return false;
        auto sampled = sample_cell(path_, cells_[next_]);
        if (!sampled) return fail(sampled.error());
        interval = std::move(*sampled);
        ++next_;
        return true;
    }

  private:
    const path::AxisPath& path_;
    std::vector<Cell> cells_;
    std::size_t next_ = 0;
};

IntervalStream::IntervalStream(std::unique_ptr<State> state) : state_(std::move(state)) {}
IntervalStream::~IntervalStream() = default;
IntervalStream::IntervalStream(IntervalStream&&) noexcept = default;
IntervalStream& IntervalStream::operator=(IntervalStream&&) noexcept = default;

Result<IntervalStream> IntervalStream::make(const path::AxisPath& path, const FeedOptions& options) {
    if (auto checked = check(path, options); !checked) return fail(checked.error());
    return IntervalStream(std::make_unique<State>(path, limits_of(path, options)));
}
Result<bool> IntervalStream::next(Interval& interval) {
    return state_->next(interval);
}

class StretchPlanner::State {
  public:
    State(const path::AxisPath& path, const FeedOptions& options)
        : limits_(limits_of(path, options)),
          jerk_share_(1 - options.jerk_margin),
          planner_(limits_, {options.calm, options.window},
                   [this](const Interval& interval, const motion::ProfilePiece& piece) { take(interval, piece); }) {}

    void push(const Interval& interval) { planner_.push(interval); }
    Result<StretchPlan> finish();

  private:
    void take(const Interval& interval, const motion::ProfilePiece& piece);

    LimitSet limits_;
    double jerk_share_;
    StretchPlan out_;
    FeedPlanner planner_;
};

void StretchPlanner::State::take(const Interval& interval, const motion::ProfilePiece& piece) {
    const Peaks peaks = peaks_of(interval, piece, limits_);
    out_.profile.pieces.push_back(piece);
    out_.causes.push_back(cause_of(peaks));
    for (int a = 0; a < limits_.count; ++a) {
        AxisPeaks& axis = out_.peaks[a];
        axis.velocity = std::max(axis.velocity, peaks.velocity[a]);
        axis.acceleration = std::max(axis.acceleration, peaks.acceleration[a]);
        axis.jerk = std::max(axis.jerk, peaks.jerk[a] * jerk_share_);
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
