#pragma once

#include <algorithm>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "trunnion/feed/live_planner.hpp"

#include "detail/descent.hpp"
#include "detail/live_grid.hpp"
#include "detail/window.hpp"

namespace trunnion::feed {

/// What a LivePlanner is and does. live_planner.cpp follows the commands from tick to tick, live_change.cpp decides
/// what is tried when the motion must change, live_look.cpp sees how soon the machine could stand, live_window.cpp
/// plans a window from where the plan in hand is left and takes it over.
class LivePlanner::State {
  public:
    using PathPlace = path::PathPlace;

    State(const path::AxisPath& path, const FeedOptions& options, double period_s, double longest_plan_s);

    Result<void> prepare() { return grid_.lay(); }
    double period_s() const { return period_s_; }
    double longest_plan_s() const { return longest_plan_s_; }
    void set_override(bool rapid, double factor) {
        if (rapid == path_.tool_path().rapid) set_pace({factor, pace_.largest_mm_s});
    }
    void set_largest_speed(double mm_s) { set_pace({pace_.factor, mm_s}); }
    void hold() { held_ = true; }
    void resume();
    void set_single_block(bool on);
    Result<LiveState> tick(bool may_plan);
    std::size_t plans() const { return plans_; }
    std::size_t periods_left() const;
    LiveState ahead(std::size_t periods) const { return state_at(static_cast<double>(ticks_ + periods) * period_s_); }
    void set_end(std::optional<PathPlace> place);
    void keep(std::size_t lead);
    void take_back(std::size_t lead);
    /// Takes over what another one does, on a path that is the same here; false: it cannot.
    Result<bool> go_on_from(const State& other, const SamePath& same);

  private:
    using ProfilePiece = motion::ProfilePiece;
    static constexpr double same_place_mm = 1e-9;
    static constexpr std::size_t periods_ahead = 2;  // from there on the plan in hand may change at the soonest
    /// Of the limits of velocity, acceleration and feed plans leave a trifle, for `room_for`.
    static constexpr double kept_back = 1 - 4e-4;
    /// A braking that breaks limits by more has led to a dead end.
    static constexpr double dead_end = 1.02;

    /// What is made of the programmed speed, or of a rapid's limits: so many times it, and no more than this of the
    /// tip.
    struct Pace {
        double factor = 1;
        double largest_mm_s = std::numeric_limits<double>::infinity();
        bool operator==(const Pace&) const = default;
        bool stands() const { return factor == 0 || largest_mm_s == 0; }
        bool above(const Pace& other) const { return factor > other.factor || largest_mm_s > other.largest_mm_s; }
        Pace or_faster(const Pace& other) const {
            return {std::max(factor, other.factor), std::max(largest_mm_s, other.largest_mm_s)};
        }
    };
    /// What the commands ask for, and what the plan in hand was made for.
    struct Wish {
        bool stand = false;
        Pace pace;
        bool single_block = false;
        bool operator==(const Wish&) const = default;
    };
    /// A cell of the plan in hand; its piece counts from its begin_s on until the next one's.
    struct Step {
        Cell cell;
        ProfilePiece piece;
        Pace pace;
    };
    struct PlanInHand {
        Wish made_for;
        std::optional<PathPlace> block_goal;  // where a single block ends
        bool ends_at_goal = false;            // else at a throw-away stop or a hold
        bool waits = false;                   // behind a single block
        std::vector<Step> steps;
        std::size_t border = 0;  // from this step on it may be replaced by a longer one
        double end_s = 0;
    };
    /// How many periods ahead a change counts: more where the last ones were taken back, fewer again where they hold.
    class Lead {
      public:
        std::size_t periods() const { return periods_ahead + more_; }
        void came_late(std::size_t wanted);
        void was_in_time(std::size_t wanted);

      private:
        std::size_t more_ = 0;
    };
    static double end_of(const std::vector<Step>& steps) {
        return steps.back().piece.begin_s + steps.back().piece.duration_s;
    }
    /// Where a new plan leaves the one in hand.
    struct Branch {
        PathPlace place;
        double begin_s = 0;
        std::size_t kept = 0;  // steps of the plan in hand that stay
        bool at_rest = false;
        MovingStart start;
    };
    /// The speed that a solve starts from: that of the plan in hand, pushed together along the path, and not above that
    /// of a braking that begins later.
    struct Guess {
        const Descent* braking = nullptr;
        double delay_mm = 0, compression = 1;
        bool blank = false;  // nothing of all this: the solver's own start
    };
    /// What is tried: where to, up to where the old pace counts, how suddenly, and a first guess of the speed.
    struct Trial {
        PathPlace goal;
        Pace pace;
        double old_pace_until_mm = -1;
        double level_mm = std::numeric_limits<double>::infinity();  // cells where the new pace begins to count
        double stop_mm = 0;                                         // > 0: cells as fine as a stop of that way needs
        bool stand = false;
        std::size_t window = 0;  // cells; 0: as many as longer ways take
        Guess guess;
    };
    /// The way ahead of a branch, finely sampled as far as a stop may take.
    struct Look {
        std::vector<Interval> intervals;
        double stop_mm = 0;            // closed form, by the limits at the branch
        double path_jerk_mm_s3 = 0;    // by the limits at the branch
        double reach_mm = 0;           // of the intervals
        std::optional<Descent> steep;  // the hardest braking; may lead to a dead end
    };

