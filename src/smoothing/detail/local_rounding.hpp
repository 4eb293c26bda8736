#pragma once

#include <vector>

#include "trunnion/path/tool_path.hpp"
#include "trunnion/smoothing/smoothing.hpp"

#include "detail/coordinates.hpp"

namespace trunnion::smoothing {

/// Rounding::beudaert: every vertex between straight blocks on its own, by at most half of the shorter block. Blocks
/// that turn a vector far, and arcs, are divided into straight ones first, at the cost of at most a fifth of the
/// tolerances. A standstill is left where a corner cannot be rounded: reversals, and vertices at which the tip or the
/// top point stands still on one side; with Link::linear also where a rounding that turns the tool joins its legs.
void round_locally(const path::Run& run, VertexRange range, path::StopCause stop, const SmoothingOptions& options,
                   std::vector<path::ToolPath>& out);

}  // namespace trunnion::smoothing
