#include "trunnion/geometry/bspline_basis.hpp"

#include <algorithm>

namespace trunnion::geometry {

namespace {

using Values = std::array<double, max_degree + 1>;

/// The s with t_s ≤ u < t_{s+1} within the domain; beyond its ends the outermost non-empty interval.
std::size_t span_at(int degree, std::span<const double> knots, double u) noexcept {
    const auto first = knots.begin() + degree, last = knots.end() - degree - 1;
    auto after = std::upper_bound(first, last, u);
    if (after == last) after = std::lower_bound(first, last, *last);
    if (after == first) after = std::upper_bound(first, last, *first);
    return static_cast<std::size_t>(after - knots.begin()) - 1;
}

/// N_{s−p} … N_s of degree p.
Values values(int degree, const double* knot, double u) noexcept {
    Values out{};
    out[0] = 1;
    for (int r = 1; r <= degree; ++r) {
        double from_left = 0;
        for (int j = 0; j < r; ++j) {
            const double left = knot[1 + j - r], right = knot[1 + j];
            const double part = out[j] / (right - left);
            out[j] = from_left + (right - u) * part;
            from_left = (u - left) * part;
        }
        out[r] = from_left;
    }
    return out;
}

/// The derivatives of the splines of one degree from the values, or the same derivatives, of those of one less.
Values raised(const Values& lower, int degree, const double* knot) noexcept {
    Values out{};
    for (int j = 0; j < degree; ++j) {
        const double slope = degree * lower[j] / (knot[1 + j] - knot[1 + j - degree]);
        out[j] -= slope;
        out[j + 1] += slope;
    }
    return out;
}

}  // namespace

BasisFunctions basis_functions(int degree, std::span<const double> knots, double u) noexcept {
    const std::size_t span = span_at(degree, knots, u);
    const double* const knot = knots.data() + span;
    BasisFunctions out;
    out.first = span - static_cast<std::size_t>(degree);
    out.derivative[0] = values(degree, knot, u);
    out.derivative[1] = raised(values(degree - 1, knot, u), degree, knot);
    if (degree > 1) out.derivative[2] = raised(raised(values(degree - 2, knot, u), degree - 1, knot), degree, knot);
    return out;
}

}  // namespace trunnion::geometry
