#include "detail/screening.hpp"

#include <algorithm>
#include <cmath>

namespace trunnion::feed {
namespace {

double speed_bound(const PathSample& s, const LimitSet& limits) {
    double inverse = 0;
    for (int c = 0; c < coordinates; ++c) {
        const double rate = s.q1[c] / limits.of[c].velocity;
        inverse = std::max(inverse, rate * rate);
    }
    return 1 / inverse;
}

bool bounded(double limit) {
    return limit < LimitSet::unbounded;
}

/// Largest |x′| at x ≤ `x`.
double largest_slope(const PathSample& s, const LimitSet& limits, double x) {
    double slope = LimitSet::unbounded;
    for (int c = 0; c < coordinates; ++c) {
        const double limit = limits.of[c].acceleration, q1 = std::abs(s.q1[c]);
        if (bounded(limit) && q1 > 0) slope = std::min(slope, 2 * (limit + std::abs(s.q2[c]) * x) / q1);
    }
    return slope;
}

/// The coordinate with the largest |q′| per unit of the limit.
template <class Limit>
int leader(const PathSample& s, const Limit& limit_of) {
    int best = -1;
    double most = 0;
    for (int c = 0; c < coordinates; ++c) {
        const double rate = std::abs(s.q1[c]) / limit_of(c);
        if (rate > most) {
            most = rate;
            best = c;
        }
    }
    return best;
}

double largest_x(const PathSample& s, const LimitSet& limits) {
    double x = speed_bound(s, limits);
    for (int i = 0; i < coordinates; ++i) {
        const double ai = limits.of[i].acceleration;
        if (!bounded(ai)) continue;
        const double bi = s.q2[i] / ai, ci = 0.5 * s.q1[i] / ai;
        if (ci == 0 && std::abs(bi) * x > 1) x = 1 / std::abs(bi);
        for (int j = i + 1; j < coordinates; ++j) {
            const double aj = limits.of[j].acceleration;
            const double bj = s.q2[j] / aj, cj = 0.5 * s.q1[j] / aj;  // 0 where unbounded
            const double cross = std::abs(bi * cj - bj * ci), room = std::abs(ci) + std::abs(cj);
            if (cross * x > room && room > 0) x = room / cross;
        }
    }
    return x;
}

}  // namespace

Extent largest_motion(const PathSample& s, const LimitSet& limits) {
    const double x = largest_x(s, limits);
    return {x, largest_slope(s, limits, x)};
}

NeededRows needed_rows(const PathSample& s, const LimitSet& limits) {
    constexpr double certainly_inside = 0.999;
    const auto [x, slope] = largest_motion(s, limits);
    const double by_q3 = x * std::sqrt(x), by_q2 = 1.5 * slope * std::sqrt(x);
    const int jerk_leader = leader(s, [&](int c) { return limits.of[c].jerk; });
    const int leading = leader(s, [&](int c) { return limits.of[c].acceleration; });
    NeededRows out;
    for (int c = 0; c < coordinates; ++c) {
        const machine::AxisLimits& limit = limits.of[c];
        const bool still = s.q1[c] == 0 && s.q2[c] == 0 && s.q3[c] == 0;
        if (bounded(limit.jerk) && !still) {
            const double r = jerk_leader < 0 ? 0 : s.q1[c] / s.q1[jerk_leader];
            const double from_leader = jerk_leader < 0 ? 0 : std::abs(r) * limits.of[jerk_leader].jerk;
            const double d3 = jerk_leader < 0 ? s.q3[c] : s.q3[c] - r * s.q3[jerk_leader],
                         d2 = jerk_leader < 0 ? s.q2[c] : s.q2[c] - r * s.q2[jerk_leader];
            const double load = from_leader + std::abs(d3) * by_q3 + (d2 == 0 ? 0 : std::abs(d2) * by_q2);
            if (c == jerk_leader || !(load < certainly_inside * limit.jerk)) out.jerk |= 1u << c;
        }
        if (bounded(limit.acceleration) && !still) {
            const double r = leading < 0 ? 0 : s.q1[c] / s.q1[leading];
            const double from_leader = leading < 0 ? 0 : std::abs(r) * limits.of[leading].acceleration;
            const double d2 = leading < 0 ? s.q2[c] : s.q2[c] - r * s.q2[leading];
            const double load = from_leader + std::abs(d2) * x;
            if (c == leading || !(load < certainly_inside * limit.acceleration)) out.acceleration |= 1u << c;
        }
    }
    return out;
}

}  // namespace trunnion::feed
