#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "trunnion/path/tool_path.hpp"
#include "trunnion/smoothing/smoothing.hpp"

#include "detail/measure.hpp"
#include "detail/straight.hpp"

namespace trunnion::smoothing {

/// Programmed vertices inside a range that stand alone as corners: more than half of their kink is a corner at its own
/// scale, and its bump takes less than half of the shorter of both blocks, which are straight.
std::vector<std::size_t> lone_corners(const path::Run& run, VertexRange range, const Measure& measure);

/// Smooths what lies in a range: (range, why it stands still behind it, out).
using SmoothRange = std::function<void(VertexRange, path::StopCause, std::vector<path::ToolPath>&)>;

/// Smooths a range with its lone corners handed over to Beudaert's rounding: what lies between them is smoothed by
/// `between` as if it stood still at them, which leaves its ends straight where its blocks are; a corner takes as much
/// of that as it needs, at most half of the shorter block. A corner that finds no straight legs or cannot be rounded
/// is given back.
void smooth_with_handed_corners(const path::Run& run, VertexRange range, path::StopCause stop,
                                const SmoothingOptions& options, const SmoothRange& between,
                                std::vector<path::ToolPath>& out);

}  // namespace trunnion::smoothing
