#pragma once

#include <cstddef>
#include <optional>

#include "trunnion/path/tool_path.hpp"

namespace trunnion::smoothing {

/// Where one path goes over to another one that is the same there but for rounding.
struct Splice {
    std::size_t from_piece = 0;  ///< of the first path, where the result begins; nothing of it changes up to `at_piece`
    std::size_t at_piece = 0;    ///< of the first path: at its begin the result leaves it
    double behind_mm = 0;        ///< p of the first path at which the second one begins (may be negative)
};

/// The first path up to a place and the second one behind it: of two smoothings of one program, the first without its
/// end, the second without its begin. Away from those, by the reach of a bump or two, both are the same curve, cut into
/// other pieces; the piece behind the joint is the septic polynomial from the state of the first to that of the second,
/// so that the result is C³. What that piece is off the second path is added to `bound`.
///
/// Pieces and blocks of the first path before `at_piece` are taken over as they are, from `from_piece` and the block
/// in which it begins on; blocks of both are the same by `line`. None where the paths are farther apart at the joint
/// than `largest_gap` (mm; rad · 30 mm), or the second one is not there.
std::optional<path::ToolPath> spliced(const path::ToolPath& first, const path::ToolPath& second, const Splice& where,
                                      double largest_gap);

}  // namespace trunnion::smoothing
