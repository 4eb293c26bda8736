#pragma once

#include <algorithm>

namespace trunnion::pipeline {

/// The part as it is looked at wherever a plan keeps out of it and wherever that is checked: one body, and one idea of
/// how deep is a gouge, so that what is planned does not fail its check.

/// Of the part's triangles. Links and parts of passes are planned to depths of passing_depth_mm(); chords and triangles
/// are within the gouge tolerance of what is meant.
inline double part_tolerance_mm(double gouge_tolerance_mm) {
    constexpr double share = 0.5, finest_mm = 0.002;
    return std::max(share * gouge_tolerance_mm, finest_mm);
}
inline double passing_depth_mm(double gouge_tolerance_mm) {
    return std::max(gouge_tolerance_mm, 2 * part_tolerance_mm(gouge_tolerance_mm));
}

/// Between poses of a check, of a tool of that radius: tools of 50 mm and more in proportion, and none through a sheet.
inline double check_step_mm(double radius_mm) {
    return std::min(std::max(1.0, 0.02 * radius_mm), 0.5 * radius_mm);
}

}  // namespace trunnion::pipeline
