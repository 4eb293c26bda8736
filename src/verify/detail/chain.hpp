#pragma once

#include <array>
#include <optional>

#include <Eigen/Core>

#include "trunnion/machine/machine.hpp"

namespace trunnion::verify {

/// The gauge point and the tool axis in the workpiece.
struct Gauge {
    Eigen::Vector3d point_mm;
    Eigen::Vector3d axis;
    Eigen::Vector3d tip_mm(double tool_length_mm) const { return point_mm - tool_length_mm * axis; }
};

/// The checker's own forward kinematics: the tool is carried from joint to joint through the chain, from the tool to
/// the workpiece, x ← R(θ)(x − c) + c or x ← x + v d.
class Chain {
  public:
    Chain(const machine::Machine& machine, const machine::Frame& workpiece);

    Gauge gauge(const machine::AxisPosition& position) const;

    /// Tool axis in the workpiece, and how it changes when the axes move at `rate` (linear ones do not count).
    struct Turning {
        Eigen::Vector3d axis, rate;
    };
    Turning turning(const machine::AxisPosition& position, const machine::AxisPosition& rate) const;

    /// `rotary` with its linear axes such that the gauge point is at `point_mm`; empty where they do not span space.
    std::optional<machine::AxisPosition> with_gauge_at(const Eigen::Vector3d& point_mm,
                                                       const machine::AxisPosition& rotary) const;

  private:
    struct Joint {
        int axis = 0;
        bool rotary = false;
        double sign = 1;
        Eigen::Vector3d direction, point_mm;
    };
    std::array<Joint, machine::max_axes> joints_{};  // workpiece → tool
    int count_ = 0;
    int linear_count_ = 0;
    machine::Frame workpiece_;
};

}  // namespace trunnion::verify
