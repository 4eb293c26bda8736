#pragma once

#include <optional>

#include <Eigen/Core>

#include "trunnion/program/program.hpp"

#include "detail/curve_course.hpp"

namespace trunnion::verify {

/// How the position of a move goes, straight, round or along a curve, in the frame the move is written in.
class PositionWay {
  public:
    static PositionWay straight(const Eigen::Vector3d& start, const Eigen::Vector3d& end);
    /// Empty: the start is on the axis of the arc, a number of it is not finite, its direction is no unit vector, or
    /// the end is off the arc by more than `off_arc_mm`.
    static std::optional<PositionWay> round(const Eigen::Vector3d& start, const Eigen::Vector3d& end,
                                            const program::Arc& arc);
    static constexpr double off_arc_mm = 1e-3;
    /// Empty: an end of the curve is off the given one by more than `off_curve_mm`.
    static std::optional<PositionWay> along(const Eigen::Vector3d& start, const Eigen::Vector3d& end,
                                            const CurveCourse& curve);
    static constexpr double off_curve_mm = 1e-3;

    /// At share w of the angle, of the straight way, or of the curve's parameter.
    Eigen::Vector3d at(double w) const;
    double turn_rad() const { return angle_rad_; }
    const std::optional<CurveCourse>& curve() const { return curve_; }

  private:
    Eigen::Vector3d foot_ = Eigen::Vector3d::Zero();   // of the start on the arc's axis; straight: the start
    Eigen::Vector3d climb_ = Eigen::Vector3d::Zero();  // what the whole way goes besides turning
    Eigen::Vector3d spoke_ = Eigen::Vector3d::Zero();  // from the foot to the start
    Eigen::Vector3d normal_ = Eigen::Vector3d::UnitZ();
    double angle_rad_ = 0;
    std::optional<CurveCourse> curve_;  // foot and climb are what it is off its ends
    double growth_ = 0;                 // radius at the end / radius at the start, less 1
};

}  // namespace trunnion::verify
