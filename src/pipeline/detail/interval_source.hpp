#pragma once

#include <optional>

#include "trunnion/feed/plan_stretch.hpp"

#include "detail/stretch_source.hpp"

namespace trunnion::pipeline {

/// The stretches of a program with their intervals: all of the geometry that planning the speed needs. Knows nothing of
/// the speed, so that it may run on another thread, ahead of who takes the elements. Both arguments must outlive it.
class IntervalSource {
  public:
    IntervalSource(StretchSource& stretches, const feed::FeedOptions& options)
        : stretches_(stretches), options_(options) {}

    /// The elements of the stretches, batches of intervals behind every StretchBegin. Errors: those of StretchSource
    /// and feed::IntervalStream, with the line of the stretch.
    NextElement next();

    double grid_s() const { return grid_s_; }

  private:
    NextElement next_batch();
    NextElement failed(const Diagnostic& error) const;

    StretchSource& stretches_;
    const feed::FeedOptions& options_;
    StretchBegin stretch_;
    double share_at_begin_ = 0;
    std::optional<feed::IntervalStream> intervals_;
    double grid_s_ = 0;
};

}  // namespace trunnion::pipeline
