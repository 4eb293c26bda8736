#include "detail/curve_course.hpp"

#include <algorithm>
#include <cmath>

namespace trunnion::verify {

namespace {

using program::Curve;

bool is_index(std::int32_t index, std::size_t size) {
    return index >= 0 && static_cast<std::size_t>(index) < size;
}

bool is_finite(double x) {
    return std::isfinite(x);
}

}  // namespace

bool CurveCourse::is_curve(const Curve& curve, std::size_t rotary_letters) {
    if (curve.degree < 1 || curve.degree > highest_degree) return false;
    const std::size_t order = static_cast<std::size_t>(curve.degree) + 1, count = curve.position_mm.size();
    const auto fits = [count](const auto& list) { return list.empty() || list.size() == count; };
    if (count < order || curve.knots.size() != count + order) return false;
    if (!fits(curve.weights) || !fits(curve.axis) || !fits(curve.rotary_rad)) return false;
    const auto are_words = [&](const auto& words) {
        return std::all_of(words.begin(), words.begin() + static_cast<std::ptrdiff_t>(rotary_letters), is_finite);
    };
    const auto is_vector = [](const Eigen::Vector3d& v) { return v.allFinite(); };
    return std::ranges::all_of(curve.knots, is_finite) && std::ranges::is_sorted(curve.knots) &&
           std::ranges::all_of(curve.weights, [](double w) { return w > 0 && std::isfinite(w); }) &&
           std::ranges::all_of(curve.position_mm, is_vector) && std::ranges::all_of(curve.axis, is_vector) &&
           std::ranges::all_of(curve.rotary_rad, are_words);
}

const Curve* CurveCourse::curve_of(const program::Program& program, const program::Move& move) {
    if (!is_index(move.curve_part, program.curve_parts.size())) return nullptr;
    const std::int32_t curve = program.curve_parts[static_cast<std::size_t>(move.curve_part)].curve;
    return is_index(curve, program.curves.size()) ? &program.curves[static_cast<std::size_t>(curve)] : nullptr;
}

std::optional<CurveCourse> CurveCourse::make(const program::Program& program, const program::Move& move) {
    const program::CurvePart& part = program.curve_parts[static_cast<std::size_t>(move.curve_part)];
    CurveCourse out;
    out.curve_ = curve_of(program, move);
    out.from_u_ = part.from_u;
    out.to_u_ = part.to_u;
    if (!(part.from_u < part.to_u)) return {};
    const auto& knots = out.curve_->knots;
    const auto after = std::upper_bound(knots.begin(), knots.end(), part.from_u) - knots.begin();
    const auto degree = static_cast<std::size_t>(out.curve_->degree);
    out.span_ = static_cast<std::size_t>(after) - 1;
    const bool inside = after > static_cast<std::ptrdiff_t>(degree) && out.span_ < out.curve_->position_mm.size();
    if (!inside || !(part.to_u <= knots[out.span_ + 1])) return {};
    out.first_ = out.span_ - degree;
    return out;
}

/// Cox-de Boor: N_{i,p} from N_{i,p−1}, the p + 1 functions that are not 0 in the span.
CurveCourse::Shares CurveCourse::shares(double w) const {
    const double u = w == 1 ? to_u_ : from_u_ + w * (to_u_ - from_u_);
    const auto& knots = curve_->knots;
    const auto degree = static_cast<std::size_t>(curve_->degree);
    Shares basis{1};
    for (std::size_t p = 1; p <= degree; ++p) {
        Shares next{};
        for (std::size_t k = 0; k < p; ++k) {
            const double left = knots[span_ + 1 + k - p], right = knots[span_ + 1 + k];
            const double rising = (u - left) / (right - left);
            next[k] += (1 - rising) * basis[k];
            next[k + 1] += rising * basis[k];
        }
        basis = next;
    }
    if (curve_->weights.empty()) return basis;
    double sum = 0;
    for (std::size_t k = 0; k <= degree; ++k) sum += basis[k] *= curve_->weights[first_ + k];
    for (double& share : basis) share /= sum;
    return basis;
}

Eigen::Vector3d CurveCourse::sum(const std::vector<Eigen::Vector3d>& points, double w) const {
    const Shares share = shares(w);
    Eigen::Vector3d out = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k <= static_cast<std::size_t>(curve_->degree); ++k) out += share[k] * points[first_ + k];
    return out;
}

Eigen::Vector3d CurveCourse::position(double w) const {
    return sum(curve_->position_mm, w);
}

Eigen::Vector3d CurveCourse::axis(double w) const {
    return sum(curve_->axis, w);
}

std::array<double, program::max_rotary_letters> CurveCourse::rotary_rad(double w) const {
    const Shares share = shares(w);
    std::array<double, program::max_rotary_letters> out{};
    for (std::size_t k = 0; k <= static_cast<std::size_t>(curve_->degree); ++k)
        for (std::size_t letter = 0; letter < out.size(); ++letter)
            out[letter] += share[k] * curve_->rotary_rad[first_ + k][letter];
    return out;
}

}  // namespace trunnion::verify
