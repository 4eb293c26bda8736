#pragma once

#include <span>

#include "trunnion/base/result.hpp"
#include "trunnion/geometry/bspline_curve.hpp"
#include "trunnion/geometry/bspline_surface.hpp"

namespace trunnion::interpolation {

/// A C⁴ curve in (u, v) along places of a pass: a quintic B-spline over the length of their polyline in space, mm, by
/// least squares with as few knots as leave every place within `tolerance_mm` of the curve, measured on the surface
/// across the curve; through the first and the last place. Fewer than six places: the polynomial through them.
///
/// The length of chords as parameter makes |C′| nearly 1. Points of a curve on the surface are on the surface whatever
/// the tolerance: it moves the pass sideways, by less than what shows in ridges.
///
/// Third coordinate 0. Errors: INTP0005 fewer than two places apart, or they do not make a curve. Cost: some µs a
/// place. Allocates.
Result<geometry::BsplineCurve> fit_places(const geometry::BsplineSurface& surface,
                                          std::span<const geometry::SurfacePlace> places, double tolerance_mm);

}  // namespace trunnion::interpolation
