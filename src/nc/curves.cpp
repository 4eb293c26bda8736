#include "detail/curves.hpp"

#include <algorithm>
#include <cmath>

namespace trunnion::nc {

using Eigen::Vector3d;
using program::Curve;

namespace {

constexpr int most_degree = 7;
/// Weight, then position, axis and rotary words, all times the weight.
constexpr int homogeneous_size = 10;
using Homogeneous = Eigen::Matrix<double, homogeneous_size, 1>;

Homogeneous homogeneous(const Curve& curve, std::size_t i) {
    const double weight = curve.weights.empty() ? 1 : curve.weights[i];
    Homogeneous point = Homogeneous::Zero();
    point[0] = weight;
    point.segment<3>(1) = weight * curve.position_mm[i];
    if (!curve.axis.empty()) point.segment<3>(4) = weight * curve.axis[i];
    if (!curve.rotary_rad.empty()) point.segment<3>(7) = weight * Vector3d(curve.rotary_rad[i].data());
    return point;
}

/// Of the knots the last one below u, so that a jump of a derivative belongs to the span behind it.
std::size_t span_before(const Curve& curve, double u) {
    const auto p = static_cast<std::size_t>(curve.degree);
    const auto first = curve.knots.begin() + curve.degree;
    const auto last = curve.knots.begin() + static_cast<std::ptrdiff_t>(curve.position_mm.size());
    const auto found = std::lower_bound(first, last, u);
    if (found != first) return static_cast<std::size_t>(found - curve.knots.begin()) - 1;
    return p + static_cast<std::size_t>(std::upper_bound(first, last, u) - first) - 1;
}

/// Where those of `first` … `last` are of spans. A 0 at an end repeats a knot that has its full multiplicity.
std::optional<Spans> spans_between(std::span<const double> lengths, const std::vector<bool>& repeats, std::size_t first,
                                   std::size_t last, int degree) {
    Spans spans{.distances = {}, .points = {}, .first_point = 0, .last_point = lengths.size() - 1};
    for (; first <= last && lengths[first] == 0; ++first)
        if (!repeats[++spans.first_point]) return {};
    for (; first <= last && lengths[last] == 0; --last)
        if (!repeats[spans.last_point--]) return {};
    int multiplicity = 1;
    for (std::size_t i = first; i <= last; ++i) {
        spans.distances.push_back(lengths[i]);
        spans.points.push_back(i);
        multiplicity = lengths[i] == 0 ? multiplicity + 1 : 1;
        if (multiplicity > degree) return {};
    }
    if (spans.distances.empty()) return {};
    return spans;
}

}  // namespace

std::optional<Spans> spans_of(std::span<const double> lengths, const std::vector<bool>& repeats, int degree) {
    const auto spare = static_cast<std::size_t>(degree) - 1, last = lengths.size() - 1;
    const auto all_zero = [&](std::size_t first, std::size_t count) {
        return std::ranges::all_of(lengths.subspan(first, count), [](double length) { return length == 0; });
    };
    for (std::size_t at_start = 0; at_start <= spare; ++at_start) {
        const std::size_t at_end = spare - at_start;
        if (!all_zero(1, at_start) || !all_zero(last + 1 - at_end, at_end)) continue;
        if (auto spans = spans_between(lengths, repeats, 1 + at_start, last - at_end, degree)) return spans;
    }
    return {};
}

CurvePose pose_at(const Curve& curve, double u) {
    const auto p = static_cast<std::size_t>(curve.degree);
    const std::size_t span = span_before(curve, u);
    std::array<Homogeneous, most_degree + 1> point;
    for (std::size_t i = 0; i <= p; ++i) point[i] = homogeneous(curve, span - p + i);
    for (std::size_t level = 1; level <= p; ++level)
        for (std::size_t i = p; i >= level; --i) {
            const double from = curve.knots[span - p + i], to = curve.knots[span + 1 + i - level];
            const double share = (u - from) / (to - from);
            point[i] = (1 - share) * point[i - 1] + share * point[i];
        }
    const Homogeneous pose = point[p] / point[p][0];
    return {pose.segment<3>(1), pose.segment<3>(4), {pose[7], pose[8], pose[9]}};
}

std::vector<double> clamped_knots(int degree, std::span<const double> distances) {
    std::vector<double> knots(static_cast<std::size_t>(degree) + 1, 0);
    for (const double distance : distances) knots.push_back(knots.back() + distance);
    knots.insert(knots.end(), static_cast<std::size_t>(degree), knots.back());
    return knots;
}

std::vector<double> bernstein_ordinates(std::span<const double> coefficients) {
    // Column by column of Pascal's triangle: ordinate i is Σ_k (i over k) / (d over k) · coefficient k.
    const std::size_t count = coefficients.size();
    std::vector<double> ordinates(count);
    for (std::size_t i = 0; i < count; ++i) {
        double share = 1;
        for (std::size_t k = 0; k <= i; ++k) {
            ordinates[i] += share * coefficients[k];
            if (k < i) share *= static_cast<double>(i - k) / static_cast<double>(count - 1 - k);
        }
    }
    return ordinates;
}

bool has_direction_everywhere(const Curve& curve) {
    const auto p = static_cast<std::size_t>(curve.degree);
    for (std::size_t first = 0; first + p < curve.axis.size(); ++first) {
        if (!(curve.knots[first + p] < curve.knots[first + p + 1])) continue;
        const std::span within(curve.axis.data() + first, p + 1);
        Vector3d middle = Vector3d::Zero();
        for (const Vector3d& axis : within) middle += axis.stableNormalized();
        if (!std::ranges::all_of(within, [&](const Vector3d& axis) { return axis.dot(middle) > 0; })) return false;
    }
    return true;
}

void follow_curve(program::Program& program, program::Move& move, const program::CurvePart& part) {
    move.curve_part = static_cast<std::int32_t>(program.curve_parts.size());
    program.curve_parts.push_back(part);
}

}  // namespace trunnion::nc
