#pragma once

#include <algorithm>
#include <array>

#include "trunnion/geometry/bspline_surface.hpp"
#include "trunnion/machine/kinematics.hpp"

namespace trunnion::interpolation::detail {

using machine::VectorSeries;

/// A surface's point and first partial derivatives along a curve, as series in the curve's parameter: what the basis
/// functions make of series u and v carries all mixed derivatives to order 4 of the surface along.
struct SeriesOnSurface {
    VectorSeries at, by_u, by_v;
};

using SeriesValues = std::array<Taylor3, geometry::max_degree + 1>;

/// N_{s−p} … N_s of degree p at a series (Piegl & Tiller, The NURBS Book, §2.2).
inline SeriesValues basis_series(int degree, const double* knot, const Taylor3& u) noexcept {
    SeriesValues out{};
    out[0] = 1;
    for (int r = 1; r <= degree; ++r) {
        Taylor3 from_left;
        for (int j = 0; j < r; ++j) {
            const double left = knot[1 + j - r], right = knot[1 + j];
            const Taylor3 part = out[j] * (1 / (right - left));
            out[j] = from_left + (right - u) * part;
            from_left = (u - left) * part;
        }
        out[r] = from_left;
    }
    return out;
}

/// Their derivatives by u, from the values of one degree less (eq. 2.7).
inline SeriesValues slopes_of(const SeriesValues& lower, int degree, const double* knot) noexcept {
    SeriesValues out{};
    for (int j = 0; j < degree; ++j) {
        const Taylor3 slope = lower[j] * (degree / (knot[1 + j] - knot[1 + j - degree]));
        out[j] -= slope;
        out[j + 1] += slope;
    }
    return out;
}

struct SeriesBasis {
    std::size_t first;
    SeriesValues value, slope;
};

inline SeriesBasis basis_along(const geometry::SurfaceDirection& direction, const Taylor3& u) noexcept {
    const auto begin = direction.knots.begin() + direction.degree;
    const auto end = direction.knots.end() - direction.degree - 1;
    auto after = std::upper_bound(begin, end, u.value());
    if (after == end) after = std::lower_bound(begin, end, *end);
    if (after == begin) after = std::upper_bound(begin, end, *begin);
    const double* const knot = &*(after - 1);
    return {static_cast<std::size_t>(after - direction.knots.begin()) - 1 - static_cast<std::size_t>(direction.degree),
            basis_series(direction.degree, knot, u),
            slopes_of(basis_series(direction.degree - 1, knot, u), direction.degree, knot)};
}

/// The same sums for homogeneous coordinates: x, y, z, and the weight as fourth.
struct HomogeneousSeries {
    std::array<Taylor3, 4> at, by_u, by_v;
};

inline HomogeneousSeries sums_along(const geometry::BsplineSurface& surface, const Taylor3& u,
                                    const Taylor3& v) noexcept {
    const SeriesBasis along_u = basis_along(surface.u(), u), along_v = basis_along(surface.v(), v);
    const std::size_t columns = surface.v().points();
    const auto& weights = surface.weights();
    HomogeneousSeries out;
    for (int k = 0; k <= surface.u().degree; ++k) {
        std::array<Taylor3, 4> row, row_slope;
        for (int l = 0; l <= surface.v().degree; ++l) {
            const std::size_t index =
                (along_u.first + static_cast<std::size_t>(k)) * columns + along_v.first + static_cast<std::size_t>(l);
            const double weight = weights.empty() ? 1 : weights[index];
            for (int i = 0; i < 4; ++i) {
                const double coordinate = i < 3 ? weight * surface.control_points_mm()[index][i] : weight;
                row[i] += coordinate * along_v.value[l];
                row_slope[i] += coordinate * along_v.slope[l];
            }
        }
        for (int i = 0; i < (weights.empty() ? 3 : 4); ++i) {
            out.at[i] += along_u.value[k] * row[i];
            out.by_u[i] += along_u.slope[k] * row[i];
            out.by_v[i] += along_u.value[k] * row_slope[i];
        }
    }
    return out;
}

inline SeriesOnSurface on_surface(const geometry::BsplineSurface& surface, const Taylor3& u,
                                  const Taylor3& v) noexcept {
    const HomogeneousSeries h = sums_along(surface, u, v);
    SeriesOnSurface out;
    for (int i = 0; i < 3; ++i) {
        out.at[i] = h.at[i];
        out.by_u[i] = h.by_u[i];
        out.by_v[i] = h.by_v[i];
        if (surface.weights().empty()) continue;
        out.at[i] = h.at[i] / h.at[3];
        out.by_u[i] = (h.by_u[i] - h.by_u[3] * out.at[i]) / h.at[3];
        out.by_v[i] = (h.by_v[i] - h.by_v[3] * out.at[i]) / h.at[3];
    }
    return out;
}

inline Taylor3 dot(const VectorSeries& a, const VectorSeries& b) noexcept {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline VectorSeries cross(const VectorSeries& a, const VectorSeries& b) noexcept {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline VectorSeries scaled(const VectorSeries& a, const Taylor3& factor) noexcept {
    return {a[0] * factor, a[1] * factor, a[2] * factor};
}
inline VectorSeries sum(const VectorSeries& a, const VectorSeries& b) noexcept {
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
inline VectorSeries unit(const VectorSeries& a) noexcept {
    return scaled(a, 1.0 / sqrt(dot(a, a)));
}

/// f as a series in s, where f is one in w and ds/dw is `rate`.
struct Reparameter {
    Taylor3 w;  // of s, without its value

    explicit Reparameter(const Taylor3& rate) noexcept {
        const double s1 = rate.c[0], s2 = rate.c[1] / 2, s3 = rate.c[2] / 3, power = s1 * s1 * s1;
        w = {0, 1 / s1, -s2 / power, (2 * s2 * s2 - s1 * s3) / (power * s1 * s1)};
    }
    Taylor3 operator()(const Taylor3& f) const noexcept { return compose(w, f.c[0], f.c[1], f.c[2], f.c[3]); }
    VectorSeries operator()(const VectorSeries& f) const noexcept {
        return {(*this)(f[0]), (*this)(f[1]), (*this)(f[2])};
    }
};

}  // namespace trunnion::interpolation::detail
