#include "trunnion/surfacing/chord_steps.hpp"

#include <algorithm>
#include <cmath>

namespace trunnion::surfacing {

namespace {

/// The longest step from `from` that keeps the tolerance, at most `limit`; `guess` > 0.
double longest_step(const StepError& error, double from, double guess, double limit, double tolerance,
                    double shortest) {
    constexpr double aim = 0.999, low_enough = 0.997;
    double kept = 0, broken = limit, step = std::min(guess, limit);
    for (int attempt = 0; attempt < 40; ++attempt) {
        const double e = error(from, from + step);
        if (e <= tolerance) {
            kept = step;
            if (step >= limit || e > low_enough * tolerance) break;
        } else {
            broken = step;
            if (step <= shortest) return step;
        }
        if (broken - kept < 1e-3 * broken && kept > 0) break;
        // The error of a smooth curve is in proportion to the square of the step.
        const double factor = e > 0 ? std::clamp(std::sqrt(aim * tolerance / e), 0.1, 4.0) : 4.0;
        const double next = std::min(step * factor, limit);
        const bool between = next > kept && (next < broken || (broken == limit && next <= limit));
        step = std::max(between ? next : 0.5 * (kept + broken), shortest);
    }
    return kept > 0 ? kept : shortest;
}

void level_stub(const StepError& error, std::vector<double>& at, double tolerance) {
    const std::size_t n = at.size();
    if (n < 3 || at[n - 1] - at[n - 2] >= 0.25 * (at[n - 2] - at[n - 3])) return;
    const double middle = 0.5 * (at[n - 3] + at[n - 1]);
    if (error(at[n - 3], middle) <= tolerance && error(middle, at[n - 1]) <= tolerance) at[n - 2] = middle;
}

}  // namespace

std::vector<double> chord_steps(const StepError& error, double begin, double end, double tolerance, double longest) {
    std::vector<double> at{begin};
    const double shortest = 1e-6 * (end - begin);
    double step = std::min(longest, end - begin);
    while (at.back() < end) {
        const double limit = std::min(longest, end - at.back());
        step = longest_step(error, at.back(), step, limit, tolerance, std::min(shortest, limit));
        at.push_back(step >= end - at.back() ? end : at.back() + step);
    }
    level_stub(error, at, tolerance);
    return at;
}

double chord_error_mm(const std::function<Eigen::Vector3d(double)>& curve, double from, double to) {
    const Eigen::Vector3d a = curve(from), way = curve(to) - a;
    const double length = std::max(way.squaredNorm(), 1e-300);
    const auto off = [&](double t) {
        const Eigen::Vector3d p = curve(t) - a;
        return (p - std::clamp(p.dot(way) / length, 0.0, 1.0) * way).norm();
    };
    constexpr int parts = 8;
    double largest = 0, at = 0.5 * (from + to);
    for (int k = 1; k < parts; ++k) {
        const double t = from + (to - from) * k / parts;
        if (const double e = off(t); e > largest) largest = e, at = t;
    }
    // The top of the parabola through the largest one and its neighbours.
    const double h = (to - from) / parts, before = off(at - h), after = off(at + h);
    const double bend = 2 * largest - before - after;
    return bend > 0 ? largest + std::pow(after - before, 2) / (8 * bend) : largest;
}

}  // namespace trunnion::surfacing
