#pragma once

#include "trunnion/base/result.hpp"
#include "trunnion/surfacing/face.hpp"

namespace trunnion::surfacing::detail {

/// SURF0211 where normals of a face are opposite on both sides of a place, so that nothing tells on which side of it
/// the material is: where the surface turns over between borders that cross, where it folds back, at the end of a line
/// on which it goes through itself. S_u × S_v is bounded patch by patch, by Bernstein coefficients; what these leave
/// open is halved down to 2 µm and then judged by normals at corners, which have to go on for 20 µm to both sides;
/// after 20 000 halvings what is left open counts as sound. Cost: some 10 µs a patch, at most some tenths of a second.
Result<void> check_side(const Face& face);

}  // namespace trunnion::surfacing::detail
