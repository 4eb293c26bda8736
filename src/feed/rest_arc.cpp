#include "detail/rest_arc.hpp"

#include <algorithm>
#include <cmath>

#include "detail/bernstein.hpp"

namespace trunnion::feed {
namespace {

const double alpha_of_unit_jerk = std::pow(6.0, 4.0 / 3) / 4;

double sign_of(RestSide side) {
    return side == RestSide::start ? 1 : -1;
}

/// Bounds over an arc with α = 1 (and j of that α = 1 taken apart): of every coordinate √x-, x- and jerk-like loads.
struct UnitLoads {
    double velocity = 0, acceleration = 0, jerk = 0;  ///< per √α, per α, per j
};
using AllUnitLoads = std::array<UnitLoads, coordinates>;

template <std::size_t n>
double hull(const std::array<double, n>& f) {
    double out = 0;
    for (const double value : f) out = std::max(out, std::abs(value));
    return std::isfinite(f[0] + f[n - 1]) ? out : LimitSet::unbounded;
}

/// Takes over the loads between two places at u0 < u1 from the rest.
void add_segment(double u0, const PathSample& s0, double u1, const PathSample& s1, double sign, AllUnitLoads& out) {
    const double h = u1 - u0, u13 = std::cbrt(u1);
    const Bernstein<double, 1> u{u0, u1};
    const Bernstein<double, 2> u2{u0 * u0, u0 * u1, u1 * u1};
    for (int c = 0; c < coordinates; ++c) {
        if (s0.q1[c] == 0 && s1.q1[c] == 0 && s0.q2[c] == 0 && s1.q2[c] == 0) continue;
        const Bernstein<double, 5> q1 =
            quintic(sign * s0.q1[c], s0.q2[c], sign * s0.q3[c], sign * s1.q1[c], s1.q2[c], sign * s1.q3[c], h);
        const Bernstein<double, 4> q2 = derivative(q1, h);
        const Bernstein<double, 3> q3 = derivative(q2, h);
        Bernstein<double, 5> jerk = q1, acceleration{};
        add_product(9, u, q2, jerk);
        add_product(4.5, u2, q3, jerk);
        add_product(1, u, q2, acceleration);
        for (int i = 0; i < 6; ++i) acceleration[i] += 2.0 / 3 * q1[i];
        out[c].velocity = std::max(out[c].velocity, u13 * u13 * hull(q1));
        out[c].acceleration = std::max(out[c].acceleration, u13 * hull(acceleration));
        out[c].jerk = std::max(out[c].jerk, hull(jerk));
    }
}

AllUnitLoads unit_loads(const Interval& interval, RestSide side) {
    AllUnitLoads out{};
    const double sign = sign_of(side);
    for (std::size_t k = 1; k < interval.arc.size(); ++k) {
        const ArcSample &a = interval.arc[k - 1], &b = interval.arc[k];
        add_segment(a.from_rest_mm, a.sample, b.from_rest_mm, b.sample, sign, out);
    }
    for (int k = 1; interval.arc.empty() && k < samples_per_interval; ++k) {
        const double step = interval.length_mm / (samples_per_interval - 1);
        const int from = side == RestSide::start ? k - 1 : samples_per_interval - k,
                  to = side == RestSide::start ? k : samples_per_interval - 1 - k;
        add_segment((k - 1) * step, interval.samples[from], k * step, interval.samples[to], sign, out);
    }
    return out;
}

double speed_alpha(const PathSample& s, double u, const LimitSet& limits) {
    double inverse = 0;
    for (int c = 0; c < coordinates; ++c) {
        const double rate = s.q1[c] / limits.of[c].velocity;
        inverse = std::max(inverse, rate * rate);
    }
    return 1 / (inverse * u * std::cbrt(u));
}

double acceleration_alpha(const PathSample& s, double u, RestSide side, const LimitSet& limits) {
    const double u13 = std::cbrt(u);
    double inverse = 0;
    for (int c = 0; c < coordinates; ++c) {
        const double load = std::abs(s.q2[c] * u * u13 + sign_of(side) * 2.0 / 3 * s.q1[c] * u13);
        inverse = std::max(inverse, load / limits.of[c].acceleration);
    }
    return 1 / inverse;
}

double jerk_alpha(const PathSample& s, double u, RestSide side, const LimitSet& limits) {
    const double sign = sign_of(side);
    double inverse = 0;
    for (int c = 0; c < coordinates; ++c) {
        const double load = std::abs(sign * (s.q1[c] + 4.5 * u * u * s.q3[c]) + 9 * u * s.q2[c]);
        inverse = std::max(inverse, load / limits.of[c].jerk);
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

LargestAlpha largest_alpha(const Interval& interval, RestSide side, const LimitSet& limits) {
    LargestAlpha out{std::numeric_limits<double>::max(), {}};
    const auto take = [&](double alpha, LimitName::Order order, int coordinate) {
        if (!(alpha < out.alpha)) return;
        out = {alpha, {order, coordinate}};
    };
    const AllUnitLoads loads = unit_loads(interval, side);
    for (int c = 0; c < coordinates; ++c) {
        const machine::AxisLimits& limit = limits.of[c];
        const double rate = loads[c].velocity / limit.velocity;
        take(1 / (rate * rate), LimitName::Order::velocity, c);
        take(limit.acceleration / loads[c].acceleration, LimitName::Order::acceleration, c);
        take(arc_alpha(limit.jerk / loads[c].jerk), LimitName::Order::jerk, c);
    }
    return out;
}

std::array<Peaks::OfCoordinate, coordinates> arc_loads(const Interval& interval, RestSide side, const LimitSet& limits,
                                                       double alpha) {
    const AllUnitLoads loads = unit_loads(interval, side);
    std::array<Peaks::OfCoordinate, coordinates> out;
    for (int c = 0; c < coordinates; ++c)
        out[c] = {std::sqrt(alpha) * loads[c].velocity / limits.of[c].velocity,
                  alpha * loads[c].acceleration / limits.of[c].acceleration,
                  arc_jerk_mm_s3(alpha) * loads[c].jerk / limits.of[c].jerk};
    return out;
}

double rest_alpha(const PathSample& rest, const LimitSet& limits) {
    return jerk_alpha(rest, 0, RestSide::start, limits);
}

bool is_jerk_phase(const PathSample& sample, double u, RestSide side, const LimitSet& limits, double alpha) {
    constexpr double nearly = 0.985, half_way_to_acceleration = 1.26, half_the_speed = 4;
    return jerk_alpha(sample, u, side, limits) >= nearly * alpha &&
           acceleration_alpha(sample, u, side, limits) >= half_way_to_acceleration * alpha &&
           speed_alpha(sample, u, limits) >= half_the_speed * alpha;
}

ArcJoint arc_joint(const Interval& interval, RestSide side, const LimitSet& limits) {
    const double h = interval.length_mm;
    const LargestAlpha largest = largest_alpha(interval, side, limits);
    return {4 / (3 * h), largest.alpha * h * std::cbrt(h), 3 * h, largest.held_by};
}

}  // namespace trunnion::feed