    Wish wish() const { return {held_ || pace_.stands(), pace_, single_block_}; }
    void set_pace(const Pace& pace);
    double present_s() const { return static_cast<double>(ticks_) * period_s_; }
    PathPlace standing_place() const;
    double end_mm() const { return grid_.distance_mm(standing_place()); }
    bool stands_at_end() const;
    LiveState state_at(double now) const;
    std::size_t block_at(double p_mm) const;
    PathPlace block_end(std::size_t block) const;

    /// Where the motion leads to; never before the place where the plan in hand stands.
    PathPlace goal() const;
    bool take_over(const State& other, const SamePath& same);
    Result<bool> leave_before(std::size_t last);
    double effect_s(const Lead& lead) const;
    Result<void> follow(bool may_plan);
    Result<void> restart(double begin_s);
    Result<void> stop(const Branch& branch);
    Result<bool> plan_stop(const Branch& branch, double way_mm, const Descent* braking, const Guess& other);
    Result<void> stop_sooner(const Branch& branch);
    Result<void> go_on(const Branch& branch);
    Result<bool> go_on_to(PathPlace goal, const Branch& branch, const Look& look);
    Result<void> extend(double earliest_s);

    std::size_t step_at(double time_s) const;
    Branch branch_at(double time_s) const;
    Pace pace_in_hand(double p_mm) const;
    double old_pace_until(const Branch& branch) const;
    MovingStart state_in_hand(double p_mm) const;
    const Step* step_over(double p_mm) const;

    double factor_of(const Pace& pace, std::size_t block) const;
    bool means_the_same(const Wish& wish) const;
    double fastest_tip(const Cell& cell) const;
    void apply(const Pace& pace, const Cell& cell, Interval& interval) const;
    Result<Interval> sample(const Cell& cell, const Pace& pace) const;
    Result<Look> look_ahead(const Branch& branch, const Pace& pace) const;
    Result<std::vector<Interval>> survey(const Branch& branch, const Pace& pace, double reach_mm) const;
    Result<std::optional<Descent>> first_stop(const Branch& branch, const Look& look) const;
    std::optional<Descent> later_stop(std::span<const Interval> intervals, const Branch& branch) const;
    bool is_exact(const Branch& branch, const Trial& trial) const;
    std::size_t window_of(const Trial& trial) const { return trial.window > 0 ? trial.window : window_; }
    std::size_t window_for(const Branch& branch, const Look& look) const;
    Course course(const Branch& branch, const Trial& trial) const;
    Result<bool> plan(const Branch& branch, const Trial& trial) { return plan(branch, trial, wish()); }
    Result<bool> plan(const Branch& branch, const Trial& trial, const Wish& made_for);
    Result<std::vector<Step>> solve(const Branch& branch, const Trial& trial, const Course& way);
    Course nearer(const Branch& branch, Course way, const std::vector<Step>& steps) const;
    void make_guess(const Branch& branch, const Guess& guess, std::span<const Cell> cells);
    LimitSet room_for(MovingStart start, const PathSample& here) const;
    void adopt(const Branch& branch, std::vector<Step> steps);
    std::size_t commit_count(std::size_t first) const;

    const path::AxisPath& path_;
    Sampler sampler_;
    LimitSet limits_;
    double calm_, period_s_, longest_plan_s_;
    std::size_t base_, window_;
    LiveGrid grid_;
    WindowSolver solver_;

    Pace pace_;
    bool held_ = false, single_block_ = false;
    std::size_t ticks_ = 0, next_trial_ = 0, plans_ = 0;
    std::optional<PathPlace> end_;  // set_end()
    PlanInHand now_, kept_;
    Lead command_lead_, way_lead_;
    int failed_trials_ = 0;      // of a longer way, since the last plan
    std::size_t next_lift_ = 0;  // that is tried for a lower override
    std::vector<double> known_middle_;
    int probes_left_ = 0;         // of a stop
    double out_of_reach_mm_ = 0;  // a place too near to stop at
};

}  // namespace trunnion::feed
