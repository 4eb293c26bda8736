#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "trunnion/geometry/great_circle.hpp"
#include "trunnion/path/run.hpp"

namespace trunnion::path {

/// One block along a curve of the program as a function of v ∈ [0, 1], the curve's own parameter from the block's start
/// to its end: position and orientation in the coordinates of its run, and the length p along it,
///     (dp/dv)² = |dposition/dv|² + (ρ dω/dv)², dω² = |daxis|², or the sum of the squares of the rotary axes' turns.
/// A rotary axis counts in full, without the lever that turn_rad has for straight moves: so p is as smooth as the
/// curve. Refers to the run's curve. Nothing allocates.
class CurveWay {
  public:
    /// Precondition: the block is along a curve.
    CurveWay(const Run& run, std::size_t block);
    CurveWay(const Run& run, const CurvePiece& curve, const PathCoordinates& from, const PathCoordinates& to);

    const CurvePiece& curve() const { return *curve_; }

    /// The orientation is unit under law vector.
    PathCoordinates at(double v) const;

    /// With derivatives by v. Cost about 0.5 µs.
    std::array<Taylor3, 6> by_parameter(double v) const;

    /// With derivatives by p: |dc/dp| = 1 in the metric of p. Precondition: speed_mm(v) > 0.
    std::array<Taylor3, 6> by_length(double v) const;

    double speed_mm(double v) const;  ///< dp/dv

    /// p from one parameter to another, to 1e-9 of it where the speed is smooth.
    double length_mm(double from, double to) const;

    /// Length of the position's way alone, as exactly.
    double way_mm() const;

    /// The parameter at a share of the whole length, to 1e-9.
    double at_length(double share) const;

  private:
    const CurvePiece* curve_;
    PathCoordinates from_, to_;
    bool vectors_;
    std::optional<geometry::GreatCircle> turn_;  // law vector, where the curve says nothing of the tool axis
};

}  // namespace trunnion::path
