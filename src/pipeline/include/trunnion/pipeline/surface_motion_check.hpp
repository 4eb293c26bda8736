#pragma once

#include <optional>
#include <span>

#include "trunnion/base/result.hpp"
#include "trunnion/machine/kinematics.hpp"
#include "trunnion/pipeline/plan.hpp"
#include "trunnion/pipeline/surface.hpp"

namespace trunnion::pipeline {

/// Keeps where a motion takes the tool, to ask behind it whether that is in the part. Goes between a motion and its
/// observer: what it is given it hands on.
class MotionInPart : public PlanObserver {
  public:
    /// `cutter`, `holder`: the body that is asked for; `kinematics` with the tool's length and the workpiece's frame.
    /// All must outlive it.
    MotionInPart(const machine::Kinematics& kinematics, const surfacing::Cutter& cutter,
                 const surfacing::Holder& holder, PlanObserver& next);

    void setpoint_limit(const SetpointLimit& limit) override { next_.setpoint_limit(limit); }
    void setpoint(const motion::Setpoint& row) override;
    void path_sample(const PathSample& sample) override { next_.path_sample(sample); }
    void event(const EventRow& row) override { next_.event(row); }
    bool progress(double share) override { return next_.progress(share); }

    /// Asks of the setpoints, links and rapids too, by forward kinematics: how deep tool and holder are in the part, at
    /// setpoints between which no point of the tool goes farther than 1 mm (check_part()); setpoints that are farther
    /// apart with straight moves between. `part`: its faces. Errors: those of PartBody::make. Cost: 10 µs a mm.
    Result<SurfacePartCheck> check(std::span<const surfacing::Face> part, double gouge_tolerance_mm);

  private:
    double way_mm(const machine::Pose& from, const machine::Pose& to) const;
    void keep(const machine::Pose& pose);

    const machine::Kinematics& kinematics_;
    const surfacing::Cutter& cutter_;
    const surfacing::Holder& holder_;
    PlanObserver& next_;
    double arm_mm_;
    std::optional<machine::Pose> kept_, last_;
    SurfaceResult motion_;
};

}  // namespace trunnion::pipeline
