#pragma once

#include <vector>

#include "trunnion/surfacing/plan_surface.hpp"

namespace trunnion::surfacing::detail {

/// The passes as a program: from the retract height down to each pass and up again, over the lift height between the
/// ends of passes beside each other.
program::Program program_of(const std::vector<Pass>& passes, const SurfaceOptions& options);

}  // namespace trunnion::surfacing::detail
