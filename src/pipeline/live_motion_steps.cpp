#include "detail/live_motion_steps.hpp"

#include <limits>
#include <utility>
#include <variant>

namespace trunnion::pipeline {

PlanOptions live_options(const PlanOptions& options) {
    PlanOptions out = options;
    if (smoothing::follows_exactly(out.smoothing)) out.smoothing.rounding = smoothing::Rounding::none;
    out.feed.period_s = options.period_s;
    return out;
}

Result<std::optional<LiveStep>> LiveStepSource::next() {
    for (;;) {
        auto element = stretches_.next();
        if (!element) return fail(element.error());
        if (!*element) {
            if (events_.empty()) return std::nullopt;
            LiveStep last;
            last.events = std::exchange(events_, {});
            return last;
        }
        if (auto* run = std::get_if<RunBegin>(&(*element)->content)) {
            run_ = std::move(*run);
            next_event_ = 0;
        } else if (auto* begin = std::get_if<StretchBegin>(&(*element)->content)) {
            auto step = step_of(*begin);
            if (!step) return fail(step.error());
            return std::move(*step);
        } else {
            take_events_before(std::numeric_limits<std::size_t>::max());
        }
    }
}

/// Events up to a block, that block's own included, happen at the standstill before it.
void LiveStepSource::take_events_before(std::size_t block) {
    for (; next_event_ < run_.events.size() && run_.events[next_event_].block <= block; ++next_event_)
        events_.push_back(run_.program->events[run_.events[next_event_].event]);
}

Result<LiveStep> LiveStepSource::step_of(const StretchBegin& begin) {
    take_events_before(begin.first_block);
    LiveStep out;
    out.events = std::exchange(events_, {});
    out.stretch = begin.stretch;
    out.program = run_.program;
    const auto& blocks = begin.stretch->tool_path.blocks;
    for (; next_event_ < run_.events.size() && run_.events[next_event_].block <= blocks.back().run_block; ++next_event_)
        out.passed.push_back({run_.events[next_event_].block, run_.program->events[run_.events[next_event_].event]});
    auto planner =
        feed::LivePlanner::make(*begin.stretch->axis_path, options_.feed, options_.period_s, longest_plan_s_);
    if (!planner) return fail(located(planner.error(), *run_.program, blocks.front().line));
    out.planner.emplace(std::move(*planner));
    return out;
}

std::vector<Diagnostic> LiveStepSource::diagnostics() const {
    std::vector<Diagnostic> out = parts_.diagnostics();
    const auto met = stretches_.diagnostics();
    out.insert(out.end(), met.begin(), met.end());
    return out;
}

LiveStepsAhead::~LiveStepsAhead() {
    queue_.close();
    thread_.join();
}

void LiveStepsAhead::work() noexcept {
    try {
        for (bool last = false; !last;) {
            Batch batch = make_batch();
            last = batch.last;
            if (!queue_.push(std::move(batch))) break;
        }
    } catch (...) {
        thrown_ = std::current_exception();
        threw_ = true;
    }
    queue_.close();
}

/// A few steps at once where they are short: a hand-over costs more than a short stretch.
LiveStepsAhead::Batch LiveStepsAhead::make_batch() {
    Batch out;
    for (std::size_t blocks = 0; out.steps.size() < most_steps && blocks < most_blocks;) {
        auto step = source_.next();
        out.last = !step || !*step;
        if (!step) out.error = step.error();
        if (out.last) break;
        if ((*step)->stretch) blocks += (*step)->stretch->tool_path.blocks.size();
        out.steps.push_back(std::move(**step));
    }
    return out;
}

Result<LiveStepsAhead::Next> LiveStepsAhead::take(LiveStep& step, bool wait) {
    while (next_ == batch_.steps.size()) {
        if (batch_.error) return fail(*batch_.error);
        if (batch_.last) return Next::none;
        auto batch = wait ? queue_.pop() : queue_.try_pop();
        if (!batch && threw_) std::rethrow_exception(thrown_);
        if (!batch) return Next::not_yet;
        batch_ = std::move(*batch);
        next_ = 0;
    }
    step = std::move(batch_.steps[next_++]);
    return Next::step;
}

}  // namespace trunnion::pipeline
