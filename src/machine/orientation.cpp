#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "trunnion/machine/kinematics.hpp"

#include "detail/vector.hpp"

/// Which rotary positions give a tool axis.
///
/// Two axes a₁ (nearest to the workpiece) ⟂ a₂ ⟂ tool: R₂(θ₂) moves the tool in the plane of a₁ and g = a₂ × a₁, where
/// it stands at the angle ψ = θ₂ + ψ₀ from a₁; then R₁(θ₁) turns it about a₁. In the frame (g, a₂, a₁) the axis is
///     (X, Y, Z) = (sin ψ cos θ₁, sin ψ sin θ₁, cos ψ),
/// so θ₁ = atan2(σY, σX), ψ = atan2(σ√(X² + Y²), Z) with σ = ±1 for the two branches; X = Y = 0 is the pole.
/// One axis a ⟂ tool e: the frame is (e, a × e, a), in which the axis is (cos θ, sin θ, 0).
namespace trunnion::machine {

using detail::Vector;

namespace {

constexpr double reach_rad = 1e-6;
constexpr double pole_rad = 1e-8;
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

/// σ of the branch whose first angle, or where both are as near, whose second is the nearer one.
double nearest_branch(const Vector<double>& n, double tool_angle, double near_first, double near_last) {
    constexpr double as_near = 1e-9;
    const auto apart = [](double a, double b) { return std::abs(std::remainder(a - b, 2 * pi)); };
    const double to_plus = apart(std::atan2(n[1], n[0]), near_first), to_minus = pi - to_plus;
    if (std::abs(to_plus - to_minus) > as_near) return to_plus < to_minus ? 1 : -1;
    const double h = std::hypot(n[0], n[1]);
    const auto last = [&](double sigma) { return std::atan2(sigma * h, n[2]) - tool_angle; };
    return apart(last(1), near_last) <= apart(last(-1), near_last) ? 1 : -1;
}

}  // namespace

void Kinematics::prepare_orientation() {
    Eigen::Matrix3d rows = Eigen::Matrix3d::Identity();
    const Eigen::Vector3d& first = turns_[0].direction;
    if (rotary_count_ == 2) {
        rows << turns_[1].direction.cross(first).transpose(), turns_[1].direction.transpose(), first.transpose();
        const Eigen::Vector3d tool = rows * tool_at_zero;
        tool_angle_ = std::atan2(tool.x(), tool.z());
    } else if (rotary_count_ == 1) {
        rows << tool_at_zero.transpose(), first.cross(tool_at_zero).transpose(), first.transpose();
    }
    to_orientation_frame_ = rows * workpiece_.rotation;
}

RotarySolutions Kinematics::rotary_for(const Eigen::Vector3d& axis_in_workpiece) const noexcept {
    RotarySolutions out;
    if (rotary_count_ < 2) {
        const RotarySeries found =
            rotary_series({axis_in_workpiece.x(), axis_in_workpiece.y(), axis_in_workpiece.z()}, {});
        for (int k = 0; k < rotary_count_; ++k) out.rotary_rad[0][k] = wrapped(found[k].value());
        out.count = (tool_axis(out.rotary_rad[0]) - axis_in_workpiece).norm() <= reach_rad ? 1 : 0;
        out.degenerate = rotary_count_ == 1 && out.count == 1 && turns_[0].direction.cross(tool_at_zero).norm() < 0.5;
        return out;
    }
    const Eigen::Vector3d n = to_orientation_frame_ * axis_in_workpiece;
    const double h = std::hypot(n.x(), n.y());
    out.degenerate = h <= pole_rad;
    out.count = out.degenerate ? 1 : 2;
    for (int branch = 0; branch < out.count; ++branch) {
        const double sigma = branch == 0 ? 1 : -1;
        const double first = out.degenerate ? 0 : std::atan2(sigma * n.y(), sigma * n.x());
        const double second = std::atan2(sigma * h, n.z()) - tool_angle_;
        out.rotary_rad[branch][turns_[0].index] = wrapped(turns_[0].sign * first);
        out.rotary_rad[branch][turns_[1].index] = wrapped(turns_[1].sign * second);
    }
    return out;
}

RotarySeries Kinematics::rotary_series(const VectorSeries& axis, const RotaryPosition& near_rad) const noexcept {
    if (rotary_count_ == 0) return {};
    const VectorSeries n = detail::times(to_orientation_frame_, axis);
    return rotary_count_ == 1 ? turn_of_one(n, near_rad) : turns_of_two(n, near_rad);
}

/// An axis parallel to the tool, and an orientation in its direction, leave it where it is.
RotarySeries Kinematics::turn_of_one(const VectorSeries& n, const RotaryPosition& near_rad) const noexcept {
    const auto v = values_of(n);
    const double h = std::hypot(v[0], v[1]);
    const bool tells_nothing = to_orientation_frame_.row(1).squaredNorm() < 0.5 || h <= pole_rad * std::hypot(h, v[2]);
    if (tells_nothing) return {Taylor3(near_rad[0])};
    Taylor3 out = turns_[0].sign * atan2(n[1], n[0]);
    out.c[0] = wound_near(out.c[0], near_rad[0]);
    return {out};
}

RotarySeries Kinematics::turns_of_two(const VectorSeries& n, const RotaryPosition& near_rad) const noexcept {
    const Turn &first = turns_[0], &last = turns_[1];
    const auto v = values_of(n);
    const double h = std::hypot(v[0], v[1]);
    const double near_first = first.sign * near_rad[first.index], near_last = last.sign * near_rad[last.index];
    const auto finish = [&](const Taylor3& theta_first, const Taylor3& theta_last) {
        RotarySeries out;
        out[first.index] = first.sign * theta_first;
        out[last.index] = last.sign * theta_last;
        out[first.index].c[0] = wound_near(out[first.index].c[0], near_rad[first.index]);
        out[last.index].c[0] = wound_near(out[last.index].c[0], near_rad[last.index]);
        return out;
    };
    const double unit = std::hypot(h, v[2]);
    if (h <= pole_rad * unit) {
        const Taylor3 along = std::cos(near_first) * n[0] + std::sin(near_first) * n[1];
        return finish(near_first, atan2(along, n[2]) - tool_angle_);
    }
    const double sigma = nearest_branch(v, tool_angle_, near_first, near_last);
    const Polar flat = polar(n[0], n[1], sigma, unit);
    return finish(flat.angle, atan2(flat.length, n[2]) - tool_angle_);
}

}  // namespace trunnion::machine
