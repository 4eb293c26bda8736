#pragma once

#include <span>
#include <vector>

#include "trunnion/surfacing/freed_plan.hpp"

namespace trunnion::surfacing::detail {

/// How high up the tool axis the way to each pass goes so that the tool is nowhere in the part, and the way up from the
/// last one: one more than passes. 0: as the options say. The retract height is tried, and doubled up to 5 times.
/// Errors: SURF0314.
Result<std::vector<double>> free_links(std::span<const Pass> passes, const Cutter& cutter, const PartBody& part,
                                       const SurfaceOptions& options, const FreeingOptions& freeing);

/// The same to twice the part's tolerance; 0 too where no height is free.
std::vector<double> links_where_free(std::span<const Pass> passes, const Cutter& cutter, const PartBody& part,
                                     const SurfaceOptions& options);

}  // namespace trunnion::surfacing::detail
