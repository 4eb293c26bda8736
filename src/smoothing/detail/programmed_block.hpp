#pragma once

#include <optional>

#include <Eigen/Geometry>

#include "trunnion/geometry/great_circle.hpp"
#include "trunnion/geometry/helix.hpp"
#include "trunnion/path/curve_way.hpp"

#include "detail/coordinates.hpp"
#include "detail/septic.hpp"

namespace trunnion::smoothing {

/// One programmed block as a function of the share w ∈ [0, 1] of its length: straight or an arc in position; vectors
/// turn in a plane at constant rate, rotary axes go linearly. Along a curve w is the share of its parameter.
class ProgrammedBlock {
  public:
    ProgrammedBlock(const path::Run& run, std::size_t block);

    double length_mm() const { return length_; }
    double turn_rad() const { return turn_ ? turn_->angle_rad() : 0; }  ///< in a plane; rotary axes: 0
    const std::optional<geometry::Helix>& arc() const { return arc_; }
    const std::optional<path::CurveWay>& curve() const { return curve_; }

    /// Along a curve whose parameter goes evenly enough for a few pieces by p to follow it.
    bool is_regular_curve() const;

    Coordinates place(double w) const;
    /// With derivatives by p.
    HermiteEnd at(double w) const;

  private:
    Coordinates from_, to_;
    double length_;
    std::optional<geometry::GreatCircle> turn_;
    std::optional<geometry::Helix> arc_;
    std::optional<path::CurveWay> curve_;
};

/// Whether a curve ends at a vertex and another one goes on with the same tangent and curvature, of position and
/// orientation: at most the third derivative changes.
bool curve_goes_on(const path::Run& run, std::size_t vertex);

}  // namespace trunnion::smoothing
