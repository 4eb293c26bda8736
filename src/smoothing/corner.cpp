#include "trunnion/smoothing/corner.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace trunnion::smoothing {

namespace {

constexpr double smallest_angle_rad = 1e-3;

std::unexpected<Diagnostic> refuse(const char* code, std::string text, double value, std::string limit,
                                   std::string hint) {
    Diagnostic refusal{.code = code,
                       .text = std::move(text),
                       .value = fmt::format("{:.6g}", value),
                       .limit = std::move(limit),
                       .hint = std::move(hint)};
    return fail(std::move(refusal));
}

double half_angle_cosine(double cosine) {
    return std::sqrt(std::max(0.0, (1 + cosine) / 2));
}

double half_angle_sine(double cosine) {
    return std::sqrt(std::max(0.0, (1 - cosine) / 2));
}

/// Two segments that meet, seen from the corner.
struct Wedge {
    Eigen::Vector3d corner_mm;
    std::array<Eigen::Vector3d, 2> away;  // unit, towards the segment before and the one after
    std::array<double, 2> length_mm;

    double cosine() const { return std::clamp(away[0].dot(away[1]), -1.0, 1.0); }
    double shorter_mm() const { return std::min(length_mm[0], length_mm[1]); }
};

Result<Wedge> wedge(const Eigen::Vector3d& before, const Eigen::Vector3d& corner, const Eigen::Vector3d& after,
                    std::string_view which) {
    Wedge out{corner,
              {(before - corner).stableNormalized(), (after - corner).stableNormalized()},
              {(before - corner).stableNorm(), (after - corner).stableNorm()}};
    for (const double length : out.length_mm)
        if (!(length > 0) || !std::isfinite(length))
            return refuse("SMTH0102", fmt::format("a segment of the {} at a corner has no length", which), length,
                          "above 0 mm", "leave out repeated points");
    const double angle = 2 * std::asin(std::min(1.0, (out.away[0] - out.away[1]).norm() / 2));
    if (angle < smallest_angle_rad)
        return refuse("SMTH0103", fmt::format("the {} turns back on itself at a corner", which), angle,
                      fmt::format("{} rad", smallest_angle_rad), "stop there");
    return out;
}

Result<void> check(double tolerance_mm, std::string_view which) {
    if (tolerance_mm > 0 && std::isfinite(tolerance_mm)) return {};
    return refuse("SMTH0101", fmt::format("the corner tolerance of the {} is not usable", which), tolerance_mm,
                  "above 0 mm", "with no tolerance a corner is an exact stop");
}

Result<void> check_ratio(double ratio) {
    if (ratio > 1 && std::isfinite(ratio)) return {};
    return refuse("SMTH0104", "the ratio of outer to inner length of a corner is not usable", ratio, "above 1",
                  fmt::format("{} is the usual one", usual_corner_ratio));
}

std::array<CornerSide, 2> bottom_sides(const Wedge& at, double tolerance_mm, double ratio) {
    const double outer = std::min(ratio * inner_length_mm(tolerance_mm, at.cosine()), at.shorter_mm() / 2);
    const CornerSide side{outer / ratio, outer, at.cosine()};
    return {side, side};
}

Result<geometry::BsplineCurve> spline_over(const Wedge& at, const std::array<CornerSide, 2>& sides) {
    return geometry::BsplineCurve::make(
        3, {0, 0, 0, 0, 0.5, 1, 1, 1, 1},
        {at.corner_mm + sides[0].outer_mm * at.away[0], at.corner_mm + sides[0].inner_mm * at.away[0], at.corner_mm,
         at.corner_mm + sides[1].inner_mm * at.away[1], at.corner_mm + sides[1].outer_mm * at.away[1]});
}

std::array<CornerSide, 2> top_sides(const Wedge& top, const std::array<double, 2>& rate, double bottom_outer_mm,
                                    double tolerance_mm) {
    const std::array<double, 2> outer{rate[0] * bottom_outer_mm, rate[1] * bottom_outer_mm};
    const double unfolded = std::min(outer[0], outer[1]) / least_top_ratio;
    const double inner = std::min(inner_length_mm(tolerance_mm, top.cosine()), unfolded);
    return {CornerSide{inner, outer[0], top.cosine()}, CornerSide{inner, outer[1], top.cosine()}};
}

}  // namespace

