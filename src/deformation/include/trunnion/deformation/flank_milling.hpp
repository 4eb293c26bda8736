#pragma once

#include <limits>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "trunnion/base/result.hpp"
#include "trunnion/deformation/designed_surface.hpp"
#include "trunnion/deformation/dual_path.hpp"
#include "trunnion/deformation/flank_tool.hpp"

namespace trunnion::deformation {

/// A point of the surface that the side of a moving tool leaves.
struct EnvelopePoint {
    Eigen::Vector3d point_mm;
    Eigen::Vector3d normal;  ///< unit, from the tool into the material
};

/// The envelope of a tool's side along a dual path at parameter u and height z of the tool, on the side of `towards`:
/// in closed form for every outline, from the axis, its rate, and the tip's velocity at u. None where the tool does not
/// move across its axis at this height, or the section lies within what others sweep (a steep cone plunging).
/// No allocation. Cost about 1 µs. Source: condition n·V = 0 on the tool's side.
std::optional<EnvelopePoint> envelope_point(const DualPath& path, const FlankTool& tool, double u, double height_mm,
                                            const Eigen::Vector3d& towards) noexcept;

/// Where the envelope and the designed surface are compared.
struct FlankRange {
    double from_height_mm = 0, to_height_mm = 20;  ///< of the tool that is to fit the surface
    int heights = 9;                               ///< ≥ 2, even distances
    int places_per_interval = 8;                   ///< of u in every knot interval
};

/// Signed deviations of the envelope from the designed surface, mm: above 0 material stays, below 0 the tool cuts into
/// the part.
struct DeviationMap {
    std::vector<double> u, height_mm;
    std::vector<double> deviation_mm;       ///< row by row: u.size() × height_mm.size()
    double highest_mm = 0, deepest_mm = 0;  ///< largest and smallest
    double peak_mm = 0;                     ///< largest magnitude
    double mean_square_root_mm = 0;
};

/// Errors: DEFO0111 tool or heights, DEFO0113 no envelope at a place (says which), DEFO0112 the surface has no normal
/// where it is asked. Allocates. Cost about 5 µs a place.
Result<DeviationMap> deviation_map(const DualPath& path, const FlankTool& tool, const DesignedSurface& surface,
                                   const FlankRange& range);

/// Poses at which the tool's side passes both edges of the surface, v = 0 and v = 1, on the side of its normals, from
/// u's begin to its end: the usual positioning on a blade, tangent where the surface is straight across. The lower
/// contact lies at `lower_height_mm` of the tool. Errors: DEFO0105 fewer than 2 poses, DEFO0111 tool, DEFO0112 no
/// normal at an edge, DEFO0114 no such pose is found.
Result<std::vector<Pose>> two_point_poses(const DesignedSurface& surface, const FlankTool& tool, int count,
                                          double lower_height_mm);

/// Refuses a tool whose side is rounder than a hollow of the surface: DEFO0110 with the radius that fits; the outline
/// of a barrel likewise along the axis. Twist alone is not refused: every cylinder deviates on it. Looked at in the
/// places of deviation_map(); its errors too.
Result<void> check_hollows(const DualPath& path, const FlankTool& tool, const DesignedSurface& surface,
                           const FlankRange& range);

struct FlankDeformation {
    FlankRange range{};
    double most_movement_mm = 1;  ///< of a control point along each axis of the frame at most so much / √3; > 0
    /// One-sided: nowhere in the range may the tool cut deeper into the part than this, ≥ 0. Infinite: not asked.
    double deepest_mm = std::numeric_limits<double>::infinity();
    /// Rounds of weighting by deviation behind the least squares, which bring the peak down: 0 leaves plain squares.
    int peak_rounds = 3;
};

struct DeformedFlank {
    DualPath path;
    DeviationMap before, after;
    double movement_mm = 0;        ///< largest of a control point
    double distance_error_mm = 0;  ///< of the path, as distance_error_mm()
    int iterations = 0;
};

/// Moves the control points of f and g so that the squared deviations over the range become least (Ceres, exact
/// derivatives), then weighs peaks. Knots stay: the path is C² as before; the direction of g − f is what counts, its
/// length is drawn to h. The peak is never larger than that of the path given, which is returned where nothing is
/// better (or, one-sided, where it alone keeps the bound). Verified between the places of the optimisation: `after` is
/// looked at in places of its own.
///
/// Errors: those of check_hollows() and deviation_map(); DEFO0105 options out of range; DEFO0115 the bound on one side
/// cannot be kept within the movement allowed, says the depth that could. Allocates.
/// Source: Affouard et al. 2004; Lartigue, Duc, Affouard 2003 (envelope, deformation in the least-square sense).
Result<DeformedFlank> deform_flank(const DualPath& path, const FlankTool& tool, const DesignedSurface& surface,
                                   const FlankDeformation& options);

}  // namespace trunnion::deformation
