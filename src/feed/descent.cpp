#include "detail/descent.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace trunnion::feed {
namespace {

constexpr int most_bisections = 40;
constexpr std::size_t strides_of_way_out = 30;
constexpr double bisection_end = 0.02;  // of a sample's step
constexpr double standing = 1e-6;       // of x at the start
constexpr double dead_end = 1.01;       // of a limit: where no x″ is allowed

/// Keeps |constant + factor e| ≤ bound.
struct Bound {
    double constant, factor, bound;
    double ratio(double e) const { return std::abs(constant + factor * e) / bound; }
};

/// What the limits say of x″ on a step h between two samples: jerk at its begin, acceleration at its end.
class Allowance {
  public:
    Allowance(const PathSample& here, const PathSample& next, const LimitSet& limits, MovingStart at, double h) {
        const double inverse_root = 1 / std::sqrt(at.x);
        for (std::size_t a = 0; a < coordinates; ++a) {
            bounds_[2 * a] = {here.q3[a] * at.x + 1.5 * here.q2[a] * at.d, 0.5 * here.q1[a],
                              limits.of[a].jerk * inverse_root};
            bounds_[2 * a + 1] = {next.q2[a] * (at.x + h * at.d) + 0.5 * next.q1[a] * at.d,
                                  next.q2[a] * h * h / 2 + 0.5 * next.q1[a] * h, limits.of[a].acceleration};
        }
        for (const Bound& b : bounds_) {
            if (std::abs(b.factor) < 1e-300) continue;
            const double centre = -b.constant / b.factor, reach = b.bound / std::abs(b.factor);
            low_ = std::max(low_, centre - reach);
            high_ = std::min(high_, centre + reach);
        }
        if (low_ > high_) low_ = high_ = (low_ + high_) / 2;  // nothing is allowed: the middle is the least wrong
    }
    double between(double part) const { return low_ + part * (high_ - low_); }
    double worst(double e) const {
        double out = 0;
        for (const Bound& b : bounds_) out = std::max(out, b.ratio(e));
        return out;
    }

  private:
    std::array<Bound, std::size_t{2} * coordinates> bounds_;
    double low_ = -std::numeric_limits<double>::infinity(), high_ = std::numeric_limits<double>::infinity();
};

/// From one sample to the next, half an interval on.
struct Stride {
    const PathSample *here, *next;
    double h;
};

std::vector<Stride> strides_of(std::span<const Interval> intervals) {
    std::vector<Stride> out;
    out.reserve(2 * intervals.size());
    for (const Interval& interval : intervals) {
        const PathSample* middle = &interval.samples[samples_per_interval / 2];
        out.push_back({&interval.samples.front(), middle, interval.length_mm / 2});
        out.push_back({middle, &interval.samples.back(), interval.length_mm / 2});
    }
    return out;
}

/// A place of a run: the state, and what it took to come there.
struct Knot {
    MovingStart at;
    double way = 0, worst = 0;
};

class Shooting {
  public:
    Shooting(std::span<const Interval> intervals, const LimitSet& limits, MovingStart start)
        : limits_(limits), strides_(strides_of(intervals)), floor_(standing * start.x) {
        braking_.push_back({start});
    }

    /// Runs with the lowest x″; `careful`: from which the highest one still leads out without breaking a limit.
    void brake(Braking braking) {
        for (std::size_t k = 0; k < strides_.size(); ++k) {
            if (braking == Braking::hardest) {
                const Knot next = step(k, braking_[k], 0);
                if (!(next.at.x > floor_)) return;
                braking_.push_back(next);
                continue;
            }
            Knot next, best;
            for (const double part : {0.0, 0.25, 0.5, 0.75, 1.0}) {
                next = step(k, braking_[k], part);
                const double worst = std::max(next.worst, way_out(k + 1, next));
                if (part == 0 || worst < best.worst) {
                    best = next;
                    best.worst = worst;
                }
                if (worst <= std::max(dead_end, braking_[k].worst)) break;
            }
            if (!(best.at.x > floor_)) return;
            braking_.push_back(best);
        }
    }

    enum class Outcome { level, stood, ran_out };
    struct Shot {
        Outcome outcome = Outcome::ran_out;
        Descent curve;
        bool within_cap = false;  // at its end
        double over_cap_mm = 0;   // up to there x was above the caps
    };

    /// The braking run up to a switching point, counted in strides; from there on the highest x″.
    Shot shot(double switch_at) const {
        Shot out;
        std::size_t k = std::min(static_cast<std::size_t>(switch_at), braking_.size() - 1);
        for (std::size_t i = 0; i <= k; ++i) note(i, braking_[i], out);
        Knot at = braking_[k];
        for (double mix = 1 - (switch_at - static_cast<double>(k)); k < strides_.size(); ++k, mix = 1) {
            const Allowance allowed = allowance(k, at);
            const double before = k + 1 < braking_.size() ? e_of(k) : allowed.between(0);
            const Knot next = taken(k, at, allowed, before + std::clamp(mix, 0.0, 1.0) * (allowed.between(1) - before));
            if (!(next.at.x > floor_)) {
                out.outcome = Outcome::stood;
                out.curve.length_mm = at.way + strides_[k].h * std::clamp(at.at.x / (at.at.x - next.at.x), 0.0, 1.0);
                break;
            }
            at = next;
            note(k + 1, at, out);
            if (at.at.d < 0) continue;
            out.outcome = Outcome::level;
            break;
        }
        out.curve.worst = at.worst;
        return out;
    }