CornerBasis corner_basis(double u, Half half) noexcept {
    const bool mirrored = half == Half::second;
    const double v = mirrored ? 1 - u : u, v2 = v * v, w = 1 - 2 * v;
    CornerBasis b;
    b.row(0) << w * w * w, -6 * w * w, 24 * w, -48;
    b.row(1) << 2 * v * (3 + v * (-9 + 7 * v)), 6 + v * (-36 + 42 * v), -36 + 84 * v, 84;
    b.row(2) << 2 * v2 * (3 - 4 * v), 12 * v * w, 12 - 48 * v, -48;
    b.row(3) << 2 * v2 * v, 6 * v2, 12 * v, 12;
    b.row(4).setZero();
    if (!mirrored) return b;
    CornerBasis backwards = b.colwise().reverse();
    backwards.col(1) *= -1;
    backwards.col(3) *= -1;
    return backwards;
}

double inner_length_mm(double tolerance_mm, double cosine) noexcept {
    const double shrink = half_angle_cosine(cosine);
    return shrink > 0 ? 2 * tolerance_mm / shrink : std::numeric_limits<double>::infinity();
}

double corner_error_mm(double inner_mm, double cosine) noexcept {
    return inner_mm * half_angle_cosine(cosine) / 2;
}

double polyline_error_mm(double inner_mm, double cosine) noexcept {
    return corner_error_mm(inner_mm, cosine) * half_angle_sine(cosine);
}

double end_curvature_slope(const CornerSide& side) noexcept {
    const double gap = side.outer_mm - side.inner_mm;  // L1 (r − 1)
    const double sine = 2 * half_angle_sine(side.cosine) * half_angle_cosine(side.cosine);
    return sine * side.inner_mm / (18 * gap * gap * gap);
}

Result<geometry::BsplineCurve> corner_spline(const Eigen::Vector3d& before_mm, const Eigen::Vector3d& corner_mm,
                                             const Eigen::Vector3d& after_mm, const CornerShape& shape) {
    if (auto usable = check(shape.tolerance_mm, "path"); !usable) return fail(std::move(usable.error()));
    if (auto usable = check_ratio(shape.ratio); !usable) return fail(std::move(usable.error()));
    auto at = wedge(before_mm, corner_mm, after_mm, "path");
    if (!at) return fail(std::move(at.error()));
    return spline_over(*at, bottom_sides(*at, shape.tolerance_mm, shape.ratio));
}

Result<DualCorner> dual_corner(const RuledPose& before, const RuledPose& corner, const RuledPose& after,
                               const DualCornerShape& shape) {
    if (auto usable = check(shape.tip_tolerance_mm, "tip"); !usable) return fail(std::move(usable.error()));
    if (auto usable = check(shape.top_tolerance_mm, "top"); !usable) return fail(std::move(usable.error()));
    if (auto usable = check_ratio(shape.ratio); !usable) return fail(std::move(usable.error()));
    auto bottom = wedge(before.bottom_mm, corner.bottom_mm, after.bottom_mm, "tip");
    if (!bottom) return fail(std::move(bottom.error()));
    auto top = wedge(before.top_mm, corner.top_mm, after.top_mm, "top");
    if (!top) return fail(std::move(top.error()));

    const std::array<double, 2> rate{top->length_mm[0] / bottom->length_mm[0],
                                     top->length_mm[1] / bottom->length_mm[1]};
    const auto below = bottom_sides(*bottom, shape.tip_tolerance_mm, shape.ratio);
    const auto above = top_sides(*top, rate, below[0].outer_mm, shape.top_tolerance_mm);
    auto tip_curve = spline_over(*bottom, below);
    if (!tip_curve) return fail(std::move(tip_curve.error()));
    auto top_curve = spline_over(*top, above);
    if (!top_curve) return fail(std::move(top_curve.error()));
    auto curves = geometry::DualSpline::make(std::move(*tip_curve), std::move(*top_curve));
    if (!curves) return fail(std::move(curves.error()));
    return DualCorner{std::move(*curves), below, above, rate};
}

}  // namespace trunnion::smoothing
