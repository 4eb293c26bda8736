#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Geometry>

#include "trunnion/machine/kinematics.hpp"

#include "detail/vector.hpp"

/// Which rotary positions give a tool axis.
///
/// Two axes: a₁ nearest to the workpiece, a₂, and the tool e, with e₁ = ∠(a₁, a₂) and e₂ = ∠(a₂, e) folded into ]0,
/// π/2] by the choice of the directions' sense; D = e₁ − e₂, S = e₁ + e₂. In the frame (g, m, a₁), g along a₂ × a₁ and
/// m = a₁ × g, R₂(θ₂) brings the tool to
///     w = (sin e₂ sin ψ, sin D + 2 sin e₂ cos e₁ sin²(ψ/2), cos β),   ψ = θ₂ + ψ₀ = 0 where it is nearest to a₁,
/// and R₁(θ₁) turns w about a₁. Height and radius of n tell β, the spherical triangle (a₁, a₂, n) then tells ψ:
///     cos D − cos β = 2 sin e₁ sin e₂ sin²(ψ/2),   cos β − cos S = 2 sin e₁ sin e₂ cos²(ψ/2),
/// and θ₁ is the angle of n less that of w about a₁, the lag. The two branches are ±ψ. At e₁ = e₂ the first equation is
/// a square on both sides, sin(β/2) = sin e₁ sin(ψ/2): with β signed like ψ all is smooth through the pole β = 0. With
/// e₁ = e₂ = π/2 the rest falls away: ψ = β, w in the plane of g and a₁. Source: half-angle formulas of the spherical
/// triangle; Lavernhe 2006, Eq. 3 is the case of right angles.
///
/// One axis a at an angle to the tool: the frame is (c × a, c, a) with c along a × e; in it the axis is (sin ε cos θ,
/// sin ε sin θ, cos ε).
namespace trunnion::machine {

using detail::Vector;

namespace {

constexpr double reach_rad = 1e-6;
constexpr double pole_rad = 1e-8;
constexpr double right_angle_within = 1e-9;  ///< rad; the same for equal angles
constexpr double rim_rounding = 4 * std::numeric_limits<double>::epsilon();
constexpr double pi = std::numbers::pi;
const Eigen::Vector3d tool_at_zero = Eigen::Vector3d::UnitZ();

/// In (−π, π].
double wrapped(double angle) {
    const double out = std::remainder(angle, 2 * pi);
    return out <= -pi ? out + 2 * pi : out;
}

double wound_near(double angle, double near) {
    return near + std::remainder(angle - near, 2 * pi);
}

double value_of(double x) {
    return x;
}
double value_of(const Taylor3& x) {
    return x.value();
}

Vector<double> values_of(const VectorSeries& v) {
    return {v[0].value(), v[1].value(), v[2].value()};
}

/// Angle and length of (x, y) as series, on the ray of the base point or, with σ = −1, on its opposite: length is
/// signed. Rotating the base point onto the first axis leaves no difference of large terms, however short the vector
/// is. A motion whose line misses the origin by no more than the rounding of `unit`, the length that x and y are a part
/// of, goes through it: its lateral part is noise, which the derivatives would blow up by powers of 1/length.
struct Polar {
    Taylor3 angle, length;
};
Polar polar(const Taylor3& x, const Taylor3& y, double sigma, double unit) {
    constexpr double rounding = 1e-14;
    const double r = sigma * std::hypot(x.value(), y.value()), c = x.value() / r, s = y.value() / r;
    const Taylor3 along = c * x + s * y;
    Taylor3 across = c * y - s * x;
    across.c[0] = 0;
    for (int k = 1; k < 4; ++k)
        if (std::abs(r * across.c[k]) <= rounding * unit * std::abs(along.c[k])) across.c[k] = 0;
    const Taylor3 t = across / along;
    const Taylor3 secant{1, 0, 0.5 * t.c[1] * t.c[1], t.c[1] * t.c[2]};
    return {{std::atan2(s, c), t.c[1], t.c[2], t.c[3] - t.c[1] * t.c[1] * t.c[1] / 3}, along * secant};
}

double apart(double a, double b) {
    return std::abs(std::remainder(a - b, 2 * pi));
}

/// At right angles: σ of the branch whose first angle, or where both are as near, whose second is the nearer one.
double right_angled_branch(const Vector<double>& n, double tool_angle, double near_first, double near_last) {
    constexpr double as_near = 1e-9;
    const double to_plus = apart(std::atan2(n[1], n[0]), near_first), to_minus = pi - to_plus;
    if (std::abs(to_plus - to_minus) > as_near) return to_plus < to_minus ? 1 : -1;
    const double psi = std::atan2(std::hypot(n[0], n[1]), n[2]);
    return apart(psi - tool_angle, near_last) <= apart(-psi - tool_angle, near_last) ? 1 : -1;
}

double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    const double angle = std::atan2(a.cross(b).norm(), a.dot(b));
    return std::abs(angle - pi / 2) <= right_angle_within ? pi / 2 : angle;
}

}  // namespace