    /// The shot with the earliest switch that is low enough.
    template <class Enough>
    std::optional<Shot> earliest(const Enough& enough) const {
        Shot best = shot(0);
        if (enough(best)) return best;
        double low = 0, high = static_cast<double>(braking_.size());
        best = shot(high);
        if (!enough(best)) return std::nullopt;
        for (int k = 0; k < most_bisections && high - low > bisection_end; ++k) {
            const double middle = (low + high) / 2;
            Shot tried = shot(middle);
            const bool down = enough(tried);
            (down ? high : low) = middle;
            if (down) best = std::move(tried);
        }
        return best;
    }

  private:
    Allowance allowance(std::size_t k, const Knot& from) const {
        const Stride& s = strides_[k];
        return {*s.here, *s.next, limits_, from.at, s.h};
    }
    Knot taken(std::size_t k, const Knot& from, const Allowance& allowed, double e) const {
        const double h = strides_[k].h;
        return {{from.at.x + h * (from.at.d + h * e / 2), from.at.d + h * e},
                from.way + h,
                std::max(from.worst, allowed.worst(e))};
    }
    Knot step(std::size_t k, const Knot& from, double part) const {
        const Allowance allowed = allowance(k, from);
        return taken(k, from, allowed, allowed.between(part));
    }
    double e_of(std::size_t k) const { return (braking_[k + 1].at.d - braking_[k].at.d) / strides_[k].h; }

    /// The worst of the limits on the way from here to where the speed does not fall any more.
    double way_out(std::size_t k, Knot at) const {
        const std::size_t end = std::min(k + strides_of_way_out, strides_.size());
        for (; k < end && at.at.x > floor_ && at.at.d < 0; ++k) at = step(k, at, 1);
        return at.worst;
    }

    void note(std::size_t knot, const Knot& at, Shot& out) const {
        out.curve.way_mm.push_back(at.way);
        out.curve.x.push_back(at.at.x);
        if (knot == 0) return;
        const double rate = strides_[knot - 1].next->q1[programmed_feed];
        out.within_cap = at.at.x * rate * rate <= 1;
        if (!out.within_cap) out.over_cap_mm = at.way;
    }

    const LimitSet& limits_;
    std::vector<Stride> strides_;
    double floor_;
    std::vector<Knot> braking_;
};

using Outcome = Shooting::Outcome;

}  // namespace

double Descent::x_at(double at_mm) const {
    if (at_mm >= way_mm.back()) return at_mm <= length_mm ? x.back() : 0;
    const auto next = std::upper_bound(way_mm.begin() + 1, way_mm.end(), at_mm);
    const std::size_t k = static_cast<std::size_t>(next - way_mm.begin()) - 1;
    const double part = (at_mm - way_mm[k]) / (way_mm[k + 1] - way_mm[k]);
    return x[k] + part * (x[k + 1] - x[k]);
}

std::optional<Descent> shortest_stop(std::span<const Interval> intervals, const LimitSet& limits, MovingStart start,
                                     Braking braking) {
    Shooting shooting(intervals, limits, start);
    shooting.brake(braking);
    auto shot = shooting.earliest([](const Shooting::Shot& s) { return s.outcome == Outcome::stood; });
    if (!shot) return std::nullopt;
    return std::move(shot->curve);
}

std::optional<Descent> shortest_descent(std::span<const Interval> intervals, const LimitSet& limits,
                                        MovingStart start) {
    Shooting shooting(intervals, limits, start);
    shooting.brake(Braking::hardest);
    auto shot = shooting.earliest([](const Shooting::Shot& s) {
        return s.outcome == Outcome::stood || (s.outcome == Outcome::level && s.within_cap);
    });
    if (!shot) return std::nullopt;
    shot->curve.length_mm = shot->over_cap_mm;
    return std::move(shot->curve);
}

bool must_stand(std::span<const Interval> intervals, const LimitSet& limits, MovingStart start) {
    return start.d < 0 && Shooting(intervals, limits, start).shot(0).outcome == Outcome::stood;
}

double stopping_distance_mm(double v, double a, double most_a, double most_j) {
    if (a < 0 && a * a / (2 * most_j) >= v) return 2.0 / 3 * v * v / -a;
    const double peak = std::min(std::max(most_a, a), std::sqrt(most_j * v + a * a / 2));
    const double t1 = (a + peak) / most_j, v1 = v + t1 * (a - most_j * t1 / 2);
    const double s1 = t1 * (v + t1 * (a / 2 - most_j * t1 / 6));
    const double t2 = std::max(0.0, (v1 - peak * peak / (2 * most_j)) / peak), s2 = t2 * (v1 - peak * t2 / 2);
    return s1 + s2 + peak * peak * peak / (6 * most_j * most_j);
}

}  // namespace trunnion::feed
