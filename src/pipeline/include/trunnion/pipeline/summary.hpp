#pragma once

#include <optional>
#include <string>
#include <vector>

#include "trunnion/base/diagnostic.hpp"
#include "trunnion/machine/machine.hpp"
#include "trunnion/pipeline/plan_options.hpp"

namespace trunnion::pipeline {

/// How hard one axis works.
struct AxisLoad {
    char letter = 'X';
    double velocity_ratio = 0, acceleration_ratio = 0, jerk_ratio = 0;  ///< peak / limit
    double jerk_rms = 0;                                                ///< √(∫ (jerk/limit)² dt / time in motion)
    double limiting_share = 0;  ///< share of the cutting time in which this axis is what limits
};

/// A place where the feed falls under nine tenths of what is programmed.
struct FeedDrop {
    int line = 0;
    double s_from_mm = 0, s_to_mm = 0;
    double feed_min_mm_s = 0, programmed_feed_mm_s = 0;
    double lost_s = 0;  ///< against the programmed feed
    std::string cause;  ///< what costs most there: `A jerk`, `X acceleration`, …
    /// The slowest place lies in a block transition that uses more than 0.9 of its tolerance: more would help.
    bool at_tolerance = false;
};

struct ExactStops {
    int total = 0, reversals = 0, rapids = 0, dwells = 0, events = 0, words = 0, corners = 0;
};

/// What smoothness costs.
struct Calm {
    double weight = 0;
    std::optional<double> price_s;  ///< time with this weight minus time without; empty: not looked for
};

/// What more of one limit is worth.
struct Worth {
    std::string what;               ///< `A jerk`, `X velocity`, `feed`, `tip tolerance`, `calm`, …
    std::string change;             ///< `+10 %`, `x 2`, `off`
    std::optional<double> saves_s;  ///< found by planning again with it; empty: no plan was found (PIPE0103)
    /// The same by the multipliers of the plan at hand: −d(time)/d(ln limit)·0.1. Empty for tolerances and calm.
    std::optional<double> gradient_s;
};

/// Seconds and memory that the work itself took. With two threads the seconds are those of both, waiting left out, so
/// that their sum may be more than `elapsed_s`.
struct Work {
    double read_s = 0, smooth_s = 0, plan_s = 0, sample_s = 0;
    double replan_s = 0;   ///< for the price of calm and for `worth`
    double elapsed_s = 0;  ///< from the call of plan() to its end
    double peak_memory_mb = 0;
};

/// What a run of `plan` came to. Names, units and meanings as in interfaces.md.
struct Summary {
    std::string program, dialect, machine, setup;
    PlanOptions options;
    double cycle_time_s = 0, cut_time_s = 0, rapid_time_s = 0, dwell_time_s = 0;
    double path_length_mm = 0;
    std::size_t setpoints = 0, blocks = 0, intervals = 0;
    double jerk_free_bound_s = 0;
    double tip_deviation_mm = 0, orientation_deviation_rad = 0, height_deviation_mm = 0;  ///< bounds on the maxima
    double tolerance_used = 0;  ///< median over the block transitions that are rounded
    ExactStops exact_stops;
    std::vector<AxisLoad> axes;
    std::vector<FeedDrop> feed_drops;
    Calm calm;
    std::vector<Worth> worth;  ///< what saves most first, what was not found last; empty unless asked for
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
