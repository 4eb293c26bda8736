#include "detail/window.hpp"

#include <algorithm>
#include <cmath>

#include "detail/rest_arc.hpp"

namespace trunnion::feed {
namespace {

using motion::ProfilePiece;

constexpr int max_iterations = 60, warm_iterations = 40, max_rounds = 30;
constexpr std::size_t intervals_an_iteration = 100;  // more of a long window
constexpr double gap = 3e-4;
constexpr double tightening_trigger = 1.0002;

ProfilePiece arc_piece(const Interval& interval, RestSide side, double joint_x) {
    ProfilePiece piece;
    piece.kind = side == RestSide::start ? ProfilePiece::Kind::rest_start : ProfilePiece::Kind::rest_stop;
    const double h = interval.length_mm;
    piece.jerk_mm_s3 = arc_jerk_mm_s3(joint_x / (h * std::cbrt(h)));
    return piece;
}

void place(const Interval& interval, ProfilePiece& piece) {
    piece.path_piece = interval.begin.piece;
    piece.path_offset_mm = interval.begin.offset_mm;
    piece.length_mm = interval.length_mm;
}

/// The worst of all peaks of a plan; infinite where something is not finite.
struct Verdict {
    double worst = 0, lambda = 1;
    bool positive = true;
    bool safe() const { return positive && worst <= allowed_ratio; }
};

Verdict examine(const WindowProblem& window, std::span<const ProfilePiece> pieces, std::vector<Peaks>& peaks) {
    static const Interest interest = interest_from(tightening_trigger);
    const LoadCheck check(*window.limits);
    Verdict out;
    peaks.resize(pieces.size());
    for (std::size_t k = 0; k < pieces.size(); ++k) {
        peaks[k] = check.peaks(window.intervals[k], pieces[k], interest);
        out.worst = std::max(out.worst, peaks[k].worst());
        out.lambda = std::min(out.lambda, lambda_for(peaks[k]));
        out.positive = out.positive && is_positive(pieces[k]);
    }
    out.positive = out.positive && std::isfinite(out.worst);
    return out;
}

bool tighten_all(const WindowProblem& window, std::span<const Peaks> peaks) {
    bool changed = false;
    for (std::size_t k = 0; k < peaks.size(); ++k)
        changed |= tighten(peaks[k], tightening_trigger, window.tightening[k]);
    return changed;
}

void forget_tightening(const WindowProblem& window) {
    for (Tightening& tightening : window.tightening) {
        Tightening none;
        none.needed = tightening.needed;
        tightening = none;
    }
}

void screen_rows(const WindowProblem& window) {
    for (std::size_t k = 0; k < window.intervals.size(); ++k) {
        auto& needed = window.tightening[k].needed;
        if (needed) continue;
        needed.emplace();
        for (int i = 0; i < samples_per_interval; ++i)
            (*needed)[i] = needed_rows(window.intervals[k].samples[i], *window.limits);
    }
}

double duration(std::span<const ProfilePiece> pieces) {
    double total = 0;
    for (const ProfilePiece& piece : pieces) total += motion::time_to(piece, piece.length_mm);
    return total;
}

}  // namespace

CoreProblem WindowSolver::core_of(const WindowProblem& window) const {
    CoreProblem core;
    core.intervals = window.intervals.subspan(window.first_core(), window.core_count());
    core.tightening = window.tightening.subspan(window.first_core(), window.core_count());
    core.limits = window.limits;
    core.calm = window.calm;
    core.far_from = std::max(window.far_from, window.first_core()) - window.first_core();
    core.from_rest = window.from_rest;
    if (window.from_rest) core.start = arc_joint(window.intervals.front(), RestSide::start, *window.limits);
    core.stop = arc_joint(window.intervals.back(), RestSide::stop, *window.limits);
    return core;
}

std::vector<ProfilePiece> WindowSolver::pieces_of(const WindowProblem& window, const Trajectory& core) const {
    const std::size_t n = window.core_count();
    std::vector<ProfilePiece> out;
    out.reserve(window.intervals.size());
    if (window.from_rest) out.push_back(arc_piece(window.intervals.front(), RestSide::start, core.x[0]));
    for (std::size_t k = 0; k < n; ++k) {
        ProfilePiece piece;
        piece.x0 = core.x[k];
        piece.d0 = core.d[k];
        piece.e0 = core.e0[k];
        piece.e1 = core.e1[k];
        out.push_back(piece);
    }
    out.push_back(arc_piece(window.intervals.back(), RestSide::stop, core.x[n]));
    for (std::size_t k = 0; k < out.size(); ++k) place(window.intervals[k], out[k]);
    return out;
}

/// Solves and tightens until every interval holds its limits everywhere, or the rounds are used up. Where the solver
/// gets lost after a tightening, of other motions maybe than are possible from here, it begins anew without any.
WindowPlan WindowSolver::improve(const WindowProblem& window) {
    WindowPlan plan;
    solver_->begin(core_of(window), start_);
    const int more = static_cast<int>(window.intervals.size() / intervals_an_iteration);
    int patience = max_iterations + more;
    for (bool anew = false;; ++plan.rounds) {
        const SolveReport report = solver_->run(gap, std::min(patience, window.most_iterations - plan.iterations));
        plan.iterations += report.iterations;
        plan.fallback = !report.converged;
        if (!report.converged && plan.rounds > 0 && !anew && plan.iterations < window.most_iterations) {
            anew = true;
            forget_tightening(window);
            patience = max_iterations + more;
            solver_->begin(core_of(window), start_);
            continue;
        }
        plan.pieces = pieces_of(window, solver_->trajectory());
        plan.safe = examine(window, plan.pieces, peaks_).safe();
        if (plan.safe || !report.converged || plan.rounds >= max_rounds) return plan;
        if (!tighten_all(window, peaks_)) return plan;
        patience = warm_iterations + more;
        solver_->retighten(core_of(window));
    }
}

WindowPlan WindowSolver::solve(const WindowProblem& window) {
    screen_rows(window);
    const CoreProblem core = core_of(window);
    make_start_profile(window, core, start_);
    WindowPlan plan = improve(window);
    if (plan.safe || !window.from_rest) return plan;
    // A profile with x > 0 becomes feasible when it is slowed down enough; the faster of the two that are at hand is
    // taken.
    plan.fallback = true;
    std::vector<ProfilePiece> slow = pieces_of(window, start_);
    slow_down(slow, examine(window, slow, peaks_).lambda);
    const Verdict verdict = examine(window, plan.pieces, peaks_);
    if (verdict.positive) slow_down(plan.pieces, verdict.lambda);
    if (!verdict.positive || duration(slow) < duration(plan.pieces)) plan.pieces = std::move(slow);
    plan.safe = examine(window, plan.pieces, peaks_).safe();
    return plan;
}

}  // namespace trunnion::feed
