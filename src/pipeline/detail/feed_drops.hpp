#pragma once

#include <map>
#include <string>
#include <vector>

#include "trunnion/feed/plan_stretch.hpp"
#include "trunnion/pipeline/summary.hpp"

#include "detail/stretch_table.hpp"

namespace trunnion::pipeline {

/// Collects where the feed falls under nine tenths of what is programmed, and how long each axis limits.
class FeedDropCollector {
  public:
    /// Of the drops the `most` that lose most are kept.
    FeedDropCollector(double tip_tolerance_mm, std::size_t most);

    void add(const path::AxisPath& path, const feed::StretchPlan& plan, const StretchTable& table);
    /// In order of the path.
    std::vector<FeedDrop> take();
    /// Cutting time in which the axis was what limits, s.
    double limiting_s(int axis) const { return limiting_s_[axis]; }

  private:
    void close();
    void drop_the_least();

    double reach_mm_;  // of the widest block transition
    std::size_t most_;
    std::vector<FeedDrop> drops_;  // never more than some times `most`
    FeedDrop open_;
    std::map<std::string, double> open_causes_;
    bool is_open_ = false;
    std::array<double, machine::max_axes> limiting_s_{};
};

}  // namespace trunnion::pipeline
