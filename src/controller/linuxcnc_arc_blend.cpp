#include "detail/linuxcnc_arc_blend.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace trunnion::controller::linuxcnc {

namespace {

constexpr double right_angle = std::numbers::pi / 2;
constexpr double coplanar = 1e-6;
constexpr double normal_share = 0.8660254037844386;  ///< of the acceleration, across the way on an arc

/// One of the two segments at the corner, as the blend sees it.
struct Leg {
    const Segment* segment = nullptr;
    bool arc = false, convex = false;
    Vector3d tangent = Vector3d::Zero();  ///< unit, in the direction of motion, at the corner
    Vector3d centre = Vector3d::Zero();   ///< of the circle that stands for an arc's spiral
    double radius = 0, most_angle = 0;
    double usable_mm = 0;
};

/// A limit, and the axis that it comes from.
struct AxisLimit {
    double value = std::numeric_limits<double>::infinity();
    int slot = -1;
};

/// The largest value of a vector along any direction of the plane across `normal`, limited axis by axis.
AxisLimit least_in_plane(const Vector3d& limit, const Vector3d& normal) {
    AxisLimit least;
    for (int i = 0; i < 3; ++i) {
        Vector3d in_plane = (Vector3d::Unit(i) - normal[i] * normal).cwiseAbs();
        in_plane[i] = std::max(in_plane[i], 1e-12);
        const double most = limit[i] / in_plane.norm();
        if (most < least.value) least = {most, i};
    }
    return least;
}

Leg leg_of(const Segment& segment, const Vector3d& tangent) {
    Leg leg;
    leg.segment = &segment;
    leg.arc = segment.shape == Shape::arc;
    leg.tangent = tangent;
    return leg;
}

/// The work on one corner: what the two legs allow, the radius, and where the arc lies.
class Corner {
  public:
    Corner(const Segment& before, const Segment& after, const Limits& limits, const LinuxcncSettings& settings)
        : before_(leg_of(before, before.end_direction())),
          after_(leg_of(after, after.start_direction())),
          limits_(limits),
          settings_(settings),
          corner_(before.end.linear_mm) {}

    std::optional<ArcBlend> blend();

  private:
    bool measure();
    void use_arc(Leg& leg, double share, double sense, double tangent_half_rad);
    void find_speed();
    bool find_radius();
    bool find_centre();
    bool centre_beside_line_and_arc(const Leg& line, double side);
    bool centre_between_arcs();
    bool trims_fit();
    Vector3d touch_on(const Leg& leg, double trim) const;
    ArcBlend pieces() const;
    bool smooth(const ArcBlend& made) const;

