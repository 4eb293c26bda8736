#pragma once

#include <span>
#include <vector>

#include "trunnion/base/result.hpp"
#include "trunnion/geometry/dual_spline.hpp"
#include "trunnion/surfacing/orientation_surface.hpp"
#include "trunnion/surfacing/plan_surface.hpp"

namespace trunnion::surfacing {

/// A face, the tool on it, and the surfaces that lead the tool: what all here is about. All must outlive it.
struct GuidedTool {
    const Face& face;
    const Cutter& cutter;
    const OrientationSurface& orientation;  ///< with its guiding surface
};

/// The tool at a place, `along` the direction of motion in space (any length, need not be tangent). From K on S₁, the
/// axis u of S₂ and the face's normal n: C_L = K + (R − r) v with v the unit part of n across u, tip = C_L − r u.
///
/// u ∥ n: v is undefined, and of an axis nearly upright it is noise. So an axis that is within what S₂ may be off of
/// the normal (OrientationSurface::slack_rad()) is the normal, and v its limit for an axis that leans less and less
/// towards the feed, v = −along: the tip of a flat or torus tool then does not jump on passes with lead, but unlike
/// Cutter::touching() it does not stand over the contact. Of a ball all this means nothing.
/// The contact is off the face by at most the guiding surface's error bound.
/// Errors: SURF0303 no normal, SURF0307 u ⟂ n, SURF0309 outside the surfaces. Source: Affouard 2004, Eq. 1.
Result<Contact> contact_at(const GuidedTool& tool, const geometry::SurfacePlace& place, const Eigen::Vector3d& along);

struct SurfacePathOptions {
    double chord_tolerance_mm = 0.0005;  ///< how far straight moves may lead the tool off touching the surface
    double longest_step_mm = 5;
};

/// The image of a polyline in (u, v): poses at its corners, and between them as many more as straight moves (tip
/// linear, axis in one plane) need to touch the surface within the chord tolerance; looked at in three places of each
/// move. Errors: those of contact_at(), SURF0301 an option, SURF0309 fewer than two places, SURF0312 moves of a
/// millionth of a polyline's piece do not touch within the tolerance: a tool that is no ball leans through the normal
/// there, and its contact would jump from one side of its end to the other.
Result<Pass> pass_on(const GuidedTool& tool, std::span<const geometry::SurfacePlace> polyline, int index,
                     const SurfacePathOptions& options = {});

/// Planned passes with the same contacts and the orientations of the surface instead of their own.
Result<std::vector<Pass>> reoriented(const GuidedTool& tool, std::span<const Pass> passes,
                                     const SurfacePathOptions& options = {});

/// A pass as two splines.
struct PassSpline {
    geometry::DualSpline spline;  ///< tip and the point `height` up; parameter: length of the contacts' polyline, mm
    double tip_error_mm = 0, axis_error_rad = 0;
    std::size_t poses = 0;
};
struct PassSplineOptions {
    double tip_tolerance_mm = 0.001, axis_tolerance_rad = 0.0002;
    double height_mm = 50;
    std::size_t most_poses = 20'000;
};

/// A pass through places as a C² dual spline: a cubic in (u, v) through them, by the distances of their contacts, and
/// tip and top along it interpolated by cubics (not-a-knot) at so many poses that the true poses are met within the
/// tolerances, at equal parameters; twice as many until it is so. The errors are the largest of four places between any
/// two poses, where the error of an interpolating cubic is largest within 4 %; not a proof. Errors: as pass_on(),
/// SURF0305 more than `most_poses`.
Result<PassSpline> dual_spline_on(const GuidedTool& tool, std::span<const geometry::SurfacePlace> places,
                                  const PassSplineOptions& options = {});

}  // namespace trunnion::surfacing