/// Of the branch whose second turn has the sign of the radius it is made from. The lag is the angle of w about a₁: n is
/// read on its ray or, with a radius < 0, on its opposite. At the rim, and outside, it is that of the foot point.
template <class S>
struct Kinematics::Triangle {
    S turn{};                     // ψ
    S cos_lag = S(1), sin_lag{};  // of any common length
    bool at_rim = false;
};

void Kinematics::prepare_orientation() {
    Eigen::Matrix3d rows = Eigen::Matrix3d::Identity();
    if (rotary_count_ == 2) {
        fold_cones();
        const Eigen::Vector3d &first = turns_[0].direction, &last = turns_[1].direction;
        const Eigen::Vector3d across = last.cross(first).normalized();
        rows << across.transpose(), first.cross(across).transpose(), first.transpose();
        tool_angle_ = std::atan2(tool_at_zero.dot(across), tool_at_zero.dot(across.cross(last)));
    } else if (rotary_count_ == 1) {
        const Eigen::Vector3d& only = turns_[0].direction;
        along_tool_ = only.cross(tool_at_zero).norm() <= reach_rad;
        const Eigen::Vector3d across = along_tool_ ? only.unitOrthogonal() : only.cross(tool_at_zero).normalized();
        rows << across.cross(only).transpose(), across.transpose(), only.transpose();
    }
    to_orientation_frame_ = rows * workpiece_.rotation;
}

/// Half angles up to π/2: an axis that points away is the axis of the other sense, counted the other way.
void Kinematics::fold_cones() {
    const auto face = [](Turn& turn, const Eigen::Vector3d& towards) {
        if (turn.direction.dot(towards) >= -right_angle_within) return;
        turn.direction = -turn.direction;
        turn.sign = -turn.sign;
    };
    face(turns_[1], tool_at_zero);
    face(turns_[0], turns_[1].direction);
    const double first = angle_between(turns_[0].direction, turns_[1].direction);
    double last = angle_between(turns_[1].direction, tool_at_zero);
    if (std::abs(first - last) <= right_angle_within) last = first;
    const auto versine = [](double angle) { return 2 * std::sin(angle / 2) * std::sin(angle / 2); };
    cones_ = {.right_angles = first + last == pi,
              .pole = first == last,
              .cos_first = first == pi / 2 ? 0 : std::cos(first),
              .sin_first = std::sin(first),
              .sin_last = std::sin(last),
              .inner = versine(first - last),
              .sin_inner = std::sin(first - last),
              .outer = versine(first + last),
              .beyond = versine(pi - first - last)};
}

