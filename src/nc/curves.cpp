#include "detail/curves.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

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

/// The polar form of the polynomial of one span, by de Boor's scheme with a parameter of its own on each level.
Homogeneous polar(const Curve& curve, std::size_t span, std::span<const double> at) {
    const auto p = static_cast<std::size_t>(curve.degree);
    std::array<Homogeneous, most_degree + 1> point;
    for (std::size_t i = 0; i <= p; ++i) point[i] = homogeneous(curve, span - p + i);
    for (std::size_t level = 1; level <= p; ++level)
        for (std::size_t i = p; i >= level; --i) {
            const double from = curve.knots[span - p + i], to = curve.knots[span + 1 + i - level];
            const double share = (at[level - 1] - from) / (to - from);
            point[i] = (1 - share) * point[i - 1] + share * point[i];
        }
    return point[p];
}

/// The knots of a part, both of its ends as often as a curve takes that begins and ends there.
std::vector<double> knots_within(const Curve& curve, double from_u, double to_u) {
    const auto fold = static_cast<std::size_t>(curve.degree) + 1;
    std::vector<double> knots(fold, from_u);
    std::ranges::copy_if(curve.knots, std::back_inserter(knots), [&](double u) { return from_u < u && u < to_u; });
    knots.insert(knots.end(), fold, to_u);
    return knots;
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
    std::array<double, most_degree> at;
    at.fill(u);
    const Homogeneous point = polar(curve, span_before(curve, u), at);
    const Homogeneous pose = point / point[0];
    return {pose.segment<3>(1), pose.segment<3>(4), {pose[7], pose[8], pose[9]}};
}

Curve part_of_curve(const Curve& curve, double from_u, double to_u) {
    const auto p = static_cast<std::size_t>(curve.degree);
    Curve out;
    out.degree = curve.degree;
    out.knots = knots_within(curve, from_u, to_u);
    const double first_weight = polar(curve, span_before(curve, out.knots[p + 1]), std::span(out.knots).first(p))[0];
    for (std::size_t i = 0; i + p + 1 < out.knots.size(); ++i) {
        std::size_t span = i;  // any that this control point takes part in
        while (!(out.knots[span] < out.knots[span + 1])) ++span;
        const std::span at = std::span(out.knots).subspan(i + 1, p);
        Homogeneous point = polar(curve, span_before(curve, out.knots[span + 1]), at);
        if (!curve.weights.empty()) out.weights.push_back(point[0] / first_weight);
        point /= point[0];
        out.position_mm.emplace_back(point.segment<3>(1));
        if (!curve.axis.empty()) out.axis.emplace_back(point.segment<3>(4));
        if (!curve.rotary_rad.empty()) out.rotary_rad.push_back({point[7], point[8], point[9]});
    }
    for (double& knot : out.knots) knot -= from_u;
    return out;
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

std::vector<double> power_coefficients(std::span<const double> ordinates) {
    std::vector<double> out(ordinates.begin(), ordinates.end());
    const std::size_t degree = out.size() - 1;
    for (std::size_t k = 1; k <= degree; ++k)
        for (std::size_t i = degree; i >= k; --i) out[i] -= out[i - 1];
    double choices = 1;
    for (std::size_t k = 1; k <= degree; ++k) {
        choices *= static_cast<double>(degree + 1 - k) / static_cast<double>(k);
        out[k] *= choices;
    }
    return out;
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

const Curve* curve_followed(const program::Program& program, std::size_t move) {
    if (move >= program.moves.size() || program.moves[move].curve_part == program::no_curve_part) return nullptr;
    const auto& part = program.curve_parts[static_cast<std::size_t>(program.moves[move].curve_part)];
    return &program.curves[static_cast<std::size_t>(part.curve)];
}

std::size_t moves_along_curve(const program::Program& program, std::size_t first) {
    const Curve* const curve = curve_followed(program, first);
    if (!curve || first == 0) return 0;
    const program::Move& begin = program.moves[first];
    const auto event = std::ranges::upper_bound(program.events, first, {}, &program::Event::before_move);
    const std::size_t end = event == program.events.end() ? program.moves.size() : event->before_move;
    const program::CurvePart* before = nullptr;
    std::size_t k = first;
    for (; k < end && curve_followed(program, k) == curve; ++k) {
        const program::Move& move = program.moves[k];
        const program::CurvePart& part = program.curve_parts[static_cast<std::size_t>(move.curve_part)];
        const bool stops = k > first && program.moves[k - 1].exact_stop;
        const bool goes_on = (!before || part.from_u == before->to_u) && move.space == begin.space &&
                             move.offset == begin.offset && move.tool == begin.tool && move.law == begin.law &&
                             move.kind == program::MoveKind::feed;
        if (stops || !goes_on) break;
        before = &part;
    }
    return k - first;
}

void follow_curve(program::Program& program, program::Move& move, const program::CurvePart& part) {
    move.curve_part = static_cast<std::int32_t>(program.curve_parts.size());
    program.curve_parts.push_back(part);
}

}  // namespace trunnion::nc
