#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "trunnion/base/result.hpp"
#include "trunnion/feed/feed_planner.hpp"
#include "trunnion/feed/interval.hpp"
#include "trunnion/motion/feed_profile.hpp"
#include "trunnion/path/axis_path.hpp"

namespace trunnion::feed {

/// Factors > 0 on the limits of one axis: what would more of them be worth?
struct LimitFactors {
    double velocity = 1, acceleration = 1, jerk = 1;
};

struct FeedOptions {
    double calm = 0.001;       ///< smoothness weight ≥ 0, see PlannerOptions
    double jerk_margin = 0;    ///< share of every jerk limit to leave unused, in [0, 1)
    std::size_t window = 400;  ///< intervals planned at once, see PlannerOptions
    /// Largest distance of the tip's path from the straight steps between setpoints `period_s` apart.
    double chord_error_mm = std::numeric_limits<double>::infinity();
    double period_s = 1e-3;  ///< of the chord error
    /// Along the tip's path in the workpiece (in machine space: of the linear axes together), rapids too.
    double tip_acceleration_mm_s2 = std::numeric_limits<double>::infinity();
    double tip_jerk_mm_s3 = std::numeric_limits<double>::infinity();
    /// How fast the tool may turn: as AxisSample::turn_rate counts.
    double turn_velocity_rad_s = std::numeric_limits<double>::infinity();
    std::array<LimitFactors, machine::max_axes> factors{};
    std::function<int(int window)> budget;  ///< see PlannerOptions
};

/// What holds the speed down on a piece of the profile.
struct Cause {
    enum class Kind : std::uint8_t { none, feed, velocity, acceleration, jerk, chord } kind = Kind::none;
    /// Of velocity, acceleration, jerk: index in AxisVector, or `tip_way`, `tool_turn`.
    int axis = -1;
    bool operator==(const Cause&) const = default;
};

/// `feed`, `chord`, `A jerk`, `X velocity`, `tip acceleration`, `tool velocity`, …; `none` where nothing limits.
std::string name_of(const Cause& cause, const machine::Machine& machine);

/// Peak / limit of one axis (the whole limit, without the jerk margin).
struct AxisPeaks {
    double velocity = 0, acceleration = 0, jerk = 0;
};

struct StretchPlan {
    motion::FeedProfile profile;
    std::vector<Cause> causes;  ///< one a piece of the profile
    std::array<AxisPeaks, machine::max_axes>
        peaks{};                   ///< bounds over the whole motion, at most 1e-4 above what is reached
    double jerk_free_bound_s = 0;  ///< same path, velocity, acceleration and feed limits only
    std::size_t intervals = 0;
    int windows = 0, iterations = 0, tightening_rounds = 0;
    int fallbacks = 0;                                      ///< windows whose plan is not the optimum
    std::array<double, machine::max_axes> jerk_square_s{};  ///< ∫ (jerk/limit)² dt, of the whole limit
    std::array<LimitWorth, machine::max_axes> worth{};      ///< what a little more of each limit is worth
    double feed_worth_s = 0;                                ///< the same of the programmed feed
};

/// The ṗ that the programmed feed of a block allows at a place, mm/s; infinite where it bounds nothing.
double feed_speed_cap(const path::BlockSpan& block, const path::AxisSample& sample);

/// The intervals of one stretch, from its begin to its end. Reads the axis path and nothing of the planner, so that it
/// may run on another thread, ahead of a StretchPlanner. The path must outlive it.
class IntervalStream {
  public:
    /// Errors: FEED0001 an option outside its range, FEED0005 the stretch is shorter than a micrometre (of p),
    /// FEED0006 a limit is 0, negative, missing or not finite, FEED0008 a programmed feed is not more than 0.
    static Result<IntervalStream> make(const path::AxisPath& path, const FeedOptions& options);
    ~IntervalStream();
    IntervalStream(IntervalStream&&) noexcept;
    IntervalStream& operator=(IntervalStream&&) noexcept;

    /// Writes the next interval; false behind the last one. Errors: FEED0002 derivatives of the path are not finite,
    /// FEED0009 the path jumps in position.
    Result<bool> next(Interval& interval);

  private:
    class State;
    explicit IntervalStream(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

/// Plans a stretch from its intervals as they come (FeedPlanner) and collects profile, causes, peaks and worth.
class StretchPlanner {
  public:
    StretchPlanner(const path::AxisPath& path, const FeedOptions& options);
    ~StretchPlanner();
    StretchPlanner(StretchPlanner&&) noexcept;
    StretchPlanner& operator=(StretchPlanner&&) noexcept;

    void push(const Interval& interval);
    /// What is planned so far, from the begin of the stretch: it grows at the end, and what it has stays as it is. Each
    /// piece holds the limits, and a motion over them can go on. Where finish() fails they end at rest.
    const motion::FeedProfile& planned() const noexcept;
    /// Once, behind the last interval. Errors: FEED0003 / FEED0004 as FeedPlanner.
    Result<StretchPlan> finish();

  private:
    class State;
    std::unique_ptr<State> state_;
};

/// Grids a stretch (IntervalStream) and plans its speed in minimum time from rest to rest (StretchPlanner): all axis
/// limits (`rapid` ones for a rapid) and the programmed feed are held to 1.0004. The grid follows the path: fine where
/// an axis' direction turns, near rest points and where the feed changes, some millimetres where nothing happens.
/// Errors: of both. Cost about 15 µs an interval; memory 0.1 kB an interval beside the planner's window.
Result<StretchPlan> plan_stretch(const path::AxisPath& path, const FeedOptions& options);

}  // namespace trunnion::feed
