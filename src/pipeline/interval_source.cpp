#include "detail/interval_source.hpp"

#include "detail/stopwatch.hpp"

namespace trunnion::pipeline {

namespace {

constexpr std::size_t batch_size = 64;

/// Where an interval ends, as a share of its stretch.
double share_behind(const feed::Interval& interval, const path::ToolPath& tool_path) {
    return (tool_path.pieces[interval.begin.piece].begin_mm + interval.begin.offset_mm + interval.length_mm) /
           tool_path.length_mm();
}

}  // namespace

NextElement IntervalSource::next() {
    if (intervals_) return next_batch();
    auto element = stretches_.next();
    if (!element || !*element) return element;
    const auto* begin = std::get_if<StretchBegin>(&(*element)->content);
    if (!begin) return element;
    const Stopwatch watch(grid_s_);
    stretch_ = *begin;
    share_at_begin_ = (*element)->share;
    auto intervals = feed::IntervalStream::make(*stretch_.stretch->axis_path, options_);
    if (!intervals) return failed(intervals.error());
    intervals_.emplace(std::move(*intervals));
    return element;
}

NextElement IntervalSource::next_batch() {
    const Stopwatch watch(grid_s_);
    IntervalBatch batch;
    batch.intervals.reserve(batch_size);
    feed::Interval interval;
    double share = share_at_begin_;
    while (!batch.last && batch.intervals.size() < batch_size) {
        const auto more = intervals_->next(interval);
        if (!more) return failed(more.error());
        batch.last = !*more;
        if (*more) batch.intervals.push_back(std::move(interval));
    }
    if (batch.last) {
        intervals_.reset();
        share = stretch_.share_at_end;
    } else {
        share += (stretch_.share_at_end - share) * share_behind(batch.intervals.back(), stretch_.stretch->tool_path);
    }
    return Element{std::move(batch), share};
}

NextElement IntervalSource::failed(const Diagnostic& error) const {
    return fail(located(error, stretches_.program(), stretch_.stretch->tool_path.blocks.front().line));
}

}  // namespace trunnion::pipeline
