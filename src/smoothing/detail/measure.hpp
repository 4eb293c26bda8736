#pragma once

#include "trunnion/smoothing/smoothing.hpp"

#include "detail/coordinates.hpp"

namespace trunnion::smoothing {

/// What a deviation in Coordinates means for the tool, and how much of the tolerances it uses. Linear parts only; what
/// the certificate must add (curvature of the sphere, change of lever) is its own.
class Measure {
  public:
    /// `range` is what the lever arm of machine space is taken over.
    Measure(const path::Run& run, VertexRange range, const SmoothingOptions& options);

    /// Angle of the tool, rad; with two rotary axes a bound of it, exact where they turn the tool at right angles.
    /// `lever` is that of the axis nearest to the workpiece at the place.
    double turn(const Coordinates& d, double lever) const;
    /// Deviation of the point `height_mm` up the tool axis from the tip, mm.
    double point(const Coordinates& d, double lever, double height_mm) const;
    /// Deviation / tolerance, the larger of both.
    double use(const Coordinates& d, double lever) const;
    /// Weights of the squares of coordinates in |d_tip|² + (flank height · turn)², by which places are called near.
    Coordinates metric(double lever) const;
    /// Product of two deviations in that metric.
    double product(const Coordinates& a, const Coordinates& b, double lever) const {
        return a.cwiseProduct(metric(lever)).dot(b);
    }
    /// Square of a length in that metric below which no deviation breaks a tolerance.
    double nearness_square() const;
    /// The same of deviations that are already known.
    double use_of(double tip_mm, double turn_rad, double height_mm) const;

    /// Largest turn that the tolerances allow, rad.
    double turn_tolerance_rad() const;
    double controlled_height_mm() const { return options_.controlled_height_mm; }
    double flank_height_mm() const { return options_.flank_height_mm; }
    double tip_tolerance_mm() const { return options_.tip_tolerance_mm; }
    bool vectors() const { return vectors_; }
    int lever_axis() const { return lever_axis_; }  ///< index in Coordinates, −1: none
    /// Space machine: the tip moves at most so far per radian of a rotary axis; else 0.
    double arm_mm() const { return arm_mm_; }
    /// Deviations of the axes are not those of the tool: machine space with turning axes.
    bool has_arm() const { return arm_mm_ > 0; }

  private:
    SmoothingOptions options_;
    bool vectors_;
    int lever_axis_;
    double arm_mm_ = 0;  // machine space: the tip moves at most so far per radian of a rotary axis
    // Two rotary axes: |∂n/∂θ| of the one farther from the workpiece, and the largest |∂n/∂θ₁ · ∂n/∂θ₂|.
    double other_lever_ = 1, product_ = 0;
};

/// Levers below this count as this much: a rotary axis is never quite free.
inline constexpr double least_lever = 0.02;

}  // namespace trunnion::smoothing
