#pragma once

#include <vector>

#include <Eigen/Core>

#include "trunnion/deformation/dual_path.hpp"
#include "trunnion/deformation/rotary_use.hpp"

#include "detail/pole_approach.hpp"

namespace trunnion::deformation::detail {

/// The axis vectors of a path turned about one direction beside a pole: in full (rigidly) where the path comes nearest,
/// less and less away from it, not at all at both ends.
///
/// Positive angles lead over the pole: the distance β from it becomes |β − angle|.
class PoleTurn {
  public:
    /// In full up to path::level_share of the reach, which is counted in the turn of the tool from the nearest place;
    /// it is as large as wanted, or as control points stand wide, where there is room between the two u. Adds knots
    /// where control points stand too wide for what room there is.
    static PoleTurn make(const DualPath& path, const PoleApproach& approach, double reach_rad, double from_u,
                         double to_u);

    DualPath turned(double angle_rad, double controlled_height_mm) const;
    double from_u() const { return from_u_; }  ///< outside of it nothing changes
    double to_u() const { return to_u_; }

  private:
    explicit PoleTurn(const DualPath& path) : path_(path) {}
    DualPath path_;
    Eigen::Vector3d about_ = Eigen::Vector3d::UnitX();
    std::vector<double> share_;  // of every control point
    double from_u_ = 0, to_u_ = 0;
};

/// Velocity of the axis nearest to the workpiece over its limit, at the feed.
double free_axis_ratio(const DualPath& path, const Machining& machining, double u);

/// The largest between two u; looked for more closely around `near_u`.
double free_axis_ratio(const DualPath& path, const Machining& machining, double from_u, double to_u, double near_u);

}  // namespace trunnion::deformation::detail
