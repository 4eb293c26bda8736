#pragma once

#include <cstddef>
#include <cstdint>

#include "trunnion/interpolation/surface_path.hpp"
#include "trunnion/interpolation/surface_profile.hpp"
#include "trunnion/interpolation/surface_step.hpp"
#include "trunnion/machine/kinematics.hpp"

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
/// axes go on from where they stood a period before.
///
/// Keeps references to all it is made from, which must outlive it. Real-time safe: at() is noexcept, allocates nothing,
/// takes no lock; at most three evaluations of the surface, one inverse kinematics, 30 Newton steps in the profile's
/// time law, one step for every profile piece that was passed since the call before. Cost 1-2 µs for a bicubic.
class SurfaceInterpolator {
  public:
    /// `begin_rad`: rotary axes at the start of the pass (path::AxisPath::begin_position).
    SurfaceInterpolator(const SurfaceCurve& curve, const SurfacePath& path, const SurfaceProfile& profile,
                        const machine::RotaryPosition& begin_rad, StepOrder order) noexcept;

    /// State at `time_s` from the start of the pass. Times must not descend from call to call.
    SurfaceInstant at(double time_s) noexcept;

  private:
    machine::Pose pose_on_surface(std::size_t path_piece, double way_mm) noexcept;
    machine::Pose pose_on_bridge(std::size_t path_piece, double offset_mm) const noexcept;
    void place_axes(SurfaceInstant& now) noexcept;

    const SurfaceCurve* curve_;
    const SurfacePath* path_;
    const SurfaceProfile* profile_;
    StepOrder order_;
    SurfaceContact contact_;         // of the last period on the surface
    double way_mm_ = 0;              // its way
    std::size_t contact_piece_ = 0;  // and the piece of the path that it lies on
    std::size_t profile_piece_ = 0;
    machine::RotaryPosition rotary_rad_;
};

}  // namespace trunnion::interpolation
