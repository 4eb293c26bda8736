#pragma once

#include <array>

#include <Eigen/Core>

#include "trunnion/numeric/taylor3.hpp"

namespace trunnion::geometry {

/// A circle, helix or spiral from one point to another about a line: with w ∈ [0, 1], φ its angle and c the foot of the
/// start on the line,
///     x(w) = c + ρ(w)·(cos(wφ) e₁ + sin(wφ) e₂) + w·h·n + w·m,   ρ(w) = ρ₀ + w(ρ₁ − ρ₀),
/// n the unit direction of the line, e₁ from c to the start, e₂ = n × e₁, h the way along the line, and m what the end
/// given differs from the end so reached (0 but for rounding where the angle was computed from the ends). Immutable.
class Helix {
  public:
    /// `on_line`: any point of the line; `normal`: unit. Precondition: the start is not on the line; finite values.
    Helix(const Eigen::Vector3d& start, const Eigen::Vector3d& end, const Eigen::Vector3d& on_line,
          const Eigen::Vector3d& normal, double angle_rad) noexcept;

    double angle_rad() const noexcept { return angle_rad_; }
    double radius_at_start() const noexcept { return radius_; }
    double radius_at_end() const noexcept { return radius_ + widening_; }

    /// Length; exact for circles and helices, of a spiral √((φ·mean radius)² + h² + (ρ₁ − ρ₀)²), short by less than
    /// a thousandth for less than a tenth of the radius.
    double length() const noexcept;

    /// Largest distance of a chord from the curve when the curve is cut into `parts` equal shares of w.
    double chord_error(int parts) const noexcept;

    Eigen::Vector3d at(double w) const noexcept;
    /// The same with three derivatives of whatever w is a function of.
    std::array<Taylor3, 3> at(const Taylor3& w) const noexcept;

  private:
    Eigen::Vector3d foot_, out_, ahead_, along_;  // c, e₁, e₂, h·n + m
    double radius_, widening_, angle_rad_;
};

}  // namespace trunnion::geometry
