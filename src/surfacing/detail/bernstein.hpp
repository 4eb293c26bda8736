#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace trunnion::surfacing::detail {

inline double binomial(int n, int k) noexcept {
    double out = 1;
    for (int i = 0; i < k; ++i) out = out * (n - i) / (i + 1);
    return out;
}

/// Polynomial over (s, t) in [0, 1]²: Σ Σ c_ij s^i (1 − s)^(n−i) t^j (1 − t)^(m−j), c_ij the Bernstein coefficients
/// times their binomials: so products are convolutions. Values lie in the hull of the Bernstein coefficients.
template <class Value>
struct Bernstein {
    int degree_u = 0, degree_v = 0;
    std::vector<Value> c;

    Bernstein(int n, int m, const Value& zero)
        : degree_u(n), degree_v(m), c(static_cast<std::size_t>(n + 1) * static_cast<std::size_t>(m + 1), zero) {}

    Value& at(int i, int j) noexcept { return c[index(i, j)]; }
    const Value& at(int i, int j) const noexcept { return c[index(i, j)]; }
    Value coefficient(int i, int j) const { return at(i, j) / (binomial(degree_u, i) * binomial(degree_v, j)); }

    /// Calls with every Bernstein coefficient.
    template <class Visit>
    void each(const Visit& visit) const {
        for (int i = 0; i <= degree_u; ++i)
            for (int j = 0; j <= degree_v; ++j) visit(coefficient(i, j));
    }

  private:
    std::size_t index(int i, int j) const noexcept {
        return static_cast<std::size_t>(i) * static_cast<std::size_t>(degree_v + 1) + static_cast<std::size_t>(j);
    }
};

using ScalarBernstein = Bernstein<double>;
using VectorBernstein = Bernstein<Eigen::Vector3d>;

/// Of Bernstein coefficients coefficient(i, j).
template <class Value, class Coefficient>
Bernstein<Value> bernstein(int n, int m, const Value& zero, const Coefficient& coefficient) {
    Bernstein<Value> out(n, m, zero);
    for (int i = 0; i <= n; ++i)
        for (int j = 0; j <= m; ++j) out.at(i, j) = binomial(n, i) * binomial(m, j) * coefficient(i, j);
    return out;
}

/// Σ op(a, b) of two polynomials, op bilinear: a product, a scalar or a cross product.
template <class Value, class A, class B, class Op>
Bernstein<Value> product(const Bernstein<A>& a, const Bernstein<B>& b, const Value& zero, const Op& op) {
    Bernstein<Value> out(a.degree_u + b.degree_u, a.degree_v + b.degree_v, zero);
    for (int i = 0; i <= a.degree_u; ++i)
        for (int j = 0; j <= a.degree_v; ++j)
            for (int k = 0; k <= b.degree_u; ++k)
                for (int l = 0; l <= b.degree_v; ++l) out.at(i + k, j + l) += op(a.at(i, j), b.at(k, l));
    return out;
}
inline VectorBernstein times(const ScalarBernstein& a, const VectorBernstein& b) {
    return product(a, b, Eigen::Vector3d(Eigen::Vector3d::Zero()),
                   [](double x, const Eigen::Vector3d& y) -> Eigen::Vector3d { return x * y; });
}
inline ScalarBernstein times(const ScalarBernstein& a, const ScalarBernstein& b) {
    return product(a, b, 0.0, [](double x, double y) { return x * y; });
}
inline VectorBernstein cross(const VectorBernstein& a, const VectorBernstein& b) {
    return product(a, b, Eigen::Vector3d(Eigen::Vector3d::Zero()),
                   [](const Eigen::Vector3d& x, const Eigen::Vector3d& y) -> Eigen::Vector3d { return x.cross(y); });
}
inline ScalarBernstein dot(const VectorBernstein& a, const VectorBernstein& b) {
    return product(a, b, 0.0, [](const Eigen::Vector3d& x, const Eigen::Vector3d& y) { return x.dot(y); });
}

/// The difference of two polynomials of the same degrees.
template <class Value>
Bernstein<Value> minus(Bernstein<Value> a, const Bernstein<Value>& b) {
    for (std::size_t k = 0; k < a.c.size(); ++k) a.c[k] -= b.c[k];
    return a;
}

template <class Value>
Bernstein<Value> by_u(const Bernstein<Value>& a) {
    const Value zero = a.c.front() - a.c.front();
    if (a.degree_u == 0) return Bernstein<Value>(0, a.degree_v, zero);
    return bernstein<Value>(a.degree_u - 1, a.degree_v, zero, [&](int i, int j) -> Value {
        return a.degree_u * (a.coefficient(i + 1, j) - a.coefficient(i, j));
    });
}
template <class Value>
Bernstein<Value> by_v(const Bernstein<Value>& a) {
    const Value zero = a.c.front() - a.c.front();
    if (a.degree_v == 0) return Bernstein<Value>(a.degree_u, 0, zero);
    return bernstein<Value>(a.degree_u, a.degree_v - 1, zero, [&](int i, int j) -> Value {
        return a.degree_v * (a.coefficient(i, j + 1) - a.coefficient(i, j));
    });
}

/// Along S_u × S_v of S = a/w, w > 0: w⁴ S_u × S_v, where w is constant w² S_u × S_v.
inline VectorBernstein normal_of(const ScalarBernstein& w, const VectorBernstein& a) {
    if (w.degree_u == 0 && w.degree_v == 0) return cross(by_u(a), by_v(a));
    return cross(minus(times(w, by_u(a)), times(by_u(w), a)), minus(times(w, by_v(a)), times(by_v(w), a)));
}

struct HullRange {
    double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
};
inline HullRange range(const ScalarBernstein& a) {
    HullRange out;
    a.each([&](double c) { out = {std::min(out.low, c), std::max(out.high, c)}; });
    return out;
}
/// A bound of the length from above, and one from below: along the mean direction, not above 0 where they spread more
/// than a quarter turn from it.
inline double longest(const VectorBernstein& a) {
    double out = 0;
    a.each([&](const Eigen::Vector3d& c) { out = std::max(out, c.norm()); });
    return out;
}
inline double shortest(const VectorBernstein& a) {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    a.each([&](const Eigen::Vector3d& c) { mean += c; });
    double out = std::numeric_limits<double>::infinity();
    a.each([&](const Eigen::Vector3d& c) { out = std::min(out, c.dot(mean)); });
    const double length = mean.norm();
    return length > 0 ? out / length : 0;
}

}  // namespace trunnion::surfacing::detail
