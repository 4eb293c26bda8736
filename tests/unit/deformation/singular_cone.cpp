#include "trunnion/deformation/singular_cone.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "pole_cases.hpp"

namespace trunnion::deformation {
namespace {

using Eigen::Vector3d;
using std::numbers::pi;

const machine::Axis& rotary(const machine::Machine& machine, int which) {
    return machine.axes[static_cast<std::size_t>(machine.linear_count() + which)];
}

/// Velocity ratio of the rotary axes for the worst direction of a turn of the tool axis, by differences of the inverse
/// kinematics: nothing of what is tested has a part in it.
double worst_ratio(const Workshop& shop, const Vector3d& axis, double rate_rad_s) {
    constexpr double step = 1e-7;
    const Vector3d along = axis.unitOrthogonal(), across = axis.cross(along);
    const auto at = shop.kinematics.rotary_for(axis);
    if (at.count != 2) return HUGE_VAL;
    double out = 0;
    for (int k = 0; k < 360; ++k) {
        const double turn = k * degree;
        const Vector3d way = std::cos(turn) * along + std::sin(turn) * across;
        const auto more = shop.kinematics.rotary_for((axis + step * way).normalized());
        const auto less = shop.kinematics.rotary_for((axis - step * way).normalized());
        if (more.count != 2 || less.count != 2) return HUGE_VAL;
        for (int r = 0; r < 2; ++r) {
            const auto which = static_cast<std::size_t>(r);
            const double moved = std::remainder(more.rotary_rad[0][which] - less.rotary_rad[0][which], 2 * pi);
            out = std::max(out, std::abs(moved) / (2 * step) * rate_rad_s / rotary(shop.machine, r).feed.velocity);
        }
    }
    return out;
}

/// A tool axis at an angle from the cone's direction; `round` tells where around it.
Vector3d tilted(const SingularCone& cone, double angle_rad, double round) {
    const Vector3d across = geometry::rotation_about(cone.direction, round) * cone.direction.unitOrthogonal();
    return std::cos(angle_rad) * cone.direction + std::sin(angle_rad) * across;
}

TEST(SingularCone, of_every_shipped_machine_is_where_the_velocity_limit_is_reached) {
    int machines = 0;
    const machine::Frame lying{{10, 20, 30}, geometry::rotation_about(Vector3d(1, 2, 0.5), 1.1)};
    for (const auto& entry : std::filesystem::directory_iterator(machine_folder())) {
        SCOPED_TRACE(entry.path().stem().string());
        ++machines;
        for (const machine::Frame& frame : {machine::Frame{}, lying}) {
            const Workshop shop(shipped_machine(entry.path().stem().string()), 1000, {}, frame);
            const double rate =
                0.3 * std::min(rotary(shop.machine, 0).feed.velocity, rotary(shop.machine, 1).feed.velocity);
            const auto cones = singular_cones(shop.machine, shop.kinematics, rate);
            ASSERT_EQ(cones.size(), shop.machine.rotary_count == 2 ? 2U : 0U);
            for (const SingularCone& cone : cones) {
                EXPECT_NEAR(cone.direction.norm(), 1, 1e-12);
                EXPECT_GT(cone.half_angle_rad, 0);
                EXPECT_TRUE(!cone.pole || shop.kinematics.rotary_for(cone.direction).degenerate);
                // Of a rim the reach ends on one side: 45° and 90° are reached from 0 up.
                const double inwards = cone.pole || cone.angle_rad < 45 * degree ? 1 : -1;
                for (const double round : {0.3, 2.0, 4.5}) {
                    const auto at = [&](double share) {
                        return tilted(cone, cone.angle_rad + inwards * share * cone.half_angle_rad, round);
                    };
                    EXPECT_GT(worst_ratio(shop, at(0.98), rate), 1) << "cone at " << cone.angle_rad / degree;
                    EXPECT_LT(worst_ratio(shop, at(1.02), rate), 1) << "cone at " << cone.angle_rad / degree;
                }
            }
        }
    }
    EXPECT_EQ(machines, 16);
}

TEST(SingularCone, half_angle_of_a_trunnion_is_the_arc_sine_of_the_rates) {
    const Workshop shop(shipped_machine("ucp710"), 3000);
    const double rate = 25 * degree;  // C: 120 deg/s
    const auto cones = singular_cones(shop.machine, shop.kinematics, rate);
    ASSERT_EQ(cones.size(), 2U);
    for (const auto& cone : cones) {
        EXPECT_TRUE(cone.pole);
        EXPECT_EQ(shop.machine.axes[static_cast<std::size_t>(cone.axis)].letter, 'C');
        EXPECT_NEAR(cone.half_angle_rad, std::asin(25.0 / 120.0), 1e-12);
        EXPECT_NEAR(std::abs(cone.direction.z()), 1, 1e-15);
    }
    EXPECT_LT(cones[0].direction.dot(cones[1].direction), 0);
}

TEST(SingularCone, lies_along_the_axis_nearest_to_the_workpiece) {
    const Workshop shop(shipped_machine("xyzab-tdr"), 1000);  // A nearest: the pole is along X
    const auto cones = singular_cones(shop.machine, shop.kinematics, 0.01);
    ASSERT_EQ(cones.size(), 2U);
    for (const auto& cone : cones) EXPECT_NEAR(std::abs(cone.direction.x()), 1, 1e-15);
    EXPECT_EQ(shop.machine.axes[static_cast<std::size_t>(cones[0].axis)].letter, 'A');
}

TEST(SingularCone, a_nutating_machine_has_one_pole_and_a_rim) {
    const Workshop shop(shipped_machine("dmu70evo"), 1000);
    const auto cones = singular_cones(shop.machine, shop.kinematics, 0.1);
    ASSERT_EQ(cones.size(), 2U);
    EXPECT_TRUE(cones[0].pole);
    EXPECT_NEAR(cones[0].direction.z(), 1, 1e-12);
    EXPECT_FALSE(cones[1].pole);
    EXPECT_NEAR(cones[1].angle_rad, 90 * degree, 1e-9);
}

TEST(SingularCone, unequal_cones_have_two_rims) {
    auto machine = shipped_machine("dmu70evo");
    machine.axes[3].direction = Vector3d(0, -1, 2).normalized();  // 26.6° to C, as the tool is: still a pole
    EXPECT_TRUE(singular_cones(machine, Workshop(machine, 1).kinematics, 0.1)[0].pole);
    machine.axes[4].direction = Vector3d(0, 0.3, 1).normalized();
    const Workshop shop(machine, 1000);
    const auto cones = singular_cones(shop.machine, shop.kinematics, 0.1);
    ASSERT_EQ(cones.size(), 2U);
    EXPECT_FALSE(cones[0].pole);
    EXPECT_FALSE(cones[1].pole);
    const double first = std::atan(0.3) + std::atan(0.5), second = std::atan(0.5);
    EXPECT_NEAR(cones[0].angle_rad, first - second, 1e-9);
    EXPECT_NEAR(cones[1].angle_rad, first + second, 1e-9);
    for (const auto& cone : cones) {
        const double inwards = cone.angle_rad < first ? 1 : -1;
        EXPECT_GT(worst_ratio(shop, tilted(cone, cone.angle_rad + inwards * 0.98 * cone.half_angle_rad, 1), 0.1), 1);
        EXPECT_LT(worst_ratio(shop, tilted(cone, cone.angle_rad + inwards * 1.02 * cone.half_angle_rad, 1), 0.1), 1);
    }
}

TEST(SingularCone, a_rate_beyond_the_limit_is_a_cone_up_to_the_other_pole) {
    const Workshop shop(shipped_machine("ucp710"), 3000);
    for (const auto& cone : singular_cones(shop.machine, shop.kinematics, 130 * degree))
        EXPECT_NEAR(cone.half_angle_rad, pi, 1e-12);
}

TEST(RotaryJacobian, loses_its_rank_at_the_pole_and_has_the_gains_of_the_spherical_triangle) {
    const Workshop shop(shipped_machine("nutating-table"), 3000);
    EXPECT_NEAR(rotary_jacobian(shop.kinematics, {0, 1}).determinant(), 0, 1e-12);
    const double e = 45 * degree;
    for (const double turn : {0.1, 0.8, 2.5}) {
        const auto at = rotary_jacobian(shop.kinematics, {turn, -0.7});
        const double tilt = 2 * std::asin(std::sin(e) * std::sin(turn / 2));
        EXPECT_NEAR(at.nearest_gain() * std::sin(e) * std::sin(turn), 1, 1e-9);
        EXPECT_NEAR(at.other_gain() * std::sin(e) * std::sin(e) * std::sin(turn), std::sin(tilt), 1e-9);
        EXPECT_NEAR(at.nearest.norm(), std::sin(tilt), 1e-9);
    }
}

}  // namespace
}  // namespace trunnion::deformation
