#pragma once

#include <Eigen/Core>

#include "trunnion/geometry/surface_shape.hpp"
#include "trunnion/surfacing/cutter.hpp"

namespace trunnion::surfacing {

/// Distance of two neighbouring passes of a flat tool that stands upright on a convex surface, for a scallop of height
/// h > 0: P = 2R/(R+h) √(2Rh + h²) (Lin & Koren, Eq. 2), R the conjugate radius, mm; infinite for a plane. All mm.
double flat_interval_mm(double radius_mm, double scallop_mm) noexcept;

/// The largest interval at which a flat of diameter D reaches to where the tangents of neighbouring passes meet: P = 2R
/// sin(atan(D/2R)), which is D for a plane. Eq. 2 holds up to there: D ≥ P(R + h)/R.
double flat_reach_mm(double radius_mm, double diameter_mm) noexcept;

/// The same for a body of radius `tool_mm` on a surface of radius `radius_mm` across the feed, positive where convex,
/// negative where concave, infinite for a plane: the distance of two contacts whose ridge between them is h high, both
/// circles exact. The largest one where ridges stay below h. Precondition: concave only with −radius > tool.
double round_interval_mm(double radius_mm, double tool_mm, double scallop_mm) noexcept;

/// How fast tool and surface part from their contact, 1/mm: K_tool + W in the tangent frame. The gap at a small way d
/// is ½ dᵀMd. Positive definite where the tool fits.
Eigen::Matrix2d parting(const Cutter& cutter, const geometry::SurfaceShape& at, const Eigen::Vector3d& axis) noexcept;

/// Least gap between a tool and the surface round a place, mm, negative where the tool is in it, along the normal
/// there. The tool stands near to where it would touch that place: its point E with the same normal is h above it and d
/// beside it, so the gap at x is h + ½ (x−d)ᵀK(x−d) + ½ xᵀWx, least h + ½ dᵀ(W − W M⁻¹ W)d. To second order in d; a
/// turn of the axis by δ moves E by some δ/K, which is far for a leaning flat tool. An upright tool that is no ball,
/// one whose E is half its flat radius away, and one that does not fit has no such point: then the place's own
/// distance.
double gap_nearby_mm(const Cutter& cutter, const geometry::SurfaceShape& at, const CutterPose& pose) noexcept;

/// Interval of passes with feed ⟂ `across` (unit, tangent frame), mm, for ridges of height `scallop_mm`: twice the
/// farthest reach across the feed of {d : gap(d) ≤ scallop}. With gap(d) = ½ dᵀMd that is the conjugate radius of M,
/// nᵀM⁻¹n; of upright flat and torus tools it is cut off by the rounded edge and the rim, which decide where a flat
/// tool is fed obliquely to the rulings of a developable surface. What remains of the finite size of tilted tools is
/// for whoever measures ridges. At most longest_interval_mm(). `by_normal_radius`: with the radius of the normal
/// section instead, as Lin & Koren have it; where a tool leans, which their rule does not, with what its end sweeps
/// along the feed on a surface as curved all round as it is most, if that is the wider one. Never above the other.
/// Precondition: the tool fits (M positive semidefinite).
double path_interval_mm(const Cutter& cutter, const geometry::SurfaceShape& at, const Eigen::Vector3d& axis,
                        const Eigen::Vector2d& across, double scallop_mm, bool by_normal_radius = false) noexcept;

/// The interval beyond which the tool's end does not reach the middle between two passes, whatever the scallop: the
/// tool's diameter, of an upright flat tool flat_reach_mm().
double longest_interval_mm(const Cutter& cutter, const geometry::SurfaceShape& at, const Eigen::Vector3d& axis,
                           const Eigen::Vector2d& across) noexcept;

}  // namespace trunnion::surfacing
