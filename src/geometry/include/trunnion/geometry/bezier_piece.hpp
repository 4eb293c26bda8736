#pragma once

#include <array>

#include <Eigen/Core>

namespace trunnion::geometry {

inline constexpr int max_degree = 7;

/// A curve's point and its first three derivatives by its parameter: mm, mm/u, mm/u², mm/u³.
using CurvePoint = std::array<Eigen::Vector3d, 4>;

/// The same in homogeneous coordinates (w x, w y, w z, w), and the point that they stand for.
using HomogeneousPoint = std::array<Eigen::Vector4d, 4>;
CurvePoint quotient(const HomogeneousPoint& homogeneous) noexcept;

/// Rational Bézier curve over v ∈ [0, 1]: C(v) = Σ B_k(v) w_k P_k / Σ B_k(v) w_k, B_k the Bernstein polynomials of the
/// degree; one piece of a B-spline. Plain data, nothing allocates. Precondition of all functions: positive weights.
///
/// Source: Farin, Curves and Surfaces for CAGD, ch. 4-5 (de Casteljau, hulls) and 13 (rational).
struct BezierPiece {
    int degree = 1;                                         ///< 1 … 7
    std::array<Eigen::Vector4d, max_degree + 1> control{};  ///< (w_k P_k, w_k); the first degree + 1 count

    /// Cost about 0.1 µs for a cubic.
    CurvePoint evaluate(double v) const noexcept;
    Eigen::Vector3d at(double v) const noexcept;

    /// The part between two parameters, 0 ≤ from < to ≤ 1, over [0, 1] again.
    BezierPiece part(double from, double to) const noexcept;

    /// The curve of the control points turn·P_k + shift: an affine map of the curve.
    BezierPiece mapped(const Eigen::Matrix3d& turn, const Eigen::Vector3d& shift) const noexcept;

    /// Moves start and end to the given points; the curve between goes along, in proportion to the control points'
    /// number. For differences that are rounding.
    void fit_ends(const Eigen::Vector3d& start, const Eigen::Vector3d& end) noexcept;

    /// Σ |P_{k+1} − P_k|: bounds the length.
    double polygon_length() const noexcept;

    /// A bound of |C(v) − ((1 − v)·C(0) + v·C(1))| over all v, by the convex hull of the difference's control points:
    /// for a short piece at most 1.5 times the largest value (degree 3: 4/3).
    double chord_error() const noexcept;

    /// As a direction, C may have any length: a bound of the angle between C(v) and (1 − v)·n₀ + v·n₁, n₀ and n₁ the
    /// unit directions at the ends, rad; π where the control points do not all lie on the side of n₀ + n₁.
    double chord_turn() const noexcept;

    /// As a direction: Σ of the angles between the successive control points, rad; bounds the turn. π and more where
    /// one of them is 0.
    double polygon_turn() const noexcept;
};

}  // namespace trunnion::geometry
