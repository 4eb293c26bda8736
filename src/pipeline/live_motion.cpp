#include "trunnion/pipeline/live_motion.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "detail/live_motion_steps.hpp"

namespace trunnion::pipeline {

namespace {

using Next = LiveStepsAhead::Next;

constexpr double largest_feed_override = 2, largest_rapid_override = 1;
constexpr double dwell_at_once_s = 0.5;  // that the plan in hand stands ahead

Result<void> check_override(const char* name, double factor, double largest) {
    if (factor >= 0 && factor <= largest) return {};
    return fail({.code = "PIPE0141",
                 .text = fmt::format("{} override outside its range", name),
                 .value = fmt::format("{}", factor),
                 .limit = fmt::format("0…{}", largest)});
}

Result<void> check_options(const PlanOptions& options) {
    const auto positive = [](double x) { return std::isfinite(x) && x > 0; };
    if (positive(options.period_s) && positive(options.feed_override)) return {};
    return fail({.code = "PIPE0001", .text = "period and feed override must be more than 0"});
}

}  // namespace

/// Follows the steps one after another; at each standstill between two of them it looks at what is to be waited for.
class LiveMotion::State {
  public:
    State(program::ProgramParts& parts, const machine::Machine& machine, const machine::Setup& setup,
          const PlanOptions& options, double longest_plan_s)
        : period_s_(options.period_s), steps_(parts, machine, setup, options, longest_plan_s) {}

    Result<void> begin();
    const LiveRow& row() const { return row_; }

    void set_feed_override(double factor);
    void set_rapid_override(double factor);
    void hold();
    void resume();
    void set_single_block(bool on);
    void stop();

    Result<LiveMotionState> tick(bool may_plan);
    std::size_t plan() const { return plans_ + (step_.planner ? step_.planner->plans() : 0); }
    void rows_ahead(std::vector<LiveRow>& rows) const;
    void keep_plan(std::size_t lead);
    void take_back_plan(std::size_t lead);
    std::vector<Diagnostic> diagnostics() const { return ended_ ? steps_.diagnostics() : std::vector<Diagnostic>(); }

  private:
    Result<Next> take_step(bool wait);
    void pass_on_commands();
    void end_stretch();
    bool answer_events(LiveMotionState& out);
    bool dwell();
    Result<LiveMotionState> move(LiveMotionState out, bool may_plan);
    LiveRow row_of(const feed::LiveState& state) const;
    void pass_events(std::size_t block, LiveMotionState& out);

    double period_s_;
    LiveStepsAhead steps_;
    LiveStep step_;
    std::size_t next_event_ = 0;   // of the step's standstill
    std::size_t next_passed_ = 0;  // of the step's stretch
    bool ended_ = false;           // no step to come
    LiveRow row_;
    std::size_t plans_ = 0;                              // of stretches behind, and of dwells
    std::size_t dwell_rows_ = 0, dwell_rows_ahead_ = 0;  // left; of them in the plan in hand

