#include "trunnion/surfacing/cutter.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <fmt/format.h>

namespace trunnion::surfacing {

Result<Cutter> Cutter::make(const machine::Tool& tool, double reach_mm) {
    using machine::ToolKind;
    const double radius = tool.diameter_mm / 2;
    const double corner = tool.kind == ToolKind::ball    ? radius
                          : tool.kind == ToolKind::torus ? tool.corner_radius_mm
                                                         : 0;
    const bool torus_fits = tool.kind != ToolKind::torus || (corner > 0 && corner <= radius);
    if (tool.kind == ToolKind::taper || !(radius > 0) || !torus_fits || !std::isfinite(radius) || !(reach_mm >= 0))
        return fail(
            {.code = "SURF0201",
             .text = "surfaces are machined with flat, ball and torus tools that have a diameter",
             .value = fmt::format("diameter {} mm, corner radius {} mm", tool.diameter_mm, tool.corner_radius_mm),
             .hint = "give kind, diameter and corner_radius in the setup"});
    Cutter out;
    out.radius_ = radius;
    out.corner_ = corner;
    out.reach_ = std::max(reach_mm > 0 ? reach_mm : tool.diameter_mm, 2 * corner);
    return out;
}

MeridianDistance Cutter::in_meridian(double out, double up) const noexcept {
    const double sideways = out - flat_radius_mm();
    const double below = corner_ - up, above = up - (reach_ - corner_);
    const double along = std::max(below, above), along_sign = below > above ? -1.0 : 1.0;
    if (sideways > 0 && along > 0) {
        const double outside = std::sqrt(sideways * sideways + along * along);
        return {outside - corner_, sideways / outside, along_sign * along / outside};
    }
    if (sideways > along) return {sideways - corner_, 1, 0};
    return {along - corner_, 0, along_sign};
}

double Cutter::distance_mm(const CutterPose& pose, const Eigen::Vector3d& point) const noexcept {
    const Eigen::Vector3d from_tip = point - pose.tip_mm;
    const double up = from_tip.dot(pose.axis);
    return in_meridian(std::sqrt(std::max(0.0, from_tip.squaredNorm() - up * up)), up).value;
}

double Cutter::height_mm(const CutterPose& pose, const Eigen::Vector3d& point, const Eigen::Vector3d& direction,
                         double limit) const noexcept {
    double t = 0, distance = 0;
    // Towards the body by its distance never passes its surface; from inside backwards the same way.
    for (int step = 0; step < 200 && std::abs(t) < limit; ++step) {
        distance = distance_mm(pose, point + t * direction);
        t += distance;
        if (std::abs(distance) < 1e-10) return t;
    }
    // Along a wall it gets nowhere: from outside it never enters.
    return distance > 0 ? limit : std::max(t, -limit);
}

bool Cutter::upright(const Eigen::Vector3d& normal, const Eigen::Vector3d& axis) noexcept {
    return normal.cross(axis).norm() < 1e-6;
}

CutterPose Cutter::touching(const Eigen::Vector3d& contact, const Eigen::Vector3d& normal,
                            const Eigen::Vector3d& axis) const noexcept {
    const Eigen::Vector3d across = normal - normal.dot(axis) * axis;
    const Eigen::Vector3d inward =
        upright(normal, axis) ? Eigen::Vector3d(Eigen::Vector3d::Zero()) : across.normalized();
    return {contact + corner_ * (normal - axis) + flat_radius_mm() * inward, axis};
}

Eigen::Matrix2d Cutter::curvature(const geometry::SurfaceShape& at, const Eigen::Vector3d& axis) const noexcept {
    if (is_ball()) return Eigen::Matrix2d::Identity() / corner_;
    if (upright(at.normal, axis)) return Eigen::Matrix2d::Zero();
    const double sine = at.normal.cross(axis).norm();
    const Eigen::Vector2d meridian = at.components(axis).normalized();
    const Eigen::Vector2d round(-meridian.y(), meridian.x());
    constexpr double edge_mm = 1e-6;  // a sharp edge: as good as no radius at all
    return meridian * meridian.transpose() / std::max(corner_, edge_mm) +
           round * round.transpose() * (sine / (flat_radius_mm() + corner_ * sine));
}

}  // namespace trunnion::surfacing
