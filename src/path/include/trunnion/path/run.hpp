#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "trunnion/geometry/bezier_piece.hpp"
#include "trunnion/geometry/helix.hpp"
#include "trunnion/machine/kinematics.hpp"
#include "trunnion/path/pole_passage.hpp"
#include "trunnion/program/program.hpp"

namespace trunnion::path {

using program::Feed;
using program::FeedRule;
using program::OrientationLaw;
using program::Space;

/// Reference height ρ: one radian of the tool counts as so many millimetres of path.
inline constexpr double reference_height_mm = 30.0;

/// Coordinates of a place on a path: position (tip in the workpiece, or the linear machine axes in machine space; mm)
/// and orientation (law vector: the tool axis, unit; law rotary and machine space: positions of the machine's rotary
/// axes in its order, rad, in the control's count, the rest 0).
struct PathCoordinates {
    std::array<double, 3> position_mm{};
    std::array<double, 3> orientation{};
};

/// The part of a program's curve that one block follows, over v ∈ [0, 1], with the block's vertices at its ends.
struct CurvePiece {
    geometry::BezierPiece position;
    /// Law vector: the direction of the tool axis, of any length. Else: the rotary axes' positions, rad. None: from
    /// vertex to vertex in proportion to v, vectors on the great circle.
    std::optional<geometry::BezierPiece> orientation;
};

inline constexpr std::int32_t no_curve = -1;

/// One programmed block of a run, from vertex i to vertex i + 1.
struct Block {
    double length_mm = 0;  ///< dp: √(|Δtip|² + (ρ Δω)²), conventions.md; along a curve: CurveWay
    Feed feed;
    std::int32_t line = 0;
    std::int32_t arc = program::no_arc;  ///< index in Run::arcs; no_arc: no arc
    std::int32_t curve = no_curve;       ///< index in Run::curves; neither arc nor curve: straight
};

/// Why motion stands still at the end of a run or stretch.
/// (`turn`: rotary axes were turned in place at the pole; it belongs to the stop before it. `law`: the next move turns
/// by another orientation law.)
enum class StopCause : std::uint8_t { end, reversal, rapid, event, exact_stop, space, tool, law, corner, turn };

/// An event of the program (index in Program::events) that falls where blocks[block] of the run begins; block =
/// blocks.size(): at the run's end.
struct RunEvent {
    std::size_t event = 0;
    std::size_t block = 0;
};

/// Consecutive moves without a standstill between: what smoothing may round as one. Rapids are runs of one block.
/// vertices.size() = blocks.size() + 1; every block is longer than 0.
struct Run {
    Space space = Space::workpiece;  ///< workpiece or machine
    OrientationLaw law = OrientationLaw::vector;
    bool rapid = false;
    std::size_t first_move = 0;                       ///< index in Program::moves of the move of blocks[0]
    const machine::Kinematics* kinematics = nullptr;  ///< not owned
    std::vector<PathCoordinates> vertices;
    std::vector<machine::RotaryPosition> stands;  ///< law vector: where the rotary axes are to stand at every vertex
    std::vector<PolePassage> passages;            ///< ascending: where the rotary axes are to go through the pole
    std::vector<Block> blocks;
    std::vector<program::Arc> arcs;  ///< in the frame of the vertices' positions
    std::vector<CurvePiece> curves;  ///< in the coordinates of the vertices
    std::vector<RunEvent> events;
    StopCause stop = StopCause::end;  ///< what the standstill at its end is for
    double controlled_height_mm = 0;  ///< of the tool in use: the controlled point lies so far up the axis from the tip
};

/// dω between two places under the law (rotary: with the lever of the axis nearest to the workpiece at their middle,
/// at least 0.1), rad.
double turn_rad(const Run& run, const PathCoordinates& from, const PathCoordinates& to);

/// dp of a block between two places, mm: straight, or along an arc in the frame of the positions.
double block_length_mm(const Run& run, const PathCoordinates& from, const PathCoordinates& to,
                       const program::Arc* arc = nullptr);

/// The curve of an arc between two positions.
geometry::Helix helix_between(const program::Arc& arc, const PathCoordinates& from, const PathCoordinates& to);

}  // namespace trunnion::path
