#pragma once

#include <cstddef>
#include <vector>

#include "trunnion/deformation/flank_milling.hpp"

namespace trunnion::deformation {

/// A height of the tool at a place of the path, and where it faces the surface.
struct FlankSample {
    std::size_t u_index = 0, height_index = 0;
    double u = 0, height_mm = 0;
    SurfaceFoot facing;  ///< nearest to the point of the axis
};

/// The u and heights of a range.
std::vector<double> places_along(const DualPath& path, const FlankRange& range);
std::vector<double> heights_of(const FlankRange& range);

/// All samples of a range, u by u, from the lowest height up. Errors: DEFO0105, DEFO0111, DEFO0112 as deviation_map().
Result<std::vector<FlankSample>> walk_flank(const DualPath& path, const FlankTool& tool, const DesignedSurface& surface,
                                            const FlankRange& range);

Diagnostic no_envelope(const FlankSample& sample);

}  // namespace trunnion::deformation
