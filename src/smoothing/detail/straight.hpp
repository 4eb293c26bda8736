#pragma once

#include <vector>

#include "trunnion/path/tool_path.hpp"
#include "trunnion/smoothing/smoothing.hpp"

#include "detail/coordinates.hpp"

namespace trunnion::smoothing {

/// Change of the tangent, relative, that is rounding.
inline constexpr double no_kink = 1e-9;
/// Between tangents; sharper corners are reversals: |c′| of the rounded corner would fall to 0.07.
inline constexpr double reversal_cosine = -0.99;

/// dP/dp at the begin or end of a programmed block, orientation times the reference height: unit length but for the
/// lever. Law vector: of the slerp.
Coordinates tangent_at_begin(const path::Run& run, std::size_t block);
Coordinates tangent_at_end(const path::Run& run, std::size_t block);

/// Appends the programmed blocks between two vertices as they are, as one stretch. The vertices between must have no
/// kink.
void append_straight(const path::Run& run, VertexRange range, path::StopCause stop, const SmoothingOptions& options,
                     std::vector<path::ToolPath>& out);

/// A stretch with everything but pieces, bounds and uses.
path::ToolPath stretch(const path::Run& run, VertexRange range, path::StopCause stop);

}  // namespace trunnion::smoothing
