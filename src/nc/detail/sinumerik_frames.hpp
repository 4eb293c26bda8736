#pragma once

#include <optional>

#include <Eigen/Core>
#include <Eigen/LU>

#include "trunnion/program/program.hpp"

namespace trunnion::nc::sinumerik {

/// Where programmed coordinates come to lie in the work offset's frame: x_offset = linear · x_programmed + origin_mm.
/// Translations, rotations, scales and mirrors on top of each other.
class CoordinateFrame {
  public:
    CoordinateFrame() = default;
    CoordinateFrame(const Eigen::Matrix3d& linear, const Eigen::Vector3d& origin_mm);

    static CoordinateFrame shifted(const Eigen::Vector3d& origin_mm) {
        return {Eigen::Matrix3d::Identity(), origin_mm};
    }
    static CoordinateFrame stretched(const Eigen::Vector3d& factors) {
        return {factors.asDiagonal(), Eigen::Vector3d::Zero()};
    }
    /// Turned about X, Y or Z (0 … 2).
    static CoordinateFrame turned(int axis, double angle_rad);
    /// About Z, then about the new Y, then about the new X: the control's RPY.
    static CoordinateFrame turned_rpy(const Eigen::Vector3d& angles_rad);

    /// This frame with `inner` on top of it.
    CoordinateFrame with(const CoordinateFrame& inner) const;

    bool is_identity() const { return identity_; }
    /// Whether the programmed axes are not parallel to those of the work offset.
    bool turns() const { return !identity_ && !linear_.isApprox(Eigen::Matrix3d::Identity(), 1e-12); }

    /// Coordinates that are not known are NaN. An outer coordinate to which only unknown ones contribute is NaN: it is
    /// left as it was. Empty where known and unknown ones mix.
    std::optional<Eigen::Vector3d> outward(const Eigen::Vector3d& programmed) const;
    /// NaN wherever an unknown coordinate contributes.
    Eigen::Vector3d inward(const Eigen::Vector3d& outer) const;
    Eigen::Vector3d direction_inward(const Eigen::Vector3d& outer) const { return inverse_ * outer; }

    /// A tool vector, unit; empty where different scales would bend it.
    std::optional<Eigen::Vector3d> tool_axis(const Eigen::Vector3d& programmed) const;
    /// A circle about X, Y or Z (0 … 2); empty where different scales make it an ellipse or a skewed helix.
    std::optional<program::Arc> arc(const program::Arc& programmed, int normal_axis) const;

  private:
    Eigen::Matrix3d linear_ = Eigen::Matrix3d::Identity(), inverse_ = Eigen::Matrix3d::Identity();
    Eigen::Vector3d origin_mm_ = Eigen::Vector3d::Zero();
    bool identity_ = true;
};

}  // namespace trunnion::nc::sinumerik
