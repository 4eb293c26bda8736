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
    explicit FeedDropCollector(double tip_tolerance_mm);

    void add(const path::AxisPath& path, const feed::StretchPlan& plan, const StretchTable& table);
    /// Drops in order of the path; the ones that lose least are left out beyond `most`.
    std::vector<FeedDrop> take(std::size_t most);
    /// Cutting time in which the axis was what limits, s.
    double limiting_s(int axis) const { return limiting_s_[axis]; }

  private:
    void close();

    double reach_mm_;  // of the widest block transition
    std::vector<FeedDrop> drops_;
    FeedDrop open_;
    std::map<std::string, double> open_causes_;
    bool is_open_ = false;
    std::array<double, machine::max_axes> limiting_s_{};
};

}  // namespace trunnion::pipeline
