#pragma once

#include <span>
#include <vector>

#include "trunnion/surfacing/plan_surface.hpp"

namespace trunnion::surfacing::detail {

/// Up the tool axis.
CutterPose raised(const CutterPose& pose, double height_mm);

/// A way between passes.
struct Link {
    double height_mm = 0;           ///< up the tool axis; 0: as the options say
    std::vector<CutterPose> round;  ///< empty, or rapids from above the one pass to above the other
};

/// Whether the way from one pass to another is a short one, over the lift height.
bool is_beside(const Pass& before, const Pass& next, const SurfaceOptions& options);

/// Makes a program of a plan's passes: from the retract height down to each pass and up again, over the lift height
/// between the ends of passes beside each other. `links`: the way to each pass, and up from the last one; empty: all as
/// the options say. Diagnostics of the plan's program stay.
void write_program(SurfacePlan& plan, const SurfaceOptions& options, std::span<const Link> links);

/// The moves of one link, from the end of `before` down to the begin of `next`; either may be null.
program::Program program_of_link(const Pass* before, const Pass* next, const SurfaceOptions& options, const Link& link);

}  // namespace trunnion::surfacing::detail
