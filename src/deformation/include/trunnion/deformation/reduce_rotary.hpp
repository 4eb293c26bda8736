#pragma once

#include <functional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "trunnion/base/result.hpp"
#include "trunnion/deformation/dual_path.hpp"
#include "trunnion/deformation/orientation_change.hpp"
#include "trunnion/deformation/rotary_use.hpp"

namespace trunnion::deformation {

struct AngleRange {
    double least_rad = 0, most_rad = 0;
};

/// Lead (towards the feed positive) and tilt (towards normal × feed positive) of a tool axis n against a surface normal
/// N, t the feed direction across N: atan2(n·t, n·N) and atan2(n·(N × t), n·N), rad.
struct LeadAndTilt {
    double lead_rad = 0, tilt_rad = 0;
};
LeadAndTilt lead_and_tilt(const Eigen::Vector3d& tool_axis, const Eigen::Vector3d& normal, const Eigen::Vector3d& feed);

/// How far the tool may be turned, and what it may not touch.
struct OrientationFreedom {
    double orientation_tolerance_rad = 0;  ///< from the path given, > 0
    /// Unit normal of the part at u, out of the material; empty: lead and tilt are free. Where the controlled point
    /// stands still the feed has no direction: lead and tilt are not looked at there.
    std::function<Eigen::Vector3d(double u)> surface_normal;
    AngleRange lead, tilt;  ///< used with surface_normal
    /// How far the tool in a pose stays off what it must not touch, mm, negative inside; smooth. Empty: nothing.
    std::function<double(double u, const Pose& pose)> clearance_mm;
    double least_clearance_mm = 0;
};

struct RotaryReduced {
    DualPath path;
    bool changed = false;  ///< false: no path was found that turns less and is not slower; `path` is the one given
    OrientationChange change;
    double least_clearance_mm = 0;  ///< at the places looked at; 0 without a clearance
    RotaryUse before, after;        ///< `after` is never worse in travel or in velocity-limited time
};

/// Turns the tool within its freedom so that the rotary axes move less and more evenly.
///
/// Unknown are two cubic splines of the rotary positions over the path's knots; the sum of (θ̇/V)² and of (θ̈/A)² a
/// tenth of a second long, both at the feed, is made small by least squares (Ceres), with what is not allowed
/// (deviation, lead and tilt, clearance, ranges) as steep penalties. The axis vectors of the new control points pass
/// through the tool axes of the result at the knots' averages. What comes out is measured at 16 places a knot interval;
/// where it breaks anything it is drawn back towards the path given until nothing is broken. The first and the last
/// pose stay. The tool turns about its controlled point, as in avoid_pole.hpp.
///
/// Cost for 200 control points under 1 s. Allocates. One thread: the same bits always.
///
/// Errors: DEFO0201, DEFO0202 as in avoid_pole.hpp, DEFO0205 the path given is already outside of the allowed lead,
/// tilt or clearance, DEFO0206 a machine without rotary axes; PATH0101, PATH0102, PATH0103 where it cannot be followed.
///
/// Source: Affouard et al. 2004 (the aim); the formulation is our own.
Result<RotaryReduced> reduce_rotary(const DualPath& path, const Machining& machining,
                                    const OrientationFreedom& freedom);

struct PosesRotaryReduced {
    std::vector<Pose> poses;  ///< as many as given; the controlled point of each is where it was, to rounding
    RotaryReduced spline;
};

/// The same for poses, by way of the dual path that fit_dual_path makes of them. Errors: those of both.
Result<PosesRotaryReduced> reduce_rotary(std::span<const Pose> poses, const DualFit& fit, const Machining& machining,
                                         const OrientationFreedom& freedom);

}  // namespace trunnion::deformation
