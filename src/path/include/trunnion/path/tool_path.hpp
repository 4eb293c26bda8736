#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "trunnion/path/run.hpp"

namespace trunnion::path {

/// Polynomial of degree 7 on one interval of the path parameter: coefficients in u = (p − begin_mm)/length_mm ∈ [0, 1].
/// coefficient[k][i] belongs to u^i; k = 0…2 position (mm), k = 3…5 orientation (law vector: a vector along the tool
/// axis, not normalised, never 0; law rotary and machine space: rad).
struct PathPiece {
    double begin_mm = 0;
    double length_mm = 0;
    std::array<std::array<double, 8>, 6> coefficient{};
};

/// Where a programmed block lies on the path.
struct BlockSpan {
    double begin_mm = 0, end_mm = 0;
    Feed feed;
    std::int32_t line = 0;
    double time_scale_mm = 0;   ///< programmed length dp of the whole block: G93's ṗ is time_scale_mm / feed.value
    std::size_t run_block = 0;  ///< index in Run::blocks; parts of one block may lie on several stretches
};

/// What smoothing guarantees of a stretch, over all of it, against the programmed path at equal p.
struct DeviationBound {
    double tip_mm = 0;  ///< of the controlled point
    double orientation_rad = 0;
    double height_mm = 0;  ///< of the point at the flank height
};

/// Tool path from rest to rest as geometry over the path parameter p, from 0 at its start. C³ inside; along curves of
/// the program that are followed exactly C², the third derivative jumps at their knots. dp/du > 0.
struct ToolPath {
    Space space = Space::workpiece;
    OrientationLaw law = OrientationLaw::vector;
    bool rapid = false;
    const machine::Kinematics* kinematics = nullptr;  ///< not owned
    std::vector<PathPiece> pieces;                    ///< abutting, from p = 0
    std::vector<BlockSpan> blocks;                    ///< abutting, from p = 0
    DeviationBound bound;
    std::vector<float> transition_use;  ///< deviation / tolerance at every block transition inside
    StopCause stop = StopCause::end;    ///< what the standstill at its end is for
    double length_mm() const { return pieces.empty() ? 0 : pieces.back().begin_mm + pieces.back().length_mm; }
};

/// Value of the piece's polynomials at `offset_mm` from its start, and derivatives by p up to the third as Taylor
/// coefficients (numeric/taylor3.hpp). Cost about 60 flops a coordinate.
std::array<Taylor3, 6> evaluate(const PathPiece& piece, double offset_mm) noexcept;

}  // namespace trunnion::path
