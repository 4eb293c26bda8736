#pragma once

#include "trunnion/deformation/dual_path.hpp"
#include "trunnion/machine/machine.hpp"

namespace trunnion::deformation {

/// What reshaping did to a path, at equal u.
struct OrientationChange {
    double orientation_deviation_rad = 0;  ///< bound on the angle between the tool axes before and after
    double controlled_point_mm = 0;        ///< how far the controlled point moved: largest of 16 places a knot interval
    double surface_mm = 0;                 ///< bound on how far any point of the tool's cutting end left its old place
};

/// The angle by which two axis vectors D and D′ differ is at most asin(|D′ − D|/|D|). Over each knot interval |D′ − D|
/// is bounded by the hull of its control points and |D| by theirs along the direction in the middle, on parts of the
/// interval of which four are looked at. Precondition: both paths are cubic without weights and have the same domain;
/// knots of the one are among those of the other, or equal. Allocates.
OrientationChange orientation_change(const DualPath& before, const DualPath& after, const machine::Tool& tool);

/// How far the cutting end of a tool leaves its place when it turns by an angle about its controlled point: every point
/// of it is within the corner radius r of a circle of radius R − r at the height r (of the ball's centre, of the edge
/// of a flat end), and that circle moves by at most 2 sin(angle/2)·√((R − r)² + (r − c)²), c the controlled point's
/// height. Exactly 0 for a ball turned about its centre. A taper counts as its rounded tip.
double turned_surface_mm(const machine::Tool& tool, double angle_rad);

}  // namespace trunnion::deformation
