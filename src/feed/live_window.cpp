#include <algorithm>
#include <cmath>

#include "detail/live_state.hpp"

namespace trunnion::feed {
namespace {

using path::PathPlace;

constexpr std::size_t largest_growth = 8;
constexpr double tail_of_stopping_distance = 1.5;
// Sizes of cells: beside a standstill, where a command changes the motion, and against how fast the speed changes.
constexpr double rest_growth = 0.14, stop_growth = 0.25, command_growth = 0.3;
constexpr double cells_of_a_stop = 20, flat_of_a_stop = 1.5;
constexpr double share_of_change = 0.19;  // of x / x′
constexpr double arc_share_of_course = 0.01, arc_share_of_stop = 0.03;
constexpr double at_border = 1e-6;  // of a cell
constexpr double start_room = 1e-4;
constexpr double share_of_longest = 0.8;  // of the time, up to the place of a standstill that ends a long plan
// Rounds of tightening cost time, and from a moving start they do not always end: most need none from here.
constexpr double command_tightening = 1.001;
constexpr double stops_ahead = 4;
// From a moving start the plan in hand stays where none is found, and time is short: most plans take below 80.
constexpr int most_iterations = 150;

double square(double v) {
    return v * v;
}

}  // namespace

PathPlace LivePlanner::State::standing_place() const {
    if (now_.steps.empty()) return grid_[0].begin;
    const Cell& last = now_.steps.back().cell;
    return {last.begin.piece, last.begin.offset_mm + last.length_mm};
}

bool LivePlanner::State::stands_at_end() const {
    return grid_.distance_mm(standing_place()) >= path_.length_mm() - same_place_mm;
}

std::size_t LivePlanner::State::step_at(double time_s) const {
    const auto next = std::upper_bound(now_.steps.begin() + 1, now_.steps.end(), time_s,
                                       [](double t, const Step& step) { return t < step.piece.begin_s; });
    return static_cast<std::size_t>(next - now_.steps.begin()) - 1;
}

LivePlanner::State::Branch LivePlanner::State::branch_at(double time_s) const {
    Branch out;
    std::size_t k = step_at(time_s);
    double delta = motion::distance_at(now_.steps[k].piece, time_s - now_.steps[k].piece.begin_s);
    const double until = k + 1 < now_.steps.size() ? now_.steps[k + 1].piece.begin_s : now_.end_s;
    const double reach = motion::distance_at(now_.steps[k].piece, until - now_.steps[k].piece.begin_s);
    out.begin_s = time_s;
    if (k + 1 < now_.steps.size() && reach - delta < at_border * reach) {
        ++k;
        delta = 0;
        out.begin_s = now_.steps[k].piece.begin_s;
    } else if (delta < at_border * reach) {
        delta = 0;
        out.begin_s = now_.steps[k].piece.begin_s;
    }
    const Step& step = now_.steps[k];
    const motion::PathState state = motion::state_at(step.piece, delta);
    out.kept = delta > 0 ? k + 1 : k;
    out.place = {step.cell.begin.piece, step.cell.begin.offset_mm + delta};
    out.start = {square(state.speed_mm_s), 2 * state.acceleration_mm_s2};
    out.at_rest = !(state.speed_mm_s > 0);
    return out;
}

/// The last step of the plan in hand that begins before a place.
const LivePlanner::State::Step* LivePlanner::State::step_over(double p_mm) const {
    const auto next =
        std::upper_bound(now_.steps.begin(), now_.steps.end(), p_mm + same_place_mm,
                         [this](double p, const Step& step) { return p < grid_.distance_mm(step.cell.begin); });
    return next == now_.steps.begin() ? nullptr : &*(next - 1);
}

LivePlanner::State::Pace LivePlanner::State::pace_in_hand(double p_mm) const {
    const Step* step = step_over(p_mm);
    return step ? step->pace : Pace{0, 0};
}

/// The plan in hand at a place; x = 0 where it has none or comes to its standstill.
MovingStart LivePlanner::State::state_in_hand(double p_mm) const {
    const Step* step = step_over(p_mm);
    if (!step || step->piece.kind == ProfilePiece::Kind::rest_stop) return {};
    const double delta = p_mm - grid_.distance_mm(step->cell.begin);
    if (delta > step->piece.length_mm) return {};
    const motion::PathState state = motion::state_at(step->piece, std::max(delta, 0.0));
    return {square(state.speed_mm_s), 2 * state.acceleration_mm_s2};
}

/// Whether the window reaches the goal, or half as far again.
bool LivePlanner::State::is_exact(const Branch& branch, const Trial& trial) const {
    const std::size_t window = window_of(trial);
    return grid_.index_of(trial.goal) - grid_.index_of(branch.place) < window + window / 2;
}

/// Cells for a command, which must be planned soon: some stops ahead, whatever longer ways take.
std::size_t LivePlanner::State::window_for(const Branch& branch, const Look& look) const {
    const double far_mm = grid_.distance_mm(branch.place) + stops_ahead * look.stop_mm;
    const std::size_t cells = grid_.index_of(grid_.place_at(far_mm)) - grid_.index_of(branch.place);
    return std::clamp(cells, base_, window_);
}

Course LivePlanner::State::course(const Branch& branch, const Trial& trial) const {
    Course out;
    out.from = branch.place;
    out.from_rest = branch.at_rest;
    out.exact_stop = is_exact(branch, trial);
    out.to = trial.goal;
    if (!out.exact_stop) {
        const std::size_t window = window_of(trial), end = grid_.index_of(branch.place) + window;
        std::size_t longest = end - window / 10 - 1;
        for (std::size_t k = longest; k < end; ++k)
            if (grid_[k].length_mm > grid_[longest].length_mm) longest = k;
        out.to = grid_.end_of(longest);
    }
    const double way = grid_.distance_mm(out.to) - grid_.distance_mm(out.from);
    out.largest_arc_mm = (trial.stand ? arc_share_of_stop : arc_share_of_course) * way;
    if (branch.at_rest)
        out.begin.push_back({0, 0, rest_growth});
    else
        out.begin.push_back({share_of_change * branch.start.x / std::abs(branch.start.d), 0, rest_growth});
    if (trial.stop_mm > 0)
        out.begin.push_back({trial.stop_mm / cells_of_a_stop, flat_of_a_stop * trial.stop_mm, command_growth});
    if (trial.old_pace_until_mm > grid_.distance_mm(out.from) && trial.old_pace_until_mm < grid_.distance_mm(out.to))
        out.focus = {grid_.place_at(trial.old_pace_until_mm), trial.level_mm};
    if (out.exact_stop) out.end.push_back({0, 0, trial.stand ? stop_growth : rest_growth});
    return out;
}

/// x at the middles of the first cells.
void LivePlanner::State::make_guess(const Branch& branch, const Guess& guess, std::span<const Cell> cells) {
    known_middle_.clear();
    if (branch.at_rest || guess.blank) return;
    const double here = grid_.distance_mm(branch.place);
    for (const Cell& cell : cells) {
        const double way = grid_.distance_mm(cell.begin) + cell.length_mm / 2 - here;
        double x = state_in_hand(here + guess.compression * way).x;
        if (guess.braking) {
            const double braking = guess.braking->x_at(std::max(way - guess.delay_mm, 0.0));
            x = x > 0 ? std::min(x, braking) : braking;
        }
        known_middle_.push_back(x);
    }
}

/// Limits and caps a trifle above what plans are made for, as far as the state of the plan in hand needs it: a plan is
/// checked between samples and may stand there a little above what a solve would take as its start.
LimitSet LivePlanner::State::room_for(MovingStart start, const PathSample& here) const {
    const auto room = [](double ratio) { return std::clamp(ratio * (1 + start_room), 1.0, 1 / kept_back); };
    LimitSet out = limits_;
    for (int c = 0; c < coordinates; ++c) {
        machine::AxisLimits& limit = out.of[c];
        limit.velocity *= room(std::abs(here.q1[c]) * std::sqrt(start.x) / limit.velocity);
        limit.acceleration *= room(std::abs(here.q2[c] * start.x + here.q1[c] * start.d / 2) / limit.acceleration);
    }
    return out;
}

/// The course to a standstill on the way of a plan that lasts too long.
Course LivePlanner::State::nearer(const Branch& branch, Course way, const std::vector<Step>& steps) const {
    const double until_s = branch.begin_s + share_of_longest * longest_plan_s_;
    const auto behind = std::upper_bound(steps.begin() + 1, steps.end(), until_s,
                                         [](double t, const Step& step) { return t < step.piece.begin_s; });
    const Step& step = *(behind - 1);
    way.to = {step.cell.begin.piece,
              step.cell.begin.offset_mm + motion::distance_at(step.piece, until_s - step.piece.begin_s)};
    way.exact_stop = true;
    way.end.push_back({0, 0, rest_growth});
    if (way.focus && grid_.distance_mm(way.focus->place) >= grid_.distance_mm(way.to)) way.focus.reset();
    way.largest_arc_mm =
        std::min(way.largest_arc_mm, arc_share_of_course * (grid_.distance_mm(way.to) - grid_.distance_mm(way.from)));
    return way;
}

/// Plans a window and takes the plan over if it is safe.
Result<bool> LivePlanner::State::plan(const Branch& branch, const Trial& trial, const Wish& made_for) {
    const Course way = course(branch, trial);
    auto steps = solve(branch, trial, way);
    if (!steps) return fail(steps.error());
    if (steps->empty()) return false;
    now_.ends_at_goal = way.exact_stop && !trial.stand;
    if (end_of(*steps) - branch.begin_s > longest_plan_s_) {
        auto shorter = solve(branch, trial, nearer(branch, way, *steps));
        if (!shorter) return fail(shorter.error());
        if (!shorter->empty()) {
            steps = std::move(shorter);
            now_.ends_at_goal = false;
        }
    }
    now_.waits = now_.ends_at_goal && single_block_;
    now_.made_for = made_for;
    next_trial_ = ticks_;
    if (single_block_ && !trial.stand) now_.block_goal = trial.goal;
    adopt(branch, std::move(*steps));
    return true;
}

/// The steps along a course, with their times; none where no safe plan was found.
Result<std::vector<LivePlanner::State::Step>> LivePlanner::State::solve(const Branch& branch, const Trial& trial,
                                                                        const Course& way) {
    const std::vector<Cell> cells = grid_.cells(way);
    std::vector<Step> steps(cells.size());
    std::vector<Interval> intervals;
    intervals.reserve(cells.size());
    for (std::size_t k = 0; k < cells.size(); ++k) {
        const double p = grid_.distance_mm(cells[k].begin);
        steps[k].cell = cells[k];
        steps[k].pace = p < trial.old_pace_until_mm ? trial.pace.or_faster(pace_in_hand(p)) : trial.pace;
        auto sampled = sample(cells[k], steps[k].pace);
        if (!sampled) return fail(sampled.error());
        intervals.push_back(std::move(*sampled));
    }
    make_guess(branch, trial.guess, cells);
    const LimitSet limits = branch.at_rest ? limits_ : room_for(branch.start, intervals.front().samples.front());
    Tightening ahead;
    if (trial.stop_mm > 0)
        for (Tightening::OfSamples& factors : ahead.jerk) factors.fill(command_tightening);
    std::vector<Tightening> tightening(cells.size(), ahead);
    WindowProblem window;
    window.intervals = intervals;
    window.tightening = tightening;
    window.limits = &limits;
    window.calm = calm_;
    window.from_rest = branch.at_rest;
    window.x0 = branch.start.x;
    window.d0 = branch.start.d;
    window.known_middle = known_middle_;
    if (!branch.at_rest) window.most_iterations = most_iterations;
    const bool is_left_before = !way.exact_stop || (end_ && !trial.stand);
    if (is_left_before) window.far_from = cells.size() / 2;
    const WindowPlan made = solver_.solve(window);
    if (!made.safe) return std::vector<Step>();
    double time = branch.begin_s;
    for (std::size_t k = 0; k < cells.size(); ++k) {
        ProfilePiece& piece = steps[k].piece = made.pieces[k];
        piece.begin_s = time;
        piece.duration_s = motion::time_to(piece, piece.length_mm);
        time += piece.duration_s;
    }
    return steps;
}

void LivePlanner::State::adopt(const Branch& branch, std::vector<Step> steps) {
    ++plans_;
    failed_trials_ = 0;
    next_lift_ = 0;
    now_.end_s = end_of(steps);
    const std::size_t present = now_.steps.empty() || branch.at_rest ? 0 : step_at(present_s());
    now_.steps.resize(branch.at_rest ? 0 : branch.kept);
    now_.steps.erase(now_.steps.begin(),
                     now_.steps.begin() + static_cast<std::ptrdiff_t>(std::min(present, now_.steps.size())));
    const std::size_t first = now_.steps.size();
    now_.steps.insert(now_.steps.end(), steps.begin(), steps.end());
    const std::size_t count = commit_count(first);
    if (!now_.ends_at_goal && count < steps.size() / 8 && window_ < largest_growth * base_) window_ *= 2;
    now_.border = first + std::max<std::size_t>(count, 1);
}

/// How much of a new plan a longer one would leave as it is, see FeedPlanner.
std::size_t LivePlanner::State::commit_count(std::size_t first) const {
    const auto x0 = [this](std::size_t k) { return now_.steps[k].piece.x0; };
    double stopping = 0, rise = 0;
    for (std::size_t k = now_.steps.size(); k-- > first + 1 && x0(k) >= rise;) {
        stopping += now_.steps[k].piece.length_mm;
        rise = x0(k);
    }
    std::size_t count = now_.steps.size();
    for (double left = 0; count > first && left < tail_of_stopping_distance * stopping; --count)
        left += now_.steps[count - 1].piece.length_mm;
    return std::min(count - first, (now_.steps.size() - first) / 2);
}

}  // namespace trunnion::feed
