#pragma once

#include <array>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "trunnion/base/result.hpp"
#include "trunnion/geometry/bezier_piece.hpp"

namespace trunnion::geometry {

/// One polynomial piece of a curve in power form over local v ∈ [0, 1]: C(u) = Σ c_k v^k, v = (u − u_begin)/(u_end −
/// u_begin).
struct PolynomialPiece {
    double u_begin = 0, u_end = 0;
    int degree = 0;
    std::array<Eigen::Vector3d, max_degree + 1> coefficients_mm{};  ///< the first degree + 1 count, the others are 0
};

/// B-spline curve of degree p ≤ 7: C(u) = Σ N_{i,p}(u) P_i, with weights Σ N_{i,p}(u) w_i P_i / Σ N_{i,p}(u) w_i; u
/// from t_p to t_n for n control points and the knots t_0 ≤ … ≤ t_{n+p}, clamped or not. Basis functions live on
/// half-open intervals [t_i, t_{i+1}[ with 0/0 := 0; at the end of the domain the last non-empty interval is closed.
/// Where an inner knot has multiplicity m the curve is C^{p−m}, and the derivatives given there are those on the right.
///
/// Immutable. Source: Piegl & Tiller, The NURBS Book, §3.2-3.3 (derivatives as B-splines of differences of the control
/// points), evaluated by de Boor's recurrence; with weights in homogeneous coordinates, derivatives by eq. 4.8.
class BsplineCurve {
  public:
    /// Errors: GEOM0101 degree not in 1…7, GEOM0102 not p + 1 or more control points, or knots ≠ control points + p +
    /// 1, GEOM0103 knots decrease or are not finite, GEOM0104 a knot more often than p times inside or p + 1 times at
    /// an end (the curve would break) or an empty domain, GEOM0105 a control point is not finite, GEOM0107 weights are
    /// not one a control point, or not positive and finite. No weights: all are 1.
    static Result<BsplineCurve> make(int degree, std::vector<double> knots,
                                     std::vector<Eigen::Vector3d> control_points_mm, std::vector<double> weights = {});

    int degree() const noexcept { return degree_; }
    double begin() const noexcept { return knots_[static_cast<std::size_t>(degree_)]; }
    double end() const noexcept { return knots_[points_.size()]; }
    const std::vector<double>& knots() const noexcept { return knots_; }
    const std::vector<Eigen::Vector3d>& control_points_mm() const noexcept { return points_; }
    const std::vector<double>& weights() const noexcept { return weights_; }  ///< empty: all are 1

    /// Outside [begin, end] the first or last piece is continued. No allocation. Cost about 0.15 µs for a cubic, a
    /// search in the knots included; with weights 0.25 µs.
    CurvePoint evaluate(double u) const noexcept;

    /// The curve as polynomials, one for every non-empty knot interval, in order and without gaps. Precondition: no
    /// weights. Allocates.
    std::vector<PolynomialPiece> pieces() const;

    /// The non-empty knot interval t_s ≤ u < t_{s+1} within the domain; outside of it the first or the last one.
    std::pair<double, double> interval_at(double u) const noexcept;

    /// The curve from `from` to `to` as a Bézier curve of the same degree. Precondition: `from` < `to`, both in the
    /// closure of one knot interval. No allocation. Cost about 0.5 µs for a cubic.
    BezierPiece piece(double from, double to) const noexcept;

  private:
    BsplineCurve() = default;
    std::size_t span_of(double u) const noexcept;
    std::array<Eigen::Vector3d, max_degree + 1> local_points(std::size_t span) const noexcept;
    std::array<Eigen::Vector4d, max_degree + 1> local_homogeneous(std::size_t span) const noexcept;

    int degree_ = 0;
    std::vector<double> knots_;
    std::vector<Eigen::Vector3d> points_;
    std::vector<double> weights_;
};

}  // namespace trunnion::geometry
