#pragma once

#include <map>
#include <span>
#include <vector>

#include "trunnion/surfacing/plan_surface.hpp"

namespace trunnion::surfacing::detail {

/// How far material is left round a place where a pass is cut away. Passes, faces and tool must outlive it.
class LeftReach {
  public:
    LeftReach(std::span<const Pass> planned, std::span<const Face> faces, const Cutter& cutter, double scallop_mm);

    /// Of two contacts that follow each other on a pass of `index`: to the farther one of the passes beside, the tool's
    /// diameter at the most. With no pass beside as wide as the tool cuts by its interval, and a tenth of its radius at
    /// the least; along a border so, or to the nearest pass. Cost: that of the contacts of the passes beside, along a
    /// border of all.
    double between_mm(const Contact& from, const Contact& to, int index) const;

  private:
    double to_passes_beside_mm(const Eigen::Vector3d& point, int index) const;
    double to_any_pass_mm(const Eigen::Vector3d& point) const;
    double width_of_cut_mm(const Contact& from, const Contact& to) const;

    std::span<const Face> faces_;
    const Cutter& cutter_;
    double scallop_mm_;
    std::map<int, std::vector<const Pass*>> by_index_;
};

}  // namespace trunnion::surfacing::detail
