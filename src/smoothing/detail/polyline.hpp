#pragma once

#include <cstdint>
#include <vector>

#include "detail/coordinates.hpp"

namespace trunnion::smoothing {

/// The programmed path as straight blocks in Coordinates. Blocks that turn a vector far are divided along the great
/// circle, so vertices are the programmed ones and some between.
struct Polyline {
    std::vector<Coordinates> vertex;
    std::vector<double> gap_mm;            ///< of block i, vertex i → i + 1
    std::vector<Coordinates> slope;        ///< dP/dp on block i
    std::vector<double> lever;             ///< at every vertex: Kinematics::lever; law vector: 1
    std::vector<std::int32_t> programmed;  ///< the run's vertex, −1: lies inside a block
    double largest_turn_rad = 0;           ///< of a vector within one block of this polyline
    std::size_t blocks() const { return gap_mm.size(); }
};

/// Blocks turning a vector more than `turn_rad` are divided. Precondition: no doubled points in the run.
Polyline make_polyline(const path::Run& run, VertexRange range, double turn_rad);

/// Kinematics::lever of rotary coordinates; 1 where there is none.
double lever_at(const path::Run& run, const Coordinates& at);

/// Index in Coordinates of the rotary axis that lever belongs to, −1: none.
int lever_axis(const path::Run& run);

}  // namespace trunnion::smoothing
