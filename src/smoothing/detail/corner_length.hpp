#pragma once

#include <array>

#include "trunnion/numeric/taylor3.hpp"
#include "trunnion/smoothing/corner.hpp"

#include "detail/coordinates.hpp"

namespace trunnion::smoothing {

/// A corner spline in any coordinates by its five control points.
class CornerPolygon {
  public:
    explicit CornerPolygon(const std::array<Coordinates, 5>& points) : points_(points) {}

    /// Taylor coefficients by u.
    std::array<Coordinates, 4> at(double u, Half half) const noexcept;

  private:
    std::array<Coordinates, 5> points_;
};

/// Path length along a corner spline as a function of its parameter. Exact to some 1e-13 of the length: Gauss's rule
/// on quarters of each half, where the speed is smooth.
class CornerLength {
  public:
    explicit CornerLength(const CornerPolygon& curve);

    double total_mm() const noexcept { return at_border_.back(); }
    /// From the begin to u, and three derivatives by u.
    Taylor3 at(double u, Half half) const noexcept;
    /// The parameter at a length, in [0, total].
    double parameter_at(double length_mm) const noexcept;

  private:
    static constexpr int parts = 8;
    double integral(double from, double to, Half half) const noexcept;

    std::array<std::array<double, 5>, 2> square_speed_{};  // of each half: |dC/du|² in powers of u
    std::array<double, parts + 1> at_border_{};
};

}  // namespace trunnion::smoothing
