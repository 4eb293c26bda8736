#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "trunnion/feed/interval.hpp"

/// How soon a moving machine can stand, or be down at the feed: shooting along the path. From the state at the begin of
/// the intervals the path jerk is the most negative one that all axes allow, then from a switching point on the most
/// positive one; the point is bisected. An estimate to a few percent, for the windows that are planned then; the curve
/// is their first guess. Cost about 50 µs for 40 intervals.
namespace trunnion::feed {

struct Descent {
    std::vector<double> way_mm, x;  ///< at the samples, from the start
    double length_mm = 0;           ///< from there on the machine stands, or x is within the caps
    double worst = 0;  ///< of jerk and acceleration, of their limits: above 1 where the lowest x″ led to a dead end

    double x_at(double way_mm) const;  ///< linear between; 0 behind the end
};

/// ṗ² and its derivative where the machine is.
struct MovingStart {
    double x = 0, d = 0;
};

/// Braking as hard as the limits allow at every place may end where nothing is allowed any more: in corners, where one
/// axis brakes and another one speeds up. Careful braking looks ahead at every step, for some ms.
enum class Braking : std::uint8_t { hardest, careful };

/// The shortest stop; none where the intervals end before it.
std::optional<Descent> shortest_stop(std::span<const Interval> intervals, const LimitSet& limits, MovingStart start,
                                     Braking braking);

/// The shortest way down to the caps of the samples.
std::optional<Descent> shortest_descent(std::span<const Interval> intervals, const LimitSet& limits, MovingStart start);

/// Whether the machine brakes so hard that it comes to a standstill whatever is done.
bool must_stand(std::span<const Interval> intervals, const LimitSet& limits, MovingStart start);

/// Way and time scale of a stop under path limits that do not change.
double stopping_distance_mm(double speed_mm_s, double acceleration_mm_s2, double most_acceleration_mm_s2,
                            double most_jerk_mm_s3);

}  // namespace trunnion::feed
