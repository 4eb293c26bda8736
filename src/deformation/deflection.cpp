#include "trunnion/deformation/deflection.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "trunnion/geometry/great_circle.hpp"

#include "detail/spline_equations.hpp"

namespace trunnion::deformation {

using Eigen::Vector3d;

namespace {

constexpr int most_rounds = 24;
constexpr int places_of_interval = 8;
constexpr int length_parts = 8;  // of a knot interval

/// Nodes and weights of Gauss' rule with 5 points over [0, 1].
constexpr std::array<std::array<double, 2>, 5> gauss{{{0.046910077030668004, 0.11846344252809454},
                                                      {0.23076534494715846, 0.23931433524968324},
                                                      {0.5, 0.28444444444444444},
                                                      {0.7692346550528415, 0.23931433524968324},
                                                      {0.953089922969332, 0.11846344252809454}}};

/// The way of the tip at every u.
class TipLength {
  public:
    explicit TipLength(const DualPath& path) : path_(path) {
        const std::vector<double> at = stations_of(path.spline.bottom().knots());
        for (std::size_t k = 0; k + 1 < at.size(); ++k)
            for (int i = 0; i < length_parts; ++i)
                u_.push_back(std::lerp(at[k], at[k + 1], static_cast<double>(i) / length_parts));
        u_.push_back(at.back());
        for (std::size_t k = 0; k + 1 < u_.size(); ++k) s_.push_back(s_.back() + between(u_[k], u_[k + 1]));
    }

    double at(double u) const {
        const auto after = std::ranges::upper_bound(u_, u);
        const auto k = static_cast<std::size_t>(std::max<std::ptrdiff_t>(after - u_.begin(), 1)) - 1;
        return s_[k] + between(u_[k], u);
    }

  private:
    double between(double from, double to) const {
        double sum = 0;
        for (const auto& [place, weight] : gauss)
            sum += weight * path_.spline.bottom().evaluate(from + place * (to - from))[1].norm();
        return sum * (to - from);
    }

    const DualPath& path_;
    std::vector<double> u_, s_{0};
};

class Compensation {
  public:
    Compensation(const DualPath& path, const Deflection& deflection, double tolerance_mm)
        : wanted_(path), deflection_(deflection), tolerance_mm_(tolerance_mm), length_(path) {}

    Result<CompensatedPath> run() {
        std::vector<double> at = stations_of(wanted_.spline.bottom().knots());
        while (at.size() < 4) at = finer(at, std::vector<bool>(at.size() - 1, true));
        double residual_mm = 0;
        for (int round = 0; round < most_rounds; ++round) {
            auto made = through(at);
            if (!made) return fail(made.error());
            residual_mm = 0;
            const std::vector<bool> bad = too_far(made->path, at, residual_mm);
            if (std::ranges::none_of(bad, [](bool b) { return b; }))
                return CompensatedPath{std::move(made->path), largest_mm_, residual_mm};
            at = finer(at, bad);
        }
        return fail({.code = "DEFO0106",
                     .text = "no path compensates the deflection within the tolerance",
                     .value = fmt::format("{:.4g} mm", residual_mm),
                     .limit = fmt::format("{:.4g} mm", tolerance_mm_),
                     .hint = "the value could be kept; a smoother field, or a larger tolerance"});
    }

  private:
    Pose bent_back(double u) {
        Pose out = wanted_.at(u);
        const Vector3d off = deflection_(length_.at(u), out);
        largest_mm_ = std::max(largest_mm_, off.norm());
        out.tip_in_workpiece_mm -= off;
        return out;
    }

    Result<FittedDualPath> through(const std::vector<double>& at) {
        DualFit fit{.distance_mm = wanted_.distance_mm, .parameters = at};
        std::vector<Pose> poses;
        for (const double u : at) {
            poses.push_back(bent_back(u));
            if (poses.back().tip_in_workpiece_mm.allFinite()) continue;
            return fail(
                {.code = "DEFO0116", .text = fmt::format("the deflection is not finite at {:.6g} mm", length_.at(u))});
        }
        return fit_dual_path(poses, fit);
    }

