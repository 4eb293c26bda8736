#pragma once

#include <cstdint>

#include <plan_buffer.h>
#include <tpmod/order_ring.h>

#include "trunnion/machine/kinematics.hpp"
#include "trunnion/pipeline/queue_motion.hpp"

namespace trunnion::app {

/// LinuxCNC's poses (X Y Z A B C U V W: the controlled point, by the tool's length above the tip, in the workpiece as
/// it is clamped; rotary axes in degrees) to and from a motion's.
class WorldPoses {
  public:
    /// Errors: RT0101 linear axes other than X, Y, Z, or rotary ones other than A, B, C; those of Kinematics::make.
    static Result<WorldPoses> make(const machine::Machine& machine, double tool_length_mm);

    pipeline::QueuedPose pose_of(const double (&world)[9]) const;
    trunnion_row row_of(const pipeline::LiveRow& row) const;
    double tool_length_mm() const { return tool_length_mm_; }

  private:
    WorldPoses(const machine::Machine& machine, machine::Kinematics kinematics, double tool_length_mm)
        : machine_(&machine), kinematics_(kinematics), tool_length_mm_(tool_length_mm) {}

    const machine::Machine* machine_;
    machine::Kinematics kinematics_;
    double tool_length_mm_;
};

/// A line or arc that was ordered behind `begin`.
pipeline::QueuedMove move_of(const trunnion_order& order, const pipeline::QueuedPose& begin, const WorldPoses& poses);

}  // namespace trunnion::app
