#pragma once

#include <limits>

#include <Eigen/Core>

#include "trunnion/base/result.hpp"
#include "trunnion/program/program.hpp"

namespace trunnion::nc {

/// How badly a circle may be written. Of a circle by its centre, the distances of its two ends from the line through
/// the centre may differ by max(least_mm, share · the larger of them), and never by more than most_mm; the arc is then
/// a spiral. Of a circle by its radius, the chord may be longer than the diameter by 2·short_mm; it is then half a
/// turn.
struct ArcTolerance {
    double least_mm, share, most_mm, short_mm;
};

/// LinuxCNC's: 0.005 mm and 0.1 %, at most 0.5 mm; 0.00127 mm by radius.
inline constexpr ArcTolerance linuxcnc_arcs{0.005, 1e-3, 0.5, 1.27e-3};
/// The same in a program in inches: 0.0005 in, 0.1 %, 0.05 in; 0.00005 in.
inline constexpr ArcTolerance linuxcnc_inch_arcs{0.0127, 1e-3, 1.27, 1.27e-3};
/// Sinumerik's as delivered: CIRCLE_ERROR_CONST 0.01 mm and CIRCLE_ERROR_FACTOR 0.001.
inline constexpr ArcTolerance sinumerik_arcs{0.01, 1e-3, std::numeric_limits<double>::infinity(), 0.01};

/// The circles that part programs write, as program::Arc. `clockwise` is as seen by one who looks against `normal` (in
/// G17 from +Z down on X to the right and Y up; G18 from +Y, G19 from +X): the angle about the normal is then negative.
/// Ends less than 1 nm from each other across the normal are a whole turn. What the ends differ by along the
/// normal makes a helix. Points in mm in one frame, finite; `normal` unit. The diagnostics have code, text, value and
/// limit; the reader puts in the place. Radii up to 10 km: else NC0213.

/// `further_turns`: whole turns besides, 0 … 1000. Errors: NC0207 the radii do not fit, NC0209 an end on the centre,
/// NC0212 turns, NC0213.
Result<program::Arc> arc_by_centre(const Eigen::Vector3d& start, const Eigen::Vector3d& end,
                                   const Eigen::Vector3d& centre, const Eigen::Vector3d& normal, bool clockwise,
                                   double further_turns, const ArcTolerance& tolerance);

/// A negative radius means the longer way round, more than half a turn. Errors: NC0208 too small for the ends, NC0209
/// zero, NC0210 the ends coincide, NC0212 turns, NC0213.
Result<program::Arc> arc_by_radius(const Eigen::Vector3d& start, const Eigen::Vector3d& end, double radius_mm,
                                   const Eigen::Vector3d& normal, bool clockwise, double further_turns,
                                   const ArcTolerance& tolerance);

/// The circle through three points, less than a turn; its normal is that about which it turns by a positive angle.
/// Errors: NC0211 the points lie on a line or coincide, NC0213.
Result<program::Arc> arc_through(const Eigen::Vector3d& start, const Eigen::Vector3d& via, const Eigen::Vector3d& end);

/// The square of the way along a circle or helix, mm², from a place on it that `step` separates from its end.
double square_of_way(const program::Arc& arc, const Eigen::Vector3d& from, const Eigen::Vector3d& step);

}  // namespace trunnion::nc
