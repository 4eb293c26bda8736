#include <algorithm>
#include <array>
#include <cmath>

#include "detail/live_state.hpp"

namespace trunnion::feed {
namespace {

using path::PathPlace;

/// Places that are tried for a stop, of the way of the braking that was found.
constexpr std::array<double, 6> stop_stretches{1.004, 1.02, 1.06, 1.15, 1.4, 2};
// Near the shortest stop the time grows with the root of the way: a percent more of way is some percent of time.
constexpr int most_probes = 8;
constexpr double near_enough = 1.015;
constexpr double near_goal = 3;  // of a stop: the speed is the braking's, not that of the plan in hand
/// Where a lower feed begins to count: of the way down to it, and what is added of the way of a stop.
struct Lift {
    double of_descent, of_stop;
};
constexpr std::array<Lift, 7> lifts{
    {{1.003, 0}, {1.01, 0}, {1.03, 0.01}, {1.1, 0.03}, {1.3, 0.1}, {1.8, 0.4}, {3, 1.2}}};
constexpr double share_of_levelling = 0.25, least_levelling = 1e-4;  // the latter of the way of a stop
constexpr std::size_t most_goals = 4;
constexpr int ticks_between_trials = 4;

}  // namespace

/// Stops at the nearest place for which a plan is found, or where the plan in hand ends.
Result<void> LivePlanner::State::stop(const Branch& branch) {
    const auto look = look_ahead(branch, {});
    if (!look) return fail(look.error());
    const bool straight_down = look->steep && look->steep->worst <= dead_end;
    Result<std::optional<Descent>> found = look->steep;
    if (!straight_down) found = first_stop(branch, *look);
    if (!found) return fail(found.error());
    const double here = grid_.distance_mm(branch.place), left = end_mm() - here;
    out_of_reach_mm_ = here + (look->steep ? look->steep->length_mm : 0);
    probes_left_ = most_probes;
    for (const double stretch : stop_stretches) {
        const double way = *found ? stretch * (*found)->length_mm : left;
        if (way >= left) {
            now_.made_for = wish();  // the plan in hand ends soon enough
            return {};
        }
        const auto done = plan_stop(branch, way, &**found, {.blank = true});
        if (!done) return fail(done.error());
        if (*done) return {};
        out_of_reach_mm_ = std::max(out_of_reach_mm_, straight_down ? here + way : 0);
    }
    return {};
}

/// Plans a stop after so much way; whether the solver comes through hangs on its guess, and there are two.
Result<bool> LivePlanner::State::plan_stop(const Branch& branch, double way_mm, const Descent* braking,
                                           const Guess& other) {
    Trial trial;
    trial.goal = grid_.place_at(grid_.distance_mm(branch.place) + way_mm);
    trial.pace = pace_;
    trial.old_pace_until_mm = path_.length_mm();
    trial.stop_mm = braking ? braking->length_mm : way_mm;
    trial.stand = true;
    if (braking) {
        trial.guess = {.braking = braking, .delay_mm = way_mm - braking->length_mm};
        const auto done = plan(branch, trial);
        if (!done || *done) return done;
    }
    trial.guess = other;
    return plan(branch, trial);
}

/// Where the shortest stop is only known to lie between two places: tries one in between, tick by tick.
Result<void> LivePlanner::State::stop_sooner(const Branch& branch) {
    if (probes_left_ == 0 || branch.at_rest) return {};
    --probes_left_;
    const auto look = look_ahead(branch, {});
    if (!look) return fail(look.error());
    const double here = grid_.distance_mm(branch.place), left = end_mm() - here;
    const double nearest = out_of_reach_mm_ - here;
    if (!(nearest > 0) || left < near_enough * nearest) {
        probes_left_ = 0;
        return {};
    }
    const double way = std::sqrt(nearest * left);
    const auto done = plan_stop(branch, way, look->steep ? &*look->steep : nullptr, {.compression = left / way});
    if (!done) return fail(done.error());
    if (!*done) out_of_reach_mm_ = here + way;
    return {};
}

/// Goes on under new commands.
Result<void> LivePlanner::State::go_on(const Branch& branch) {
    const auto look = look_ahead(branch, pace_);
    if (!look) return fail(look.error());
    next_trial_ = ticks_ + ticks_between_trials;
    if (must_stand(look->intervals, limits_, branch.start)) return {};
    if (!single_block_) now_.block_goal.reset();
    if (!single_block_ || now_.block_goal) {
        const auto done = go_on_to(goal(), branch, *look);
        return done ? Result<void>{} : fail(done.error());
    }
    const double here = grid_.distance_mm(branch.place);
    const double nearest = look->steep ? here + look->steep->length_mm : end_mm();
    const std::size_t first = block_at(here), last = block_at(path_.length_mm());
    std::size_t trials = 0;
    for (std::size_t block = first; block <= last && trials < most_goals; ++block) {
        const PathPlace goal = block_end(block);
        if (grid_.distance_mm(goal) < nearest && block < last) continue;
        ++trials;
        const auto done = go_on_to(goal, branch, *look);
        if (!done) return fail(done.error());
        if (*done) return {};
    }
    return {};
}

Result<bool> LivePlanner::State::go_on_to(PathPlace goal, const Branch& branch, const Look& look) {
    Trial trial;
    trial.goal = goal;
    trial.pace = pace_;
    trial.stop_mm = look.stop_mm;
    trial.window = window_for(branch, look);
    const double here = grid_.distance_mm(branch.place), way = grid_.distance_mm(goal) - here;
    if (look.steep && way < near_goal * look.steep->length_mm)
        trial.guess = {.braking = &*look.steep, .delay_mm = way - look.steep->length_mm};
    if (!pace_in_hand(here).above(pace_)) return plan(branch, trial);
    const auto down = shortest_descent(look.intervals, limits_, branch.start);
    if (!down) return false;
    trial.guess.braking = &*down;
    // Where the speed levels out it does so within this way.
    const double level_speed = std::sqrt(down->x_at(down->length_mm)),
                 levelling = level_speed * std::sqrt(2 * level_speed / look.path_jerk_mm_s3);
    trial.level_mm = share_of_levelling * std::max(levelling, least_levelling * look.stop_mm);
    do {
        const Lift& lift = lifts[next_lift_];
        trial.old_pace_until_mm = here + lift.of_descent * down->length_mm + lift.of_stop * look.stop_mm;
        const auto done = plan(branch, trial);
        if (!done || *done) return done;
        next_lift_ = (next_lift_ + 1) % lifts.size();
    } while (single_block_ && next_lift_ > 0);  // else one a tick: each takes time
    if (next_lift_ > 0) next_trial_ = ticks_;
    return false;
}

/// Plans farther when the part of the plan in hand is used up that a longer one would not change. Where none is found
/// it is tried again by the solver's own start, and then from a later place.
Result<void> LivePlanner::State::extend(double earliest_s) {
    if (now_.made_for.stand || now_.ends_at_goal || now_.border >= now_.steps.size()) return {};
    const double border_s = now_.steps[now_.border].piece.begin_s;
    if (earliest_s + period_s_ < border_s) return {};
    const Branch branch = branch_at(std::max(earliest_s, border_s));
    if (branch.at_rest) return {};
    Trial trial;
    trial.goal = goal();
    trial.pace = now_.made_for.pace;
    trial.old_pace_until_mm = old_pace_until(branch);
    if (grid_.distance_mm(trial.goal) <= end_mm() + same_place_mm) return {};
    trial.guess.blank = failed_trials_ % 2 == 1;
    const auto done = plan(branch, trial, now_.made_for);
    if (!done) return fail(done.error());
    if (!*done && ++failed_trials_ % 2 == 0) now_.border += (now_.steps.size() - now_.border + 3) / 4;
    return {};
}

/// Up to where the plan in hand still goes by a higher pace than the one it was made for.
double LivePlanner::State::old_pace_until(const Branch& branch) const {
    double out = grid_.distance_mm(branch.place);
    for (std::size_t k = std::max<std::size_t>(branch.kept, 1) - 1;
         k < now_.steps.size() && now_.steps[k].pace.above(now_.made_for.pace); ++k)
        out = grid_.distance_mm(now_.steps[k].cell.begin) + now_.steps[k].cell.length_mm;
    return out;
}

}  // namespace trunnion::feed
