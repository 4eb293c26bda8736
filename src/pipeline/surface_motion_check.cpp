#include "trunnion/pipeline/surface_motion_check.hpp"

#include <algorithm>

#include "trunnion/geometry/great_circle.hpp"

#include "detail/part_looks.hpp"

namespace trunnion::pipeline {

MotionInPart::MotionInPart(const machine::Kinematics& kinematics, const surfacing::Cutter& cutter,
                           const surfacing::Holder& holder, PlanObserver& next)
    : kinematics_(kinematics),
      cutter_(cutter),
      holder_(holder),
      next_(next),
      arm_mm_(std::max(cutter.reach_mm(), holder.to_mm) + std::max(cutter.radius_mm(), holder.radius_mm)) {}

void MotionInPart::setpoint(const motion::Setpoint& row) {
    const machine::Pose pose = kinematics_.forward(row.position);
    // What is kept closer than check_part() steps is not divided there.
    if (last_ && way_mm(*kept_, pose) > std::min(1.0, check_step_mm(cutter_.radius_mm()))) keep(*last_);
    if (!kept_) keep(pose);
    last_ = pose;
    next_.setpoint(row);
}

double MotionInPart::way_mm(const machine::Pose& from, const machine::Pose& to) const {
    return (to.tip_in_workpiece_mm - from.tip_in_workpiece_mm).norm() +
           arm_mm_ * geometry::angle_between(from.axis_in_workpiece, to.axis_in_workpiece);
}

void MotionInPart::keep(const machine::Pose& pose) {
    motion_.plan.program.moves.push_back({.position_mm = pose.tip_in_workpiece_mm, .axis = pose.axis_in_workpiece});
    kept_ = pose;
}

Result<SurfacePartCheck> MotionInPart::check(std::span<const surfacing::Face> part, double gouge_tolerance_mm) {
    if (last_) keep(*last_);
    return check_part(part, cutter_, motion_, gouge_tolerance_mm, holder_);
}

}  // namespace trunnion::pipeline
