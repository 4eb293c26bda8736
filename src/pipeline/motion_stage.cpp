#include "detail/motion_stage.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "detail/path_samples.hpp"
#include "detail/stopwatch.hpp"

namespace trunnion::pipeline {

Result<void> MotionStage::take(const Element& element) {
    if (const auto* run = std::get_if<RunBegin>(&element.content)) begin(*run);
    if (const auto* stretch = std::get_if<StretchBegin>(&element.content)) begin(*stretch);
    if (const auto* batch = std::get_if<IntervalBatch>(&element.content)) return plan(*batch);
    if (std::holds_alternative<RunEnd>(element.content)) events_before_block(std::numeric_limits<std::size_t>::max());
    return {};
}

void MotionStage::begin(const RunBegin& run) {
    run_ = run;
    next_event_ = 0;
    account_.add_blocks(run.blocks);
}

void MotionStage::begin(const StretchBegin& stretch) {
    stretch_ = stretch;
    events_before_block(stretch.first_block);
    planner_.emplace(path(), options_.feed);
}

Result<void> MotionStage::plan(const IntervalBatch& batch) {
    std::optional<Result<feed::StretchPlan>> planned;
    {
        const Stopwatch watch(plan_s_);
        for (const feed::Interval& interval : batch.intervals) planner_->push(interval);
        if (batch.last) planned.emplace(planner_->finish());
    }
    if (!planned) return {};
    if (!*planned) return fail(located(planned->error(), *run_.program, path().tool_path().blocks.front().line));
    perform(**planned);
    return {};
}

/// Samples a planned stretch and adds it to the summary.
void MotionStage::perform(const feed::StretchPlan& plan) {
    const Stopwatch watch(sample_s_);
    const path::ToolPath& tool_path = path().tool_path();
    const StretchTable table = StretchTable::of(path(), plan.profile, s_mm_);
    if (!moved_) at_ = path().begin_position();
    moved_ = true;
    hold_until(time_s_);
    events_of_stretch(plan.profile, table);
    sample(plan, table);
    if (options_.path_samples)
        hand_out_path_samples(path(), plan.profile, table, p_mm_, options_.smoothing.flank_height_mm, observer_);
    account_.add(path(), plan, table, run_.program->source);
    at_ = path().end_position();
    line_ = tool_path.blocks.back().line;
    time_s_ += plan.profile.duration_s();
    s_mm_ = table.s_mm.back();
    p_mm_ += tool_path.length_mm();
}

/// Events that fall before a block while the axes stand; dwells pass time.
void MotionStage::events_before_block(std::size_t block) {
    for (; next_event_ < run_.events.size() && run_.events[next_event_].block <= block; ++next_event_) {
        const program::Event& event = run_.program->events[run_.events[next_event_].event];
        observer_.event({time_s_, s_mm_, &event});
        if (event.dwell_s <= 0) continue;
        account_.add_dwell(event.dwell_s);
        time_s_ += event.dwell_s;
    }
}

/// Events inside a stretch: those that do not stop the motion.
void MotionStage::events_of_stretch(const motion::FeedProfile& profile, const StretchTable& table) {
    const auto& blocks = path().tool_path().blocks;
    for (; next_event_ < run_.events.size(); ++next_event_) {
        const auto block =
            std::lower_bound(blocks.begin(), blocks.end(), run_.events[next_event_].block,
                             [](const path::BlockSpan& span, std::size_t wanted) { return span.run_block < wanted; });
        if (block == blocks.end()) return;
        const double p = block->begin_mm;
        observer_.event({time_s_ + table.time_at(profile, p), table.way_at(p),
                         &run_.program->events[run_.events[next_event_].event]});
    }
}

void MotionStage::emit(const motion::Setpoint& row) {
    observer_.setpoint(row);
    ++row_;
}

/// Rows of standstill up to a time.
void MotionStage::hold_until(double time_s) {
    for (double t = static_cast<double>(row_) * options_.period_s; t < time_s;
         t = static_cast<double>(row_) * options_.period_s)
        emit({t, at_, line_, s_mm_, 0});
}

/// What holds the speed down at an instant of the stretch.
SetpointLimit MotionStage::limit_at(const feed::StretchPlan& plan, const interpolation::Instant& now) const {
    const path::ToolPath& tool_path = path().tool_path();
    path::AxisSample at;
    path().evaluate(now.place, at);
    const double tip_rate = std::hypot(at.tip[0].d1(), at.tip[1].d1(), at.tip[2].d1());
    return {.programmed_feed_mm_s = tip_rate * feed::feed_speed_cap(tool_path.blocks[now.block], at),
            .cause = plan.causes[now.path_state.profile_piece],
            .rapid = tool_path.rapid};
}

void MotionStage::sample(const feed::StretchPlan& plan, const StretchTable& table) {
    const double end_s = time_s_ + plan.profile.duration_s();
    interpolation::Interpolator interpolator(path(), plan.profile);
    for (double t = static_cast<double>(row_) * options_.period_s; t < end_s;
         t = static_cast<double>(row_) * options_.period_s) {
        const interpolation::Instant now = interpolator.at(t - time_s_);
        const std::size_t piece = now.path_state.profile_piece;
        const double s = table.s_mm[piece] + (now.tip_in_workpiece_mm - table.tip_mm[piece]).norm();
        if (options_.setpoint_limits) observer_.setpoint_limit(limit_at(plan, now));
        emit({t, now.position, path().tool_path().blocks[now.block].line, s, now.tip_speed_mm_s});
    }
}

Summary MotionStage::finish() {
    if (moved_) {
        hold_until(time_s_);
        emit({static_cast<double>(row_) * options_.period_s, at_, line_, s_mm_, 0});
    }
    Summary out = account_.take();
    out.cycle_time_s = time_s_;
    out.path_length_mm = s_mm_;
    out.setpoints = row_;
    out.work.plan_s = plan_s_;
    out.work.sample_s = sample_s_;
    return out;
}

}  // namespace trunnion::pipeline
