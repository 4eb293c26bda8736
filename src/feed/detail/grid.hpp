#pragma once

#include <vector>

#include "trunnion/base/result.hpp"
#include "trunnion/feed/interval.hpp"

/// Where the intervals of a stretch lie, and their samples.
namespace trunnion::feed {

/// An interval without its samples.
struct Cell {
    path::PathPlace begin;
    double length_mm = 0;
    std::size_t block = 0;  ///< of the tool path, whose feed holds
    bool from_rest = false, to_rest = false;
};

/// Cells from begin to end of the path; the first and the last one are the arcs at rest. Sizes follow the path, grow by
/// 1.15 from the arcs and at most about 1.5 elsewhere.
std::vector<Cell> make_grid(const path::AxisPath& path, const LimitSet& limits);

/// Evaluates the path in a cell. Errors: FEED0002.
Result<Interval> sample_cell(const path::AxisPath& path, const Cell& cell);

}  // namespace trunnion::feed
