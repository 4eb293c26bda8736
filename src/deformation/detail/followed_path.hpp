#pragma once

#include <memory>
#include <utility>

#include "trunnion/base/result.hpp"
#include "trunnion/deformation/dual_path.hpp"
#include "trunnion/deformation/rotary_use.hpp"
#include "trunnion/path/axis_path.hpp"

namespace trunnion::deformation::detail {

/// DEFO0201: whatever deforms control points wants cubics without weights.
Result<void> check_cubic(const DualPath& path);

/// DEFO0202: a feed, a tool or a start that make no sense.
Result<void> check_machining(const Machining& machining);

/// |dt/du| at the feed: controlled point and turn of the tool as RotaryUse says.
double seconds_per_u(const DualPath& path, double u, const Machining& machining) noexcept;

/// A dual path as a tool path whose parameter is u − begin, and its image through the machine. Where it goes through a
/// pole a piece ends, as AxisPath wants it.
class FollowedPath {
  public:
    /// From the beginning of the path to `end_u`, on the branch and winding nearest to `near` at the beginning.
    static Result<FollowedPath> make(const DualPath& path, const Machining& machining,
                                     const machine::RotaryPosition& near, double end_u);

    const path::AxisPath& axes() const { return *axes_; }
    double u_of(path::PathPlace place) const {
        return begin_u_ + geometry_->pieces[place.piece].begin_mm + place.offset_mm;
    }

  private:
    FollowedPath() = default;
    double begin_u_ = 0;
    std::unique_ptr<path::ToolPath> geometry_;  // the axes refer to it
    std::unique_ptr<path::AxisPath> axes_;
};

/// All positions in which the rotary axes may stand at the beginning of a path: both branches, and of an axis with a
/// range the windings beside 0 that lie in it. Nearest to 0 first. The one given by the machining, if it gives one.
std::vector<machine::RotaryPosition> beginnings(const DualPath& path, const Machining& machining);

/// What rotary_use() adds up, of one followed path.
RotaryUse use_of(const FollowedPath& followed, const DualPath& path, const Machining& machining);

}  // namespace trunnion::deformation::detail
