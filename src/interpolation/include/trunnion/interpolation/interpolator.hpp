#pragma once

#include <cstddef>

#include <Eigen/Core>

#include "trunnion/motion/feed_profile.hpp"
#include "trunnion/path/axis_path.hpp"

namespace trunnion::interpolation {

/// Where everything is at one moment of a stretch.
struct Instant {
    machine::AxisPosition position;
    motion::PathState path_state;
    path::PathPlace place;
    Eigen::Vector3d tip_in_workpiece_mm = Eigen::Vector3d::Zero();
    double tip_speed_mm_s = 0;
    std::size_t block = 0;  ///< index in ToolPath::blocks
};

/// Turns the feed profile of one stretch into axis positions, one call per control period.
///
/// Keeps references to path and profile, which must outlive it. Real-time safe: at() is noexcept, allocates nothing,
/// takes no lock; one inverse kinematics and at most 30 Newton steps, plus one step for every profile piece and block
/// that was passed since the call before.
class Interpolator {
  public:
    Interpolator(const path::AxisPath& path, const motion::FeedProfile& profile) noexcept;

    double duration_s() const noexcept { return profile_->duration_s(); }

    /// State at `time_s` from the stretch's start. Times must not descend from call to call; before the start and
    /// behind the end the machine stands.
    Instant at(double time_s) noexcept;

  private:
    const path::AxisPath* path_;
    const motion::FeedProfile* profile_;
    std::size_t piece_ = 0, block_ = 0;
};

}  // namespace trunnion::interpolation
