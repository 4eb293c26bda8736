#include "detail/position_way.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace trunnion::verify {

namespace {

constexpr double unit_slack = 1e-9;
constexpr double least_radius_mm = 1e-9;

}  // namespace

PositionWay PositionWay::straight(const Eigen::Vector3d& start, const Eigen::Vector3d& end) {
    PositionWay out;
    out.foot_ = start;
    out.climb_ = end - start;
    return out;
}

std::optional<PositionWay> PositionWay::round(const Eigen::Vector3d& start, const Eigen::Vector3d& end,
                                              const program::Arc& arc) {
    const bool finite = arc.centre_mm.allFinite() && arc.normal.allFinite() && std::isfinite(arc.angle_rad);
    if (!finite || std::abs(arc.normal.norm() - 1) > unit_slack) return {};
    PositionWay out;
    out.normal_ = arc.normal;
    out.angle_rad_ = arc.angle_rad;
    out.foot_ = arc.centre_mm + arc.normal.dot(start - arc.centre_mm) * arc.normal;
    out.spoke_ = start - out.foot_;
    const double radius = out.spoke_.norm();
    if (!(radius > least_radius_mm)) return {};
    const Eigen::Vector3d height = arc.normal.dot(end - out.foot_) * arc.normal;
    out.growth_ = (end - out.foot_ - height).norm() / radius - 1;
    // what rounding of the angle leaves over is spread along the way
    const Eigen::Vector3d left_over = end - height - out.at(1);
    if (!(left_over.norm() <= off_arc_mm)) return {};
    out.climb_ = height + left_over;
    return out;
}

std::optional<PositionWay> PositionWay::along(const Eigen::Vector3d& start, const Eigen::Vector3d& end,
                                              const CurveCourse& curve) {
    const Eigen::Vector3d at_start = start - curve.position(0), at_end = end - curve.position(1);
    if (!(std::max(at_start.norm(), at_end.norm()) <= off_curve_mm)) return {};
    PositionWay out = straight(at_start, at_end);
    out.curve_ = curve;
    return out;
}

Eigen::Vector3d PositionWay::at(double w) const {
    if (curve_) return curve_->position(w) + foot_ + w * climb_;
    const Eigen::Vector3d turned = Eigen::AngleAxisd(w * angle_rad_, normal_) * spoke_;
    return foot_ + w * climb_ + (1 + w * growth_) * turned;
}

}  // namespace trunnion::verify