/// From the radius of n about a₁ (signed like ψ) and its height along a₁, of a common length. Differences of nearly
/// equal terms are taken where they are small: from the pole that is nearer, as radius² / (length ± height).
template <class S>
Kinematics::Triangle<S> Kinematics::oblique_triangle(const S& radius, const S& height) const noexcept {
    using std::atan2, std::sqrt;
    const S length = sqrt(radius * radius + height * height);
    const double sigma = std::copysign(1.0, value_of(radius));
    const bool upper = value_of(height) > 0;
    const S from_axis = radius * radius / (upper ? length + height : length - height);  // length·(1 ∓ cos β)
    S inside = upper ? from_axis - cones_.inner * length : (2 - cones_.inner) * length - from_axis;
    S outside = upper ? cones_.outer * length - from_axis : from_axis - cones_.beyond * length;
    const double noise = rim_rounding * value_of(length);
    const bool inner_rim = !cones_.pole && value_of(inside) <= noise * cones_.inner;
    const bool outer_rim = value_of(outside) <= noise * (upper ? cones_.outer : cones_.beyond);
    if (inner_rim) inside = S(0);
    const S cosine = outer_rim ? S(0) : sqrt(outside);
    S sine(0);
    if (!inner_rim) sine = cones_.pole && upper ? radius / sqrt(length + height) : sigma * sqrt(inside);
    Triangle<S> out{.turn = 2 * atan2(sine, cosine), .at_rim = inner_rim || outer_rim};
    if (cones_.pole) {
        out.cos_lag = cosine;
        out.sin_lag = cones_.cos_first * sine;
    } else {
        out.cos_lag = sigma * sine * cosine;
        out.sin_lag = sigma * (cones_.cos_first * inside + cones_.sin_first * cones_.sin_inner * length);
    }
    return out;
}

/// With the first axis held, the tool moves on the second one's cone: sin ψ and cos ψ from n's parts along the ray of
/// the first axis and along a₁. A pole that lies out of reach leaves the second axis where it comes nearest.
Taylor3 Kinematics::oblique_turn_at_pole(const VectorSeries& n, double first_rad) const noexcept {
    const bool upper = n[2].value() > 0;
    if (!cones_.pole || !upper) return Taylor3(upper ? 0 : pi);
    const Taylor3 along = std::cos(first_rad) * n[0] + std::sin(first_rad) * n[1];
    const Taylor3 length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    return atan2(cones_.sin_last * along, n[2] - cones_.cos_first * cones_.cos_first * length);
}

RotarySolutions Kinematics::rotary_for(const Eigen::Vector3d& axis_in_workpiece) const noexcept {
    if (rotary_count_ < 2) return solutions_of_one(axis_in_workpiece);
    const Eigen::Vector3d n = to_orientation_frame_ * axis_in_workpiece;
    const double h = std::hypot(n.x(), n.y());
    const Triangle<double> at =
        cones_.right_angles ? Triangle<double>{std::atan2(h, n.z())} : oblique_triangle(h, n.z());
    RotarySolutions out;
    out.degenerate = h <= pole_rad;
    out.count = out.degenerate || at.at_rim ? 1 : 2;
    for (int branch = 0; branch < out.count; ++branch) {
        const double sigma = branch == 0 ? 1 : -1;
        const double across = sigma * at.cos_lag * n.y() - at.sin_lag * n.x();
        const double along = sigma * at.cos_lag * n.x() + at.sin_lag * n.y();
        const double first = out.degenerate ? 0 : std::atan2(across, along);
        out.rotary_rad[branch][turns_[0].index] = wrapped(turns_[0].sign * first);
        out.rotary_rad[branch][turns_[1].index] = wrapped(turns_[1].sign * (sigma * at.turn - tool_angle_));
    }
    if (at.at_rim && (tool_axis(out.rotary_rad[0]) - axis_in_workpiece).norm() > reach_rad) return {};
    return out;
}

RotarySolutions Kinematics::solutions_of_one(const Eigen::Vector3d& axis_in_workpiece) const noexcept {
    RotarySolutions out;
    const RotarySeries found = rotary_series({axis_in_workpiece.x(), axis_in_workpiece.y(), axis_in_workpiece.z()}, {});
    for (int k = 0; k < rotary_count_; ++k) out.rotary_rad[0][k] = wrapped(found[k].value());
    out.count = (tool_axis(out.rotary_rad[0]) - axis_in_workpiece).norm() <= reach_rad ? 1 : 0;
    out.degenerate = along_tool_ && out.count == 1;
    return out;
}

