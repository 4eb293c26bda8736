#include "trunnion/feed/live_planner.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "detail/live_state.hpp"

namespace trunnion::feed {
namespace {

using path::PathPlace;

constexpr double largest_override = 2, largest_rapid_override = 1;
constexpr std::size_t least_more = 100, most_more = 1600;  // periods, of a lead

Diagnostic problem(std::string code, std::string text, double value, std::string limit) {
    Diagnostic out;
    out.code = std::move(code);
    out.text = std::move(text);
    out.value = fmt::format("{}", value);
    out.limit = std::move(limit);
    return out;
}

}  // namespace

void LivePlanner::State::set_pace(const Pace& pace) {
    if (pace == pace_) return;
    pace_ = pace;
    next_lift_ = 0;
}

/// Whether another pace makes no difference on the plan in hand: a largest speed above what is programmed.
bool LivePlanner::State::means_the_same(const Wish& wish) const {
    const Wish& is = now_.made_for;
    if (is.stand || wish.stand || is.single_block != wish.single_block || path_.tool_path().rapid) return false;
    return std::ranges::all_of(now_.steps, [&](const Step& step) {
        return factor_of(step.pace, step.cell.block) == factor_of(wish.pace, step.cell.block);
    });
}

void LivePlanner::State::resume() {
    held_ = false;
    if (present_s() >= now_.end_s) now_.waits = false;
}

void LivePlanner::State::set_single_block(bool on) {
    single_block_ = on;
    if (present_s() < now_.end_s) now_.waits = on && now_.ends_at_goal && now_.made_for.single_block;
}

Result<LiveState> LivePlanner::State::tick(bool may_plan) {
    if (auto done = follow(may_plan); !done) return fail(done.error());
    ++ticks_;
    return ahead(0);
}

std::size_t LivePlanner::State::periods_left() const {
    if (now_.steps.empty()) return 0;
    auto out = static_cast<std::size_t>(std::max((now_.end_s - present_s()) / period_s_, 0.0));
    while (static_cast<double>(ticks_ + out) * period_s_ < now_.end_s) ++out;
    return out;
}

void LivePlanner::State::set_end(std::optional<PathPlace> place) {
    end_ = place;
    if (grid_.distance_mm(goal()) > end_mm() + same_place_mm) now_.ends_at_goal = false;
}

PathPlace LivePlanner::State::goal() const {
    if (now_.block_goal) return *now_.block_goal;
    if (!end_) return grid_.end();
    const PathPlace stand = standing_place();
    return grid_.distance_mm(*end_) > grid_.distance_mm(stand) ? *end_ : stand;
}

void LivePlanner::State::Lead::came_late(std::size_t wanted) {
    more_ = std::min(std::max({2 * more_, wanted, least_more}), most_more);
}

void LivePlanner::State::Lead::was_in_time(std::size_t wanted) {
    more_ = std::min(std::max(more_ - (more_ + 15) / 16, wanted), most_more);
}

void LivePlanner::State::keep(std::size_t lead) {
    const bool commanded = kept_.made_for != now_.made_for;
    (commanded ? command_lead_ : way_lead_).was_in_time(lead);
    kept_ = now_;
}

void LivePlanner::State::take_back(std::size_t lead) {
    const bool commanded = kept_.made_for != now_.made_for;
    (commanded ? command_lead_ : way_lead_).came_late(lead);
    now_ = kept_;
    next_trial_ = ticks_;
    ++plans_;
}

LiveState LivePlanner::State::state_at(double now) const {
    LiveState out;
    if (now_.steps.empty() || now >= now_.end_s || now < now_.steps.front().piece.begin_s) {
        const bool started = !now_.steps.empty() && now >= now_.end_s;
        out.place = started || now_.steps.empty() ? standing_place() : now_.steps.front().cell.begin;
        out.status = started && stands_at_end() ? LiveStatus::finished : LiveStatus::holding;
    } else {
        const Step& step = now_.steps[step_at(now)];
        const double delta = motion::distance_at(step.piece, now - step.piece.begin_s);
        const motion::PathState state = motion::state_at(step.piece, delta);
        out.status = LiveStatus::moving;
        out.place = {step.cell.begin.piece, step.cell.begin.offset_mm + delta};
        out.speed_mm_s = state.speed_mm_s;
        out.acceleration_mm_s2 = state.acceleration_mm_s2;
        out.jerk_mm_s3 = state.jerk_mm_s3;
    }
    out.block = block_at(grid_.distance_mm(out.place));
    return out;
}

/// The block that holds behind a place.
std::size_t LivePlanner::State::block_at(double p_mm) const {
    const auto& blocks = path_.tool_path().blocks;
    if (blocks.empty()) return 0;
    const auto found = std::upper_bound(blocks.begin(), blocks.end() - 1, p_mm + same_place_mm,
                                        [](double p, const path::BlockSpan& block) { return p < block.end_mm; });
    return static_cast<std::size_t>(found - blocks.begin());
}

PathPlace LivePlanner::State::block_end(std::size_t block) const {
    const auto& blocks = path_.tool_path().blocks;
    return block + 1 >= blocks.size() ? grid_.end() : grid_.place_at(blocks[block].end_mm);
}

/// When a change counts that is made with this lead; in the middle of what is left where that is less than twice it.
double LivePlanner::State::effect_s(const Lead& lead) const {
    const std::size_t periods = std::min(lead.periods(), periods_left() / 2);
    return static_cast<double>(ticks_ + std::max(periods, periods_ahead)) * period_s_;
}

/// Lets commands and the way ahead change the plan in hand.
Result<void> LivePlanner::State::follow(bool may_plan) {
    const double soonest_s = static_cast<double>(ticks_ + periods_ahead) * period_s_;
    if (now_.end_s <= soonest_s) return restart(now_.steps.empty() ? present_s() : soonest_s);
    if (!may_plan) return {};
    if (now_.made_for != wish() && means_the_same(wish())) now_.made_for = wish();
    if (now_.made_for == wish() && !now_.made_for.stand) return extend(effect_s(way_lead_));
    const Branch branch = branch_at(effect_s(command_lead_));
    if (branch.at_rest) return {};
    if (now_.made_for == wish()) return stop_sooner(branch);
    if (wish().stand) return stop(branch);
    if (ticks_ >= next_trial_) return go_on(branch);
    return extend(effect_s(way_lead_));  // as long as no plan is found for what is asked
}

/// From standstill there is always a plan, unless the path itself is broken.
Result<void> LivePlanner::State::restart(double begin_s) {
    if (wish().stand || now_.waits || (!now_.steps.empty() && stands_at_end())) return {};
    Branch branch;
    branch.place = standing_place();
    branch.begin_s = begin_s;
    branch.at_rest = true;
    if (present_s() < now_.end_s) return {};
    Trial trial;
    trial.pace = pace_;
    now_.block_goal.reset();
    if (single_block_) now_.block_goal = block_end(block_at(grid_.distance_mm(branch.place)));
    trial.goal = goal();
    if (grid_.distance_mm(trial.goal) <= end_mm() + same_place_mm) return {};
    const auto done = plan(branch, trial);
    if (!done) return fail(done.error());
    if (*done) return {};
    Diagnostic out;
    out.code = "FEED0004";
    out.text = "no motion holds the limits on this stretch";
    out.place.path_length_mm = grid_.distance_mm(branch.place);
    return fail(out);
}

LivePlanner::LivePlanner(std::unique_ptr<State> state) : state_(std::move(state)) {}
LivePlanner::~LivePlanner() = default;
LivePlanner::LivePlanner(LivePlanner&&) noexcept = default;
LivePlanner& LivePlanner::operator=(LivePlanner&&) noexcept = default;

Result<LivePlanner> LivePlanner::make(const path::AxisPath& path, const FeedOptions& options, double period_s,
                                      double longest_plan_s) {
    if (!(period_s > 0 && std::isfinite(period_s)))
        return fail(problem("FEED0011", "the control's period must be positive", period_s, "0 s"));
    if (const auto stream = IntervalStream::make(path, options); !stream) return fail(stream.error());
    auto state = std::make_unique<State>(path, options, period_s, longest_plan_s);
    if (auto ready = state->prepare(); !ready) return fail(ready.error());
    return LivePlanner(std::move(state));
}

Result<void> LivePlanner::set_feed_override(double factor) {
    if (!(factor >= 0 && factor <= largest_override))
        return fail(problem("FEED0010", "a feed override must lie between 0 and 2", factor, "0…2"));
    state_->set_override(false, factor);
    return {};
}
Result<void> LivePlanner::set_rapid_override(double factor) {
    if (!(factor >= 0 && factor <= largest_rapid_override))
        return fail(problem("FEED0010", "a rapid override must lie between 0 and 1", factor, "0…1"));
    state_->set_override(true, factor);
    return {};
}
Result<void> LivePlanner::set_largest_speed(double mm_s) {
    if (!(mm_s >= 0)) return fail(problem("FEED0010", "a largest speed must not be below 0", mm_s, "0 mm/s"));
    state_->set_largest_speed(mm_s);
    return {};
}
void LivePlanner::hold() {
    state_->hold();
}
void LivePlanner::resume() {
    state_->resume();
}
void LivePlanner::set_single_block(bool on) {
    state_->set_single_block(on);
}
Result<LiveState> LivePlanner::tick(bool may_plan) {
    return state_->tick(may_plan);
}
std::size_t LivePlanner::plans() const {
    return state_->plans();
}
std::size_t LivePlanner::periods_left() const {
    return state_->periods_left();
}
LiveState LivePlanner::ahead(std::size_t periods) const {
    return state_->ahead(periods);
}
void LivePlanner::set_end(std::optional<path::PathPlace> place) {
    state_->set_end(place);
}
void LivePlanner::keep(std::size_t lead) {
    state_->keep(lead);
}
void LivePlanner::take_back(std::size_t lead) {
    state_->take_back(lead);
}

}  // namespace trunnion::feed
