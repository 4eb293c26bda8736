#include <algorithm>

#include "detail/live_state.hpp"

namespace trunnion::feed {

/// The steps of the plan in hand from the present one on, on the longer path. Those behind the branch are but a guess.
Result<bool> LivePlanner::State::go_on_from(const State& other, std::size_t pieces_behind, std::size_t blocks_behind) {
    const double effect_s = static_cast<double>(other.ticks_ + periods_ahead) * period_s_;
    const bool runs =
        !other.steps_.empty() && other.end_s_ > effect_s && other.present_s() >= other.steps_.front().piece.begin_s;
    if (!runs || other.planned_ != other.wish() || other.planned_.stand || other.single_block_) return false;
    for (std::size_t k = other.step_at(other.present_s()); k < other.steps_.size(); ++k) {
        Step step = other.steps_[k];
        if (step.cell.begin.piece < pieces_behind || step.cell.block < blocks_behind) return false;
        step.cell.begin.piece -= pieces_behind;
        step.cell.block -= blocks_behind;
        if (step.cell.begin.piece >= path_.tool_path().pieces.size()) break;
        steps_.push_back(step);
    }
    override_ = other.override_;
    ticks_ = other.ticks_;
    plans_ = other.plans_;
    window_ = other.window_;
    end_s_ = other.end_s_;
    planned_ = other.planned_;
    const Branch branch = branch_at(effect_s);
    if (branch.at_rest) return false;
    Trial trial;
    trial.goal = grid_.end();
    trial.factor = override_;
    trial.old_factor_until_mm = old_factor_until(branch);
    return plan(branch, trial);
}

Result<std::optional<LivePlanner>> LivePlanner::gone_on_along(const path::AxisPath& other, const FeedOptions& options,
                                                              std::size_t pieces_behind,
                                                              std::size_t blocks_behind) const {
    if (const auto stream = IntervalStream::make(other, options); !stream) return fail(stream.error());
    auto state = std::make_unique<State>(other, options, state_->period_s(), state_->longest_plan_s());
    if (auto ready = state->prepare(); !ready) return fail(ready.error());
    const auto taken = state->go_on_from(*state_, pieces_behind, blocks_behind);
    if (!taken) return fail(taken.error());
    if (!*taken) return std::optional<LivePlanner>();
    return std::optional(LivePlanner(std::move(state)));
}

}  // namespace trunnion::feed
