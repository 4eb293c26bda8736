#pragma once

#include <cstddef>
#include <cstdint>

#include "trunnion/interpolation/surface_path.hpp"
#include "trunnion/interpolation/surface_profile.hpp"
#include "trunnion/interpolation/surface_step.hpp"
#include "trunnion/machine/kinematics.hpp"
#include "trunnion/path/axis_path.hpp"

namespace trunnion::interpolation {

enum class SurfaceStatus : std::uint8_t {
    moving,
    finished,  ///< stands at the end
    starved    ///< the profile is not planned so far: stands where the plan ends, and not within limits
};

/// Where everything is at one moment of a pass.
struct SurfaceInstant {
    SurfaceStatus status = SurfaceStatus::moving;
    machine::AxisPosition position;
    machine::Pose pose;            ///< in the workpiece
    double w = 0;                  ///< parameter of the curve; on a bridge that of the place where it began
    double way_mm = 0;             ///< of the contact, from the start of the pass: as the profile wants it
    double contact_feed_mm_s = 0;  ///< ṡ as planned
    std::size_t profile_piece = 0, path_piece = 0;
};

/// Lin & Koren's interpolator: every period the next place on the surface itself, its normal, the tool that touches it
/// there, and the machine axes.
///
/// The profile says which way of the contact is wanted at a time; the parameter follows by a step of the given order
/// from the place of the period before (from the beginning of the path's piece where that is nearer), and what a step
/// was off is made up for by the next one, so that errors do not add up: what is left is the error of one step. Rotary
/// axes go on from where they stood a period before. On bridges pose and axes are those of the axis path, which knows
/// them beside a pole and at it.
///
/// Keeps references to all it is made from, which must outlive it. Real-time safe: at() is noexcept, allocates nothing,
/// takes no lock; at most three evaluations of the surface and one of the orientation surface, one inverse kinematics,
/// 30 Newton steps in the profile's time law, one step for each profile piece that was passed since. Cost 0.6-0.9 µs.
class SurfaceInterpolator {
  public:
    /// `axes`: of the path, as the profile was planned on it.
    SurfaceInterpolator(const SurfaceCurve& curve, const SurfacePath& path, const path::AxisPath& axes,
                        const SurfaceProfile& profile, StepOrder order) noexcept;

    /// State at `time_s` from the start of the pass. Times must not descend from call to call.
    SurfaceInstant at(double time_s) noexcept;

  private:
    void place_on_surface(SurfaceInstant& now) noexcept;
    void place_on_bridge(SurfaceInstant& now, double offset_mm) noexcept;

    const SurfaceCurve* curve_;
    const SurfacePath* path_;
    const path::AxisPath* axes_;
    const SurfaceProfile* profile_;
    StepOrder order_;
    SurfaceContact contact_;         // of the last period on the surface
    double way_mm_ = 0;              // its way
    std::size_t contact_piece_ = 0;  // and the piece of the path that it lies on
    std::size_t profile_piece_ = 0;
    machine::RotaryPosition rotary_rad_;
};

}  // namespace trunnion::interpolation
