#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "trunnion/base/result.hpp"
#include "trunnion/geometry/bspline_curve.hpp"
#include "trunnion/geometry/surface_shape.hpp"
#include "trunnion/machine/kinematics.hpp"

namespace trunnion::interpolation {

/// The tool that touches a surface: radius R, corner radius r (0: flat, R: ball), and how its axis stands.
struct SurfaceTool {
    double radius_mm = 0, corner_mm = 0;
    double lead_rad = 0;  ///< axis leaning from the normal towards the feed
    double tilt_rad = 0;  ///< axis leaning towards normal × feed
    /// In place of lead and tilt: an orientation surface S₂ over the surface's (u, v), which must outlive the curve.
    /// The axis is the direction from S + r n to S₂.
    const geometry::BsplineSurface* orientation = nullptr;
};

/// The cutter contact at one parameter w of a curve on a surface.
struct SurfaceContact {
    double w = 0;
    geometry::SurfacePlace place;
    Eigen::Vector3d point_mm, by_w, by_ww;  ///< C, C′, C″
    Eigen::Vector3d normal;                 ///< unit, out of the material
    double rate_mm = 0;                     ///< |C′|: mm of contact way a unit of w
    double rate_slope_mm = 0;               ///< d|C′|/dw = C′·C″/|C′|
};

/// What moves, as series in one parameter: exact derivatives to order 3.
struct SurfaceSeries {
    machine::VectorSeries contact, tip, axis;  ///< mm; axis unit, tip → spindle
};

/// A curve C(w) = S(u(w), v(w)) on a surface, with a tool that touches the surface there.
///
/// With n the unit normal out of the material and t = C′/|C′| the feed, the tool axis is the direction of
/// n + tan(lead) t + tan(tilt) n×t, and the tip is C + r n + (R − r) v − r axis, v the unit part of n across the axis
/// (Affouard 2004, Eq. 1, with tip = C_L − r·u); with lead = tilt = 0 the tip is C. With an orientation surface the
/// axis is the direction of S₂(u, v) − (S + r n), and the tip follows in the same way.
///
/// (u, v) is polynomial between the knots of its spline. Where both the spline and the surface are C⁴, and the
/// orientation surface C³, the pose is C³; `rough_places` are the others. Immutable after make(); everything else is
/// noexcept and allocates nothing.
class SurfaceCurve {
  public:
    /// `places`: u and v over w as first and second coordinate, the third is not looked at. The surface must outlive
    /// the curve.
    /// Errors: INTP0001 tool dimensions or angles without meaning (0 ≤ r ≤ R > 0, |lead|, |tilt| < 90°), INTP0002 the
    /// curve leaves the surface's domain, or that of the orientation surface, by more than 1e-6 of it, INTP0003 no
    /// normal, or no way ahead, at a place of the curve, INTP0004 places with weights, INTP0009 an axis of the
    /// orientation surface less than 1° above the tangent plane, or, but of a ball, nearer to the normal than 0.001
    /// rad, where the side that the tool touches with is not defined. All of these at eight places between knots.
    static Result<SurfaceCurve> make(const geometry::BsplineSurface& surface, geometry::Side side,
                                     const geometry::BsplineCurve& places, const SurfaceTool& tool);

    double begin() const noexcept { return pieces_.front().u_begin; }
    double end() const noexcept { return pieces_.back().u_end; }
    const geometry::BsplineSurface& surface() const noexcept { return *surface_; }
    const SurfaceTool& tool() const noexcept { return tool_; }

    geometry::SurfacePlace place(double w) const noexcept;

    /// Cost about 0.5 µs for a bicubic.
    SurfaceContact contact(double w) const noexcept;
    /// The tool there. Cost about 30 ns; with an orientation surface 0.2 µs.
    machine::Pose pose(const SurfaceContact& contact) const noexcept;

    /// Pose and contact as series in w, exact to order 3. Cost about 2 µs for a bicubic.
    SurfaceSeries by_parameter(double w) const noexcept;
    /// The same as series in the way of the contact, s, mm: |dC/ds| = 1.
    SurfaceSeries by_way(double w) const noexcept;

    /// ∫ |C′| dw by Gauss quadrature: to 1e-13 of it over a part without a knot or rough place inside where |C′| does
    /// not change by more than some percent.
    double way_mm(double from, double to) const noexcept;

    /// Parameters at the ends and at the knots of (u, v) inside, ascending.
    std::vector<double> knots() const;
    /// Where the curve crosses a knot of the surface at which that is not C⁴, or one of the orientation surface at
    /// which that is not C³, ascending. A curve that runs along such a knot does not cross it.
    std::vector<double> rough_places() const;

  private:
    SurfaceCurve() = default;
    struct Parameters;
    std::size_t piece_at(double w) const noexcept;
    Parameters parameters(double w) const noexcept;
    Result<void> check(double w) const;
    Result<void> check_orientation(double w) const;
    machine::Pose pose_of(const SurfaceContact& contact, const Eigen::Vector3d& axis) const noexcept;
    SurfaceSeries on_orientation(const Parameters& at, const machine::VectorSeries& contact,
                                 const machine::VectorSeries& normal) const noexcept;

    const geometry::BsplineSurface* surface_ = nullptr;
    geometry::Side side_ = geometry::Side::along;
    std::vector<geometry::PolynomialPiece> pieces_;
    SurfaceTool tool_;
    double tan_lead_ = 0, tan_tilt_ = 0;
    double cosine_ = 1, sine_ = 0;  // of the angle between normal and axis
};

}  // namespace trunnion::interpolation
