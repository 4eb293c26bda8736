#pragma once

#include <Eigen/Core>

#include "trunnion/base/result.hpp"
#include "trunnion/geometry/surface_shape.hpp"
#include "trunnion/machine/machine.hpp"

namespace trunnion::surfacing {

/// Where a tool stands: tip and unit axis, tip → spindle.
struct CutterPose {
    Eigen::Vector3d tip_mm, axis;
};

/// Distance of a point from a tool's body, mm, and how it changes with the point's place in the meridian plane.
struct MeridianDistance {
    double value, by_out, by_up;
};

/// The body that cuts: a cylinder of radius R whose end has a rounded edge of radius r. r = 0: flat, r = R: ball.
class Cutter {
  public:
    /// Of a tool of kind flat, ball or torus; `reach_mm`: how far up from the tip it counts as the body; 0: its
    /// diameter. Errors: SURF0201 another kind, a diameter not above 0, or a corner radius that is not above 0 and at
    /// most half the diameter (torus).
    static Result<Cutter> make(const machine::Tool& tool, double reach_mm = 0);

    double radius_mm() const noexcept { return radius_; }
    double corner_mm() const noexcept { return corner_; }
    double flat_radius_mm() const noexcept { return radius_ - corner_; }  ///< of the flat part of its end
    double reach_mm() const noexcept { return reach_; }
    bool is_ball() const noexcept { return corner_ == radius_; }

    /// Distance of a point from the body, negative inside: exact outside and down to the medial axis inside. In the
    /// meridian plane the body is the rectangle [0, R − r] × [r, reach] grown by r. Cost about 10 ns.
    double distance_mm(const CutterPose& pose, const Eigen::Vector3d& point_mm) const noexcept;

    /// The same of a point `up` the axis from the tip and `out` from it, with its derivatives; where two of them meet
    /// (on the axis of a flat end, on the medial axis) those of one side.
    MeridianDistance in_meridian(double out_mm, double up_mm) const noexcept;

    /// How far the body is above a point along a unit direction: the least t in [−limit, limit] at which point + t ·
    /// direction enters the body; `limit_mm` where it does not. Negative: the point is inside. To 1e-9 mm where
    /// direction and the body's surface meet at more than some degrees.
    double height_mm(const CutterPose& pose, const Eigen::Vector3d& point_mm, const Eigen::Vector3d& direction,
                     double limit_mm) const noexcept;

    /// The pose in which a tool of the given axis touches a surface from outside at `contact_mm` with unit normal
    /// `normal`: contact + r n + (R − r) v − r axis, v the unit part of n across the axis; upright (axis = n) the tip
    /// is at the contact. Precondition: axis · normal > 0. Source: Affouard 2004, Eq. 1, with tip = C_L − r·u.
    CutterPose touching(const Eigen::Vector3d& contact_mm, const Eigen::Vector3d& normal,
                        const Eigen::Vector3d& axis) const noexcept;

    /// Curvature of the body at that contact, 1/mm, in the tangent frame of `at`: 1/r along the meridian and
    /// sin φ/(R − r + r sin φ) round the axis, φ the angle between axis and normal. 0 where a flat end lies on the
    /// surface.
    Eigen::Matrix2d curvature(const geometry::SurfaceShape& at, const Eigen::Vector3d& axis) const noexcept;

    /// Whether an axis counts as upright on a surface: within 1e-6 rad of the normal.
    static bool upright(const Eigen::Vector3d& normal, const Eigen::Vector3d& axis) noexcept;

  private:
    Cutter() = default;
    double radius_ = 0, corner_ = 0, reach_ = 0;
};

}  // namespace trunnion::surfacing
