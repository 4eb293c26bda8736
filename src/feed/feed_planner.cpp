#include "trunnion/feed/feed_planner.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "detail/jerk_free.hpp"
#include "detail/sampler.hpp"
#include "detail/window.hpp"

namespace trunnion::feed {

using motion::ProfilePiece;

namespace {

constexpr std::size_t smallest_window = 16, largest_growth = 8;
constexpr std::size_t kept_behind_stop = 3;  // enough for a start from rest
constexpr double tail_of_stopping_distance = 1.5;

constexpr double most_committed = 0.75;  // of a window
constexpr double margin_begins = 0.85;   // of what will about be committed
constexpr double longest_stretch = 1.25;
// A window that fails from one knot of the plan in hand is tried from a later one before half of the plan is used up.
constexpr int most_retries = 3;
constexpr std::size_t retry_after = 6;

double middle_x(const ProfilePiece& piece) {
    const double speed = motion::state_at(piece, piece.length_mm / 2).speed_mm_s;
    return speed * speed;
}

std::size_t share(double part, std::size_t size) {
    return static_cast<std::size_t>(part * static_cast<double>(size));
}

}  // namespace

class FeedPlanner::State {
  public:
    State(const LimitSet& limits, const PlannerOptions& options, Sink sink)
        : limits_(limits),
          options_(options),
          base_(std::max(options.window, smallest_window)),
          window_(base_),
          sink_(std::move(sink)),
          scan_(limits) {
        const bool known = options.start_speed_mm_s >= 0 && std::isfinite(options.start_speed_mm_s) &&
                           std::isfinite(options.start_acceleration_mm_s2);
        if (!known) give_up("FEED0001", "the start speed must be 0 or more, and the start acceleration a number");
    }

    void push(const Interval& interval) {
        if (failed_) return;
        if (!std::ranges::all_of(interval.samples, is_finite)) return give_up("FEED0002", "derivatives are not finite");
        intervals_.push_back(interval);
        tightening_.emplace_back();
        ++counts_.intervals;
        // The last window may be half as long again, so that no crumb is left for another one.
        if (intervals_.size() >= window_ + window_ / 2) step(window_);
    }

    Result<void> finish() {
        if (auto good = check_limits(limits_, 0); !good) return good;
        if (!failed_ && counts_.intervals < kept_behind_stop)
            give_up("FEED0003", "a stretch needs at least 3 intervals");
        while (!intervals_.empty()) step(intervals_.size() >= window_ + window_ / 2 ? window_ : intervals_.size());
        return failed_ ? Result<void>(fail(*failed_)) : Result<void>();
    }

    const PlannerCounts& counts() const { return counts_; }

  private:
    void step(std::size_t size);
    bool starts_moving() const { return !any_plan_ && options_.start_speed_mm_s > 0; }
    bool stands() const {
        return plan_.empty() ? !starts_moving() : plan_.front().kind == ProfilePiece::Kind::rest_start;
    }
    std::size_t stop_interval(std::size_t size) const;
    WindowProblem problem(std::size_t size);
    std::size_t commit_count(std::size_t size) const;
    void keep_old_plan(std::size_t size);
    void give_up(std::string code, std::string text, std::string hint = {});
    void commit(std::size_t count, std::size_t scanned, bool last);

