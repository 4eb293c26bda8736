#pragma once

#include <array>

#include <Eigen/Core>

#include "trunnion/base/result.hpp"
#include "trunnion/geometry/bspline_curve.hpp"
#include "trunnion/geometry/dual_spline.hpp"
#include "trunnion/machine/kinematics.hpp"
#include "trunnion/numeric/taylor3.hpp"
#include "trunnion/smoothing/link.hpp"

/// How a pair of curves, bottom C_b and top C_t, is joined to any path so that the orientation goes on smoothly: the
/// general problem of Beudaert 2013, §2.6. With the link u_top = f(u_bottom) and s the bottom curve's path length,
///
///     n(s) = D/‖D‖,   D = C_t(f(u(s))) − C_b(u(s)),
///
/// differentiated exactly, the change of ‖D‖ included (Eq. B.3 to B.5 neglect it). Series of poses are by s in mm.
namespace trunnion::smoothing {

/// The tip in mm and the unit tool axis as series in the bottom curve's path length.
struct LinkedPose {
    machine::VectorSeries tip_mm, tool_axis;
};

/// A curve at a share of its domain in [0, 1], with the derivatives by that share: curves of different knots get the
/// common domain that a link needs. No allocation.
geometry::CurvePoint point_at_share(const geometry::BsplineCurve& curve, double share) noexcept;

/// Both points of the tool at one place. `top` is the top curve at f(u) with derivatives by its own parameter, `link`
/// the series of f by u at u (its value has no part). Preconditions: the curves do not meet there and the bottom one
/// does not stand still. No allocation, 0.1 µs.
LinkedPose linked_pose(const geometry::CurvePoint& bottom, const geometry::CurvePoint& top,
                       const Taylor3& link) noexcept;

/// The same at a share of two curves' domains: the top curve is evaluated at the link's value. 0.7 µs.
LinkedPose linked_pose(const geometry::BsplineCurve& bottom, const geometry::BsplineCurve& top, double share,
                       const Taylor3& link) noexcept;

/// One end of a link, and how the orientation steps over the join with it.
struct Connection {
    LinkEnd end;
    std::array<double, 4> jump{};  ///< ‖n^(k) of the pair − n^(k) of the path‖ for k = 0…3, rad/mm^k
};

/// The entry of a link from what comes before it. `path` is the tool axis on the way to the join, by path length in
/// the direction of motion; both curves start at the join. For an exit all is seen backwards: backwards() of each.
///
/// f′ makes n′ continuous, f″ makes n″ so where the curves' own curvatures allow it, f‴ makes the step of n‴ least:
/// each by Newton's method on the exact derivative, which is affine in its unknown. `jump` says what is left: with
/// curves that meet the path's loci in position, tangent and curvature it is rounding for k < 3.
///
/// Between ruled segments and corner curves f′ and f″ are those of closed_link_end(), and so is f‴ where the tool
/// stands across the motion of both points; elsewhere this one leaves less. Cost about 1 µs, no allocation where it
/// succeeds.
///
/// Errors: SMTH0111 the curves meet, the bottom one stands still, or the top one moves along the tool alone; SMTH0112
/// the orientation jumps by more than 1e-6 rad; SMTH0113 the top curve does not leave along the path's own direction
/// (more than `tangent_tolerance_rad` off, seen along the tool); SMTH0114 it would have to run backwards or stand.
Result<Connection> connect_end(const machine::VectorSeries& path, const geometry::CurvePoint& bottom,
                               const geometry::CurvePoint& top, double tangent_tolerance_rad = 1e-6);

machine::VectorSeries backwards(const machine::VectorSeries& series) noexcept;
geometry::CurvePoint backwards(const geometry::CurvePoint& point) noexcept;

/// The tool axis of a dual spline by its bottom curve's path length.
machine::VectorSeries tool_axis_by_length(const geometry::DualSpline& path, double u) noexcept;

/// The whole link of a pair of curves that leads from the end of one dual spline to the beginning of another. The four
/// may have any degrees and knots. Allocates only to refuse.
/// Errors: those of connect_end() at either end; SMTH0115 no polynomial of degree 7 through both ends increases.
Result<ParameterLink> connect(const geometry::DualSpline& before, const geometry::BsplineCurve& bottom,
                              const geometry::BsplineCurve& top, const geometry::DualSpline& after,
                              double tangent_tolerance_rad = 1e-6);

}  // namespace trunnion::smoothing
