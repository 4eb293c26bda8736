#pragma once

#include "detail/measure.hpp"
#include "detail/polyline.hpp"
#include "detail/septic.hpp"

namespace trunnion::smoothing {

/// A slerp over the angle θ is at most this times θ³ from its chord, as an angle: max t(1−t)(1−2t)/6.
inline constexpr double chord_sideways = 0.017;

/// How far a path is from the programmed one: controlled point (mm), tool axis (rad), point at the flank height (mm).
struct Extent {
    double tip = 0, turn = 0, height = 0;
};

void widen(Extent& a, const Extent& b);

/// Bounds the deviation of polynomials from straight blocks by the Bernstein hull of the difference, halved where the
/// hull's slack matters beside the largest deviation that was seen so far. Law vector: the programmed path is the
/// slerp; the chord's distance from it is added, and that of arcs and curves from their chords.
class DeviationHull {
  public:
    DeviationHull(const path::Run& run, const Measure& measure, const Polyline& line);

    /// Over one cell: the polynomial and the straight block from → to beneath it, at equal share of the way.
    Extent over(const Bernstein& curve, const Coordinates& from, const Coordinates& to);

    /// Upper bound of the lever on a straight block.
    double lever_bound(const Coordinates& from, const Coordinates& to) const;

  private:
    /// What coordinates do to points of the tool in the workpiece, linearised at a place. Rotary axes only.
    struct Frame {
        Eigen::Matrix<double, 3, 6> tip, axis;  // of the tip, and of the unit tool axis
    };

    Frame frame(const Coordinates& at) const;
    double point(const Frame& frame, const Coordinates& d, double height_mm) const;
    double beyond_frame(const Bernstein& d, const Coordinates& step, double height_mm) const;
    double turn_beyond_frame(const Bernstein& d, const Coordinates& step) const;
    void sharpen(Extent& hull, Extent& ends, const Bernstein& d, const Coordinates& from, const Coordinates& to) const;
    Extent measured(const Coordinates& d, double lever) const;
    double take_across(Bernstein& d, const Bernstein& curve, const Coordinates& from, const Coordinates& to) const;
    double lever_beside(const Bernstein& d, double lever) const;
    Extent over(const Bernstein& curve, const Coordinates& from, const Coordinates& to, double lever, int depth);
    bool slack(const Extent& hull) const;

    const path::Run& run_;
    const Measure& measure_;
    int lever_axis_;
    bool has_frames_;
    double sideways_ = 0;  // a slerp from its chord, as an angle
    Extent chord_;         // arcs and curves from their chords
    Extent seen_;          // deviations that do occur
};

}  // namespace trunnion::smoothing
