#include "detail/jerk_free.hpp"

#include <algorithm>
#include <cmath>

namespace trunnion::feed {
namespace {

using Rows = JerkFreeScan::Rows;
constexpr int steps = JerkFreeScan::steps_per_interval;

Rows rows_at(const PathSample& s, const LimitSet& limits) {
    Rows out;
    double inverse = 0;
    for (int c = 0; c < coordinates; ++c) {
        const machine::AxisLimits& limit = limits.of[c];
        const double rate = s.q1[c] / limit.velocity;
        inverse = std::max(inverse, rate * rate);
        if (!(limit.acceleration < LimitSet::unbounded) || (s.q1[c] == 0 && s.q2[c] == 0)) continue;
        const double scale = (s.q1[c] < 0 ? -1 : 1) / limit.acceleration;
        out.b[out.count] = s.q2[c] * scale;
        out.c[out.count++] = 0.5 * s.q1[c] * scale;
    }
    out.cap = 1 / inverse;
    return out;
}

/// The quintic between two samples, in its middle.
PathSample between(const PathSample& a, const PathSample& b, double h) {
    PathSample out;
    for (int c = 0; c < coordinates; ++c) {
        out.q1[c] = (a.q1[c] + b.q1[c]) / 2 + 5 * h / 32 * (a.q2[c] - b.q2[c]) + h * h / 64 * (a.q3[c] + b.q3[c]);
        out.q2[c] = 15 / (8 * h) * (b.q1[c] - a.q1[c]) - 7.0 / 16 * (a.q2[c] + b.q2[c]) + h / 32 * (b.q3[c] - a.q3[c]);
    }
    return out;
}

/// Where a step begins.
PathSample step_sample(const Interval& interval, std::size_t step) {
    const PathSample& before = interval.samples[step / 2];
    return step % 2 == 0 ? before : between(before, interval.samples[step / 2 + 1], interval.length_mm / 2);
}

/// Largest x for which some d satisfies all rows: every pair of an upper and a lower row bounds x.
double turning_ceiling(const Rows& r) {
    double x = r.cap;
    for (int i = 0; i < r.count; ++i) {
        if (r.c[i] == 0 && std::abs(r.b[i]) * x > 1) x = 1 / std::abs(r.b[i]);
        for (int j = i + 1; j < r.count; ++j) {
            const double cross = std::abs(r.b[i] * r.c[j] - r.b[j] * r.c[i]), room = r.c[i] + r.c[j];
            if (cross * x > room && room > 0) x = room / cross;
        }
    }
    return x;
}

/// Largest x from which a step h ends at or below `next`.
double controllable(const Rows& r, double next, double h) {
    double x = turning_ceiling(r);
    for (int i = 0; i < r.count; ++i) {
        const double slope = r.c[i] - h * r.b[i], room = r.c[i] * next + h;  // −1 ≤ b x + c d with d = (next − x)/h
        if (slope * x > room) x = room / slope;
    }
    return x;
}

double reachable(const Rows& r, double x, double h) {
    double d = std::numeric_limits<double>::infinity();
    for (int i = 0; i < r.count; ++i)
        if (r.c[i] > 0) d = std::min(d, (1 - r.b[i] * x) / r.c[i]);
    return x + h * d;
}

}  // namespace

double JerkFreeScan::advance(std::span<const Interval> window, std::size_t commit, bool last) {
    const std::size_t n = window.size();
    ceiling_.resize(n * steps + 1);
    rows_.resize(n * steps);
    ceiling_[n * steps] = last ? 0 : rows_at(window.back().samples.back(), limits_).cap;
    for (std::size_t k = n; k-- > 0;) {
        const double h = window[k].length_mm / steps;
        for (std::size_t i = steps, node = k * steps + i; i-- > 0;) {
            --node;
            rows_[node] = rows_at(step_sample(window[k], i), limits_);
            ceiling_[node] = controllable(rows_[node], ceiling_[node + 1], h);
        }
        // The limits behind a knot hold on its other side too.
        if (k > 0)
            ceiling_[k * steps] = std::min(ceiling_[k * steps], rows_at(window[k - 1].samples.back(), limits_).cap);
    }
    double time = 0;
    x_ = std::min(x_, ceiling_[0]);
    for (std::size_t node = 0; node < commit * steps; ++node) {
        const double h = window[node / steps].length_mm / steps;
        const double next = std::clamp(reachable(rows_[node], x_, h), 0.0, ceiling_[node + 1]);
        time += 2 * h / (std::sqrt(x_) + std::sqrt(next));
        x_ = next;
    }
    return time;
}

}  // namespace trunnion::feed
