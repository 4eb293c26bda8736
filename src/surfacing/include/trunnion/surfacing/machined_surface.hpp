#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "trunnion/surfacing/plan_surface.hpp"

namespace trunnion::surfacing {

/// What a tool leaves of the material when it is led through poses: tip linear, axis turned in one plane between two of
/// them, as Program says it. Knows nothing of surfaces and of how the poses came about.
///
/// The moves stand in a tree of boxes around the tool's body. Immutable; 200 bytes a move and about 1 µs to build.
class MachinedSurface {
  public:
    /// `polylines`: poses of one pass each; nothing is cut between them. Long moves are divided.
    MachinedSurface(const Cutter& cutter, const std::vector<std::vector<CutterPose>>& polylines);
    MachinedSurface(const Cutter& cutter, const std::vector<Pass>& passes);

    /// Height of the material that is left above a point along a unit direction out of it, mm: the least one at which
    /// the line enters the body on any move. Negative: the point itself was cut away, so deep. Within ±`limit_mm`.
    /// Exact to some nm for poses whose heights are smooth along a move. No allocation. Cost: some µs.
    double height_mm(const Eigen::Vector3d& point_mm, const Eigen::Vector3d& direction, double limit_mm) const noexcept;

  private:
    struct Move {
        CutterPose from, to;
        CutterPose middle;
        double sweep_mm;  ///< no point of the body is farther from where it is at the middle
        double bow_mm;    ///< nor farther from where it were without turning on the way
    };
    struct Box {
        Eigen::Vector3d low, high;
        std::int32_t first, count;  ///< moves of a leaf; count = 0: children at first and first + 1
    };
    void add(const CutterPose& from, const CutterPose& to);
    void build();
    Box box_of(std::int32_t first, std::int32_t count) const;
    double least_distance(const Move& move, const Eigen::Vector3d& point) const noexcept;
    double over_move(const Move& move, const Eigen::Vector3d& point, const Eigen::Vector3d& direction,
                     double limit) const noexcept;

    Cutter cutter_;
    std::vector<Move> moves_;
    std::vector<Box> boxes_;
};

/// What the simulation found of passes over a face.
struct SurfaceVerdict {
    double highest_mm = 0;                                                 ///< material left anywhere within the face
    double deepest_mm = 0;                                                 ///< cut into the face, as a positive number
    double least_ridge_mm = 0, largest_ridge_mm = 0, median_ridge_mm = 0;  ///< between passes, away from borders
    std::size_t ridges = 0;                                                ///< measured
    std::size_t heights = 0;                                               ///< places of the grid within the face
};

struct SurfaceCheckOptions {
    double grid_mm = 1;           ///< spacing of heights all over the face
    double ridge_spacing_mm = 2;  ///< along passes, of the places where ridges are looked for
    double limit_mm = 0.1;        ///< heights are not told apart beyond
};

/// Measures a plan on its face: heights on a grid all over it, and from places of every pass the ridge towards the next
/// one: the surface is walked across the pass in small steps to the highest place before heights fall again. Ridges
/// whose walk leaves the face, or ends within two intervals of its border, are not counted as ridges. Cost: 5-10 µs a
/// height, some 40 heights a ridge.
SurfaceVerdict check_surface(const Face& face, const Cutter& cutter, const std::vector<Pass>& passes,
                             const SurfaceCheckOptions& options = {});

}  // namespace trunnion::surfacing
