#pragma once

#include <vector>

#include "trunnion/path/tool_path.hpp"

#include "detail/widths.hpp"

namespace trunnion::smoothing {

/// A part of the curve between two vertices, represented by itself: pieces depend on nothing outside the bumps' reach,
/// and a change of widths elsewhere leaves it alone. Vertices as in Bumps.
struct Section {
    std::size_t first = 0, last = 0;
    double length_mm = 0;
    std::vector<path::PathPiece> pieces;  ///< begin_mm counted from the section's start
};

/// Cuts a curve into sections of some ten widths on average, at programmed vertices. Whether a vertex is a cut depends
/// on its coordinates and the lengths of the blocks beside it alone: not on where the run starts, nor on its direction.
std::vector<Section> make_sections(const Curve& curve);

/// Represents the curve by septic Hermite pieces: at most a third of the narrowest bump each, halved until the quarter
/// points agree to 0.1 µm.
void represent(const Curve& curve, Section& section);

}  // namespace trunnion::smoothing
