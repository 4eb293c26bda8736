#pragma once

#include <span>
#include <vector>

#include "trunnion/surfacing/plan_surface.hpp"

namespace trunnion::surfacing::detail {

/// Up the tool axis.
CutterPose raised(const CutterPose& pose, double height_mm);

/// Whether the way from one pass to another is a short one, over the lift height.
bool is_beside(const Pass& before, const Pass& next, const SurfaceOptions& options);

/// The passes as a program: from the retract height down to each pass and up again, over the lift height between the
/// ends of passes beside each other. `heights_mm`: how high up the way to each pass goes, and the way up from the last
/// one, where it is above 0; empty: none is.
program::Program program_of(const std::vector<Pass>& passes, const SurfaceOptions& options,
                            std::span<const double> heights_mm = {});

}  // namespace trunnion::surfacing::detail
