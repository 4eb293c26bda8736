#pragma once

#include <optional>

#include <Eigen/Geometry>

#include "trunnion/geometry/great_circle.hpp"
#include "trunnion/geometry/helix.hpp"

#include "detail/coordinates.hpp"
#include "detail/septic.hpp"

namespace trunnion::smoothing {

/// One programmed block as a function of the share w ∈ [0, 1] of its length: straight or an arc in position; vectors
/// turn in a plane at constant rate, rotary axes go linearly.
class ProgrammedBlock {
  public:
    ProgrammedBlock(const path::Run& run, std::size_t block);

    double length_mm() const { return length_; }
    double turn_rad() const { return turn_ ? turn_->angle_rad() : 0; }  ///< of the vector; rotary axes: 0
    const std::optional<geometry::Helix>& arc() const { return arc_; }

    Coordinates place(double w) const;
    /// With derivatives by p.
    HermiteEnd at(double w) const;

  private:
    Coordinates from_, to_;
    double length_;
    std::optional<geometry::GreatCircle> turn_;
    std::optional<geometry::Helix> arc_;
};

}  // namespace trunnion::smoothing