    Leg before_, after_;
    const Limits& limits_;
    const LinuxcncSettings& settings_;
    Vector3d corner_, binormal_ = Vector3d::Zero(), centre_ = Vector3d::Zero();
    double half_rad_ = 0, turn_rad_ = 0, tolerance_mm_ = 0;
    double across_ = 0;
    AxisLimit acceleration_;
    double requested_ = 0, goal_ = 0, speed_ = 0, radius_ = 0;
    Hold goal_hold_;
    double trim_before_ = 0, trim_after_ = 0;  ///< mm on lines, rad on arcs
};

/// How much of an arc may be used; where it bends the way the corner does, its chord stands for it. `sense`: −1 before
/// the corner, 1 behind it.
void Corner::use_arc(Leg& leg, double share, double sense, double tangent_half_rad) {
    const Circle& circle = leg.segment->circle;
    const double at = sense < 0 ? circle.angle() : 0;
    const double radius = circle.start_radius() + (sense < 0 ? circle.spiral() : 0);
    leg.centre = corner_ - radius * circle.outward(at) + circle.spiral() / circle.angle() * circle.tangent_in_plane(at);
    const Vector3d spoke = corner_ - leg.centre;
    leg.radius = spoke.norm();
    leg.convex = sense < 0 ? spoke.dot(after_.tangent) < 0 : spoke.dot(before_.tangent) >= 0;
    leg.most_angle = std::min(share * circle.angle(), leg.convex ? tangent_half_rad : right_angle);
    leg.usable_mm = leg.most_angle * leg.radius;
    if (!leg.convex) return;
    leg.usable_mm = leg.radius * std::sin(leg.most_angle / 4);
    half_rad_ = std::min(half_rad_, tangent_half_rad - leg.most_angle / 4);
}

bool Corner::measure() {
    const Vector3d &u1 = before_.tangent, &u2 = after_.tangent;
    const double tangent_half = 0.5 * std::acos(std::clamp(-u1.dot(u2), -1.0, 1.0));
    if (tangent_half < 1e-6 || right_angle - tangent_half < 1e-6) return false;
    half_rad_ = tangent_half;
    binormal_ = u1.cross(u2).normalized();
    for (const Leg* leg : {&before_, &after_})
        if (leg->arc && 1 - std::abs(leg->segment->circle.normal().dot(binormal_)) > coplanar) return false;
    if (before_.arc && after_.arc && tangent_half < 15 * std::numbers::pi / 180) return false;

    const Segment &before = *before_.segment, &after = *after_.segment;
    const auto tolerance = [](const Segment& s) { return s.tolerance_mm > 0 ? s.tolerance_mm : s.nominal / 4; };
    tolerance_mm_ = std::min({tolerance(before), tolerance(after), before.nominal / 4, after.nominal / 4});
    if (before_.arc)
        use_arc(before_, 2.0 / 3, -1, tangent_half);
    else
        before_.usable_mm = std::min(before.length, before.nominal / 2);
    if (after_.arc)
        use_arc(after_, 1.0 / 3, 1, tangent_half);
    else
        after_.usable_mm = before_.arc ? after.nominal / 2 : after.length / 2;
    turn_rad_ = std::numbers::pi - 2 * half_rad_;
    acceleration_ = least_in_plane(limits_.linear_acceleration(), binormal_);
    across_ = normal_share * acceleration_.value;
    return true;
}

/// What both segments would go, within what the axes can do in the plane of the arc.
void Corner::find_speed() {
    const Segment &before = *before_.segment, &after = *after_.segment;
    requested_ = std::max(std::min(before.requested, before.top_speed), std::min(after.requested, after.top_speed));
    const double most = settings_.max_feed_override;
    goal_ = std::max(std::min(before.requested * most, before.top_speed),
                     std::min(after.requested * most, after.top_speed));
    const AxisLimit slowest = least_in_plane(limits_.linear_velocity(), binormal_);
    double in_plane = slowest.value;
    if (!before_.arc && !after_.arc) {
        const double cosine = std::cos(std::min(turn_rad_, 0.49 * std::numbers::pi));
        const double first = std::min(before.top_speed, after.top_speed / cosine);
        const double second = std::min(after.top_speed, before.top_speed / cosine);
        const double across = (after_.tangent * second - before_.tangent * first).norm();
        in_plane = std::max(in_plane, first * second * std::sin(turn_rad_) / across);
    }
    goal_hold_ = std::min(before.requested, before.top_speed) > std::min(after.requested, after.top_speed)
                     ? before.own_hold()
                     : after.own_hold();
    if (in_plane >= goal_) return;
    goal_ = in_plane;
    goal_hold_ = {motion::LimitKind::velocity, slowest.slot};
}

bool Corner::find_radius() {
    const double sine = std::sin(half_rad_), cosine = std::cos(half_rad_), tangent = std::tan(half_rad_);
    const double way = std::min({before_.usable_mm, after_.usable_mm, cosine * tolerance_mm_ / (1 - sine)});
    const double widest = way * tangent;
    speed_ = std::min(std::sqrt(across_ * widest), goal_);
    const double along = acceleration_.value / 2;
    const double time = std::min(std::sqrt(2 * along * way), speed_) / along;
    radius_ = std::max(speed_ * speed_ / across_, std::min(time * speed_ / turn_rad_, widest));
    return radius_ >= 1e-12 && radius_ * turn_rad_ >= 1e-6;
}

/// On the line's parallel at the distance of the radius, and at the right distance from the arc's centre.
bool Corner::centre_beside_line_and_arc(const Leg& line, double side) {
    const Leg& arc = &line == &before_ ? after_ : before_;
    const Vector3d inward = binormal_.cross(line.tangent);
    const Vector3d from_centre = corner_ + radius_ * inward - arc.centre;
    const double distance = arc.convex ? arc.radius - radius_ : arc.radius + radius_;
    const double half = from_centre.dot(line.tangent);
    const double root = half * half - (from_centre.squaredNorm() - distance * distance);
    if (root < 0) return false;
    const double first = -half + std::sqrt(root), second = -half - std::sqrt(root);
    const double way = std::abs(first) < std::abs(second) ? first : second;
    centre_ = corner_ + way * line.tangent + radius_ * inward;
    (side < 0 ? trim_before_ : trim_after_) = side * way;
    return side * way > 0;
}

/// Where the two offset circles meet nearest to the corner.
bool Corner::centre_between_arcs() {
    const double first = before_.convex ? before_.radius - radius_ : before_.radius + radius_;
    const double second = after_.convex ? after_.radius - radius_ : after_.radius + radius_;
    const Vector3d between = after_.centre - before_.centre;
    const double distance = between.norm();
    if (distance < 1e-12) return false;
    const double along = (first * first - second * second + distance * distance) / (2 * distance);
    const double square = first * first - along * along;
    if (square < 0) return false;
    const Vector3d foot = before_.centre + along / distance * between;
    const Vector3d aside = std::sqrt(square) * binormal_.cross(between / distance);
    const Vector3d one = foot + aside, other = foot - aside;
    centre_ = (one - corner_).norm() < (other - corner_).norm() ? one : other;
    return true;
}

bool Corner::find_centre() {
    if (!before_.arc && !after_.arc) {
        const Vector3d inward = (after_.tangent - before_.tangent).normalized();
        centre_ = corner_ + radius_ / std::sin(half_rad_) * inward;
        trim_before_ = trim_after_ = radius_ / std::tan(half_rad_);
        return true;
    }
    if (before_.arc && after_.arc) {
        if (!centre_between_arcs()) return false;
    } else if (!centre_beside_line_and_arc(before_.arc ? after_ : before_, before_.arc ? 1 : -1)) {
        return false;
    }
    return (centre_ - corner_).norm() - radius_ <= tolerance_mm_;
}

/// Arcs give up no more than their share, and no helix is shortened.
bool Corner::trims_fit() {
    for (Leg* leg : {&before_, &after_}) {
        double& trim = leg == &before_ ? trim_before_ : trim_after_;
        if (!leg->arc) {
            if (trim > leg->segment->length) return false;
            continue;
        }
        const double rise = leg->segment->circle.rise();
        if (rise * rise > 1e-6) return false;
        const Vector3d corner_spoke = (corner_ - leg->centre).normalized();
        const Vector3d blend_spoke = (centre_ - leg->centre).normalized();
        trim = std::acos(std::clamp(corner_spoke.dot(blend_spoke), -1.0, 1.0));
        if (trim > leg->most_angle) return false;
    }
    return true;
}

ArcBlend Corner::pieces() const {
    ArcBlend made{{}, *before_.segment, *after_.segment, false};
    Segment &before = made.before, &after = made.after, &blend = made.blend;
    if (before_.arc) {
        before.circle = before.circle.without_end(trim_before_);
        before.end.linear_mm = before.circle.at_angle(before.circle.angle());
        before.length = before.circle.length();
    } else {
        before.end.linear_mm = corner_ - trim_before_ * before_.tangent;
        before.length = (before.end.linear_mm - before.start.linear_mm).norm();
    }
    if (after_.arc) {
        after.circle = after.circle.without_start(trim_after_);
        after.start.linear_mm = after.circle.at_angle(0);
        after.length = after.circle.length();
    } else {
        after.start.linear_mm = corner_ + trim_after_ * after_.tangent;
        after.length = (after.end.linear_mm - after.start.linear_mm).norm();
    }
    const Vector3d first = before.end.linear_mm - centre_, last = after.start.linear_mm - centre_;
    const double angle = std::acos(std::clamp(first.normalized().dot(last.normalized()), -1.0, 1.0));
    blend.shape = Shape::blend;
    blend.circle =
        Circle(before.end.linear_mm, centre_, first.cross(last).normalized(), first.norm(), angle, Vector3d::Zero());
    blend.start = before.end;
    blend.end = after.start;
    blend.end.rotary_deg = blend.start.rotary_deg;
    blend.length = blend.nominal = first.norm() * angle;
    blend.line = after.line;
    blend.ending = Ending::tangent;
    blend.requested = requested_;
    blend.top_speed = speed_;
    blend.requested_hold = goal_hold_;
    blend.top_hold = speed_ < goal_ ? Hold{motion::LimitKind::transition} : goal_hold_;
    blend.acceleration = acceleration_.value;
    blend.acceleration_hold = {motion::LimitKind::acceleration, acceleration_.slot};
    blend.number = before.number;
    blend.acceleration_ratio = 0.5;
    blend.tolerance_mm = before.tolerance_mm;
    blend.finalised = true;
    return made;
}

/// Whether the circles that stood for spirals leave no kink beside the arc.
bool Corner::smooth(const ArcBlend& made) const {
    const Circle& circle = made.blend.circle;
    const double most = 0.25 * normal_share * acceleration_.value * settings_.servo_period_s / speed_;
    return (!before_.arc || (made.before.end_direction() - circle.tangent(0)).norm() <= most) &&
           (!after_.arc || (made.after.start_direction() - circle.tangent(circle.angle())).norm() <= most);
}

std::optional<ArcBlend> Corner::blend() {
    if (!measure()) return {};
    find_speed();
    if (!find_radius() || !find_centre() || !trims_fit()) return {};
    ArcBlend made = pieces();
    if (!smooth(made)) return {};
    const Segment& before = made.before;
    made.swallows_before = before.shape == Shape::line && !before.joined_parabolically &&
                           before.length / speed_ < settings_.gap_cycles * settings_.servo_period_s;
    if (made.swallows_before) {
        Segment& blend = made.blend;
        blend.lead_in_mm = before.length;
        blend.start = before.start;
        blend.length = blend.nominal = blend.length + before.length;
    }
    return made;
}

}  // namespace

std::optional<ArcBlend> arc_blend_between(const Segment& before, const Segment& after, const Limits& limits,
                                          const LinuxcncSettings& settings) {
    return Corner(before, after, limits, settings).blend();
}

}  // namespace trunnion::controller::linuxcnc
