#pragma once

#include <cstddef>
#include <span>

#include "trunnion/base/result.hpp"
#include "trunnion/surfacing/part_body.hpp"
#include "trunnion/surfacing/plan_surface.hpp"

namespace trunnion::surfacing {

struct LeavingOptions {
    double tolerance_mm = 0.01;  ///< depths up to it are no gouges; at least twice the part's tolerance
    Holder holder{};
};

/// A plan whose tool is nowhere in the part, and what that took.
struct ReachedPlan {
    SurfacePlan plan;                 ///< SurfacePlan::left: places of all that was cut away, too
    double left_way_mm = 0;           ///< of passes, that was cut away
    double deepest_mm = 0;            ///< that the tool would be in the part, of all poses that were looked at
    std::size_t passes_lost = 0;      ///< of which nothing is left
    std::size_t ridges_too_high = 0;  ///< places where no distance of passes keeps the scallop, or that none gets to
};

/// Cuts away the parts of passes where the tool would be in the part, to 0.01 mm along the pass, and lays the links
/// anew: over the lift height, over the retract height, doubled up to 5 times, over the lift height from any pass to
/// the next one, or round the part, in a ball that holds it, from one end of a pass to the next one. Ends of passes
/// that the tool does not get to or away from are cut back. Contacts that stay are not moved.
///
/// `plan`: of SurfaceOptions::leave_out. `part`: of the faces of the plan first, in their order, then of any others.
/// Errors: SURF0301 an option out of range; SURF0315 nothing is left of the plan. Cost: 5-20 µs a pose.
Result<ReachedPlan> leave_out_gouges(SurfacePlan plan, std::span<const Face> faces, const Cutter& cutter,
                                     const PartBody& part, const SurfaceOptions& options,
                                     const LeavingOptions& leaving = {});

/// Lays the links of a plan anew, passes as they are, the same way; as the options say where no way is free, which a
/// check of the program finds. Cost: 5-20 µs a pose.
void lead_links_clear(SurfacePlan& plan, const Cutter& cutter, const PartBody& part, const SurfaceOptions& options,
                      const LeavingOptions& leaving);

/// What links keep clear of.
struct PartBeside {
    const Cutter& cutter;
    const PartBody& body;
    LeavingOptions leaving;
};

/// One link of that kind, of passes that come one by one: the moves from the end of `before`, which is moves[0], down
/// to the first contact of `next`. Either may be missing: then they begin above `next`, or end above `before`; of both
/// the contacts there and the index count. Without a part, or where no way is free: as the options say.
program::Program link_between(const Pass* before, const Pass* next, const SurfaceOptions& options,
                              const PartBeside* part);

}  // namespace trunnion::surfacing
