#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "trunnion/base/result.hpp"

namespace trunnion::geometry {

inline constexpr int max_degree = 7;

/// One polynomial piece of a curve in power form over local v ∈ [0, 1]: C(u) = Σ c_k v^k, v = (u − u_begin)/(u_end −
/// u_begin).
struct PolynomialPiece {
    double u_begin = 0, u_end = 0;
    int degree = 0;
    std::array<Eigen::Vector3d, max_degree + 1> coefficients_mm{};  ///< the first degree + 1 count, the others are 0
};

/// A curve's point and its first three derivatives by u: mm, mm/u, mm/u², mm/u³.
using CurvePoint = std::array<Eigen::Vector3d, 4>;

/// Non-rational B-spline curve of degree p ≤ 7: C(u) = Σ N_{i,p}(u) P_i, u from t_p to t_n for n control points and the
/// knots t_0 ≤ … ≤ t_{n+p}, clamped or not. Basis functions live on half-open intervals [t_i, t_{i+1}[ with 0/0 := 0;
/// at the end of the domain the last non-empty interval is closed. Where an inner knot has multiplicity m the curve is
/// C^{p−m}, and the derivatives given there are those on the right.
///
/// Immutable. Source: Piegl & Tiller, The NURBS Book, §3.2-3.3 (derivatives as B-splines of differences of the control
/// points), evaluated by de Boor's recurrence.
class BsplineCurve {
  public:
    /// Errors: GEOM0101 degree not in 1…7, GEOM0102 not p + 1 or more control points, or knots ≠ control points + p +
    /// 1, GEOM0103 knots decrease or are not finite, GEOM0104 a knot more often than p times inside or p + 1 times at
    /// an end (the curve would break) or an empty domain, GEOM0105 a control point is not finite.
    static Result<BsplineCurve> make(int degree, std::vector<double> knots,
                                     std::vector<Eigen::Vector3d> control_points_mm);

    int degree() const noexcept { return degree_; }
    double begin() const noexcept { return knots_[static_cast<std::size_t>(degree_)]; }
    double end() const noexcept { return knots_[points_.size()]; }
    const std::vector<double>& knots() const noexcept { return knots_; }
    const std::vector<Eigen::Vector3d>& control_points_mm() const noexcept { return points_; }

    /// Outside [begin, end] the first or last piece is continued. No allocation. Cost about 0.15 µs for a cubic, a
    /// search in the knots included.
    CurvePoint evaluate(double u) const noexcept;

    /// The curve as polynomials, one for every non-empty knot interval, in order and without gaps. Allocates.
    std::vector<PolynomialPiece> pieces() const;

  private:
    using Local = std::array<Eigen::Vector3d, max_degree + 1>;

    BsplineCurve() = default;
    std::size_t span_of(double u) const noexcept;
    Local control_of(std::size_t span) const noexcept;
    void differentiate(Local& local, std::size_t span, int order) const noexcept;
    Eigen::Vector3d de_boor(Local local, std::size_t span, int degree, double u) const noexcept;

    int degree_ = 0;
    std::vector<double> knots_;
    std::vector<Eigen::Vector3d> points_;
};

}  // namespace trunnion::geometry
