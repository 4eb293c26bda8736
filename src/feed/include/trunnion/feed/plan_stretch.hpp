#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "trunnion/base/result.hpp"
#include "trunnion/motion/feed_profile.hpp"
#include "trunnion/path/axis_path.hpp"

namespace trunnion::feed {

struct FeedOptions {
    double calm = 0.001;       ///< smoothness weight ≥ 0, see PlannerOptions
    double jerk_margin = 0;    ///< share of every jerk limit to leave unused, in [0, 1)
    std::size_t window = 300;  ///< intervals planned at once, see PlannerOptions
};

/// What holds the speed down on a piece of the profile.
struct Cause {
    enum class Kind : std::uint8_t { none, feed, velocity, acceleration, jerk } kind = Kind::none;
    int axis = -1;  ///< of velocity, acceleration, jerk: index in AxisVector
    bool operator==(const Cause&) const = default;
};

/// `feed`, `A jerk`, `X velocity`, …; `none` where nothing limits.
std::string name_of(const Cause& cause, const machine::Machine& machine);

/// Peak / limit of one axis (the whole limit, without the jerk margin).
struct AxisPeaks {
    double velocity = 0, acceleration = 0, jerk = 0;
};

struct StretchPlan {
    motion::FeedProfile profile;
    std::vector<Cause> causes;  ///< one a piece of the profile
    std::array<AxisPeaks, machine::max_axes>
        peaks{};                   ///< at nine samples a piece and the parabolas between, and nearer to rest
    double jerk_free_bound_s = 0;  ///< same path, velocity, acceleration and feed limits only
    std::size_t intervals = 0;
    int windows = 0, iterations = 0, tightening_rounds = 0;
    int fallbacks = 0;  ///< windows whose plan is not the optimum
};

/// The ṗ that the programmed feed of a block allows at a place, mm/s; infinite where it bounds nothing.
double feed_speed_cap(const path::BlockSpan& block, const path::AxisSample& sample);

/// Grids a stretch and plans its speed in minimum time from rest to rest (FeedPlanner): all axis limits (`rapid` ones
/// for a rapid) and the programmed feed are held to 1.0004. The grid follows the path: fine where an axis' direction
/// turns, near rest points and where the feed changes, some millimetres where nothing happens. Errors: FEED0001 an
/// option outside its range, FEED0002 derivatives of the path are not finite, FEED0003 / FEED0004 as FeedPlanner,
/// FEED0005 the stretch has no length. Cost about 50 µs an interval; memory 0.3 kB an interval beside the planner's
/// window.
Result<StretchPlan> plan_stretch(const path::AxisPath& path, const FeedOptions& options);

}  // namespace trunnion::feed
