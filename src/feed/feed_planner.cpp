#include "trunnion/feed/feed_planner.hpp"

#include <algorithm>

#include "detail/jerk_free.hpp"
#include "detail/window.hpp"

namespace trunnion::feed {

using motion::ProfilePiece;

namespace {

constexpr std::size_t smallest_window = 16, largest_growth = 8;
constexpr std::size_t kept_behind_stop = 3;  // enough for a start from rest
constexpr double tail_of_stopping_distance = 1.5;

double middle_x(const ProfilePiece& piece) {
    const double speed = motion::state_at(piece, piece.length_mm / 2).speed_mm_s;
    return speed * speed;
}

}  // namespace

class FeedPlanner::State {
  public:
    State(const LimitSet& limits, const PlannerOptions& options, Sink sink)
        : limits_(limits),
          calm_(options.calm),
          base_(std::max(options.window, smallest_window)),
          window_(base_),
          sink_(std::move(sink)),
          scan_(limits) {}

    void push(const Interval& interval) {
        if (failed_) return;
        intervals_.push_back(interval);
        tightening_.emplace_back();
        ++counts_.intervals;
        // The last window may be half as long again, so that no crumb is left for another one.
        if (intervals_.size() >= window_ + window_ / 2) step(window_);
    }

    bool finish() {
        while (!intervals_.empty()) step(intervals_.size() >= window_ + window_ / 2 ? window_ : intervals_.size());
        return !failed_;
    }

    const PlannerCounts& counts() const { return counts_; }

  private:
    void step(std::size_t size);
    bool stands() const { return plan_.empty() || plan_.front().kind == ProfilePiece::Kind::rest_start; }
    std::size_t stop_interval(std::size_t size) const;
    WindowProblem problem(std::size_t size);
    std::size_t commit_count(std::size_t size) const;
    void keep_old_plan(std::size_t size);
    void commit(std::size_t count, std::size_t scanned, bool last);

    LimitSet limits_;
    double calm_;
    std::size_t base_, window_;
    Sink sink_;
    JerkFreeScan scan_;
    WindowSolver solver_;
    std::vector<Interval> intervals_;     // not yet committed
    std::vector<Tightening> tightening_;  // of them
    std::vector<ProfilePiece> plan_;      // of the first of them, to rest; empty at rest
    std::vector<double> known_middle_;
    double time_s_ = 0;
    bool failed_ = false;
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
    out.calm = calm_;
    out.from_rest = stands();
    known_middle_.clear();
    if (plan_.empty()) return out;
    out.x0 = plan_.front().x0;
    out.d0 = plan_.front().d0;
    for (std::size_t k = 0; k + 1 < plan_.size(); ++k) known_middle_.push_back(middle_x(plan_[k]));
    out.known_middle = known_middle_;
    return out;
}

/// How much of the plan in hand may be committed: half the window, and less where the way from the last maximum of the
/// speed to the stop is long, for behind that maximum the plan already brakes for a stop that will not be.
std::size_t FeedPlanner::State::commit_count(std::size_t size) const {
    double stopping = 0, rise = 0;
    for (std::size_t k = plan_.size(); k-- > 1 && plan_[k].x0 >= rise;) {
        stopping += plan_[k].length_mm;
        rise = plan_[k].x0;
    }
    std::size_t count = plan_.size();
    for (double left = 0; count > 0 && left < tail_of_stopping_distance * stopping; --count)
        left += plan_[count - 1].length_mm;
    return std::min(count, size / 2);
}

void FeedPlanner::State::step(std::size_t size) {
    const bool last = size == intervals_.size();
    const std::size_t planned = last ? size : stop_interval(size) + 1;
    WindowProblem window = problem(planned);
    if (!last) window.far_from = planned / 2;
    WindowPlan plan = solver_.solve(window);
    ++counts_.windows;
    counts_.iterations += plan.iterations;
    counts_.tightening_rounds += plan.rounds;
    if (plan.fallback || !plan.safe) ++counts_.fallbacks;
    if (!plan.safe) return keep_old_plan(size);
    plan_ = std::move(plan.pieces);
    if (last) return commit(plan_.size(), size, true);
    const std::size_t count = commit_count(planned);
    if (count >= planned / 8 || window_ >= largest_growth * base_)
        return commit(std::max<std::size_t>(count, 1), size, false);
    window_ *= 2;  // the stopping distance is long here: look farther before committing
}

/// The plan in hand is a checked motion to rest: half of it is used and planning tried again from there. From rest
/// there is always a plan unless the path itself is broken.
void FeedPlanner::State::keep_old_plan(std::size_t size) {
    if (!plan_.empty()) return commit((plan_.size() + 1) / 2, size, false);
    failed_ = true;
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
    Diagnostic problem;
    if (state_->counts().intervals < kept_behind_stop) {
        problem.code = "FEED0003";
        problem.text = "a stretch needs at least 3 intervals";
        return fail(problem);
    }
    if (state_->finish()) return {};
    problem.code = "FEED0004";
    problem.text = "no motion holds the limits on this stretch";
    problem.hint = "its derivatives may be too large to compute with";
    return fail(problem);
}
const PlannerCounts& FeedPlanner::counts() const {
    return state_->counts();
}

}  // namespace trunnion::feed