    std::vector<bool> too_far(const DualPath& path, const std::vector<double>& at, double& worst_mm) {
        std::vector<bool> out(at.size() - 1, false);
        for (std::size_t k = 0; k + 1 < at.size(); ++k)
            for (int i = 1; i < places_of_interval; ++i) {
                const double u = std::lerp(at[k], at[k + 1], static_cast<double>(i) / places_of_interval);
                const Pose wanted = bent_back(u), got = path.at(u);
                const double tip = (got.tip_in_workpiece_mm - wanted.tip_in_workpiece_mm).norm();
                const double turn = geometry::angle_between(got.axis_in_workpiece, wanted.axis_in_workpiece);
                worst_mm = std::max(worst_mm, tip);
                if (!(std::max(tip, turn * path.distance_mm) <= tolerance_mm_)) out[k] = true;
            }
        return out;
    }

    static std::vector<double> finer(const std::vector<double>& at, const std::vector<bool>& which) {
        std::vector<double> out{at.front()};
        for (std::size_t k = 0; k + 1 < at.size(); ++k) {
            if (which[k]) out.push_back(0.5 * (at[k] + at[k + 1]));
            out.push_back(at[k + 1]);
        }
        return out;
    }

    const DualPath& wanted_;
    const Deflection& deflection_;
    double tolerance_mm_, largest_mm_ = 0;
    TipLength length_;
};

bool is_sound(const std::vector<DeflectionSample>& samples) {
    const auto finite = [](const auto& sample) {
        return std::isfinite(sample.s_mm) && sample.deflection_mm.allFinite();
    };
    return samples.size() >= 2 && std::ranges::all_of(samples, finite) &&
           std::ranges::adjacent_find(samples, [](const auto& a, const auto& b) { return !(a.s_mm < b.s_mm); }) ==
               samples.end();
}

}  // namespace

Result<Deflection> deflection_through(const std::vector<DeflectionSample>& samples) {
    const auto refuse = [] {
        return fail({.code = "DEFO0116",
                     .text = "the samples of a deflection are fewer than 2, do not rise in s, or are not finite"});
    };
    if (!is_sound(samples)) return refuse();
    std::vector<double> inner;
    for (std::size_t i = 1; i + 1 < samples.size(); ++i) inner.push_back(samples[i].s_mm);
    SplineEquations equations(clamped_knots(samples.front().s_mm, inner, samples.back().s_mm));
    for (const auto& [s, off] : samples) equations.add_exact(s, 0, dual_point(off, off));
    for (const double s : {samples.front().s_mm, samples.back().s_mm}) equations.add_exact(s, 2, DualPoint::Zero());
    const auto solved = equations.solve();
    if (!solved) return refuse();
    return [curve = solved->bottom()](double s_mm, const Pose&) { return curve.evaluate(s_mm)[0]; };
}

double tip_length_mm(const DualPath& path) {
    return TipLength(path).at(path.end());
}

Result<CompensatedPath> compensate_deflection(const DualPath& path, const Deflection& deflection, double tolerance_mm,
                                              std::optional<double> covered_to_mm) {
    if (!(tolerance_mm > 0))
        return fail({.code = "DEFO0105", .text = "the tolerance of a compensation is not above 0"});
    const double length_mm = tip_length_mm(path);
    constexpr double beyond_mm = 1e-3;
    if (covered_to_mm && length_mm > *covered_to_mm + beyond_mm)
        return fail({.code = "DEFO0117",
                     .text = "the path goes on behind the last sample of the deflection",
                     .value = fmt::format("{:.6g} mm", length_mm),
                     .limit = fmt::format("{:.6g} mm", *covered_to_mm),
                     .hint = "samples up to the path's end"});
    return Compensation(path, deflection, tolerance_mm).run();
}

}  // namespace trunnion::deformation
