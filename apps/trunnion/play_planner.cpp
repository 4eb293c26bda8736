#include "play_planner.hpp"

#include <algorithm>
#include <chrono>
#include <thread>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"

namespace trunnion::app {

namespace {

using pipeline::LiveMotionStatus;
using pipeline::LiveRow;
using std::chrono::steady_clock;

constexpr auto longest_wait = std::chrono::seconds(5);
constexpr auto wait_at_once = std::chrono::milliseconds(2);
constexpr auto between_looks = std::chrono::microseconds(50);

}  // namespace

trunnion_row row_of(const LiveRow& row, const machine::Machine& machine) {
    trunnion_row out{};
    for (int i = 0; i < machine.axis_count; ++i)
        out.position[i] = machine.axes[i].rotary ? row.position[i] / degree : row.position[i];
    out.line = row.line;
    return out;
}

Result<void> PlanPublisher::publish_begin() {
    rows_ = {motion_.begin()};
    next_ = 1;
    if (auto handed = hand_over({.is_begin = true}); !handed) return handed;
    for (;;) {
        const auto looked = see_through();
        if (!looked) return fail(looked.error());
        if (*looked) return {};
    }
}

/// While planning takes its time the reader goes on: the next plan is made when the ticks have the whole lead again.
Result<PlanPublisher::Advance> PlanPublisher::advance() {
    Advance out;
    out.status = LiveMotionStatus::moving;
    if (const auto looked = see_through(); !looked || !*looked)
        return looked ? Result<Advance>(out) : fail(looked.error());
    for (bool planned = false; !planned && next_ < reader_next() + lead_rows_;) {
        planned = next_ + 1 >= reader_next() + lead_rows_;
        const std::uint64_t begun = reader_next();
        auto state = motion_.tick(planned);
        if (!state) return fail(state.error());
        out.status = state->status;
        out.events.insert(out.events.end(), state->events.begin(), state->events.end());
        if (state->status == LiveMotionStatus::moving)
            if (auto taken = take_row(state->row); !taken) return fail(taken.error());
        if (motion_.plan() != plan_) {
            if (auto published = publish(begun); !published) return fail(published.error());
            if (const auto looked = see_through(); !looked) return fail(looked.error());
            return out;
        }
        if (state->status != LiveMotionStatus::moving) return out;
    }
    return out;
}

/// A row that was told ahead must come as it was told; otherwise it begins a new plan.
Result<void> PlanPublisher::take_row(const LiveRow& row) {
    const std::size_t at = next_ - first_;
    ++next_;
    if (at >= rows_.size()) {
        rows_.push_back(row);
        return {};
    }
    if (rows_[at] == row) return {};
    return fail({.code = "RT0007", .text = fmt::format("row {} is not the one that was planned", next_ - 1)});
}

/// The rows of a changed plan; they are those of the one before up to where it was left. `begun`: where the reader was
/// when planning began.
Result<void> PlanPublisher::publish(std::uint64_t begun) {
    plan_ = motion_.plan();
    drop_given_rows();
    HandOver plan{.begun = begun, .before = rows_};
    motion_.rows_ahead(ahead_);
    rows_.resize(next_ - first_);
    rows_.insert(rows_.end(), ahead_.begin(), ahead_.end());
    plan.branch = branch_from(plan.before);
    return hand_over(std::move(plan));
}

void PlanPublisher::drop_given_rows() {
    const std::uint64_t given = std::min(reader_next(), next_);
    const std::uint64_t keep = std::max(first_, given - std::min(given, kept_rows_));
    rows_.erase(rows_.begin(), rows_.begin() + static_cast<std::ptrdiff_t>(keep - first_));
    first_ = keep;
}

std::uint64_t PlanPublisher::branch_from(const std::vector<LiveRow>& before) const {
    const auto differ = std::mismatch(before.begin(), before.end(), rows_.begin(), rows_.end());
    return first_ + static_cast<std::uint64_t>(differ.second - rows_.begin());
}

Result<void> PlanPublisher::hand_over(HandOver plan) {
    if (rows_.size() > TRUNNION_PLAN_ROWS)
        return fail({.code = "RT0006",
                     .text = "the way to the next standstill takes more periods than a plan holds",
                     .value = fmt::format("{}", rows_.size()),
                     .limit = fmt::format("{}", TRUNNION_PLAN_ROWS)});
    plan.until = steady_clock::now() + longest_wait;
    handed_over_ = std::move(plan);
    return {};
}

/// Whether nothing is left to be looked at; waits a little for that.
Result<bool> PlanPublisher::see_through() {
    for (const auto until = steady_clock::now() + wait_at_once; handed_over_;
         std::this_thread::sleep_for(between_looks)) {
        const auto now = steady_clock::now();
        if (is_looked_at()) {
            settle();
            break;
        }
        if (now > handed_over_->until)
            return fail({.code = "RT0005", .text = "whoever plays the rows does not look for plans"});
        if (now > until) return false;
    }
    return true;
}

/// Fills the plan in as soon as there is room for it.
bool PlanPublisher::is_looked_at() {
    if (handed_over_->number == 0) {
        trunnion_plan* const plan = trunnion_plan_to_fill(&plans_);
        if (!plan) return false;
        plan->first = first_;
        plan->branch = handed_over_->branch;
        plan->count = rows_.size();
        std::ranges::transform(rows_, plan->rows, row_of_);
        handed_over_->number = trunnion_publish(&plans_);
    }
    return __atomic_load_n(&plans_.looked_at, __ATOMIC_ACQUIRE) == handed_over_->number;
}

/// The reader has taken the plan over, or it goes on by the one before. The next change shall have twice the time of
/// this one.
void PlanPublisher::settle() {
    HandOver plan = std::move(*handed_over_);
    handed_over_.reset();
    const bool taken = __atomic_load_n(&plans_.in_use, __ATOMIC_RELAXED) == plan.number;
    if (plan.is_begin) return;
    const std::uint64_t wanted = 2 * (reader_next() - plan.begun), lead = wanted - std::min(wanted, lead_rows_);
    if (taken) return motion_.keep_plan(lead);
    ++missed_;
    motion_.take_back_plan(lead);
    plan_ = motion_.plan();
    rows_ = std::move(plan.before);
}

}  // namespace trunnion::app
