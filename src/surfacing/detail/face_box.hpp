#pragma once

#include "trunnion/base/result.hpp"
#include "trunnion/surfacing/face.hpp"

#include "detail/spline_fit.hpp"

namespace trunnion::surfacing::detail {

/// Breaks of a fit over a face's box: at the knots of its surface, joined as smoothly as normals of the surface are.
struct FaceBox {
    FitDirection u, v;
};
FaceBox face_box(const Face& face);

/// SURF0306 where the normal of the face jumps by more than `most_rad` across a knot line at which the surface's
/// derivatives may jump.
Result<void> check_creases(const Face& face, double most_rad);

}  // namespace trunnion::surfacing::detail
