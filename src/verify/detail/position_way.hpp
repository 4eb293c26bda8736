#pragma once

#include <optional>

#include <Eigen/Core>

#include "trunnion/program/program.hpp"

namespace trunnion::verify {

/// How the position of a move goes, straight or round, in the frame the move is written in.
class PositionWay {
  public:
    static PositionWay straight(const Eigen::Vector3d& start, const Eigen::Vector3d& end);
    /// Empty: the start is on the axis of the arc, a number of it is not finite, its direction is no unit vector, or
    /// the end is off the arc by more than `off_arc_mm`.
    static std::optional<PositionWay> round(const Eigen::Vector3d& start, const Eigen::Vector3d& end,
                                            const program::Arc& arc);
    static constexpr double off_arc_mm = 1e-3;

    /// At share w of the angle, or of the straight way.
    Eigen::Vector3d at(double w) const;
    double turn_rad() const { return angle_rad_; }

  private:
    Eigen::Vector3d foot_ = Eigen::Vector3d::Zero();   // of the start on the arc's axis; straight: the start
    Eigen::Vector3d climb_ = Eigen::Vector3d::Zero();  // what the whole way goes besides turning
    Eigen::Vector3d spoke_ = Eigen::Vector3d::Zero();  // from the foot to the start
    Eigen::Vector3d normal_ = Eigen::Vector3d::UnitZ();
    double angle_rad_ = 0;
    double growth_ = 0;  // radius at the end / radius at the start, less 1
};

}  // namespace trunnion::verify
