#pragma once

#include <algorithm>
#include <limits>

#include "detail/rows.hpp"

/// One interval as a stage of an optimal control problem: state (x, x′) at its left knot, controls (x″ at its left and
/// right end, linear between). The Newton step is a Riccati recursion over the stages; nothing is ever divided by h².
namespace trunnion::feed::TRUNNION_VARIANT {

/// How v, d, e at a point follow from the stage's variables (x, d, e0, e1); x has (1, 0, 0), d has (reach, 1, 0).
template <class T>
struct PointMap {
    T reach;
    T v_e0, d_e0, e_e0;
    T v_e1, d_e1, e_e1;
};

template <class T>
PointMap<T> middle_map(T h) {
    const T half = T{} + 0.5;
    return {h / 2, 5.0 * h * h / 48, 3.0 * h / 8, half, h * h / 48, h / 8, half};
}

template <class T>
PointMap<T> right_map(T h) {
    return {h, h * h / 3, h / 2, T{}, h * h / 6, h / 2, T{} + 1.0};
}

/// Symmetric matrix over (x, d, e0, e1), upper triangle.
template <class T>
struct StageMatrix {
    T xx{}, xd{}, x0{}, x1{}, dd{}, d0{}, d1{}, e00{}, e01{}, e11{};
};

template <class T>
struct StageVector {
    T x{}, d{}, e0{}, e1{};
};

template <class T>
struct Symmetric3 {
    T vv, vd, ve, dd, de, ee;
};

template <class T>
void add_congruence(const Symmetric3<T>& g, const PointMap<T>& m, StageMatrix<T>& out) {
    const T dv = m.reach * g.vv + g.vd, ddd = m.reach * g.vd + g.dd;
    const T e0v = g.vv * m.v_e0 + g.vd * m.d_e0 + g.ve * m.e_e0, e0d = g.vd * m.v_e0 + g.dd * m.d_e0 + g.de * m.e_e0,
            e0e = g.ve * m.v_e0 + g.de * m.d_e0 + g.ee * m.e_e0;
    const T e1v = g.vv * m.v_e1 + g.vd * m.d_e1 + g.ve * m.e_e1, e1d = g.vd * m.v_e1 + g.dd * m.d_e1 + g.de * m.e_e1,
            e1e = g.ve * m.v_e1 + g.de * m.d_e1 + g.ee * m.e_e1;
    out.xx += g.vv;
    out.xd += dv;
    out.x0 += e0v;
    out.x1 += e1v;
    out.dd += m.reach * dv + ddd;
    out.d0 += m.reach * e0v + e0d;
    out.d1 += m.reach * e1v + e1d;
    out.e00 += m.v_e0 * e0v + m.d_e0 * e0d + m.e_e0 * e0e;
    out.e01 += m.v_e1 * e0v + m.d_e1 * e0d + m.e_e1 * e0e;
    out.e11 += m.v_e1 * e1v + m.d_e1 * e1d + m.e_e1 * e1e;
}

template <class T>
void add_pullback(T v, T d, T e, const PointMap<T>& m, StageVector<T>& out) {
    out.x += v;
    out.d += m.reach * v + d;
    out.e0 += m.v_e0 * v + m.d_e0 * d + m.e_e0 * e;
    out.e1 += m.v_e1 * v + m.d_e1 * d + m.e_e1 * e;
}

/// Quadratic cost of a state still to come; only the matrix part.
struct CostToGo {
    double xx = 0, xd = 0, dd = 0;
};

/// Linear part of it for one right-hand side.
struct Pull {
    double x = 0, d = 0;
};

/// Adds the cost of the state at the right end, T(x, d, e0, e1) = (x + h d + h²/3 e0 + h²/6 e1, d + h/2 (e0 + e1)).
inline void add_cost(const CostToGo& p, double h, StageMatrix<double>& out) {
    const double a0 = h * h / 3, a1 = h * h / 6, b = h / 2;
    const double xd = h * p.xx + p.xd, dd = h * p.xd + p.dd;            // P (h, 1)
    const double x0 = a0 * p.xx + b * p.xd, d0 = a0 * p.xd + b * p.dd;  // P (h²/3, h/2)
    const double x1 = a1 * p.xx + b * p.xd, d1 = a1 * p.xd + b * p.dd;  // P (h²/6, h/2)
    out.xx += p.xx;
    out.xd += xd;
    out.x0 += x0;
    out.x1 += x1;
    out.dd += h * xd + dd;
    out.d0 += h * x0 + d0;
    out.d1 += h * x1 + d1;
    out.e00 += a0 * x0 + b * d0;
    out.e01 += a1 * x0 + b * d0;
    out.e11 += a1 * x1 + b * d1;
}

/// The same of its linear part.
inline void add_pull(const Pull& p, double h, StageVector<double>& out) {
    out.x += p.x;
    out.d += h * p.x + p.d;
    out.e0 += h * h / 3 * p.x + h / 2 * p.d;
    out.e1 += h * h / 6 * p.x + h / 2 * p.d;
}

/// Feedback e1 = f1 − (k1x x + k1d d + k1e e0), e0 = f0 − (k0x x + k0d d).
struct StageGain {
    double k1x, k1d, k1e, inverse1;
    double k0x, k0d, inverse0;
};

struct Feedforward {
    double e0, e1;
};

/// What the last interval owes to the arc behind it: x′ = −κx at its end, so e1 follows from the rest.
struct EndRule {
    bool active = false;
    double kappa = 0;
};

/// What rounding leaves of a pivot is never taken for less than this share of the diagonal that it came from.
inline double pivot_inverse(double pivot, double diagonal) {
    constexpr double smallest_share = 1e-13;
    return 1 / std::max({pivot, smallest_share * diagonal, std::numeric_limits<double>::min()});
}

/// (x, d, e0) after e1 = −(k1 · (x, d, e0)).
struct Reduced {
    double xx, xd, x0, dd, d0, e00;
};

inline Reduced substitute(const StageMatrix<double>& m, const StageGain& k) {
    const double sx = m.x1 - k.k1x * m.e11, sd = m.d1 - k.k1d * m.e11, s0 = m.e01 - k.k1e * m.e11;
    return {m.xx - k.k1x * m.x1 - sx * k.k1x, m.xd - k.k1x * m.d1 - sx * k.k1d,  m.x0 - k.k1x * m.e01 - sx * k.k1e,
            m.dd - k.k1d * m.d1 - sd * k.k1d, m.d0 - k.k1d * m.e01 - sd * k.k1e, m.e00 - k.k1e * m.e01 - s0 * k.k1e};
}

inline void rule_gain(double h, double kappa, StageGain& gain) {
    const double inverse = 1 / (h / 2 + kappa * h * h / 6);
    gain.k1x = kappa * inverse;
    gain.k1d = (1 + kappa * h) * inverse;
    gain.k1e = (h / 2 + kappa * h * h / 3) * inverse;
    gain.inverse1 = 0;
}

inline void optimal_gain(const StageMatrix<double>& m, StageGain& gain) {
    gain.inverse1 = pivot_inverse(m.e11, m.e11);
    gain.k1x = m.x1 * gain.inverse1;
    gain.k1d = m.d1 * gain.inverse1;
    gain.k1e = m.e01 * gain.inverse1;
}

/// Eliminates both controls from a complete stage matrix.
inline StageGain eliminate(const StageMatrix<double>& m, double h, const EndRule& end, CostToGo& cost) {
    StageGain gain;
    if (end.active)
        rule_gain(h, end.kappa, gain);
    else
        optimal_gain(m, gain);
    const Reduced r = substitute(m, gain);
    gain.inverse0 = pivot_inverse(r.e00, m.e00);
    gain.k0x = r.x0 * gain.inverse0;
    gain.k0d = r.d0 * gain.inverse0;
    cost = {std::max(r.xx - gain.k0x * r.x0, 0.0), r.xd - gain.k0x * r.d0, std::max(r.dd - gain.k0d * r.d0, 0.0)};
    return gain;
}

/// Eliminates them from a complete right-hand side.
inline Feedforward eliminate(const StageGain& gain, const StageVector<double>& g, Pull& pull) {
    const double e0 = g.e0 - gain.k1e * g.e1;
    pull.x = g.x - gain.k1x * g.e1 - gain.k0x * e0;
    pull.d = g.d - gain.k1d * g.e1 - gain.k0d * e0;
    return {e0 * gain.inverse0, g.e1 * gain.inverse1};
}

}  // namespace trunnion::feed::TRUNNION_VARIANT
