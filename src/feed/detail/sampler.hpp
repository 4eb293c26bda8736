#pragma once

#include "trunnion/feed/plan_stretch.hpp"

namespace trunnion::feed {

/// The limits of all coordinates on a stretch: the machine's (of rapids on a rapid), and those of the options.
LimitSet limits_of(const path::AxisPath& path, const FeedOptions& options);

/// Turns places of a path into samples of all coordinates that have a limit.
class Sampler {
  public:
    Sampler(const path::AxisPath& path, const FeedOptions& options)
        : path_(&path),
          limits_(limits_of(path, options)),
          chord_(options.chord_error_mm),
          period_s_(options.period_s) {}

    const path::AxisPath& path() const { return *path_; }
    const LimitSet& limits() const { return limits_; }
    bool has_chord_error() const { return chord_ < LimitSet::unbounded; }

    struct Place {
        PathSample sample;
        machine::AxisPosition position;
        double chord_rate = 0;  ///< ṗ ≤ 1/rate by the chord error
    };
    /// `block` of the tool path gives the feed.
    Place at(path::PathPlace place, std::size_t block) const;

  private:
    const path::AxisPath* path_;
    LimitSet limits_;
    double chord_, period_s_;
};

/// Whether all derivatives are finite.
bool is_finite(const PathSample& sample);

}  // namespace trunnion::feed