RotarySeries Kinematics::rotary_series(const VectorSeries& axis, const RotaryPosition& near_rad) const noexcept {
    if (rotary_count_ == 0) return {};
    const VectorSeries n = detail::times(to_orientation_frame_, axis);
    if (rotary_count_ == 1) return turn_of_one(n, near_rad);
    return cones_.right_angles ? right_angled_turns(n, near_rad) : oblique_turns(n, near_rad);
}

/// An axis parallel to the tool, and an orientation in its direction, leave it where it is.
RotarySeries Kinematics::turn_of_one(const VectorSeries& n, const RotaryPosition& near_rad) const noexcept {
    const auto v = values_of(n);
    const double h = std::hypot(v[0], v[1]);
    if (along_tool_ || h <= pole_rad * std::hypot(h, v[2])) return {Taylor3(near_rad[0])};
    Taylor3 out = turns_[0].sign * atan2(n[1], n[0]);
    out.c[0] = wound_near(out.c[0], near_rad[0]);
    return {out};
}

inline RotarySeries Kinematics::positions_of(const Taylor3& theta_first, const Taylor3& theta_last,
                                             const RotaryPosition& near_rad) const noexcept {
    const Turn &first = turns_[0], &last = turns_[1];
    RotarySeries out;
    out[first.index] = first.sign * theta_first;
    out[last.index] = last.sign * theta_last;
    out[first.index].c[0] = wound_near(out[first.index].c[0], near_rad[first.index]);
    out[last.index].c[0] = wound_near(out[last.index].c[0], near_rad[last.index]);
    return out;
}

RotarySeries Kinematics::right_angled_turns(const VectorSeries& n, const RotaryPosition& near_rad) const noexcept {
    const Turn &first = turns_[0], &last = turns_[1];
    const auto v = values_of(n);
    const double h = std::hypot(v[0], v[1]), unit = std::hypot(h, v[2]);
    const double near_first = first.sign * near_rad[first.index], near_last = last.sign * near_rad[last.index];
    if (h <= pole_rad * unit) {
        const Taylor3 along = std::cos(near_first) * n[0] + std::sin(near_first) * n[1];
        return positions_of(near_first, atan2(along, n[2]) - tool_angle_, near_rad);
    }
    const double sigma = right_angled_branch(v, tool_angle_, near_first, near_last);
    const Polar flat = polar(n[0], n[1], sigma, unit);
    return positions_of(flat.angle, atan2(flat.length, n[2]) - tool_angle_, near_rad);
}

/// Towards the rim the branches come together in both angles: by the way of both the nearer one is chosen. n is turned
/// back by the lag before its angle is taken, so that a motion through the pole shows as one.
RotarySeries Kinematics::oblique_turns(const VectorSeries& n, const RotaryPosition& near_rad) const noexcept {
    const Turn &first = turns_[0], &last = turns_[1];
    const auto v = values_of(n);
    const double h = std::hypot(v[0], v[1]), unit = std::hypot(h, v[2]);
    const double near_first = first.sign * near_rad[first.index], near_last = last.sign * near_rad[last.index];
    if (h <= pole_rad * unit)
        return positions_of(near_first, oblique_turn_at_pole(n, near_first) - tool_angle_, near_rad);
    const Triangle<double> plus = oblique_triangle(h, v[2]);
    const double angle = std::atan2(v[1], v[0]), lag = std::atan2(plus.sin_lag, plus.cos_lag);
    const double way_of_plus = apart(angle - lag, near_first) + apart(plus.turn - tool_angle_, near_last);
    const double way_of_minus = apart(angle + lag + pi, near_first) + apart(-plus.turn - tool_angle_, near_last);
    const double sigma = way_of_plus <= way_of_minus ? 1 : -1;
    const Triangle<Taylor3> at = oblique_triangle(polar(n[0], n[1], sigma, unit).length, n[2]);
    const Taylor3 along = at.cos_lag * n[0] + at.sin_lag * n[1], across = at.cos_lag * n[1] - at.sin_lag * n[0];
    const double size = unit * std::hypot(plus.cos_lag, plus.sin_lag);
    return positions_of(polar(along, across, sigma, size).angle, at.turn - tool_angle_, near_rad);
}

}  // namespace trunnion::machine
