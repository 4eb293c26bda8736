#pragma once

#include <vector>

#include "trunnion/base/result.hpp"
#include "trunnion/interpolation/surface_curve.hpp"
#include "trunnion/machine/kinematics.hpp"
#include "trunnion/path/tool_path.hpp"

namespace trunnion::interpolation {

/// Which point of the tool a programmed feed is of.
enum class FeedPoint { contact, tip };

struct SurfacePathOptions {
    double feed_mm_s = 50;
    FeedPoint feed_point = FeedPoint::contact;
    /// How far the polynomials that the feed is planned on may be off the pose at equal contact way: tip, and direction
    /// of the axis.
    double fit_tip_mm = 1e-6, fit_axis_rad = 1e-8;
    /// The same of bridges, which the tool really follows.
    double bridge_tip_mm = 2e-4, bridge_axis_rad = 2e-5;
    double longest_bridge_mm = 2;  ///< to either side of a rough place or pole
    double pole_rad = 1e-5;        ///< the axis is led through a pole that it passes within this angle
    std::int32_t line = 0;         ///< of the program
};

/// What the interpolator follows on one piece of a surface path.
struct SurfacePathPiece {
    double w_begin = 0, w_end = 0;
    /// The piece goes over a knot where the surface is less than C⁴, and with it the pose less than C³, or begins or
    /// ends at a pole: there the tool follows the polynomial, which joins both sides with all derivatives to order 3.
    bool bridge = false;
};

/// A curve on a surface as the rest of the house knows paths: septic pieces over p, the way of the contact, that have
/// the exact tip and axis with three derivatives at their ends. C³ all over.
struct SurfacePath {
    path::ToolPath tool_path;  ///< law vector, one block; bound: of the bridges
    std::vector<SurfacePathPiece> pieces;
    double fit_tip_mm = 0, fit_axis_rad = 0;  ///< largest errors of the other pieces at the places looked at
    double bridged_mm = 0;                    ///< contact way on bridges
};

/// The path of a curve for one machine and tool. With FeedPoint::contact the programmed feed bounds ṗ.
///
/// Pieces begin at the curve's knots and are halved until they fit at seven places inside each. Round every rough place
/// a bridge, as long as its tolerance lets it: a short one costs speed. Where the axis passes a pole so closely that no
/// axis could turn as fast, a bridge leads it through the pole exactly, with a joint of pieces there: path::AxisPath
/// knows the axes' derivatives at such joints, where they are 0/0.
/// Errors: INTP0006 a feed or tolerance that is not above 0, or `pole_rad` above the tolerance of bridges, INTP0007 the
/// surface has an edge across the curve: no bridge of 10 µm or more keeps the tolerance, INTP0008 the curve bends too
/// sharply to be fitted by pieces of 1 µm. Cost: some 30 µs a piece. Allocates.
Result<SurfacePath> surface_path(const SurfaceCurve& curve, const machine::Kinematics& kinematics,
                                 const SurfacePathOptions& options);

}  // namespace trunnion::interpolation
