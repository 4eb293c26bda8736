#pragma once

#include <vector>

#include "detail/path_thinning.hpp"

namespace trunnion::report::detail {

/// By how much the feed differs from that of the nearest other pass, as a share of the greater of both, 0 … 1: where it
/// is large the passes leave marks of different depth. NaN: a rapid, or no other pass within the last of `reaches_mm`.
/// These ascend: what finds no other pass within one looks within the next, so that passes of any density cost alike.
/// Another pass is what lies near in space and far along the path: more than three times the reach of the tip's way.
/// Cost O(n).
std::vector<float> neighbour_differences(const std::vector<PathPlace>& places, const std::vector<double>& reaches_mm);

/// How far to look: 0.5, 2 and 8 % of the size of the cutting path, the last at most 20 mm.
std::vector<double> neighbour_reaches_mm(const std::vector<PathPlace>& places);

}  // namespace trunnion::report::detail
