#include "detail/start_profile.hpp"

#include <algorithm>
#include <cmath>

namespace trunnion::feed {
namespace {

constexpr double share = 0.6;  // of the limits
constexpr double averaging_reach = 0.35;
constexpr double smallest = 1e-300;

/// What an interval allows: y itself, and its slope as min(flat, by_acceleration / ∛y, by_turn / y).
struct Allowance {
    double y, flat, by_acceleration, by_turn;
    double slope(double at_y) const {
        const double y_safe = std::max(at_y, smallest);
        return std::min({flat, by_acceleration / std::cbrt(y_safe), by_turn / y_safe});
    }
};

double power_3_4(double x) {
    const double root = std::sqrt(x);
    return root * std::sqrt(root);
}
double power_4_3(double y) {
    return y * std::cbrt(y);
}

Allowance allowance(const Interval& interval, const LimitSet& limits) {
    double inverse_x = 0, jerk1 = smallest, acceleration1 = smallest, jerk2 = smallest, jerk3 = 0;
    for (const PathSample& s : interval.samples)
        for (int c = 0; c < coordinates; ++c) {
            const machine::AxisLimits& limit = limits.of[c];
            const double q1 = std::abs(s.q1[c]), q2 = std::abs(s.q2[c]), rate = q1 / limit.velocity;
            inverse_x = std::max({inverse_x, rate * rate, 2 * q2 / limit.acceleration});
            jerk3 = std::max(jerk3, std::abs(s.q3[c]) / limit.jerk);
            jerk1 = std::max(jerk1, q1 / limit.jerk);
            acceleration1 = std::max(acceleration1, q1 / limit.acceleration);
            jerk2 = std::max(jerk2, q2 / limit.jerk);
        }
    const double by_jerk = std::cbrt(jerk3 / 0.3);
    inverse_x = std::max(inverse_x, by_jerk * by_jerk);
    return {share * power_3_4(1 / std::max(inverse_x, 1e-100)), std::sqrt(2.25 * share / jerk1),
            0.75 * 0.7 * share / acceleration1, 0.15 * share / jerk2};
}

/// y at the knots of the whole window, arcs included.
struct Knots {
    std::vector<double> p, y;
    std::vector<Allowance> allowed;  // of the intervals
};

Knots bound(const WindowProblem& window) {
    const std::size_t n = window.intervals.size();
    Knots k{std::vector<double>(n + 1), std::vector<double>(n + 1), {}};
    k.allowed.reserve(n);
    for (std::size_t i = 0; i < n; ++i) {
        k.allowed.push_back(allowance(window.intervals[i], *window.limits));
        k.p[i + 1] = k.p[i] + window.intervals[i].length_mm;
    }
    for (std::size_t i = 1; i < n; ++i) k.y[i] = std::min(k.allowed[i - 1].y, k.allowed[i].y);
    k.y[0] = window.from_rest ? 0 : power_3_4(window.x0);
    k.y[n] = 0;
    return k;
}

void limit_slopes(Knots& k, const WindowProblem& window) {
    const std::size_t n = k.allowed.size();
    for (std::size_t i = 0; i < n; ++i)
        k.y[i + 1] = std::min(k.y[i + 1], k.y[i] + k.allowed[i].slope(k.y[i]) * window.intervals[i].length_mm);
    for (std::size_t i = n; i-- > 0;)
        k.y[i] = std::min(k.y[i], k.y[i + 1] + k.allowed[i].slope(k.y[i + 1]) * window.intervals[i].length_mm);
}

/// ∫ y dp up to any p, by prefix sums.
class Integral {
  public:
    explicit Integral(const Knots& k) : k_(k), sum_(k.p.size()) {
        for (std::size_t i = 1; i < sum_.size(); ++i)
            sum_[i] = sum_[i - 1] + (k.y[i - 1] + k.y[i]) / 2 * (k.p[i] - k.p[i - 1]);
    }
    double operator()(double p) const {
        const auto next = std::upper_bound(k_.p.begin() + 1, k_.p.end() - 1, p);
        const std::size_t i = static_cast<std::size_t>(next - k_.p.begin()) - 1;
        const double s = p - k_.p[i], slope = (k_.y[i + 1] - k_.y[i]) / (k_.p[i + 1] - k_.p[i]);
        return sum_[i] + s * (k_.y[i] + s * slope / 2);
    }

  private:
    const Knots& k_;
    std::vector<double> sum_;
};

void average(Knots& k) {
    const Integral integral(k);
    std::vector<double> smooth = k.y;
    for (std::size_t i = 1; i + 1 < k.y.size(); ++i) {
        const double wish = averaging_reach * k.y[i] / k.allowed[i].slope(k.y[i]);
        const double reach = std::min({wish, k.p[i] - k.p.front(), k.p.back() - k.p[i]});
        const double lo = k.p[i] - reach, hi = k.p[i] + reach;
        if (hi - lo > 1e-9 * k.p.back()) smooth[i] = (integral(hi) - integral(lo)) / (hi - lo);
    }
    k.y = std::move(smooth);
}

/// x and x′ at the knots from one Bézier mid value per interval: a C¹ quadratic spline, but for a first interval that
/// the state at its begin bends to a cubic.
void spline_through(const std::vector<double>& middle, const CoreProblem& core, Trajectory& out) {
    const std::size_t n = middle.size();
    const auto h = [&](std::size_t k) { return core.intervals[k].length_mm; };
    for (std::size_t k = 1; k < n; ++k) {
        out.x[k] = (h(k) * middle[k - 1] + h(k - 1) * middle[k]) / (h(k - 1) + h(k));
        out.d[k] = 2 * (middle[k] - middle[k - 1]) / (h(k - 1) + h(k));
    }
    if (core.from_rest) {
        out.x[0] = middle[0] / (1 + core.start.kappa * h(0) / 2);
        out.d[0] = core.start.kappa * out.x[0];
    }
    out.x[n] = middle[n - 1] / (1 + core.stop.kappa * h(n - 1) / 2);
    out.d[n] = -core.stop.kappa * out.x[n];
    for (std::size_t k = 0; k < n; ++k) {
        const double rise = 6 * (out.x[k + 1] - out.x[k]) / (h(k) * h(k));
        out.e0[k] = rise - (4 * out.d[k] + 2 * out.d[k + 1]) / h(k);
        out.e1[k] = (2 * out.d[k] + 4 * out.d[k + 1]) / h(k) - rise;
    }
}

}  // namespace

void make_start_profile(const WindowProblem& window, const CoreProblem& core, Trajectory& out) {
    Knots knots = bound(window);
    limit_slopes(knots, window);
    average(knots);
    average(knots);
    const std::size_t n = window.core_count(), first = window.first_core();
    std::vector<double> middle(n);
    for (std::size_t k = 0; k < n; ++k) {
        middle[k] = std::max((power_4_3(knots.y[k + first]) + power_4_3(knots.y[k + first + 1])) / 2, smallest);
        if (k + first < window.known_middle.size()) middle[k] = std::max(middle[k], window.known_middle[k + first]);
    }
    out.resize(n);
    if (!window.from_rest) {
        out.x[0] = window.x0;
        out.d[0] = window.d0;
        middle[0] = std::max(window.x0 + window.d0 * core.intervals[0].length_mm / 2, 1e-3 * window.x0);
    }
    spline_through(middle, core, out);
}

}  // namespace trunnion::feed
