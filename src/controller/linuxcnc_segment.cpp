#include "detail/linuxcnc_segment.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace trunnion::controller::linuxcnc {

Circle::Circle(const Vector3d& start_mm, const Vector3d& centre_mm, const Vector3d& normal, double end_radius_mm,
               double angle_rad, const Vector3d& rise_mm)
    : centre_(centre_mm), normal_(normal), rise_(rise_mm), angle_(angle_rad) {
    const Vector3d spoke = start_mm - centre_mm;
    radius_ = spoke.norm();
    spiral_ = end_radius_mm - radius_;
    out_ = spoke / radius_;
    ahead_ = normal_.cross(out_);
    fit();
}

/// The length of a spiral in its plane, by its speeds at both ends.
void Circle::fit() {
    const double per_angle = std::abs(spiral_) / angle_;
    const double smaller = std::min(radius_, radius_ + spiral_);
    const double first = std::hypot(smaller, per_angle);
    const double last = std::hypot(smaller + per_angle * angle_, per_angle);
    quadratic_ = (last - first) / (2 * angle_);
    linear_ = first;
}

Vector3d Circle::outward(double angle_rad) const {
    return std::cos(angle_rad) * out_ + std::sin(angle_rad) * ahead_;
}

Vector3d Circle::ahead(double angle_rad) const {
    return std::cos(angle_rad) * ahead_ - std::sin(angle_rad) * out_;
}

Vector3d Circle::at_angle(double angle_rad) const {
    const double share = angle_rad / angle_;
    return centre_ + (radius_ + share * spiral_) * outward(angle_rad) + share * rise_;
}

Vector3d Circle::tangent(double angle_rad) const {
    const double radius = radius_ + spiral_ * angle_rad / angle_;
    return (radius * ahead(angle_rad) + spiral_ / angle_ * outward(angle_rad) + rise_ / angle_).normalized();
}

double Circle::length() const {
    return std::hypot(quadratic_ * angle_ * angle_ + linear_ * angle_, rise_.norm());
}

double Circle::angle_at(double share) const {
    const double in_plane = quadratic_ * angle_ * angle_ + linear_ * angle_;
    const double way = (spiral_ < 0 ? 1 - share : share) * in_plane;
    const double angle = 2 * way / (linear_ + std::sqrt(linear_ * linear_ + 4 * quadratic_ * way));
    return spiral_ < 0 ? angle_ - angle : angle;
}

double Circle::curvature_radius() const {
    const double per_angle = std::abs(spiral_) / angle_;
    const double squares = per_angle * per_angle + radius_ * radius_;
    const double in_plane = std::pow(squares, 1.5) / (squares + per_angle * per_angle);
    return rise_.squaredNorm() / in_plane + in_plane;
}

Circle Circle::without_start(double angle_rad) const {
    Circle rest = *this;
    const double share = angle_rad / angle_;
    rest.out_ = outward(angle_rad);
    rest.ahead_ = ahead(angle_rad);
    rest.radius_ = radius_ + share * spiral_;
    rest.spiral_ = (1 - share) * spiral_;
    rest.centre_ = centre_ + share * rise_;
    rest.rise_ = (1 - share) * rise_;
    rest.angle_ = angle_ - angle_rad;
    rest.fit();
    return rest;
}

Circle Circle::without_end(double angle_rad) const {
    Circle rest = *this;
    const double share = (angle_ - angle_rad) / angle_;
    rest.spiral_ = share * spiral_;
    rest.rise_ = share * rise_;
    rest.angle_ = angle_ - angle_rad;
    rest.fit();
    return rest;
}

Coordinates Segment::at(double way) const {
    const double share = way / length;
    Coordinates out = start + (end - start) * share;
    if (shape == Shape::arc) out.linear_mm = circle.at_share(share);
    if (shape == Shape::blend)
        out.linear_mm = way < lead_in_mm ? start.linear_mm + way / lead_in_mm * (circle.at_angle(0) - start.linear_mm)
                                         : circle.at_angle((way - lead_in_mm) / circle.start_radius());
    return out;
}

Vector3d Segment::start_direction() const {
    if (purely_rotary) return Vector3d::UnitX();
    if (shape == Shape::line) return (end.linear_mm - start.linear_mm).normalized();
    return circle.tangent(0);
}

Vector3d Segment::end_direction() const {
    if (shape == Shape::line) return start_direction();
    return circle.tangent(circle.angle());
}

double Segment::overall_acceleration() const {
    const double whole = acceleration * (1 - std::max(kink_reduction, kink_reduction_before));
    return ending == Ending::parabolic || joined_parabolically ? 0.5 * whole : whole;
}

Segment line_segment(const Coordinates& start, const Coordinates& end) {
    Segment segment;
    segment.start = start;
    segment.end = end;
    const Coordinates way = end - start;
    segment.rotary = (way.rotary_deg.array().abs() >= still).any();
    segment.purely_rotary = (way.linear_mm.array().abs() < still).all();
    segment.length = segment.purely_rotary ? way.rotary_deg.norm() : way.linear_mm.norm();
    segment.nominal = segment.length;
    return segment;
}

Segment arc_segment(const Coordinates& start, const Coordinates& end, const Circle& circle) {
    Segment segment;
    segment.shape = Shape::arc;
    segment.start = start;
    segment.end = end;
    segment.circle = circle;
    segment.rotary = ((end - start).rotary_deg.array().abs() >= still).any();
    segment.length = segment.nominal = circle.length();
    segment.acceleration_ratio = 0.5;
    return segment;
}

}  // namespace trunnion::controller::linuxcnc