    double feed_override_ = 1, rapid_override_ = 1;
    bool held_ = false, single_block_ = false, stopping_ = false;
    bool waits_for_resume_ = false;  // at an event, or behind a stretch in single block
    bool at_event_ = false;
};

Result<Next> LiveMotion::State::take_step(bool wait) {
    auto next = steps_.take(step_, wait);
    if (!next) ended_ = true;
    if (!next || *next == Next::not_yet) return next;
    ended_ = *next == Next::none;
    next_event_ = next_passed_ = 0;
    pass_on_commands();
    return next;
}

/// The first stretch is needed to know where the motion begins.
Result<void> LiveMotion::State::begin() {
    const auto next = take_step(true);
    if (!next) return fail(next.error());
    if (*next == Next::none || !step_.stretch)
        return fail({.code = "PIPE0140", .text = "nothing moves in this program"});
    row_ = {step_.stretch->axis_path->begin_position(), step_.stretch->tool_path.blocks.front().line};
    return {};
}

void LiveMotion::State::pass_on_commands() {
    if (!step_.planner) return;
    (void)step_.planner->set_feed_override(feed_override_);
    (void)step_.planner->set_rapid_override(rapid_override_);
    step_.planner->set_single_block(single_block_);
    if (held_ || stopping_) step_.planner->hold();
}

void LiveMotion::State::set_feed_override(double factor) {
    feed_override_ = factor;
    pass_on_commands();
}
void LiveMotion::State::set_rapid_override(double factor) {
    rapid_override_ = factor;
    pass_on_commands();
}
void LiveMotion::State::hold() {
    held_ = true;
    pass_on_commands();
}
void LiveMotion::State::resume() {
    held_ = waits_for_resume_ = at_event_ = false;
    if (step_.planner && !stopping_) step_.planner->resume();
}
void LiveMotion::State::set_single_block(bool on) {
    single_block_ = on;
    if (!on && !at_event_) waits_for_resume_ = false;
    pass_on_commands();
}
void LiveMotion::State::stop() {
    stopping_ = true;
    dwell_rows_ = dwell_rows_ahead_;
    pass_on_commands();
}

/// Events of the standstill that the step begins with; false: none is left that takes time.
bool LiveMotion::State::answer_events(LiveMotionState& out) {
    while (next_event_ < step_.events.size()) {
        const program::Event& event = step_.events[next_event_++];
        out.events.push_back(event);
        if (event.dwell_s > 0) {
            dwell_rows_ = static_cast<std::size_t>(std::ceil(event.dwell_s / period_s_));
            return true;
        }
        if (!event.stops_motion || !step_.stretch) continue;  // behind the last motion nothing is to be waited for
        waits_for_resume_ = at_event_ = true;
        return true;
    }
    return false;
}

/// A row of dwell, if there is one left.
bool LiveMotion::State::dwell() {
    if (dwell_rows_ahead_ == 0 && dwell_rows_ > 0 && !stopping_) {
        dwell_rows_ahead_ = std::min(dwell_rows_, static_cast<std::size_t>(std::ceil(dwell_at_once_s / period_s_)));
        ++plans_;
    }
    if (dwell_rows_ahead_ == 0) return false;
    --dwell_rows_ahead_;
    --dwell_rows_;
    return true;
}

Result<LiveMotionState> LiveMotion::State::tick(bool may_plan) {
    LiveMotionState out;
    out.row = row_;
    for (;;) {
        if (dwell()) {
            out.status = LiveMotionStatus::moving;
            return out;
        }
        const bool under_way = step_.planner && step_.planner->periods_left() > 0;
        if (stopping_ && !under_way) {
            out.status = LiveMotionStatus::stopped;
            return out;
        }
        if (waits_for_resume_) {
            out.status = at_event_ ? LiveMotionStatus::event : LiveMotionStatus::standing;
            return out;
        }
        if (answer_events(out)) continue;
        if (step_.planner) return move(std::move(out), may_plan);
        if (ended_) {
            out.status = LiveMotionStatus::finished;
            return out;
        }
        const auto next = take_step(false);
        if (!next) return fail(next.error());
        if (*next == Next::not_yet) {
            out.status = LiveMotionStatus::waiting;
            return out;
        }
        if (*next == Next::none) step_ = {};
    }
}

Result<LiveMotionState> LiveMotion::State::move(LiveMotionState out, bool may_plan) {
    const bool was_under_way = step_.planner->periods_left() > 0;
    const auto state = step_.planner->tick(may_plan);
    if (!state) {
        stopping_ = true;
        return fail(located(state.error(), *step_.program, row_.line));
    }
    row_ = out.row = row_of(*state);
    out.status = was_under_way || state->status == feed::LiveStatus::moving ? LiveMotionStatus::moving
                                                                            : LiveMotionStatus::standing;
    pass_events(step_.stretch->tool_path.blocks[state->block].run_block, out);
    if (state->status == feed::LiveStatus::finished) end_stretch();
    return out;
}

void LiveMotion::State::end_stretch() {
    plans_ += step_.planner->plans();
    step_.planner.reset();
    step_.events.clear();
    waits_for_resume_ = single_block_;
}

void LiveMotion::State::pass_events(std::size_t block, LiveMotionState& out) {
    for (; next_passed_ < step_.passed.size() && step_.passed[next_passed_].run_block <= block; ++next_passed_)
        out.events.push_back(step_.passed[next_passed_].event);
}

LiveRow LiveMotion::State::row_of(const feed::LiveState& state) const {
    return {step_.stretch->axis_path->position(state.place), step_.stretch->tool_path.blocks[state.block].line};
}

void LiveMotion::State::rows_ahead(std::vector<LiveRow>& rows) const {
    rows.assign(dwell_rows_ahead_, row_);
    if (dwell_rows_ahead_ > 0 || !step_.planner) return;
    const std::size_t count = step_.planner->periods_left();
    for (std::size_t k = 1; k <= count; ++k) rows.push_back(row_of(step_.planner->ahead(k)));
}

void LiveMotion::State::keep_plan(std::size_t lead) {
    if (step_.planner) step_.planner->keep(lead);
}

void LiveMotion::State::take_back_plan(std::size_t lead) {
    if (step_.planner) step_.planner->take_back(lead);
}

LiveMotion::LiveMotion(std::unique_ptr<State> state) : state_(std::move(state)) {}
LiveMotion::~LiveMotion() = default;
LiveMotion::LiveMotion(LiveMotion&&) noexcept = default;
LiveMotion& LiveMotion::operator=(LiveMotion&&) noexcept = default;

Result<LiveMotion> LiveMotion::make(program::ProgramParts& parts, const machine::Machine& machine,
                                    const machine::Setup& setup, const PlanOptions& options, double longest_plan_s) {
    if (auto good = check_options(options); !good) return fail(good.error());
    auto state = std::make_unique<State>(parts, machine, setup, options, longest_plan_s);
    if (auto begun = state->begin(); !begun) return fail(begun.error());
    return LiveMotion(std::move(state));
}

LiveRow LiveMotion::begin() const {
    return state_->row();
}
Result<void> LiveMotion::set_feed_override(double factor) {
    auto good = check_override("feed", factor, largest_feed_override);
    if (good) state_->set_feed_override(factor);
    return good;
}
Result<void> LiveMotion::set_rapid_override(double factor) {
    auto good = check_override("rapid", factor, largest_rapid_override);
    if (good) state_->set_rapid_override(factor);
    return good;
}
void LiveMotion::hold() {
    state_->hold();
}
void LiveMotion::resume() {
    state_->resume();
}
void LiveMotion::set_single_block(bool on) {
    state_->set_single_block(on);
}
void LiveMotion::stop() {
    state_->stop();
}
Result<LiveMotionState> LiveMotion::tick(bool may_plan) {
    return state_->tick(may_plan);
}
std::size_t LiveMotion::plan() const {
    return state_->plan();
}
void LiveMotion::rows_ahead(std::vector<LiveRow>& rows) const {
    state_->rows_ahead(rows);
}
void LiveMotion::keep_plan(std::size_t lead) {
    state_->keep_plan(lead);
}
void LiveMotion::take_back_plan(std::size_t lead) {
    state_->take_back_plan(lead);
}
std::vector<Diagnostic> LiveMotion::diagnostics() const {
    return state_->diagnostics();
}

Result<void> check_way(program::ProgramParts& parts, const machine::Machine& machine, const machine::Setup& setup,
                       const PlanOptions& options, const std::function<bool(double)>& go_on) {
    if (auto good = check_options(options); !good) return good;
    const PlanOptions used = live_options(options);
    ReadParts source({}, parts, machine, setup, used);
    StretchSource stretches(source, machine, used);
    bool moves = false;
    for (;;) {
        const auto element = stretches.next();
        if (!element) return fail(element.error());
        if (!*element) break;
        moves = moves || std::holds_alternative<StretchBegin>((*element)->content);
        if (!go_on((*element)->share)) return fail({.code = "PIPE0002", .text = "cancelled"});
    }
    if (!moves) return fail({.code = "PIPE0140", .text = "nothing moves in this program"});
    return {};
}

}  // namespace trunnion::pipeline
