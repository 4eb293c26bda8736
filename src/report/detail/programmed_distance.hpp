#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "trunnion/verify/programmed_path.hpp"

namespace trunnion::report::detail {

/// Distance of the controlled point from the programmed path, at corresponding places: a place is looked for from the
/// one before, forwards and a little backwards, and at the begin of a block where the line changes. Measured on the
/// rows alone, so that it may be asked of any control's motion.
class ProgrammedDistance {
  public:
    explicit ProgrammedDistance(std::vector<verify::ProgrammedPose> poses);

    /// mm; NaN where there is no program to compare with. `controlled_height_mm`: of the controlled point above the
    /// tip.
    double at(const Eigen::Vector3d& tip_mm, const Eigen::Vector3d& axis, std::int32_t line,
              double controlled_height_mm);

  private:
    double to_segment(std::size_t segment, const Eigen::Vector3d& point, double height_mm) const;
    void go_to_line(std::int32_t line);

    std::vector<verify::ProgrammedPose> poses_;
    std::size_t segment_ = 1;  // from pose segment_ − 1 to pose segment_
};

}  // namespace trunnion::report::detail
