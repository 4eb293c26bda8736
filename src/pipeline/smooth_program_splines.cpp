#include "detail/smooth_program_splines.hpp"

#include <algorithm>
#include <cstddef>

namespace trunnion::pipeline {

using Pose = StretchCurve::Pose;

namespace {

constexpr int most_rounds = 40;
constexpr int places_in_span = 16;

Pose operator+(const Pose& a, const Pose& b) {
    return {a.tip_mm + b.tip_mm, a.orientation + b.orientation};
}
Pose operator*(double s, const Pose& a) {
    return {s * a.tip_mm, s * a.orientation};
}

/// The spline through the stretch at its stations: slopes at them from C², by the tridiagonal system
///     m_{k−1}/h_{k−1} + 2 m_k (1/h_{k−1} + 1/h_k) + m_{k+1}/h_k = 3 (d_{k−1}/h_{k−1} + d_k/h_k),  d_k = Δf_k/h_k,
/// the first and last ones given; then to Bézier points.
struct Interpolant {
    std::vector<double> at;
    std::vector<Pose> value, slope;

    Interpolant(const StretchCurve& curve, const std::vector<double>& stations) : at(stations) {
        const std::size_t n = at.size();
        for (const double p : at) value.push_back(curve.at(p));
        slope.assign(n, Pose{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()});
        slope.front() = curve.slope(at.front());
        slope.back() = curve.slope(at.back());
        std::vector<double> beyond(n, 0);
        for (std::size_t k = 1; k + 1 < n; ++k) {
            const double left = 1 / (at[k] - at[k - 1]), right = 1 / (at[k + 1] - at[k]);
            const Pose wanted =
                3 * (left * left * (value[k] + -1 * value[k - 1]) + right * right * (value[k + 1] + -1 * value[k]));
            const double pivot = 2 * (left + right) - left * beyond[k - 1];
            beyond[k] = right / pivot;
            slope[k] = 1 / pivot * (wanted + -left * slope[k - 1]);
        }
        for (std::size_t k = n - 1; k-- > 1;) slope[k] = slope[k] + -beyond[k] * slope[k + 1];
    }

    Pose evaluate(std::size_t span, double share) const {
        const double h = at[span + 1] - at[span], t = share, s = 1 - share;
        return s * s * (1 + 2 * t) * value[span] + t * t * (1 + 2 * s) * value[span + 1] +
               h * (s * s * t * slope[span] + -(s * t * t) * slope[span + 1]);
    }

    FitDeviation deviation(const StretchCurve& curve, std::size_t span, const FitTolerance& tolerance) const {
        FitDeviation worst;
        for (int i = 1; i < places_in_span; ++i) {
            const double share = static_cast<double>(i) / places_in_span;
            Pose fit = evaluate(span, share);
            if (curve.by_vectors()) fit.orientation.normalize();
            worst.add(curve.deviation(fit, at[span] + share * (at[span + 1] - at[span]), tolerance));
        }
        return worst;
    }

    /// de Boor points: those beside a knot lie on the lines through the Bézier points, at a third of the spans around.
    FittedSpline as_spline() const {
        const std::size_t n = at.size();
        FittedSpline out;
        out.knots.assign(3, at.front());
        out.knots.insert(out.knots.end(), at.begin(), at.end());
        out.knots.insert(out.knots.end(), 3, at.back());
        const auto span = [&](std::size_t k) { return at[k + 1] - at[k]; };
        out.control.push_back(value.front());
        out.control.push_back(value.front() + span(0) / 3 * slope.front());
        // The blossom f(t_k−1, t_k, t_k+1) of an inner knot, from value, slope and curvature there.
        for (std::size_t k = 1; k + 1 < n; ++k) {
            const double left = span(k - 1), right = span(k);
            const Pose chord = 1 / right * (value[k + 1] + -1 * value[k]);
            const Pose curvature = 2 / right * (3 * chord + -2 * slope[k] + -1 * slope[k + 1]);
            out.control.push_back(value[k] + (right - left) / 3 * slope[k] + -(left * right) / 6 * curvature);
        }
        out.control.push_back(value.back() + -span(n - 2) / 3 * slope.back());
        out.control.push_back(value.back());
        return out;
    }
};

}  // namespace

Result<FittedSpline> fit_spline(const StretchCurve& curve, double from_mm, double to_mm,
                                const std::vector<double>& breaks, const FitTolerance& tolerance,
                                FitDeviation& deviation) {
    std::vector<double> stations{from_mm};
    stations.insert(stations.end(), breaks.begin(), breaks.end());
    stations.push_back(to_mm);
    for (int round = 0; round < most_rounds; ++round) {
        const Interpolant fit(curve, stations);
        std::vector<double> finer{stations.front()};
        FitDeviation worst;
        for (std::size_t k = 0; k + 1 < stations.size(); ++k) {
            const FitDeviation found = fit.deviation(curve, k, tolerance);
            worst.add(found);
            if (!found.within(tolerance)) finer.push_back(0.5 * (stations[k] + stations[k + 1]));
            finer.push_back(stations[k + 1]);
        }
        if (finer.size() == stations.size()) {
            deviation.add(worst);
            return fit.as_spline();
        }
        stations = std::move(finer);
    }
    return fail({.code = "PIPE0017",
                 .text = "no spline keeps the tolerance along this stretch",
                 .hint = "a larger tolerance, or --points"});
}

}  // namespace trunnion::pipeline
