#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>

#include "trunnion/base/result.hpp"
#include "trunnion/surfacing/gouge.hpp"
#include "trunnion/surfacing/plan_surface.hpp"

namespace trunnion::surfacing {

struct FreeingOptions {
    double tolerance_mm = 0.001;  ///< depths up to it are no gouges; at least twice the part's tolerance
    /// Of lead and tilt, counted from the feed of every pass; across it, along a border, those of the lead hold to both
    /// sides. `feed` is not used.
    OrientationLimits limits{};
    Holder holder{};
};

/// A plan without gouges, and what it took.
struct FreedPlan {
    SurfacePlan plan;  ///< passes turned say on which orientation surface they stand, which needs the plan's faces
    std::array<std::size_t, 4> gouges{};  ///< contacts from which a move gouged, by GougeKind
    std::optional<Gouge> worst;           ///< of them; none: nothing gouged, and no pass was changed
    std::size_t poses = 0;                ///< looked at in the plan as it was
    std::size_t passes_turned = 0;        ///< that stand on a deformed orientation surface
    double largest_turn_rad = 0;          ///< of the axis at a contact
    double largest_step_rad = 0;          ///< between neighbouring contacts of a pass, of the passes turned
    int rounds = 0;                       ///< of deforming, the most that any of the surfaces took
    std::size_t links_raised = 0;         ///< ways between passes that go higher than the options say
    double highest_link_mm = 0;           ///< up the tool axis, of those
};

/// Frees a plan of gouges: passes that gouge are laid on an orientation surface that is deformed (remove_gouges()), and
/// ways between passes that touch the part lead higher up the tool axis: over the retract height, doubled up to 5
/// times.
///
/// Passes of a face that lean alike have one orientation surface: those forwards, those backwards, and those along
/// borders by the nearest of four directions. Where none of them gouges they stay as they were. The contacts stay
/// anyway; with tools that are no balls ridges change with the lean, so a plan that was changed is to be simulated.
///
/// `part`: of the faces of the plan first, in their order, then of any others. Errors: SURF0313 a pass that goes on
/// over several faces gouges; SURF0314 no way between two passes is free, with place and depth; those of
/// GuidingSurface, OrientationSurface, remove_gouges() (SURF0310, SURF0311: no orientation is free, where and how deep)
/// and find_gouges(). Cost: that of find_gouges() for all passes and of remove_gouges() for those that gouge.
Result<FreedPlan> free_of_gouges(SurfacePlan plan, std::span<const Face> faces, const Cutter& cutter,
                                 const PartBody& part, const SurfaceOptions& options, const FreeingOptions& freeing);

}  // namespace trunnion::surfacing
