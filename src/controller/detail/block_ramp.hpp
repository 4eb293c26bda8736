#pragma once

#include <algorithm>
#include <cmath>

namespace trunnion::controller {

/// Speeding up and braking along one segment as a law of the speed alone: a(v) = min(4/3·√(vJ), A), or A without jerk
/// limit. Among such laws √(vJ) with the factor 4/3 is the one with which a move from rest to the speed V and back to
/// rest takes exactly as long as with ramps of constant jerk, whatever its length beyond them; capped by A it is at
/// most 2.5 % of a ramp longer. A law of the speed alone makes every limit tell in one direction: a
/// lower one never makes anything faster.
/// Units: mm of the axes' space, s.
class Ramp {
  public:
    /// jerk = infinite: acceleration alone.
    Ramp(double acceleration, double jerk) noexcept
        : acceleration_(acceleration),
          root_jerk_(std::sqrt(jerk)),
          bend_(9.0 / 16.0 * acceleration * acceleration / jerk) {
        if (!(jerk < infinite)) bend_ = root_jerk_ = 0;
        if (bend_ > 0) {
            distance_to_bend_ = bend_ * std::sqrt(bend_) / (2 * root_jerk_);
            time_to_bend_ = 1.5 * std::sqrt(bend_) / root_jerk_;
        }
    }

    /// From rest to speed v.
    double distance(double v) const noexcept {
        if (v < bend_) return v * std::sqrt(v) / (2 * root_jerk_);
        return distance_to_bend_ + (v * v - bend_ * bend_) / (2 * acceleration_);
    }
    double time(double v) const noexcept {
        if (v < bend_) return 1.5 * std::sqrt(v) / root_jerk_;
        return time_to_bend_ + (v - bend_) / acceleration_;
    }
    /// The speed at a distance from rest.
    double speed(double distance) const noexcept {
        if (distance < distance_to_bend_) {
            const double w = std::cbrt(2 * root_jerk_ * distance);
            return w * w;
        }
        return std::sqrt(bend_ * bend_ + 2 * acceleration_ * std::max(0.0, distance - distance_to_bend_));
    }
    /// What it has on the way at speed v; at most A.
    double acceleration(double v) const noexcept {
        return v < bend_ ? 4.0 / 3.0 * root_jerk_ * std::sqrt(v) : acceleration_;
    }
    bool is_jerk(double v) const noexcept { return v < bend_; }

  private:
    static constexpr double infinite = 1e300;
    double acceleration_, root_jerk_, bend_;
    double distance_to_bend_ = 0, time_to_bend_ = 0;
};

/// Speed from which a ramp of constant jerk comes to rest over a distance on which acceleration and jerk vary:
/// `accelerations` = Σ 2A·h, `root_jerks` = Σ √J·h (infinite: no jerk limit). Grows with both.
inline double stopping_speed(double accelerations, double root_jerks) noexcept {
    if (!(root_jerks < 1e300)) return std::sqrt(accelerations);
    if (!(root_jerks > 0)) return 0;
    const double w = std::cbrt(root_jerks);
    const double by_jerk = w * w, ratio = accelerations / (2 * root_jerks);  // ratio² = A²/J, the speed where A is met
    if (by_jerk <= ratio * ratio) return by_jerk;
    // v²/(2A) + vA/(2J) = distance
    const double half = accelerations * accelerations / (8 * root_jerks * root_jerks);
    return std::sqrt(half * half + accelerations) - half;
}

}  // namespace trunnion::controller
