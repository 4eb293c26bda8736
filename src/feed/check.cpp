#include "detail/check.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "detail/rest_arc.hpp"

namespace trunnion::feed {
namespace {

using motion::ProfilePiece;
using Samples = std::array<double, samples_per_interval>;

/// ṗ² and what the limits need of it: x, x′, √x, x″√x (= 2 p⃛; finite at rest).
struct Motion {
    double x, d, root, e_root;
};

Motion arc_motion(double u, double sign, double jerk) {
    const double alpha = arc_alpha(jerk), u13 = std::cbrt(u), x = alpha * u * u13;
    return {x, sign * 4.0 / 3 * alpha * u13, std::sqrt(x), 2 * jerk};
}

Motion motion_at(const ProfilePiece& piece, double delta) {
    if (piece.kind == ProfilePiece::Kind::rest_start) return arc_motion(delta, 1, piece.jerk_mm_s3);
    if (piece.kind == ProfilePiece::Kind::rest_stop) return arc_motion(piece.length_mm - delta, -1, piece.jerk_mm_s3);
    const double third = (piece.e1 - piece.e0) / piece.length_mm, e = piece.e0 + delta * third;
    const double x = piece.x0 + delta * (piece.d0 + delta * (piece.e0 / 2 + delta * third / 6));
    const double root = std::sqrt(std::max(x, 0.0));
    return {x, piece.d0 + delta * (piece.e0 + delta * third / 2), root, e * root};
}

/// Largest third difference of the samples around sample i.
double third_difference(const Samples& f, int i) {
    double largest = 0;
    for (int k = std::max(i - 2, 0); k <= std::min(i - 1, samples_per_interval - 4); ++k)
        largest = std::max(largest, std::abs(f[k + 3] - f[k] - 3 * (f[k + 2] - f[k + 1])));
    return largest;
}

/// What a parabola leaves out of a rest arc's load, in third differences: the largest of |t(t² − 1)|/6. Arcs are not
/// gridded finer where the path turns, and have no freedom to follow it.
constexpr double left_out_of_arcs = 0.064;

/// Largest |f| by the samples and by the parabolas through every three of them that turn near the limit, plus
/// `left_out` third differences; infinite where a sample is not finite.
double peak(const Samples& f, double left_out) {
    constexpr double near = 0.97;
    if (!std::isfinite(std::accumulate(f.begin(), f.end(), 0.0))) return std::numeric_limits<double>::infinity();
    double largest = std::max(std::abs(f.front()), std::abs(f.back()));
    for (int i = 1; i + 1 < samples_per_interval; ++i) {
        largest = std::max(largest, std::abs(f[i]));
        if (std::abs(f[i]) < near) continue;
        const double bend = f[i - 1] - 2 * f[i] + f[i + 1], tilt = (f[i + 1] - f[i - 1]) / 2;
        if (std::abs(tilt) < std::abs(bend))
            largest = std::max(largest, std::abs(f[i] - tilt * tilt / (2 * bend)) + left_out * third_difference(f, i));
    }
    return largest;
}

}  // namespace

double Peaks::worst() const {
    return std::max({feed, *std::ranges::max_element(velocity), *std::ranges::max_element(acceleration),
                     *std::ranges::max_element(jerk)});
}

namespace {

/// Loads of one axis at one place, of its limits.
struct Load {
    double velocity, acceleration, jerk;
};
Load load_of(const PathSample& s, const Motion& m, int axis, const machine::AxisLimits& limit) {
    return {s.q1[axis] * m.root / limit.velocity, (s.q2[axis] * m.x + 0.5 * s.q1[axis] * m.d) / limit.acceleration,
            ((s.q3[axis] * m.x + 1.5 * s.q2[axis] * m.d) * m.root + 0.5 * s.q1[axis] * m.e_root) / limit.jerk};
}

/// The places of an arc near its standstill.
void add_near_rest(const Interval& interval, const ProfilePiece& piece, const LimitSet& limits, Peaks& out) {
    for (const NearRest& near : interval.near_rest) {
        const bool start = piece.kind == ProfilePiece::Kind::rest_start;
        const Motion m = motion_at(piece, start ? near.from_rest_mm : piece.length_mm - near.from_rest_mm);
        for (int a = 0; a < limits.count; ++a) {
            const Load load = load_of(near.sample, m, a, limits.axes[a]);
            out.velocity[a] = std::max(out.velocity[a], std::abs(load.velocity));
            out.acceleration[a] = std::max(out.acceleration[a], std::abs(load.acceleration));
            out.jerk[a] = std::max(out.jerk[a], std::abs(load.jerk));
        }
    }
}

}  // namespace

Peaks peaks_of(const Interval& interval, const ProfilePiece& piece, const LimitSet& limits) {
    std::array<Motion, samples_per_interval> m;
    Peaks out;
    for (int i = 0; i < samples_per_interval; ++i) {
        m[i] = motion_at(piece, piece.length_mm * i / (samples_per_interval - 1));
        out.feed = std::max(out.feed, m[i].root / std::sqrt(interval.samples[i].feed_cap));
    }
    for (int a = 0; a < limits.count; ++a) {
        Samples velocity, acceleration, jerk;
        for (int i = 0; i < samples_per_interval; ++i) {
            const Load load = load_of(interval.samples[i], m[i], a, limits.axes[a]);
            velocity[i] = load.velocity;
            acceleration[i] = load.acceleration;
            jerk[i] = load.jerk;
        }
        const double left_out = piece.kind == ProfilePiece::Kind::cubic ? 0 : left_out_of_arcs;
        out.velocity[a] = peak(velocity, left_out);
        out.acceleration[a] = peak(acceleration, left_out);
        out.jerk[a] = peak(jerk, left_out);
    }
    if (piece.kind != ProfilePiece::Kind::cubic) add_near_rest(interval, piece, limits, out);
    return out;
}

bool is_positive(const ProfilePiece& piece) {
    if (piece.kind != ProfilePiece::Kind::cubic) return piece.jerk_mm_s3 > 0;
    const double h = piece.length_mm, x1 = motion_at(piece, h).x, d1 = piece.d0 + h * (piece.e0 + piece.e1) / 2;
    if (!(piece.x0 > 0 && x1 > 0)) return false;
    if (piece.x0 + h * piece.d0 / 3 > 0 && x1 - h * d1 / 3 > 0) return true;
    const double third = (piece.e1 - piece.e0) / h, root = piece.e0 * piece.e0 - 2 * third * piece.d0;
    if (root <= 0) return true;  // no inner extremum
    // The minimum is where x″ = +√root, in the form without cancellation.
    const double s = std::sqrt(root);
    const double at = piece.e0 >= 0 ? -2 * piece.d0 / (piece.e0 + s) : (s - piece.e0) / third;
    return !(at > 0 && at < h) || motion_at(piece, at).x > 0;
}

bool tighten(const Peaks& peaks, double trigger, double reserve, Tightening& tightening) {
    bool changed = false;
    const auto raise = [&](double ratio, double& factor) {
        if (!(ratio > trigger)) return;
        factor *= reserve * ratio;
        changed = true;
    };
    for (int a = 0; a < machine::max_axes; ++a) {
        raise(peaks.acceleration[a], tightening.acceleration[a]);
        raise(peaks.jerk[a], tightening.jerk[a]);
    }
    const double speed = std::max(peaks.feed, *std::ranges::max_element(peaks.velocity));
    if (speed > trigger) raise(speed * speed, tightening.speed);
    return changed;
}

void slow_down(std::span<ProfilePiece> pieces, double lambda) {
    for (ProfilePiece& piece : pieces) {
        piece.x0 *= lambda;
        piece.d0 *= lambda;
        piece.e0 *= lambda;
        piece.e1 *= lambda;
        piece.jerk_mm_s3 *= lambda * std::sqrt(lambda);
    }
}

double lambda_for(const Peaks& peaks) {
    const double velocity = std::max(peaks.feed, *std::ranges::max_element(peaks.velocity));
    const double jerk = std::cbrt(*std::ranges::max_element(peaks.jerk));
    return 1 / std::max({1.0, velocity * velocity, *std::ranges::max_element(peaks.acceleration), jerk * jerk});
}

}  // namespace trunnion::feed
