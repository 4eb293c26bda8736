#pragma once

#include <span>
#include <vector>

#include "trunnion/motion/feed_profile.hpp"

#include "detail/interior_point.hpp"

namespace trunnion::feed {

/// A plan is checked to this ratio of every limit at all samples of all intervals, peaks between samples included.
inline constexpr double allowed_ratio = 1.0004;

/// Peak / limit over one profile piece, by its interval's samples; between them by a parabola.
struct Peaks {
    std::array<double, machine::max_axes> velocity{}, acceleration{}, jerk{};
    double feed = 0;
    double worst() const;
};

Peaks peaks_of(const Interval& interval, const motion::ProfilePiece& piece, const LimitSet& limits);

/// x > 0 on all of the piece (its inside, for arcs): certified by Bézier values, or by the extrema themselves.
bool is_positive(const motion::ProfilePiece& piece);

/// Raises the tightening where peaks are above `trigger`, to `reserve` below the limit; whether it did.
bool tighten(const Peaks& peaks, double trigger, double reserve, Tightening& tightening);

/// x → λx: scales velocities by √λ, accelerations by λ, jerks by λ^(3/2).
void slow_down(std::span<motion::ProfilePiece> pieces, double lambda);

/// The λ ≤ 1 that brings these peaks inside the limits.
double lambda_for(const Peaks& peaks);

}  // namespace trunnion::feed
