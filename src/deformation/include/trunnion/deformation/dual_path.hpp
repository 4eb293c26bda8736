#pragma once

#include <limits>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "trunnion/base/result.hpp"
#include "trunnion/geometry/dual_spline.hpp"
#include "trunnion/machine/kinematics.hpp"

namespace trunnion::deformation {

using machine::Pose;

/// A tool path as two cubic C² splines over the same knots: f, the way of the tip, and g, the way of the point of the
/// tool axis at the distance h from it. The distance of the splines themselves differs from h by a small amount
/// (FittedDualPath::distance_error_mm): what counts is f and the *direction* of g − f, normalised wherever the path is
/// evaluated, so the distance of what is evaluated is h to rounding. In the workpiece's frame.
struct DualPath {
    geometry::DualSpline spline;  ///< bottom = f, top = g
    double distance_mm = 50;      ///< h

    double begin() const noexcept { return spline.begin(); }
    double end() const noexcept { return spline.end(); }
    /// Tip f(u) and unit axis (g − f)/|g − f|. No allocation. Cost about 0.4 µs.
    Pose at(double u) const noexcept;
    /// f(u) + height · axis(u): at the height h the point that g stands for.
    Eigen::Vector3d point_mm(double u, double height_mm) const noexcept;
};

/// A bound of | |g(u) − f(u)| − h | over all u, before normalisation: Bernstein hull of the squared distance on a
/// quarter of every knot interval. Precondition: degree ≤ 3, no weights.
double distance_error_mm(const DualPath& path);
/// The same between two places of one knot interval.
double distance_error_mm(const DualPath& path, double from, double to);

/// The parameter u of a pose. Both begin at 0.
enum class Parametrisation {
    chord_length,  ///< Σ √(|Δtip|² + (ρ Δω)²), ρ = 30 mm: the path parameter p of chords, mm
    centripetal    ///< Σ of the square roots of these steps, √mm: for poses at very uneven distances
};

/// What holds at both ends beside the pose itself.
enum class EndCondition {
    natural,    ///< second derivatives 0
    tangents,   ///< first derivatives as DualFit::tangent_at_begin, tangent_at_end say
    not_a_knot  ///< the third derivative too is continuous at the second pose and the last but one
};

/// First derivatives by u at an end.
struct PoseTangent {
    Eigen::Vector3d tip = Eigen::Vector3d::Zero();   ///< mm per u
    Eigen::Vector3d axis = Eigen::Vector3d::Zero();  ///< of the unit axis, across it, 1 per u
};

/// How poses become a dual path.
struct DualFit {
    double distance_mm = 50;  ///< h > 0
    /// Largest | |g − f| − h | before normalisation; knots are added until it holds. Infinite: as it comes out.
    double distance_tolerance_mm = 1e-3;
    /// Both 0: the path goes through all poses (interpolation). Both above 0: it passes every pose at its u within
    /// them, by least squares over as few knots as that takes; first and last pose are kept.
    double tip_tolerance_mm = 0, orientation_tolerance_rad = 0;
    Parametrisation parametrisation = Parametrisation::chord_length;
    EndCondition ends = EndCondition::not_a_knot;
    PoseTangent tangent_at_begin, tangent_at_end;
    std::vector<double> parameters;  ///< the u of every pose, rising; empty: by `parametrisation`
    std::vector<double> weights;     ///< of every pose in the least squares, > 0; empty: all 1
    std::size_t most_control_points = std::numeric_limits<std::size_t>::max();
    /// One-sided, for least squares: unit normals of the part at the poses, out of the material; empty: not asked. The
    /// fitted point of the axis at `side_height_mm` (0: the tip; the radius: centre of a ball, which carries the
    /// contact) is at no pose deeper than `deepest_mm` ≥ 0 on the part's side of where the pose has it.
    std::vector<Eigen::Vector3d> normals;
    double deepest_mm = 0, side_height_mm = 0;
};

struct FittedDualPath {
    DualPath path;
    std::vector<double> parameters;                              ///< u of every pose
    double tip_deviation_mm = 0, orientation_deviation_rad = 0;  ///< largest at the poses
    double deepest_mm = 0;                                       ///< with normals: the largest depth on the part's side
    double distance_error_mm = 0;                                ///< bound before normalisation
};

/// Fits a dual path to poses. Allocates; cost grows with the number of poses (about 10 µs each).
///
/// The tip's curve is not touched by the knots that are added for the distance: it is the same curve over more knots.
/// Deviations are those at the poses; between them nothing is known of what is wanted.
///
/// Errors: DEFO0101 fewer than 2 poses (4 with not_a_knot), DEFO0102 two neighbours are the same pose, DEFO0103 the
/// axes of two neighbours are opposite (more than 170° apart), DEFO0104 a pose is not finite or its axis not unit
/// within 1e-6, DEFO0105 options that contradict each other, DEFO0106 the tolerance cannot be met with
/// `most_control_points` (says which could), DEFO0107 the distance cannot be kept: the tool turns too far from pose to
/// pose.
///
/// Source: Affouard et al. 2004 (the form); Piegl & Tiller, The NURBS Book, §9.2-9.4 (interpolation, least squares).
Result<FittedDualPath> fit_dual_path(std::span<const Pose> poses, const DualFit& fit = {});

}  // namespace trunnion::deformation
