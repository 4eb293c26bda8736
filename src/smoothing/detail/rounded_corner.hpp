#pragma once

#include <array>
#include <optional>
#include <vector>

#include "trunnion/smoothing/link.hpp"
#include "trunnion/smoothing/smoothing.hpp"

#include "detail/deviation_hull.hpp"

namespace trunnion::smoothing {

/// The two straight legs of a corner: how the neighbours' coordinates differ from the corner's, and the way there.
struct CornerLegs {
    std::array<Coordinates, 2> to_neighbour;  ///< before, after
    std::array<double, 2> gap_mm;
    std::array<double, 2> free_share;  ///< of each leg that the corner may take
    double lever = 1;                  ///< at least least_lever
};

/// A vertex of a polyline rounded by two corner splines with linked parameters: tip and top point under law vector,
/// tip and (tip, rotary axes) together where rotary axes are programmed. In the second form the top polygon never
/// degenerates either, and the closed form of the link holds as it is.
struct RoundedCorner {
    std::array<double, 2> reach_mm{};  ///< how much of p it takes of either leg
    std::vector<path::PathPiece>
        pieces;                   ///< from entry to exit, begin_mm counted from the entry; one ends at the vertex
    Extent extent;                ///< bound of the deviation
    Coordinates at_vertex;        ///< deviation at the vertex
    bool joins_smoothly = false;  ///< C² at both ends
};

/// Rounds the vertex `at` within the tolerances; inner lengths are reduced until the hull holds them. Nothing where the
/// tip or the top point stands still on a leg, or no increasing link is found.
std::optional<RoundedCorner> round_corner(const Coordinates& at, const CornerLegs& legs, Link link,
                                          const Measure& measure, DeviationHull& hull);

}  // namespace trunnion::smoothing
