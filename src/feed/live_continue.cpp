#include <algorithm>

#include "detail/live_state.hpp"

namespace trunnion::feed {

/// The steps of the plan in hand from the present one on, on the longer path, as far as it knows their pieces.
bool LivePlanner::State::take_over(const State& other, const SamePath& same) {
    const auto& steps = other.now_.steps;
    const std::size_t present = steps.empty() ? 0 : other.step_at(other.present_s());
    now_ = other.now_;
    now_.steps.clear();
    now_.block_goal.reset();
    for (std::size_t k = present; k < steps.size(); ++k) {
        Step step = steps[k];
        if (step.cell.begin.piece < same.pieces_behind || step.cell.block < same.blocks_behind) return false;
        step.cell.begin.piece -= same.pieces_behind;
        step.cell.block -= same.blocks_behind;
        now_.steps.push_back(step);
        if (step.cell.begin.piece >= same.same_pieces) break;  // on none that the longer path has
    }
    now_.border -= std::min(now_.border, present);
    held_ = other.held_;
    single_block_ = other.single_block_;
    pace_ = other.pace_;
    command_lead_ = other.command_lead_;
    way_lead_ = other.way_lead_;
    ticks_ = other.ticks_;
    next_trial_ = other.next_trial_;
    plans_ = other.plans_;
    window_ = other.window_;
    kept_ = now_;
    return true;
}

/// Where the plan in hand stands on pieces that are the same it is one of the longer path too, and is made longer like
/// any other. Else it must be left before. A single block that is under way goes to its end first.
Result<bool> LivePlanner::State::go_on_from(const State& other, const SamePath& same) {
    if ((other.single_block_ && other.periods_left() > 0) || !take_over(other, same)) return false;
    const auto differs =
        std::ranges::find_if(now_.steps, [&](const Step& step) { return step.cell.begin.piece >= same.same_pieces; });
    if (differs != now_.steps.end() || now_.steps.empty() != other.now_.steps.empty())
        return leave_before(static_cast<std::size_t>(differs - now_.steps.begin()));
    now_.ends_at_goal = false;
    kept_ = now_;
    return true;
}

/// Branches where a cell before this one begins: from a state in the middle of one the solver does not always come
/// through.
Result<bool> LivePlanner::State::leave_before(std::size_t last) {
    const double from_s = effect_s(way_lead_);
    if (now_.end_s <= from_s || now_.made_for != wish() || now_.made_for.stand) return false;
    const std::size_t first = step_at(from_s) + 1;
    for (const std::size_t at : {std::min(now_.border, last - std::min<std::size_t>(last, 1)), first + 1, first}) {
        if (at < first || at >= last) continue;
        const Branch branch = branch_at(now_.steps[at].piece.begin_s);
        if (branch.at_rest) continue;
        Trial trial;
        trial.goal = goal();
        trial.pace = pace_;
        trial.old_pace_until_mm = old_pace_until(branch);
        trial.guess.blank = true;  // behind `last` the plan in hand is of another path, and a guess must not jump
        const auto done = plan(branch, trial);
        if (!done || *done) return done;
    }
    return false;
}

Result<std::optional<LivePlanner>> LivePlanner::gone_on_along(const path::AxisPath& other, const FeedOptions& options,
                                                              const SamePath& same,
                                                              std::optional<path::PathPlace> end) const {
    if (const auto stream = IntervalStream::make(other, options); !stream) return fail(stream.error());
    auto state = std::make_unique<State>(other, options, state_->period_s(), state_->longest_plan_s());
    if (auto ready = state->prepare(); !ready) return fail(ready.error());
    state->set_end(end);
    const auto taken = state->go_on_from(*state_, same);
    if (!taken) return fail(taken.error());
    if (!*taken) return std::optional<LivePlanner>();
    return std::optional(LivePlanner(std::move(state)));
}

}  // namespace trunnion::feed
