#pragma once

#include <array>
#include <cstdint>

#include <Eigen/Core>

#include "trunnion/motion/prediction.hpp"

namespace trunnion::controller::linuxcnc {

using Eigen::Vector3d;

/// What the planner moves. Degrees, as in the control: its thresholds are absolute numbers.
struct Coordinates {
    Vector3d linear_mm = Vector3d::Zero();   ///< X Y Z
    Vector3d rotary_deg = Vector3d::Zero();  ///< A B C

    Coordinates operator+(const Coordinates& other) const {
        return {linear_mm + other.linear_mm, rotary_deg + other.rotary_deg};
    }
    Coordinates operator-(const Coordinates& other) const {
        return {linear_mm - other.linear_mm, rotary_deg - other.rotary_deg};
    }
    Coordinates operator*(double factor) const { return {factor * linear_mm, factor * rotary_deg}; }
};

/// Of the six letters, mm and deg.
struct Limits {
    std::array<double, 6> velocity{}, acceleration{};
    Vector3d linear_velocity() const { return {velocity[0], velocity[1], velocity[2]}; }
    Vector3d linear_acceleration() const { return {acceleration[0], acceleration[1], acceleration[2]}; }
};

/// What holds a speed down, in the planner's terms.
struct Hold {
    motion::LimitKind kind = motion::LimitKind::feed;
    int slot = -1;  ///< of X Y Z A B C, where it is that of an axis
};

/// Coordinates that change less do not move.
inline constexpr double still = 1e-8;

/// A circle, helix or spiral: radius and height change in proportion to the angle.
class Circle {
  public:
    Circle() = default;
    /// `centre_mm` in the plane of the start; right-handed about `normal`; angle > 0.
    Circle(const Vector3d& start_mm, const Vector3d& centre_mm, const Vector3d& normal, double end_radius_mm,
           double angle_rad, const Vector3d& rise_mm);

    Vector3d at_angle(double angle_rad) const;
    Vector3d tangent(double angle_rad) const;  ///< unit, with spiral and rise
    Vector3d tangent_in_plane(double angle_rad) const { return ahead(angle_rad); }
    Vector3d outward(double angle_rad) const;
    Vector3d at_share(double share) const { return at_angle(angle_at(share)); }
    /// Angle at a share of the length.
    double angle_at(double share) const;
    double length() const;
    /// Radius of curvature at the start, the tighter one of the spiral.
    double curvature_radius() const;
    Circle without_start(double angle_rad) const;
    Circle without_end(double angle_rad) const;

    double angle() const { return angle_; }
    double start_radius() const { return radius_; }
    double spiral() const { return spiral_; }
    double rise() const { return rise_.norm(); }
    const Vector3d& centre() const { return centre_; }
    const Vector3d& normal() const { return normal_; }

  private:
    Vector3d ahead(double angle_rad) const;
    void fit();

    Vector3d centre_ = Vector3d::Zero(), normal_ = Vector3d::UnitZ(), out_ = Vector3d::UnitX(),
             ahead_ = Vector3d::UnitY(), rise_ = Vector3d::Zero();
    double radius_ = 0, spiral_ = 0, angle_ = 0;
    double quadratic_ = 0, linear_ = 0;  // length in the plane from the smaller radius: b0 φ² + b1 φ
};

enum class Shape : std::uint8_t { line, arc, blend };

/// How a segment ends: standing still, exactly but tangent joints are passed, overlapping with the next one, or passing
/// into it at speed.
enum class Ending : std::uint8_t { stop, exact, parabolic, tangent };

/// One segment in the planner's queue. Lengths in mm, where only rotary axes move in deg.
struct Segment {
    Shape shape = Shape::line;
    Ending ending = Ending::parabolic;
    bool rapid = false;
    bool rotary = false;         ///< a rotary letter moves
    bool purely_rotary = false;  ///< and no linear one
    std::int32_t line = 0;
    Coordinates start, end;
    Circle circle;          ///< of arcs and blends
    double lead_in_mm = 0;  ///< of a blend: straight piece before the circle, from `start`
    double length = 0, nominal = 0;
    double requested = 0, top_speed = 0, acceleration = 0;
    double tolerance_mm = 0;  ///< of its end; 0: none
    Hold requested_hold, top_hold, acceleration_hold;

    double acceleration_ratio = 1;
    double kink_speed = -1;  ///< negative: none
    double kink_reduction = 0, kink_reduction_before = 0;
    bool joined_parabolically = false;  ///< to its predecessor
    bool finalised = false;
    bool at_top = false;        ///< the look-ahead is limited here by speed, not by braking
    double end_speed = 0;       ///< by look-ahead
    Hold end_hold;              ///< why it ends slowly
    std::uint64_t number = 0;   ///< in the order of the queue
    std::uint64_t horizon = 0;  ///< the segment behind which nothing was known when that was found; 0: not that

    double progress = 0, speed = 0;
    double split_s = 0, exit_speed = 0;
    bool begun = false, active = false, ramp = false, split = false, finished = false, blending = false;
    bool on_final_deceleration = false;
    double begin_s = 0;

    Coordinates at(double way) const;
    Vector3d start_direction() const;  ///< unit, with rise and spiral; rotary alone: X
    Vector3d end_direction() const;
    /// At most so fast, and for that reason.
    void limit_top_speed(double most, Hold hold) {
        if (most >= top_speed) return;
        top_speed = most;
        top_hold = hold;
    }
    /// At its end.
    bool stands() const { return ending == Ending::stop || ending == Ending::exact; }
    /// What holds it down when nothing but itself does.
    Hold own_hold() const { return requested <= top_speed ? requested_hold : top_hold; }
    double overall_acceleration() const;  ///< along and across the way
    double acceleration_along() const { return overall_acceleration() * acceleration_ratio; }
};

Segment line_segment(const Coordinates& start, const Coordinates& end);
Segment arc_segment(const Coordinates& start, const Coordinates& end, const Circle& circle);

}  // namespace trunnion::controller::linuxcnc
