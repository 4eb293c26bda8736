#pragma once

#include <cstdint>
#include <vector>

#include "detail/coordinates.hpp"

namespace trunnion::smoothing {

/// The programmed path as straight blocks in Coordinates. Blocks that turn a vector far are divided along the great
/// circle, arcs and curves along themselves, so vertices are the programmed ones and some between. The curve kernel
/// keeps circles (its lower moments vanish): inside, an arc or a curve as chords becomes itself again, to a few chord
/// errors.
struct Polyline {
    std::vector<Coordinates> vertex;
    std::vector<double> gap_mm;            ///< of block i, vertex i → i + 1
    std::vector<Coordinates> slope;        ///< dP/dp on block i
    std::vector<double> lever;             ///< at every vertex: Kinematics::lever; law vector: 1
    std::vector<std::int32_t> programmed;  ///< the run's vertex, −1: lies inside a block
    std::vector<double> widest_mm;         ///< of a curve bump at a vertex inside an arc or curve; else ∞
    double largest_turn_rad = 0;           ///< of a vector within one block of this polyline
    double chord_error_mm = 0;             ///< largest distance of an arc or curve from its chords, at equal p
    double chord_turn_rad = 0;             ///< the same of a curve's orientation, the turn of a vector included
    std::size_t blocks() const { return gap_mm.size(); }
};

/// How finely blocks are divided.
struct Division {
    double turn_rad = 0;  ///< of a vector within a part
    double chord_mm = 0;  ///< of an arc or curve from its chord, and by which it may be displaced inside
    double bend_rad = 0;  ///< the same of a curve's orientation
};

/// Precondition: no doubled points in the run.
Polyline make_polyline(const path::Run& run, VertexRange range, Division division);

/// Kinematics::lever of rotary coordinates; 1 where there is none.
double lever_at(const path::Run& run, const Coordinates& at);

/// Index in Coordinates of the rotary axis that lever belongs to, −1: none.
int lever_axis(const path::Run& run);

}  // namespace trunnion::smoothing
