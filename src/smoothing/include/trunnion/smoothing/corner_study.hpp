#pragma once

#include <array>
#include <functional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "trunnion/base/result.hpp"
#include "trunnion/geometry/bspline_curve.hpp"
#include "trunnion/machine/kinematics.hpp"
#include "trunnion/machine/machine.hpp"
#include "trunnion/numeric/taylor3.hpp"
#include "trunnion/smoothing/connection.hpp"
#include "trunnion/smoothing/corner.hpp"

/// What is known and asked of rounded corners in Beudaert 2013, to be looked at and compared: nothing here takes part
/// in planning. Derivatives are by s, the path length of the tip in mm. docs/theory/corner-rounding.md shows the
/// results.
namespace trunnion::smoothing {

/// Eq. 11, exact: ‖d³n/ds³‖ of the tool axis, rad/mm³.
double orientation_criterion(const machine::VectorSeries& tool_axis) noexcept;

/// Eq. 11 by backward Euler from four tool axes a step apart, in order. Where a lower derivative jumps within the four
/// the value grows like 1/step² or 1/step: it says nothing without its step.
double orientation_criterion(const std::array<Eigen::Vector3d, 4>& tool_axes, double step_mm) noexcept;

/// All machine axes, mm and rad, in the order of AxisVector.
using AxisSeries = std::array<Taylor3, machine::max_axes>;

/// A machine with its setup, where its rotary axes are taken to stand, and the programmed feed.
struct StudiedMachine {
    const machine::Kinematics& kinematics;
    const machine::Machine& machine;
    machine::RotaryPosition near{};
    double programmed_mm_s = 0;
};

/// The axes' image of a pose, on the branch and winding nearest to `near`.
AxisSeries machine_axes(const StudiedMachine& on, const LinkedPose& pose) noexcept;

/// Eq. 10: min(F, V/|q′|, √(A/|q″|), ∛(J/|q‴|)) over the axes, mm/s. A figure to compare with, not a limit: with path
/// acceleration the axes can break their limits below it and keep them above it.
double feed_limit_mm_s(const machine::Machine& machine, const AxisSeries& axes, double programmed_mm_s) noexcept;

/// The least of Eq. 10 along a curve of the tip alone on three axes X, Y, Z (their feed limits in this order), without
/// a programmed feed. `samples` places in each half.
double least_feed_limit_mm_s(const geometry::BsplineCurve& corner, const std::array<machine::AxisLimits, 3>& limits,
                             int samples = 500) noexcept;

/// The pose on the ruled segment that leads to the entry (end 0) or away from the exit (end 1), in the direction of
/// motion, so far outside of the corner curve.
LinkedPose segment_pose(const DualCorner& corner, int end, double outside_mm) noexcept;

/// u_top = f(u_bottom) with its derivatives.
using Link = std::function<Taylor3(double)>;

struct CornerSample {
    double length_mm = 0;  ///< along the tip's path; 0 at the entry, negative before it
    double share = 0;      ///< u_bottom; 0 or 1 on the segments
    LinkedPose pose;
    double criterion_rad_mm3 = 0;  ///< Eq. 11, exact
    double feed_limit_mm_s = 0;    ///< Eq. 10
    double height_feed_mm_s = 0;   ///< of the point at the height, where the tip goes at feed_limit_mm_s
    AxisSeries axes;
};

/// Along a corner, in order: `per_part` steps on `margin_mm` of the segment before, on each half and on the segment
/// after. At each join two samples stand at one place, seen from both sides. The rotary axes are followed from
/// `on.near`. Preconditions: margin > 0, per_part ≥ 1.
std::vector<CornerSample> sample_corner(const DualCorner& corner, const Link& link, const StudiedMachine& on,
                                        double margin_mm, double height_mm, int per_part);

/// What a control sees of a corner that takes setpoints a fixed way apart.
struct CornerStep {
    double length_mm = 0;          ///< along the tip's path; 0 at the entry
    double criterion_rad_mm3 = 0;  ///< Eq. 11 by backward Euler
    double feed_limit_mm_s = 0;    ///< Eq. 10 by backward Euler
};

/// From `margin_mm` before the entry to as much behind the exit in steps of `step_mm`: unlike sample_corner(), this
/// shows what jumps at the joins. Preconditions: both above 0.
std::vector<CornerStep> walk_corner(const DualCorner& corner, const Link& link, const StudiedMachine& on,
                                    double margin_mm, double step_mm);

/// The parametrization spline as it was published: at three places a step apart after the entry, and mirrored before
/// the exit, the top parameter that makes the criterion by backward Euler least, found by Newton-Raphson one after the
/// other, each with those before it held; the six points and both ends interpolated by a cubic B-spline.
struct DiscreteLink {
    std::array<double, 8> bottom{}, top{};  ///< ascending; 0 and 1 at the ends
    geometry::BsplineCurve spline;          ///< (u_bottom, u_top, 0) over u_bottom

    /// Not checked to increase.
    Taylor3 at(double u_bottom) const noexcept;
};

/// Errors: SMTH0121 the step is not above 0, or six of them are longer than the corner; SMTH0122 the iteration found no
/// parameter in ]0, 1[ within 50 steps. Allocates.
Result<DiscreteLink> discrete_link(const DualCorner& corner, double step_mm);

struct SensitivitySample {
    double top = 0;  ///< u_top of the first place after the entry
    double criterion_rad_mm3 = 0, feed_limit_mm_s = 0;
};

/// What the choice of the first top parameter does to the criterion and to Eq. 10, both by backward Euler with the
/// entry and two places before it on the segment. Precondition: the step is above 0 and shorter than half the corner.
std::vector<SensitivitySample> first_point_sensitivity(const DualCorner& corner, double step_mm,
                                                       std::span<const double> tops, const StudiedMachine& on);

}  // namespace trunnion::smoothing
