#pragma once

#include <array>

#include <Eigen/Core>

#include "trunnion/base/result.hpp"
#include "trunnion/geometry/bspline_curve.hpp"
#include "trunnion/geometry/dual_spline.hpp"

/// Rounding of one corner by a cubic B-spline of five control points on the knots 0 0 0 0 ½ 1 1 1 1.
///
///     P0 ──── P1 ──────── P2        P2 is the corner; P0, P1 lie before it and P3, P4 behind it, on the segments.
///                           ╲       L1 = |P1P2| = |P2P3| is the inner length, L2 = |P0P2| (and |P4P2|) the outer one,
///                            P3     r = L2/L1 > 1 the ratio, α the interior angle P1P2P3: 180° is straight.
///                             ╲
///                              P4
///
/// Three points in line at each end make the joins to the segments G²; the third derivative jumps there (see
/// end_curvature_slope). Source: Beudaert 2013, §2.2 and appendix A; docs/theory/corner-rounding.md derives all of it.
namespace trunnion::smoothing {

/// Outer length over inner length where nothing else is asked: within two percent of the fastest at a 90° corner.
inline constexpr double usual_corner_ratio = 1.4;
/// The top polygon of a five-axis corner is kept from folding: its outer lengths are at least this times the inner one.
inline constexpr double least_top_ratio = 1.4;

/// Row i: B_i and its first three derivatives by u.
using CornerBasis = Eigen::Matrix<double, 5, 4>;

enum class Half { first, second };

/// The basis functions of Eq. A.2, u in [0, ½] or [½, 1]; `half` says which polynomials: at u = ½ the third derivatives
/// of both differ. Elsewhere the polynomials of that half are continued. No allocation, 20 ns.
CornerBasis corner_basis(double u, Half half) noexcept;

/// What the derivatives at one end of a corner curve depend on.
struct CornerSide {
    double inner_mm = 0, outer_mm = 0;  ///< L1 = |P1P2|; L2 = |P0P2|, or |P4P2| at the exit
    double cosine = -1;                 ///< of the interior angle α; −1: straight
};

/// L1 = 2ε/cos(α/2): the inner length that uses the tolerance ε ≥ 0; +∞ where the corner is straight.
double inner_length_mm(double tolerance_mm, double cosine) noexcept;

/// ε = ½ L1 cos(α/2): distance from the corner to the curve, which is at u = ½ (Eq. 3). The outer length has no part.
double corner_error_mm(double inner_mm, double cosine) noexcept;

/// ε sin(α/2): the largest distance from the curve to the programmed polyline, also at u = ½.
double polyline_error_mm(double inner_mm, double cosine) noexcept;

/// dκ/ds = sin α/(18 L1² (r − 1)³), 1/mm²: slope of the curvature at the join, on the curve's side. On the segment's
/// side it is 0, so this is the jump of the path's third derivative; it grows without bound as r → 1.
double end_curvature_slope(const CornerSide& side) noexcept;

struct CornerShape {
    double tolerance_mm = 0;            ///< corner → curve, > 0
    double ratio = usual_corner_ratio;  ///< r > 1
};

/// The rounded corner of two segments, before → corner → after, mm in any frame. L1 uses the tolerance; L2 = r L1, but
/// at most half of the shorter segment (then L1 = L2/r), so that neighbouring corners do not meet. Where the segments
/// are in line the curve is that line, over half of the shorter one.
///
/// Errors: SMTH0101 tolerance not finite or not above 0, SMTH0102 a segment without length or a point not finite,
/// SMTH0103 the way back is the way there (α below 0.001 rad), SMTH0104 ratio not finite or not above 1. Allocates.
Result<geometry::BsplineCurve> corner_spline(const Eigen::Vector3d& before_mm, const Eigen::Vector3d& corner_mm,
                                             const Eigen::Vector3d& after_mm, const CornerShape& shape);

/// A pose by two points of the tool: the tip and one at a height up its axis.
struct RuledPose {
    Eigen::Vector3d bottom_mm, top_mm;
};

struct DualCornerShape {
    double tip_tolerance_mm = 0;        ///< bottom corner → bottom curve, > 0
    double top_tolerance_mm = 0;        ///< the same of the top, > 0: the orientation tolerance at the height
    double ratio = usual_corner_ratio;  ///< of the bottom curve, > 1
};

/// A five-axis corner: both curves, and what the link of their parameters is made of. Index 0: entry, 1: exit, seen
/// from outside in both cases (the exit is the entry of the corner run backwards).
struct DualCorner {
    geometry::DualSpline curves;
    std::array<CornerSide, 2> bottom, top;
    std::array<double, 2> rate;  ///< σ = dl_top/dl_bottom on the segment
};

/// Rounds both loci of a corner between two ruled segments (tip and top point linear, at the same share of the way).
/// The bottom curve is corner_spline()'s. Where it begins and ends, so does the top curve: its outer lengths are σ
/// times those of the bottom. Its inner length uses its own tolerance as far as L1 ≤ L2/least_top_ratio at both ends;
/// beyond that the polygon would fold. Each curve passes within its tolerance of its own corner, at u = ½ of its own
/// parameter. The two share knots but not their parameter: see link.hpp. Up to a ratio of 2.4 closed_link() finds one
/// for every such corner.
///
/// Errors: those of corner_spline(), of the bottom or of the top; a top point that stands still is a segment without
/// length. Allocates.
Result<DualCorner> dual_corner(const RuledPose& before, const RuledPose& corner, const RuledPose& after,
                               const DualCornerShape& shape);

}  // namespace trunnion::smoothing
