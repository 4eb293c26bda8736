#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "trunnion/surfacing/plan_surface.hpp"

namespace trunnion::surfacing {

/// What a tool leaves of the material when it is led through poses: tip linear, axis turned in one plane between two of
/// them, as Program says it. Knows nothing of surfaces and of how the poses came about.
///
/// The moves stand in a tree of groups of poses. The distance of a convex body from a point is a convex function of the
/// body's place: its tangent plane at a group's middle bounds it for all of the group. Immutable; 400 bytes a move and
/// about 1 µs to build.
class MachinedSurface {
  public:
    /// `polylines`: poses of one pass each; nothing is cut between them. Long moves are divided.
    MachinedSurface(const Cutter& cutter, const std::vector<std::vector<CutterPose>>& polylines);
    MachinedSurface(const Cutter& cutter, const std::vector<Pass>& passes);

    /// Height of the material that is left above a point along a unit direction out of it, mm: the least one at which
    /// the line enters the body on any move. Negative: the point itself was cut away, so deep. Within ±`limit_mm`.
    /// Exact to some 10 nm. No allocation. Cost: some µs.
    double height_mm(const Eigen::Vector3d& point_mm, const Eigen::Vector3d& direction, double limit_mm) const noexcept;

    /// How far a point lies within the body at the most on any move, mm; 0 outside. Beside an edge as sharp as a knife
    /// a line along the normal leaves the material again at once, and is cut from both sides: there this is the depth.
    /// No allocation. Cost: some µs.
    double depth_mm(const Eigen::Vector3d& point_mm) const noexcept;

  private:
    struct Move {
        CutterPose from;
        Eigen::Vector3d shift, turn;  ///< of tip and axis to the move's end

        Eigen::Vector3d middle_tip() const { return from.tip_mm + 0.5 * shift; }
        CutterPose end() const { return {from.tip_mm + shift, from.axis + turn}; }
    };
    /// Poses within a cylinder round their middle, and their axes within a cone.
    struct Group {
        CutterPose middle;
        double along_mm, across_mm;  ///< half the height of that cylinder along the middle axis, its radius
        double cone_rad;
        std::int32_t first, count;  ///< moves of a leaf; count = 0: children at first and first + 1
    };
    /// The body where it is nearest to a point on a move.
    struct Nearest {
        double distance_mm;
        Eigen::Vector3d slope;  ///< of the distance by the point's place
    };
    void add(const CutterPose& from, const CutterPose& to);
    void build();
    Group group_of(std::int32_t first, std::int32_t count) const;
    double least_distance(const Group& group, const Eigen::Vector3d& point) const noexcept;
    Nearest nearest(const Move& move, const Eigen::Vector3d& point) const noexcept;
    double over_move(const Move& move, const Eigen::Vector3d& point, const Eigen::Vector3d& direction, double known,
                     double limit) const noexcept;

    Cutter cutter_;
    std::vector<Move> moves_;
    std::vector<Group> groups_;
};

/// What the simulation found of passes over a face.
struct SurfaceVerdict {
    double highest_mm = 0;  ///< material left anywhere within the face, its borders included
    /// Cut into the face, as a positive number: along the normal, but no deeper than its place lies within the tool.
    double deepest_mm = 0;
    Eigen::Vector3d highest_at_mm{0, 0, 0}, deepest_at_mm{0, 0, 0};
    /// Between passes, away from borders. Those between passes as far apart as the tool's end reaches, where no scallop
    /// bounds the interval, are `at_reach` and count for the largest one alone.
    double least_ridge_mm = 0, largest_ridge_mm = 0, median_ridge_mm = 0;
    std::size_t ridges = 0, at_reach = 0;
    double left_mm2 = 0, area_mm2 = 0;  ///< higher than left_above_mm near places left out; all, both by the grid
    std::size_t heights = 0;            ///< places of the grid within the face, and along its borders
};

struct SurfaceCheckOptions {
    double grid_mm = 1;           ///< spacing of heights all over the face and along its borders
    double ridge_spacing_mm = 2;  ///< along passes, of the places where ridges are looked for
    double limit_mm = 0.1;        ///< heights are not told apart beyond
    /// Places that the plan leaves as they are: what one reaches counts neither as left nor as a ridge, but for its
    /// area where it is higher than `left_above_mm`. What is cut too deep counts everywhere.
    std::span<const LeftPlace> left = {};
    double left_above_mm = 0.01;
};

/// Measures a plan on its face: heights on a grid all over it and at some distances from its borders, and from places
/// of every pass the ridge towards the pass of the next index: the highest place on the straight line in (u, v) to the
/// nearest contact there. Ridges nearer than two intervals to the face's border are not counted as ridges; nor is a
/// line that leaves the face. Cost: 2-5 µs a height, some 30 heights a ridge.
SurfaceVerdict check_surface(const Face& face, const Cutter& cutter, const std::vector<Pass>& passes,
                             const SurfaceCheckOptions& options = {});

}  // namespace trunnion::surfacing
