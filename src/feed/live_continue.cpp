#include <algorithm>

#include "detail/live_state.hpp"

namespace trunnion::feed {

/// The steps of the plan in hand from the present one on, on the longer path; false where that cannot be.
bool LivePlanner::State::take_over(const State& other, const SamePath& same) {
    const double effect_s = static_cast<double>(other.ticks_ + periods_ahead) * period_s_;
    const bool runs =
        !other.steps_.empty() && other.end_s_ > effect_s && other.present_s() >= other.steps_.front().piece.begin_s;
    if (!runs || other.planned_ != other.wish() || other.planned_.stand || other.single_block_) return false;
    const std::size_t present = other.step_at(other.present_s());
    for (std::size_t k = present; k < other.steps_.size(); ++k) {
        Step step = other.steps_[k];
        if (step.cell.begin.piece < same.pieces_behind || step.cell.block < same.blocks_behind) return false;
        step.cell.begin.piece -= same.pieces_behind;
        step.cell.block -= same.blocks_behind;
        if (step.cell.begin.piece >= path_.tool_path().pieces.size()) break;
        steps_.push_back(step);
    }
    border_ = other.border_ > present ? other.border_ - present : 0;
    override_ = other.override_;
    ticks_ = other.ticks_;
    plans_ = other.plans_;
    window_ = other.window_;
    end_s_ = other.end_s_;
    planned_ = other.planned_;
    return true;
}

/// Branches where a cell begins: from a state in the middle of one the solver does not always come through.
Result<bool> LivePlanner::State::go_on_from(const State& other, const SamePath& same) {
    if (!take_over(other, same)) return false;
    const double effect_s = static_cast<double>(ticks_ + periods_ahead) * period_s_;
    const auto differs =
        std::ranges::find_if(steps_, [&](const Step& step) { return step.cell.begin.piece >= same.same_pieces; });
    const auto last = static_cast<std::size_t>(differs - steps_.begin());
    const std::size_t first = step_at(effect_s) + 1;
    for (const std::size_t at : {std::min(border_, last - 1), first + 1, first}) {
        if (at < first || at >= last) continue;
        const Branch branch = branch_at(steps_[at].piece.begin_s);
        if (branch.at_rest) continue;
        Trial trial;
        trial.goal = grid_.end();
        trial.factor = override_;
        trial.old_factor_until_mm = old_factor_until(branch);
        const auto done = plan(branch, trial);
        if (!done || *done) return done;
    }
    return false;
}

Result<std::optional<LivePlanner>> LivePlanner::gone_on_along(const path::AxisPath& other, const FeedOptions& options,
                                                              const SamePath& same) const {
    if (const auto stream = IntervalStream::make(other, options); !stream) return fail(stream.error());
    auto state = std::make_unique<State>(other, options, state_->period_s(), state_->longest_plan_s());
    if (auto ready = state->prepare(); !ready) return fail(ready.error());
    const auto taken = state->go_on_from(*state_, same);
    if (!taken) return fail(taken.error());
    if (!*taken) return std::optional<LivePlanner>();
    return std::optional(LivePlanner(std::move(state)));
}

}  // namespace trunnion::feed
