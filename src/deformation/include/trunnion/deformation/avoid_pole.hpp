#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "trunnion/base/result.hpp"
#include "trunnion/deformation/dual_path.hpp"
#include "trunnion/deformation/orientation_change.hpp"
#include "trunnion/deformation/rotary_use.hpp"

namespace trunnion::deformation {

/// How a path passes a pole.
enum class PolePassing {
    through,  ///< exactly through it: the axis nearest to the workpiece hardly turns, the other one changes its branch
    near_side,  ///< around it where it passes already, out of the cone
    far_side    ///< around it on the other side, out of the cone
};

struct PoleAvoidance {
    double orientation_tolerance_rad = 0;  ///< > 0
    std::optional<PolePassing> passing;    ///< this one alone; none: what the ranges allow, with the least deviation
};

/// One place at which the path was led past a pole.
struct DeformedPassage {
    double u = 0;                                            ///< where the path comes nearest
    Eigen::Vector3d pole = Eigen::Vector3d::UnitZ();         ///< unit, workpiece
    double distance_before_rad = 0, distance_after_rad = 0;  ///< least angle between tool axis and pole
    PolePassing passing = PolePassing::through;
};

struct PoleAvoided {
    DualPath path;                          ///< the path given, bit for bit, where nothing had to be done
    std::vector<DeformedPassage> passages;  ///< by u; empty: nothing had to be done
    std::size_t ends_in_cone = 0;           ///< beginnings and ends inside a cone: left alone, motion is slow there
    OrientationChange change;
    std::optional<RotaryUse> before;  ///< none: the machine cannot follow the path as it was
    RotaryUse after;
};

/// Leads a path past the poles of a machine wherever, at the feed, the axis nearest to the workpiece would exceed its
/// velocity limit.
///
/// Around the place where the path comes nearest to the pole the axis vectors D = g − f of its control points are
/// turned about one axis, in full beside that place and less and less away from it (path::shift_share over the turn of
/// the tool). In full means rigidly, so the new least distance from the pole is exactly the one that is wanted: 0 to go
/// through it, or the least with which the axis keeps its limit. That is the smallest change that does it. Of going
/// through and around on either side the one with the least deviation is taken that keeps every axis in its range, up
/// to the next passage. The tool turns about its controlled point: the tip's curve stays bit for bit where the tip is
/// controlled; with the centre of a ball or torus f is moved so that the centre stays (OrientationChange tells how
/// well). The path keeps its degree, its continuity and both end poses; knots are added where control points stand too
/// wide.
///
/// Rims (singular_cone.hpp) and feeds that an axis cannot follow anyway are left alone: `after` tells.
/// Cost about 20 ms a passage and beginning tried. Allocates.
///
/// Errors: DEFO0201 a path that is not cubic, has weights or is not clamped, DEFO0202 options or machining that make no
/// sense, DEFO0203 the tolerance is too small (says which would do), DEFO0204 the cone cannot be left inside the axes'
/// ranges or at this feed; PATH0101, PATH0102, PATH0103 where the path cannot be followed for other reasons.
///
/// Source: Affouard et al. 2004 (deformation by control points); the turn about an axis and the choice are our own.
Result<PoleAvoided> avoid_pole(const DualPath& path, const Machining& machining, const PoleAvoidance& avoidance);

struct PosesPoleAvoided {
    std::vector<Pose> poses;  ///< as many as given; the controlled point of each is where it was, to rounding
    PoleAvoided spline;       ///< what they were taken from
};

/// The same for poses, by way of the dual path that fit_dual_path makes of them. Errors: those of both.
Result<PosesPoleAvoided> avoid_pole(std::span<const Pose> poses, const DualFit& fit, const Machining& machining,
                                    const PoleAvoidance& avoidance);

}  // namespace trunnion::deformation
