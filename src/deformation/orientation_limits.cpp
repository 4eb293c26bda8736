#include "detail/orientation_limits.hpp"

#include <cmath>

#include <Eigen/Geometry>

#include "trunnion/geometry/great_circle.hpp"

namespace trunnion::deformation {

using Eigen::Vector3d;

LeadAndTilt lead_and_tilt(const Vector3d& tool_axis, const Vector3d& normal, const Vector3d& feed) {
    const double up = tool_axis.dot(normal);
    return {std::atan2(tool_axis.dot(feed), up), std::atan2(tool_axis.dot(normal.cross(feed)), up)};
}

namespace detail {

namespace {

constexpr double clearance_unit_mm = 0.05;
constexpr double standing_mm = 1e-9;  // a controlled point that moves less per u has no direction
constexpr double kept = -1;           // of a limit that is not asked

}  // namespace

OrientationLimits::At OrientationLimits::at(double u) const {
    At out{.u = u};
    const auto axis = path_.spline.axis(u);
    out.axis = Vector3d(axis[0].value(), axis[1].value(), axis[2].value());
    out.controlled_mm = path_.point_mm(u, height_mm_);
    if (!freedom_.surface_normal) return out;
    out.normal = freedom_.surface_normal(u);
    const Vector3d way =
        path_.spline.bottom().evaluate(u)[1] + height_mm_ * Vector3d(axis[0].d1(), axis[1].d1(), axis[2].d1());
    const Vector3d across = way - way.dot(out.normal) * out.normal;
    out.leans = across.norm() > standing_mm;
    if (out.leans) out.feed = across.normalized();
    return out;
}

std::array<double, OrientationLimits::count> OrientationLimits::excess(const At& at, const Vector3d& axis) const {
    const double unit = freedom_.orientation_tolerance_rad;
    std::array<double, count> out{geometry::angle_between(axis, at.axis) / unit - 1, kept, kept, kept, kept, kept};
    if (at.leans) {
        const LeadAndTilt is = lead_and_tilt(axis, at.normal, at.feed);
        out[1] = (freedom_.lead.least_rad - is.lead_rad) / unit;
        out[2] = (is.lead_rad - freedom_.lead.most_rad) / unit;
        out[3] = (freedom_.tilt.least_rad - is.tilt_rad) / unit;
        out[4] = (is.tilt_rad - freedom_.tilt.most_rad) / unit;
    }
    if (freedom_.clearance_mm) out[5] = (freedom_.least_clearance_mm - clearance_mm(at, axis)) / clearance_unit_mm;
    return out;
}

double OrientationLimits::clearance_mm(const At& at, const Vector3d& axis) const {
    return freedom_.clearance_mm(at.u, {at.controlled_mm - height_mm_ * axis, axis});
}

}  // namespace detail

}  // namespace trunnion::deformation
