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
};

/// The cutter contact at one parameter w of a curve on a surface.
struct SurfaceContact {
    double w = 0;
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
/// (Affouard 2004, Eq. 1, with tip = C_L − r·u); with lead = tilt = 0 the tip is C.
///
/// (u, v) is polynomial between the knots of its spline. Where both the spline and the surface are C⁴ the pose is C³;
/// `rough_places` are the others. Immutable after make(); everything else is noexcept and allocates nothing.
class SurfaceCurve {
  public:
    /// `places`: u and v over w as first and second coordinate, the third is not looked at. The surface must outlive
    /// the curve.
    /// Errors: INTP0001 tool dimensions or angles without meaning (0 ≤ r ≤ R > 0, |lead|, |tilt| < 90°), INTP0002 the
    /// curve leaves the surface's domain by more than 1e-6 of it, INTP0003 no normal, or no way ahead, at a place of
    /// the curve (looked at eight times between knots), INTP0004 places with weights.
    static Result<SurfaceCurve> make(const geometry::BsplineSurface& surface, geometry::Side side,
                                     const geometry::BsplineCurve& places, const SurfaceTool& tool);

    double begin() const noexcept { return pieces_.front().u_begin; }
    double end() const noexcept { return pieces_.back().u_end; }
    const geometry::BsplineSurface& surface() const noexcept { return *surface_; }
    const SurfaceTool& tool() const noexcept { return tool_; }

    geometry::SurfacePlace place(double w) const noexcept;

    /// Cost about 0.5 µs for a bicubic.
    SurfaceContact contact(double w) const noexcept;
    /// The tool there. Cost about 30 ns.
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
    /// Where the curve crosses a knot of the surface at which it is not C⁴ there, ascending. A curve that runs along
    /// such a knot does not cross it.
    std::vector<double> rough_places() const;

  private:
    SurfaceCurve() = default;
    struct Parameters;
    std::size_t piece_at(double w) const noexcept;
    Parameters parameters(double w) const noexcept;
    Result<void> check(double w) const;

    const geometry::BsplineSurface* surface_ = nullptr;
    geometry::Side side_ = geometry::Side::along;
    std::vector<geometry::PolynomialPiece> pieces_;
    SurfaceTool tool_;
    double tan_lead_ = 0, tan_tilt_ = 0;
    double cosine_ = 1, sine_ = 0;  // of the angle between normal and axis
};

}  // namespace trunnion::interpolation
