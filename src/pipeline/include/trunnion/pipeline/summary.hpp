#pragma once

#include <string>
#include <vector>

#include "trunnion/base/diagnostic.hpp"
#include "trunnion/machine/machine.hpp"

namespace trunnion::pipeline {

/// How hard one axis works.
struct AxisLoad {
    char letter = 'X';
    double velocity_ratio = 0, acceleration_ratio = 0, jerk_ratio = 0;  ///< peak / limit
    double limiting_share = 0;  ///< share of the cutting time in which this axis is what limits
};

/// A place where the feed falls under nine tenths of what is programmed.
struct FeedDrop {
    int line = 0;
    double s_from_mm = 0, s_to_mm = 0;
    double feed_min_mm_s = 0, programmed_feed_mm_s = 0;
    double lost_s = 0;  ///< against the programmed feed
    std::string cause;  ///< what costs most there: `A jerk`, `X acceleration`, …
};

struct ExactStops {
    int total = 0, reversals = 0, rapids = 0, dwells = 0, events = 0, words = 0, corners = 0;
};

/// Seconds and memory that the work itself took.
struct Work {
    double read_s = 0, smooth_s = 0, plan_s = 0, sample_s = 0;
    double peak_memory_mb = 0;
};

/// What a run of `plan` came to. Names, units and meanings as in interfaces.md.
struct Summary {
    std::string program, dialect, machine, setup;
    double cycle_time_s = 0, cut_time_s = 0, rapid_time_s = 0, dwell_time_s = 0;
    double path_length_mm = 0;
    std::size_t setpoints = 0, blocks = 0, intervals = 0;
    double period_s = 0;
    double jerk_free_bound_s = 0;
    double tip_deviation_mm = 0, orientation_deviation_rad = 0, height_deviation_mm = 0;  ///< bounds on the maxima
    double tip_tolerance_mm = 0, orientation_tolerance_rad = 0, flank_tolerance_mm = 0, flank_height_mm = 0;
    double tolerance_used = 0;  ///< median over the block transitions that are rounded
    ExactStops exact_stops;
    std::vector<AxisLoad> axes;
    std::vector<FeedDrop> feed_drops;
    std::size_t windows = 0, fallbacks = 0;
    Work work;
    std::vector<Diagnostic> diagnostics;

    /// All limits and tolerances hold: ratios ≤ 1.001, deviations within what was asked.
    bool usable() const;
    /// A dozen lines for a person.
    std::string report() const;
};

/// The JSON of interfaces.md.
std::string to_json(const Summary& summary);

}  // namespace trunnion::pipeline
