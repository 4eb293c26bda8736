#pragma once

#include <array>
#include <cmath>

#include <Eigen/Core>

#include "trunnion/numeric/taylor3.hpp"

/// Vectors of doubles or of series, turned by constant directions: the arithmetic of a kinematic chain, written once
/// for both. `S` is double or Taylor3.
namespace trunnion::machine::detail {

template <class S>
using Vector = std::array<S, 3>;

template <class S>
struct Angle {
    S sin, cos;
};

inline Angle<double> angle_of(double rad) {
    return {std::sin(rad), std::cos(rad)};
}
inline Angle<Taylor3> angle_of(const Taylor3& rad) {
    const SinCos both = sin_cos(rad);
    return {both.sin, both.cos};
}

template <class S>
Vector<S> constant(const Eigen::Vector3d& v) {
    return {S(v.x()), S(v.y()), S(v.z())};
}

template <class S>
Vector<S> plus(const Vector<S>& a, const Vector<S>& b) {
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

template <class S>
Vector<S> minus(const Vector<S>& a, const Vector<S>& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

template <class S>
S dot(const Eigen::Vector3d& a, const Vector<S>& b) {
    return a.x() * b[0] + a.y() * b[1] + a.z() * b[2];
}

template <class S>
Vector<S> cross(const Eigen::Vector3d& a, const Vector<S>& b) {
    return {a.y() * b[2] - a.z() * b[1], a.z() * b[0] - a.x() * b[2], a.x() * b[1] - a.y() * b[0]};
}

template <class S>
S triple(const Vector<S>& a, const Vector<S>& b, const Vector<S>& c) {
    return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
}

template <class S>
Vector<S> times(const Eigen::Matrix3d& m, const Vector<S>& v) {
    return {m(0, 0) * v[0] + m(0, 1) * v[1] + m(0, 2) * v[2], m(1, 0) * v[0] + m(1, 1) * v[1] + m(1, 2) * v[2],
            m(2, 0) * v[0] + m(2, 1) * v[1] + m(2, 2) * v[2]};
}

/// v turned about the unit direction u (Rodrigues).
template <class S>
Vector<S> turned(const Vector<S>& v, const Eigen::Vector3d& u, const Angle<S>& angle) {
    const S along = dot(u, v);
    const Vector<S> side = cross(u, v);
    Vector<S> out;
    for (int i = 0; i < 3; ++i) {
        const S part = u[i] * along;
        out[i] = part + angle.cos * (v[i] - part) + angle.sin * side[i];
    }
    return out;
}

template <class S>
Vector<S> turned_back(const Vector<S>& v, const Eigen::Vector3d& u, const Angle<S>& angle) {
    return turned(v, u, {-angle.sin, angle.cos});
}

}  // namespace trunnion::machine::detail
