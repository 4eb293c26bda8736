#pragma once

#include <span>

#include "trunnion/motion/feed_profile.hpp"

#include "detail/interior_point.hpp"
#include "detail/loads.hpp"

namespace trunnion::feed {

/// A plan is held to this ratio of every limit everywhere.
inline constexpr double allowed_ratio = 1.0004;

/// Upper bounds of load / limit over one profile piece, half by half (an arc has one, in the first).
struct Peaks {
    struct OfCoordinate {
        double velocity = 0, acceleration = 0, jerk = 0;
    };
    std::array<std::array<OfCoordinate, coordinates>, 2> half{};
    OfCoordinate of(int coordinate) const;
    OfCoordinate worst_of_each() const;
    double worst() const;  ///< infinite where something is not finite
};

/// Above which bound each load is looked at more closely, until it is known to 1e-4.
using Interest = std::array<Peaks::OfCoordinate, coordinates>;
Interest interest_from(double ratio);

/// Bounds by Bernstein hulls of the loads, which are polynomials on each half: with q′ the quintic through the samples,
///     acceleration  q″x + ½q′x′                          (degree 7) against A,
///     jerk          q‴x + 3/2 q″x′ + ½q′x″               (degree 6) against J x^(−½),
///     velocity      q′                                   against V x^(−½),
/// where x^(−½) is replaced by its tangent in x, which lies below it. Cost 0.2 µs, more where a load is near its limit.
class LoadCheck {
  public:
    /// The limits must outlive it.
    explicit LoadCheck(const LimitSet& limits);
    Peaks peaks(const Interval& interval, const motion::ProfilePiece& piece, const Interest& interest) const;

  private:
    const LimitSet* limits_;
    InverseLimits inverse_;
};

/// x > 0 on all of the piece (its inside, for arcs): certified by Bézier values, or by the extrema themselves.
bool is_positive(const motion::ProfilePiece& piece);

/// Raises the tightening of the samples beside a peak above `trigger`; whether it did.
bool tighten(const Peaks& peaks, double trigger, Tightening& tightening);

/// x → λx: scales velocities by √λ, accelerations by λ, jerks by λ^(3/2).
void slow_down(std::span<motion::ProfilePiece> pieces, double lambda);

/// The λ ≤ 1 that brings these peaks inside the limits.
double lambda_for(const Peaks& peaks);

}  // namespace trunnion::feed
