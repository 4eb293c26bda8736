#pragma once

#include "trunnion/geometry/surface_shape.hpp"
#include "trunnion/surfacing/orientation_surface.hpp"

#include "detail/bezier_patch.hpp"

namespace trunnion::surfacing::detail {

/// A lean from the normal of a face, counted from a feed.
struct LeanField {
    geometry::Side side;
    FeedReference feed;
    Lean lean;
    double height_mm;
};

/// How far the way from a patch of S₁ to one of S₂ is off `height` times the axis of the lean, mm: never more, over
/// the whole rectangle of the three patches; infinite where that cannot be said. By Bernstein coefficients, to
/// rounding. Cost: 0.2 ms for bicubics along u or v, 0.4 ms by a direction.
double lean_error_bound_mm(const LeanField& field, const BezierPatch& face, const BezierPatch& guiding,
                           const BezierPatch& orientation);

}  // namespace trunnion::surfacing::detail
