#include "trunnion/deformation/singular_cone.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "trunnion/geometry/great_circle.hpp"

namespace trunnion::deformation {

using Eigen::Vector3d;
using machine::Kinematics;
using machine::RotaryPosition;

namespace {

constexpr double same_rad = 1e-9;

std::size_t nearest_axis(const Kinematics& kinematics) {
    return static_cast<std::size_t>(kinematics.rotary_nearest_workpiece());
}

Vector3d derivative(const Kinematics& kinematics, const RotaryPosition& at, std::size_t which, bool second = false) {
    machine::RotarySeries series{at[0], at[1]};
    series[which] = {at[which], 1, 0, 0};
    const machine::VectorSeries n = kinematics.tool_axis(series);
    return second ? Vector3d(n[0].d2(), n[1].d2(), n[2].d2()) : Vector3d(n[0].d1(), n[1].d1(), n[2].d1());
}

/// a = n′ × n″/|n′|², n turned about a.
Vector3d turned_about(const Kinematics& kinematics, const RotaryPosition& at, std::size_t which) {
    return derivative(kinematics, at, which).cross(derivative(kinematics, at, which, true)).normalized();
}

/// a₁, e₁ and e₂ as in machine/kinematics.hpp: both axes counted in the sense that makes the half angles at most π/2.
struct TwoCones {
    Vector3d nearest;
    double first_rad, second_rad;
};

TwoCones cones_of(const Kinematics& kinematics) {
    const std::size_t nearest = nearest_axis(kinematics), other = 1 - nearest;
    RotaryPosition at{};
    for (const double turn : {1.0, 2.0, 3.0}) {  // away from where the axis nearest to the workpiece moves nothing
        RotaryPosition tried{};
        tried[other] = turn;
        if (derivative(kinematics, tried, nearest).norm() > derivative(kinematics, at, nearest).norm()) at = tried;
    }
    Vector3d second = turned_about(kinematics, at, other), first = turned_about(kinematics, at, nearest);
    if (second.dot(kinematics.tool_axis(at)) < 0) second = -second;
    if (first.dot(second) < 0) first = -first;
    return {first, geometry::angle_between(first, second), geometry::angle_between(second, kinematics.tool_axis(at))};
}

/// β of the tool when the second axis is turned by ψ from where it folds the tool onto the first.
double tilt_at(const TwoCones& cones, double turn_rad) {
    const double inner = std::sin((cones.first_rad - cones.second_rad) / 2), half = std::sin(turn_rad / 2);
    return 2 * std::asin(std::min(1.0, std::sqrt(inner * inner + std::sin(cones.first_rad) *
                                                                     std::sin(cones.second_rad) * half * half)));
}

struct Gains {
    double nearest, other;
};

Gains gains_at(const TwoCones& cones, double turn_rad) {
    const double nearest = 1 / (std::sin(cones.first_rad) * std::abs(std::sin(turn_rad)));
    return {nearest, nearest * std::sin(tilt_at(cones, turn_rad)) / std::sin(cones.second_rad)};
}

}  // namespace

RotaryJacobian rotary_jacobian(const Kinematics& kinematics, const RotaryPosition& rotary_rad) {
    const std::size_t nearest = nearest_axis(kinematics);
    return {derivative(kinematics, rotary_rad, nearest), derivative(kinematics, rotary_rad, 1 - nearest)};
}

std::vector<SingularCone> singular_cones(const machine::Machine& machine, const Kinematics& kinematics,
                                         double turn_rate_rad_s) {
    if (machine.rotary_count < 2) return {};
    const TwoCones cones = cones_of(kinematics);
    const std::size_t nearest = nearest_axis(kinematics), first = static_cast<std::size_t>(machine.linear_count());
    const std::array<std::size_t, 2> axis{first + nearest, first + 1 - nearest};
    const auto limit = [&](std::size_t i) { return machine.axes[axis[i]].feed.velocity / turn_rate_rad_s; };
    std::vector<SingularCone> out;
    for (const double border : {0.0, std::numbers::pi}) {
        const double to_middle = border == 0 ? 1 : -1;
        const double far = tilt_at(cones, std::numbers::pi - border), there = tilt_at(cones, border);
        const auto ratios = [&](double turn) {
            const Gains gains = gains_at(cones, border + to_middle * turn);
            return std::array{gains.nearest / limit(0), gains.other / limit(1)};
        };
        const auto exceeds = [&](double turn) { return std::ranges::max(ratios(turn)) > 1; };
        double inside = 0, outside = std::numbers::pi / 2;
        const bool everywhere = exceeds(outside);
        while (!everywhere && outside - inside > 1e-15 * outside) {
            const double middle = 0.5 * (inside + outside);
            if (middle <= inside || middle >= outside) break;
            (exceeds(middle) ? inside : outside) = middle;
        }
        const auto at = ratios(everywhere ? outside : inside > 0 ? inside : outside);
        SingularCone cone;
        cone.pole = there < same_rad || there > std::numbers::pi - same_rad;
        cone.direction = cone.pole && border > 0 ? Vector3d(-cones.nearest) : cones.nearest;
        cone.angle_rad = cone.pole ? 0 : there;
        cone.half_angle_rad = std::abs((everywhere ? far : tilt_at(cones, border + to_middle * outside)) - there);
        cone.axis = static_cast<int>(axis[at[0] >= at[1] ? 0 : 1]);
        out.push_back(cone);
    }
    return out;
}

}  // namespace trunnion::deformation
