#pragma once

#include <array>
#include <cmath>

namespace trunnion {

/// Truncated Taylor series of order 3: f(p₀ + δ) = c₀ + c₁δ + c₂δ² + c₃δ³ + O(δ⁴).
/// Arithmetic on it is exact differentiation: whatever is computed from series carries its first three derivatives
/// along, with no formula to derive for a particular machine. Derivative k is k!·c_k.
/// All functions: no allocation, some ten to thirty flops.
struct Taylor3 {
    std::array<double, 4> c{};

    constexpr Taylor3() = default;
    constexpr Taylor3(double value) : c{value, 0, 0, 0} {}  // NOLINT: a constant is a series
    constexpr Taylor3(double c0, double c1, double c2, double c3) : c{c0, c1, c2, c3} {}

    constexpr double value() const { return c[0]; }
    constexpr double d1() const { return c[1]; }
    constexpr double d2() const { return 2 * c[2]; }
    constexpr double d3() const { return 6 * c[3]; }

    constexpr Taylor3& operator+=(const Taylor3& b) {
        for (int k = 0; k < 4; ++k) c[k] += b.c[k];
        return *this;
    }
    constexpr Taylor3& operator-=(const Taylor3& b) {
        for (int k = 0; k < 4; ++k) c[k] -= b.c[k];
        return *this;
    }
    constexpr Taylor3& operator*=(double s) {
        for (double& x : c) x *= s;
        return *this;
    }
};

constexpr Taylor3 operator-(const Taylor3& a) {
    return {-a.c[0], -a.c[1], -a.c[2], -a.c[3]};
}
constexpr Taylor3 operator+(Taylor3 a, const Taylor3& b) {
    return a += b;
}
constexpr Taylor3 operator-(Taylor3 a, const Taylor3& b) {
    return a -= b;
}
constexpr Taylor3 operator*(Taylor3 a, double s) {
    return a *= s;
}
constexpr Taylor3 operator*(double s, Taylor3 a) {
    return a *= s;
}

constexpr Taylor3 operator*(const Taylor3& a, const Taylor3& b) {
    return {a.c[0] * b.c[0], a.c[0] * b.c[1] + a.c[1] * b.c[0], a.c[0] * b.c[2] + a.c[1] * b.c[1] + a.c[2] * b.c[0],
            a.c[0] * b.c[3] + a.c[1] * b.c[2] + a.c[2] * b.c[1] + a.c[3] * b.c[0]};
}

/// Precondition: b.value() ≠ 0.
constexpr Taylor3 operator/(const Taylor3& a, const Taylor3& b) {
    const double inverse = 1 / b.c[0];
    Taylor3 q;
    q.c[0] = a.c[0] * inverse;
    q.c[1] = (a.c[1] - q.c[0] * b.c[1]) * inverse;
    q.c[2] = (a.c[2] - q.c[0] * b.c[2] - q.c[1] * b.c[1]) * inverse;
    q.c[3] = (a.c[3] - q.c[0] * b.c[3] - q.c[1] * b.c[2] - q.c[2] * b.c[1]) * inverse;
    return q;
}

/// f(a) from the derivatives of f at a.value(): f₀ and f′, f″/2, f‴/6.
constexpr Taylor3 compose(const Taylor3& a, double f0, double f1, double half_f2, double sixth_f3) {
    const double a1 = a.c[1], a2 = a.c[2], a3 = a.c[3];
    return {f0, f1 * a1, f1 * a2 + half_f2 * a1 * a1, f1 * a3 + 2 * half_f2 * a1 * a2 + sixth_f3 * a1 * a1 * a1};
}

/// Precondition: a.value() > 0.
inline Taylor3 sqrt(const Taylor3& a) {
    const double r = std::sqrt(a.c[0]), inverse = 1 / a.c[0], f1 = 0.5 * r * inverse;
    return compose(a, r, f1, -0.25 * f1 * inverse, 0.125 * f1 * inverse * inverse);
}

struct SinCos {
    Taylor3 sin, cos;
};
inline SinCos sin_cos(const Taylor3& a) {
    const double s = std::sin(a.c[0]), c = std::cos(a.c[0]);
    return {compose(a, s, c, -0.5 * s, -c / 6), compose(a, c, -s, -0.5 * c, s / 6)};
}
inline Taylor3 sin(const Taylor3& a) {
    return sin_cos(a).sin;
}
inline Taylor3 cos(const Taylor3& a) {
    return sin_cos(a).cos;
}

/// Angle of (x, y), in (−π, π]. Precondition: (x, y) ≠ 0 at the point of expansion.
inline Taylor3 atan2(const Taylor3& y, const Taylor3& x) {
    const Taylor3 numerator =
        x * Taylor3{y.c[1], 2 * y.c[2], 3 * y.c[3], 0} - y * Taylor3{x.c[1], 2 * x.c[2], 3 * x.c[3], 0};
    const Taylor3 slope = numerator / (x * x + y * y);  // its first three coefficients are exact
    return {std::atan2(y.c[0], x.c[0]), slope.c[0], slope.c[1] / 2, slope.c[2] / 3};
}

}  // namespace trunnion
