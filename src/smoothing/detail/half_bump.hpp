#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "detail/coordinates.hpp"

namespace trunnion::smoothing {

/// Coefficients of a polynomial of degree 8.
using Octic = std::array<double, 9>;

/// C(n, k).
consteval std::array<std::array<double, 9>, 9> binomials() {
    std::array<std::array<double, 9>, 9> c{};
    for (std::size_t n = 0; n < 9; ++n) {
        c[n][0] = 1;
        for (std::size_t k = 1; k <= n; ++k) c[n][k] = c[n - 1][k - 1] + (k < n ? c[n - 1][k] : 0);
    }
    return c;
}

/// Σ even[m]·(at + s)²ᵐ by powers of s: a bump of `Kernel` without its |t|/2, seen from beside it.
template <class Kernel>
Octic even_part(double at) {
    static constexpr auto choose = binomials();
    std::array<double, 9> power;
    power[0] = 1;
    for (std::size_t k = 1; k < 9; ++k) power[k] = power[k - 1] * at;
    Octic q{};
    for (std::size_t m = 0; m < Kernel::even.size(); ++m)
        for (std::size_t n = 0; n <= 2 * m; ++n) q[n] += Kernel::even[m] * choose[2 * m][n] * power[2 * m - n];
    return q;
}

/// Adds jump·share·w·g(d/w) and its derivatives by d up to `orders` − 1.
template <class Kernel, std::size_t orders>
void add_bump(const Coordinates& jump, double share, double width_mm, double d, std::array<Coordinates, orders>& sum) {
    if (!(share > 0) || std::abs(d) >= width_mm) return;
    const double inverse = 1 / width_mm, t = d * inverse;
    sum[0] += (share * width_mm * Kernel::bump(t)) * jump;
    if constexpr (orders > 1) sum[1] += (share * Kernel::slope(t)) * jump;
    if constexpr (orders > 2) sum[2] += (share * inverse * Kernel::density(t)) * jump;
    if constexpr (orders > 3) sum[3] += (share * inverse * inverse * Kernel::density_slope(t)) * jump;
}

/// At its vertex a bump's slope has two values: on the block before, the distance is at most this.
inline constexpr double least_ahead = -std::numeric_limits<double>::min();

}  // namespace trunnion::smoothing
