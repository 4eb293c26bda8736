#include "detail/replanning.hpp"

#include <atomic>
#include <future>

namespace trunnion::pipeline {

namespace {

using GoOn = std::function<bool(double)>;

constexpr std::size_t intervals_between_calls = 64;

Diagnostic cancelled() {
    return {.code = "PIPE0002", .text = "cancelled"};
}

/// As feed::plan_stretch, but it can be cancelled; `go_on` gets the share of the stretch. Its time in seconds.
Result<double> time_of(const path::AxisPath& path, const feed::FeedOptions& options, const GoOn& go_on) {
    auto intervals = feed::IntervalStream::make(path, options);
    if (!intervals) return fail(intervals.error());
    feed::StretchPlanner planner(path, options);
    feed::Interval interval;
    for (std::size_t count = 1;; ++count) {
        const auto more = intervals->next(interval);
        if (!more) return fail(more.error());
        if (!*more) break;
        planner.push(interval);
        const double p = path.tool_path().pieces[interval.begin.piece].begin_mm + interval.begin.offset_mm;
        if (count % intervals_between_calls == 0 && !go_on(p / path.length_mm())) return fail(cancelled());
    }
    const auto plan = planner.finish();
    if (!plan) return fail(plan.error());
    return plan->profile.duration_s();
}

Result<double> time_of(const Stretch& stretch, const machine::Machine& machine, const LimitChange& change,
                       const GoOn& go_on) {
    if (change.feed_factor == 1) return time_of(*stretch.axis_path, change.feed, go_on);
    path::ToolPath faster = stretch.tool_path;
    for (path::BlockSpan& block : faster.blocks) {
        if (block.feed.rule == path::FeedRule::block_time)
            block.feed.value /= change.feed_factor;
        else
            block.feed.value *= change.feed_factor;
    }
    const auto copy = Stretch::make(std::move(faster), machine, stretch.near, stretch.part);
    if (!copy) return fail(copy.error());
    return time_of(*(*copy)->axis_path, change.feed, go_on);
}

class Replanning {
  public:
    Replanning(const StretchSource& stretches, const machine::Machine& machine, std::span<const LimitChange> changes,
               const GoOn& go_on)
        : stretches_(stretches), machine_(machine), changes_(changes), go_on_(go_on), times_s_(changes.size(), 0.0) {}

    /// Adds a stretch to all times; false: cancelled.
    bool add(const StretchBegin& stretch, double share_at_begin, std::size_t threads) {
        const double span = stretch.share_at_end - share_at_begin, count = static_cast<double>(changes_.size());
        std::size_t at = 0;
        const GoOn told = [&](double part) {
            if (!go_on_(share_at_begin + span * (static_cast<double>(at) + part) / count)) is_cancelled_ = true;
            return !is_cancelled_;
        };
        const GoOn untold = [this](double) { return !is_cancelled_; };
        std::future<void> other;
        if (threads == 2)
            other = std::async(std::launch::async, [&] {
                for (std::size_t k = 1; k < changes_.size() && !is_cancelled_; k += 2) add(stretch, k, untold);
            });
        for (at = 0; at < changes_.size() && told(0); at += threads) add(stretch, at, told);
        if (other.valid()) other.get();
        return !is_cancelled_;
    }

    std::vector<Result<double>> take() { return std::move(times_s_); }

  private:
    void add(const StretchBegin& stretch, std::size_t k, const GoOn& go_on) {
        if (!times_s_[k]) return;
        const auto time_s = time_of(*stretch.stretch, machine_, changes_[k], go_on);
        if (time_s)
            *times_s_[k] += *time_s;
        else
            times_s_[k] =
                fail(located(time_s.error(), stretches_.program(), stretch.stretch->tool_path.blocks.front().line));
    }

    const StretchSource& stretches_;
    const machine::Machine& machine_;
    std::span<const LimitChange> changes_;
    const GoOn& go_on_;
    std::vector<Result<double>> times_s_;  // each is touched by one thread alone
    std::atomic<bool> is_cancelled_ = false;
};

}  // namespace

Result<std::vector<Result<double>>> motion_times(StretchSource& stretches, const machine::Machine& machine,
                                                 std::span<const LimitChange> changes, int threads, const GoOn& go_on) {
    Replanning replanning(stretches, machine, changes, go_on);
    for (;;) {
        const auto element = stretches.next();
        if (!element) return fail(element.error());
        if (!*element) break;
        const auto* begin = std::get_if<StretchBegin>(&(*element)->content);
        if (!begin) continue;
        if (!replanning.add(*begin, (*element)->share, static_cast<std::size_t>(threads))) return fail(cancelled());
    }
    if (!go_on(1)) return fail(cancelled());
    return replanning.take();
}

}  // namespace trunnion::pipeline