    LimitSet limits_;
    PlannerOptions options_;
    std::size_t base_, window_;
    Sink sink_;
    JerkFreeScan scan_;
    WindowSolver solver_;
    std::vector<Interval> intervals_;     // not yet committed
    std::vector<Tightening> tightening_;  // of them
    std::vector<ProfilePiece> plan_;      // of the first of them, to rest; empty at rest
    std::vector<double> known_middle_;
    double time_s_ = 0, commit_share_ = most_committed;
    int retries_ = 0;
    bool any_plan_ = false;
    std::optional<Diagnostic> failed_;
    PlannerCounts counts_;
};

/// A window's throw-away stop: the longest interval of its last tenth, with enough behind it to start again.
std::size_t FeedPlanner::State::stop_interval(std::size_t size) const {
    const std::size_t end = size - kept_behind_stop, begin = end - std::max<std::size_t>(end / 10, 1);
    std::size_t longest = begin;
    for (std::size_t k = begin; k < end; ++k)
        if (intervals_[k].length_mm > intervals_[longest].length_mm) longest = k;
    return longest;
}

WindowProblem FeedPlanner::State::problem(std::size_t size) {
    WindowProblem out;
    out.intervals = std::span<const Interval>(intervals_).first(size);
    out.tightening = std::span<Tightening>(tightening_).first(size);
    out.limits = &limits_;
    out.calm = options_.calm;
    out.from_rest = stands();
    if (options_.budget) out.most_iterations = options_.budget(counts_.windows);
    known_middle_.clear();
    if (starts_moving()) {
        out.x0 = options_.start_speed_mm_s * options_.start_speed_mm_s;
        out.d0 = 2 * options_.start_acceleration_mm_s2;
    }
    if (plan_.empty()) return out;
    out.x0 = plan_.front().x0;
    out.d0 = plan_.front().d0;
    for (std::size_t k = 0; k + 1 < plan_.size(); ++k) known_middle_.push_back(middle_x(plan_[k]));
    out.known_middle = known_middle_;
    return out;
}

/// How much of the plan in hand may be committed: three quarters of the window, and less where the way from the last
/// maximum of the speed to the stop is long, for behind that maximum the plan already brakes for a stop that will not
/// be.
std::size_t FeedPlanner::State::commit_count(std::size_t size) const {
    double stopping = 0, rise = 0;
    for (std::size_t k = plan_.size(); k-- > 1 && plan_[k].x0 >= rise;) {
        stopping += plan_[k].length_mm;
        rise = plan_[k].x0;
    }
    std::size_t count = plan_.size();
    for (double left = 0; count > 0 && left < tail_of_stopping_distance * stopping; --count)
        left += plan_[count - 1].length_mm;
    return std::min(count, share(most_committed, size));
}

void FeedPlanner::State::step(std::size_t size) {
    const bool last = size == intervals_.size();
    const std::size_t planned = last ? size : stop_interval(size) + 1;
    WindowProblem window = problem(planned);
    if (!last) window.far_from = share(margin_begins * commit_share_, planned);
    WindowPlan plan = solver_.solve(window);
    ++counts_.windows;
    counts_.iterations += plan.iterations;
    counts_.tightening_rounds += plan.rounds;
    if (plan.fallback || !plan.safe) ++counts_.fallbacks;
    if (!plan.safe) return keep_old_plan(size);
    plan_ = std::move(plan.pieces);
    retries_ = 0;
    any_plan_ = true;
    const std::size_t tail = commit_count(planned);
    std::size_t count = last ? plan_.size() : std::max<std::size_t>(tail, 1);
    if (!last && count < window.far_from + 2)
        count = std::min(window.far_from + 2, share(longest_stretch, count) + 2);  // to where the margin has begun
    if (!last && count < planned / 8 && window_ < largest_growth * base_) {
        window_ *= 2;  // the stopping distance is long here: look farther before committing
        return;
    }
    // The next window starts where about this one's commit ends: before that a plan begins to keep off the limits, so
    // that the next one has room around it.
    if (!last) commit_share_ = static_cast<double>(tail) / static_cast<double>(planned);
    if (!plan.fallback) solver_.add_worth(window, count, counts_.worth);
    commit(count, size, last);
}

/// The plan in hand is a checked motion to rest: some of it is used and planning tried again from there. From rest
/// there is always a plan unless the path itself is broken; a motion that comes with speed may need to see farther.
void FeedPlanner::State::keep_old_plan(std::size_t size) {
    if (!plan_.empty() && retries_ < most_retries && plan_.size() > 2 * retry_after) {
        ++retries_;
        return commit(retry_after, size, false);
    }
    if (!plan_.empty()) return commit((plan_.size() + 1) / 2, size, false);
    if (!starts_moving())
        return give_up("FEED0004", "no motion holds the limits on this stretch",
                       "its derivatives may be too large to compute with");
    if (size == intervals_.size() || window_ >= largest_growth * base_)
        return give_up("FEED0007", "the start speed cannot be stopped in what is left");
    window_ *= 2;
}

void FeedPlanner::State::give_up(std::string code, std::string text, std::string hint) {
    failed_ = Diagnostic{.code = std::move(code), .text = std::move(text), .hint = std::move(hint)};
    intervals_.clear();
    tightening_.clear();
}

void FeedPlanner::State::commit(std::size_t count, std::size_t scanned, bool last) {
    counts_.jerk_free_bound_s += scan_.advance(std::span<const Interval>(intervals_).first(scanned), count, last);
    for (std::size_t k = 0; k < count; ++k) {
        ProfilePiece& piece = plan_[k];
        piece.begin_s = time_s_;
        piece.duration_s = motion::time_to(piece, piece.length_mm);
        time_s_ += piece.duration_s;
        sink_(intervals_[k], piece);
    }
    const auto drop = [count](auto& from) {
        from.erase(from.begin(), from.begin() + static_cast<std::ptrdiff_t>(count));
    };
    drop(plan_);
    drop(intervals_);
    drop(tightening_);
}

FeedPlanner::FeedPlanner(const LimitSet& limits, const PlannerOptions& options, Sink sink)
    : state_(std::make_unique<State>(limits, options, std::move(sink))) {}
FeedPlanner::~FeedPlanner() = default;
FeedPlanner::FeedPlanner(FeedPlanner&&) noexcept = default;
FeedPlanner& FeedPlanner::operator=(FeedPlanner&&) noexcept = default;

void FeedPlanner::push(const Interval& interval) {
    state_->push(interval);
}
Result<void> FeedPlanner::finish() {
    return state_->finish();
}
const PlannerCounts& FeedPlanner::counts() const {
    return state_->counts();
}

Result<void> check_limits(const LimitSet& limits, int axes) {
    for (int c = 0; c < coordinates; ++c)
        for (const double limit : {limits.of[c].velocity, limits.of[c].acceleration, limits.of[c].jerk}) {
            if (limit > 0 && (c >= axes || std::isfinite(limit))) continue;
            return fail({.code = "FEED0006",
                         .text = "every limit must be more than 0, and every axis needs all three of them",
                         .value = fmt::format("{}", limit)});
        }
    return {};
}

}  // namespace trunnion::feed
