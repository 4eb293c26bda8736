#include "detail/rest_arc.hpp"

#include <algorithm>
#include <cmath>

namespace trunnion::feed {
namespace {

const double alpha_of_unit_jerk = std::pow(6.0, 4.0 / 3) / 4;

double sign_of(RestSide side) {
    return side == RestSide::start ? 1 : -1;
}

double speed_alpha(const PathSample& s, double u, const LimitSet& limits, const Tightening& tight) {
    double inverse_cap = 1 / s.feed_cap;
    for (int a = 0; a < limits.count; ++a) {
        const double rate = s.q1[a] / limits.axes[a].velocity;
        inverse_cap = std::max(inverse_cap, rate * rate);
    }
    return 1 / (tight.speed * inverse_cap * u * std::cbrt(u));
}

double acceleration_alpha(const PathSample& s, double u, RestSide side, const LimitSet& limits,
                          const Tightening& tight) {
    const double u13 = std::cbrt(u);
    double inverse = 0;
    for (int a = 0; a < limits.count; ++a) {
        const double load = std::abs(s.q2[a] * u * u13 + sign_of(side) * 2.0 / 3 * s.q1[a] * u13);
        inverse = std::max(inverse, tight.acceleration[a] * load / limits.axes[a].acceleration);
    }
    return 1 / inverse;
}

double jerk_alpha(const PathSample& s, double u, RestSide side, const LimitSet& limits, const Tightening& tight) {
    const double sign = sign_of(side);
    double inverse = 0;
    for (int a = 0; a < limits.count; ++a) {
        const double load = std::abs(sign * (s.q1[a] + 4.5 * u * u * s.q3[a]) + 9 * u * s.q2[a]);
        inverse = std::max(inverse, tight.jerk[a] * load / limits.axes[a].jerk);
    }
    return arc_alpha(1 / inverse);
}

}  // namespace

double arc_alpha(double jerk) {
    return alpha_of_unit_jerk * std::cbrt(jerk * jerk);
}

double arc_jerk_mm_s3(double alpha) {
    const double ratio = alpha / alpha_of_unit_jerk;
    return ratio * std::sqrt(ratio);
}

double largest_alpha(const Interval& interval, RestSide side, const LimitSet& limits, const Tightening& tightening) {
    double alpha = std::numeric_limits<double>::max();
    const auto hold_at = [&](double u, const PathSample& s) {
        alpha = std::min(alpha, jerk_alpha(s, u, side, limits, tightening));
        if (u == 0) return;
        alpha = std::min(
            {alpha, speed_alpha(s, u, limits, tightening), acceleration_alpha(s, u, side, limits, tightening)});
    };
    for (int i = 0; i < samples_per_interval; ++i) {
        const int from_rest = side == RestSide::start ? i : samples_per_interval - 1 - i;
        hold_at(interval.length_mm * from_rest / (samples_per_interval - 1), interval.samples[i]);
    }
    for (const NearRest& near : interval.near_rest) hold_at(near.from_rest_mm, near.sample);
    return alpha;
}

double rest_alpha(const PathSample& rest, const LimitSet& limits) {
    return jerk_alpha(rest, 0, RestSide::start, limits, {});
}

bool is_jerk_phase(const PathSample& sample, double u, RestSide side, const LimitSet& limits, double alpha) {
    constexpr double nearly = 0.985, half_way_to_acceleration = 1.26, half_the_speed = 4;
    return jerk_alpha(sample, u, side, limits, {}) >= nearly * alpha &&
           acceleration_alpha(sample, u, side, limits, {}) >= half_way_to_acceleration * alpha &&
           speed_alpha(sample, u, limits, {}) >= half_the_speed * alpha;
}

ArcJoint arc_joint(const Interval& interval, RestSide side, const LimitSet& limits, const Tightening& tightening) {
    const double h = interval.length_mm;
    return {4 / (3 * h), largest_alpha(interval, side, limits, tightening) * h * std::cbrt(h), 3 * h};
}

}  // namespace trunnion::feed
