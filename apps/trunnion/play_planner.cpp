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
constexpr auto between_looks = std::chrono::microseconds(50);

/// Waits for the reader; false: it does not look any more.
template <class Done>
bool wait_for_reader(const Done& done) {
    for (const auto until = steady_clock::now() + longest_wait; !done(); std::this_thread::sleep_for(between_looks))
        if (steady_clock::now() > until) return false;
    return true;
}

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
    const auto taken = hand_over(0);
    return taken ? Result<void>() : fail(taken.error());
}

/// While planning takes its time the reader goes on: the next plan is made when the ticks have the whole lead again.
Result<PlanPublisher::Advance> PlanPublisher::advance() {
    Advance out;
    out.status = LiveMotionStatus::moving;
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
/// when planning began; the next change shall have twice the time of this one.
Result<void> PlanPublisher::publish(std::uint64_t begun) {
    plan_ = motion_.plan();
    drop_given_rows();
    std::vector<LiveRow> before = rows_;
    motion_.rows_ahead(ahead_);
    rows_.resize(next_ - first_);
    rows_.insert(rows_.end(), ahead_.begin(), ahead_.end());
    const auto taken = hand_over(branch_from(before));
    if (!taken) return fail(taken.error());
    const std::uint64_t wanted = 2 * (reader_next() - begun), lead = wanted - std::min(wanted, lead_rows_);
    if (*taken) {
        motion_.keep_plan(lead);
        return {};
    }
    ++missed_;
    motion_.take_back_plan(lead);
    plan_ = motion_.plan();
    rows_ = std::move(before);
    return {};
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

/// Whether the reader took the plan over.
Result<bool> PlanPublisher::hand_over(std::uint64_t branch) {
    if (rows_.size() > TRUNNION_PLAN_ROWS)
        return fail({.code = "RT0006",
                     .text = "the way to the next standstill takes more periods than a plan holds",
                     .value = fmt::format("{}", rows_.size()),
                     .limit = fmt::format("{}", TRUNNION_PLAN_ROWS)});
    trunnion_plan* plan = nullptr;
    const auto silent = [] {
        return fail({.code = "RT0005", .text = "whoever plays the rows does not look for plans"});
    };
    if (!wait_for_reader([&] { return (plan = trunnion_plan_to_fill(&plans_)) != nullptr; })) return silent();
    plan->first = first_;
    plan->branch = branch;
    plan->count = rows_.size();
    std::ranges::transform(rows_, plan->rows, row_of_);
    const std::uint64_t number = trunnion_publish(&plans_);
    const auto looked = [&] { return __atomic_load_n(&plans_.looked_at, __ATOMIC_ACQUIRE) == number; };
    if (!wait_for_reader(looked)) return silent();
    return __atomic_load_n(&plans_.in_use, __ATOMIC_RELAXED) == number;
}

}  // namespace trunnion::app
