#pragma once

#include <vector>

#include "trunnion/path/run.hpp"
#include "trunnion/path/tool_path.hpp"

namespace trunnion::smoothing {

enum class Rounding {
    smooth,    ///< corners and dense blocks rounded within the tolerances
    beudaert,  ///< every corner on its own, by two linked B-splines (Beudaert 2013)
    none       ///< the programmed path itself, exact stop at every corner
};

/// What becomes of corners that stand alone, for Rounding::smooth.
enum class Corners {
    smooth,   ///< the same form as everything else
    beudaert  ///< handed over to the rounding of Rounding::beudaert
};

/// How the parameters of the two curves of a corner belong together, for Rounding::beudaert.
enum class Link {
    optimised,  ///< so that the tool turns C² (link.hpp)
    linear  ///< u_top = u_bottom: the turning speed jumps where a rounding joins, so motion has to stand still there
};

/// What may be given away of the programmed path. A tolerance ≤ 0 gives nothing: as Rounding::none.
struct SmoothingOptions {
    Rounding rounding = Rounding::smooth;
    Corners corners = Corners::smooth;
    Link link = Link::optimised;
    double tip_tolerance_mm = 0.02;
    double orientation_tolerance_rad = 0.1 * 0.017453292519943295;
    double flank_tolerance_mm = 0;  ///< > 0: deviation of the point at the flank height, in place of the orientation's
    double flank_height_mm = 30;
    double controlled_height_mm = 0;  ///< the point that the tip tolerance is of, so far up the tool axis from the tip
};

/// Whether these options leave nothing to round: Rounding::none, or a tolerance of 0.
bool follows_exactly(const SmoothingOptions& options);

/// Turns a run of programmed blocks into one or more stretches of C³ tool path, each from rest to rest, and appends
/// them to `out`, in order.
///
/// For Rounding::smooth the path is the programmed polyline P(p) in position and orientation coordinates plus one
/// compact bump at every vertex,
///
///     c(p) = P(p) + Σᵢ Δᵢ·wᵢ·g((p − pᵢ)/wᵢ),   Δᵢ = P′(pᵢ+) − P′(pᵢ−),
///
/// with g of kernel.hpp. Curves of the program enter P as chords too, divided so that position and orientation are
/// certified to be within a fortieth of the tolerances. Arcs enter P as chords within a fortieth of the tip tolerance;
/// the curve kernel keeps circles, so that away from its ends an arc comes out as itself, a chord's error at most
/// inside. The sum is the deviation at equal p, and c is C³ whatever the widths wᵢ are. Widths come from the data by
/// sums and minima alone, so that neighbouring passes are smoothed alike. The shipped pieces are septic Hermite
/// interpolants of c.
///
/// A stretch of nothing but parts of curves that meet with the same tangent and curvature is not rounded: septic pieces
/// by p follow it to 1e-8 mm and 1e-10 rad, and the third derivative jumps where the curve's does.
///
/// Guarantees, for Rounding::smooth:
/// - both tolerances hold along the whole stretch, at equal p, by ToolPath::bound: Bernstein hulls of the shipped
///   pieces minus the programmed path, not samples. Law vector: the programmed orientation is the constant-rate slerp.
/// - start and end are the programmed poses exactly, with second derivative 0.
/// - |c′| > 0.05 in the metric of p. Where the programmed path turns back on itself so that this cannot hold, the run
///   is split at that vertex: StopCause::reversal.
/// - ToolPath::transition_use is deviation / tolerance at each vertex between two blocks, the larger of both.
/// Looked at, not proved: at vertices and in the middle of blocks both tolerances hold, too, from the place of the
/// programmed path near by that fits best by |Δtip|² + (flank height · turn)² (not in machine space with turning rotary
/// axes). Where tip and tool slip along the path by different amounts, that place's tip deviation may be the larger
/// one.
///
/// For Rounding::beudaert: a cubic B-spline of five points at every vertex between straight blocks, over at most half
/// of the shorter one, and another for the orientation (corner.hpp); their parameters linked in closed form (link.hpp),
/// so that tip and orientation are C² with a jump of the third derivative at the joins and in the middle. Law vector:
/// the second curve is that of the point at the flank height (30 mm where that is 0), and blocks that turn far are
/// divided into blocks ruled by tip and that point, at the cost of at most a fifth of the tolerance. Otherwise it is
/// that of tip and rotary axes together. Both tolerances hold at equal p by the same hulls. It stands still
/// (StopCause::corner) at vertices at which the tip or the point above it stands still on one side.
///
/// Corners::beudaert hands programmed vertices over that stand alone as corners: their kink is a corner at its own
/// scale and their bump takes less than half of the shorter block beside it. Joins are C² there. A corner without
/// straight legs beside it stays with the others.
///
/// For Rounding::none, rapids, and runs of one block: positions are exact, orientations too (law vector: to 1e-10 rad),
/// with an exact stop (StopCause::corner) at every vertex where the tangent of position or orientation changes at all,
/// and at both ends of an arc, where curvature does. Arcs are exact to 3e-11 of their radius, curves to 1e-8 mm; where
/// a curve goes on with the same tangent and curvature there is no stop.
///
/// Space machine: coordinates are the machine axes. The tip's deviation in the workpiece is bounded by that of the
/// linear axes plus that of the rotary axes times the tip's largest distance from a rotary axis.
///
/// A width is at most 6 mm (larger in proportion to the root of the tip tolerance above 0.01 mm), whatever the length
/// of the blocks. The run backwards gives the same path to 1 nm.
///
/// Preconditions: as Run says; finite values. `run.kinematics` may be null under law vector in workpiece space.
/// Cost: 5-45 µs a block, linear in the run's length. Allocates. Stateless, thread safe.
void smooth(const path::Run& run, const SmoothingOptions& options, std::vector<path::ToolPath>& out);

}  // namespace trunnion::smoothing
