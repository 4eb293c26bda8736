#pragma once

#include <array>
#include <cstddef>

/// Polynomials in Bernstein form over [0, 1]: coefficient hulls bound them. `T` is a number or several side by side.
namespace trunnion::feed {

template <class T, int degree>
using Bernstein = std::array<T, static_cast<std::size_t>(degree) + 1>;

consteval double binomial(std::size_t n, std::size_t k) {
    double out = 1;
    for (std::size_t i = 1; i <= k; ++i) out = out * static_cast<double>(n - k + i) / static_cast<double>(i);
    return out;
}

/// Weights of the products of coefficients i and j.
template <std::size_t m, std::size_t n>
consteval std::array<std::array<double, n>, m> product_weights() {
    std::array<double, m> left;
    std::array<double, n> right;
    std::array<double, m + n - 1> sum;
    for (std::size_t i = 0; i < m; ++i) left[i] = binomial(m - 1, i);
    for (std::size_t j = 0; j < n; ++j) right[j] = binomial(n - 1, j);
    for (std::size_t k = 0; k < m + n - 1; ++k) sum[k] = binomial(m + n - 2, k);
    std::array<std::array<double, n>, m> out;
    for (std::size_t i = 0; i < m; ++i)
        for (std::size_t j = 0; j < n; ++j) out[i][j] = left[i] * right[j] / sum[i + j];
    return out;
}

/// Adds factor · f · g to a polynomial of degree m + n − 2.
template <class T, class F, class G, std::size_t sum, std::size_t m, std::size_t n>
[[gnu::always_inline]] inline void add_product(double factor, const std::array<F, m>& f, const std::array<G, n>& g,
                                               std::array<T, sum>& out) {
    static_assert(sum + 1 == m + n);
    static constexpr std::array<std::array<double, n>, m> weight = product_weights<m, n>();
#pragma GCC unroll 8
    for (std::size_t i = 0; i < m; ++i)
#pragma GCC unroll 8
        for (std::size_t j = 0; j < n; ++j) out[i + j] += factor * weight[i][j] * g[j] * f[i];
}

/// The quintic with these values and derivatives at both ends of an interval of length h.
template <class T>
[[gnu::always_inline]] inline Bernstein<T, 5> quintic(T a0, T a1, T a2, T b0, T b1, T b2, double h) {
    const T ta = h / 5 * a1, tb = h / 5 * b1;
    return {a0, a0 + ta, a0 + 2.0 * ta + h * h / 20 * a2, b0 - 2.0 * tb + h * h / 20 * b2, b0 - tb, b0};
}

/// d/dp of a polynomial over an interval of length h.
template <class T, std::size_t n>
[[gnu::always_inline]] inline std::array<T, n - 1> derivative(const std::array<T, n>& f, double h) {
    std::array<T, n - 1> out;
    for (std::size_t i = 0; i + 1 < n; ++i) out[i] = static_cast<double>(n - 1) / h * (f[i + 1] - f[i]);
    return out;
}

/// The same polynomial on the left and the right half.
template <class T, std::size_t n>
void halve(const std::array<T, n>& f, std::array<T, n>& left, std::array<T, n>& right) {
    right = f;
    for (std::size_t k = 0; k < n; ++k) {
        left[k] = right[0];
        for (std::size_t i = 0; i + 1 < n - k; ++i) right[i] = 0.5 * (right[i] + right[i + 1]);
    }
}

/// The value in the middle.
template <class T, std::size_t n>
T middle_of(std::array<T, n> f) {
    for (std::size_t k = n - 1; k > 0; --k)
        for (std::size_t i = 0; i < k; ++i) f[i] = 0.5 * (f[i] + f[i + 1]);
    return f[0];
}

/// The same polynomial, one degree up.
template <class T, std::size_t n>
[[gnu::always_inline]] inline std::array<T, n + 1> elevated(const std::array<T, n>& f) {
    std::array<T, n + 1> out;
    out[0] = f[0];
    out[n] = f[n - 1];
    for (std::size_t i = 1; i < n; ++i) {
        const double part = static_cast<double>(i) / static_cast<double>(n);
        out[i] = part * f[i - 1] + (1 - part) * f[i];
    }
    return out;
}

}  // namespace trunnion::feed
