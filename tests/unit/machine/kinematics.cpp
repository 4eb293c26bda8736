#include "trunnion/machine/kinematics.hpp"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "machines.hpp"

namespace {

using namespace trunnion;
using namespace trunnion::machine;
using namespace trunnion::machine::examples;
using Eigen::Vector3d;

constexpr double pi = std::numbers::pi;
constexpr double deg = pi / 180;

Kinematics made(const Machine& machine, double length_mm = 0) {
    return Kinematics::make(machine, {}, length_mm).value();
}

std::string code_of(const Machine& machine) {
    const auto result = Kinematics::make(machine, {}, 0);
    return result ? "" : result.error().code;
}

TEST(Kinematics, ToolAxisOfTheTrunnionIsThePublishedOne) {
    const auto k = made(machine_of("CAXYZ", "AC"));
    for (const double a : {-25 * deg, 0.0, 40 * deg, 110 * deg})
        for (const double c : {-3.0, 0.5, 2.0}) {
            const Vector3d n = k.tool_axis(RotaryPosition{a, c});
            EXPECT_NEAR(n.x(), std::sin(c) * std::sin(a), 1e-15);
            EXPECT_NEAR(n.y(), -std::cos(c) * std::sin(a), 1e-15);
            EXPECT_NEAR(n.z(), std::cos(a), 1e-15);
        }
}

TEST(Kinematics, SolutionsOfTheTrunnionAreThePublishedOnes) {
    const auto k = made(machine_of("CAXYZ", "AC"));
    const Vector3d n = Vector3d(0.3, -0.5, 0.6).normalized();
    const auto solutions = k.rotary_for(n);
    ASSERT_EQ(solutions.count, 2);
    const double a = std::atan2(std::hypot(n.x(), n.y()), n.z()), c = std::atan2(n.x(), -n.y());
    EXPECT_NEAR(solutions.rotary_rad[0][0], a, 1e-15);
    EXPECT_NEAR(solutions.rotary_rad[0][1], c, 1e-15);
    EXPECT_NEAR(solutions.rotary_rad[1][0], -a, 1e-15);
    EXPECT_NEAR(solutions.rotary_rad[1][1], c - pi, 1e-15);
}

/// Lin and Koren's check: an orientation error of 0.017° moves the tip by 45.596 µm when the part's vector is (·, 96,
/// 120).
TEST(Kinematics, ATurnOfAMovesAPointByItsDistance) {
    const auto k = made(machine_of({usual('X'), usual('Y'), usual('Z'), rotary('A', Vector3d::UnitX())}, "AXYZ"));
    const auto before = k.linear_for(Vector3d(31, 96, 120), {0, 0}),
               after = k.linear_for(Vector3d(31, 96, 120), {0.017 * deg, 0});
    const Vector3d moved(after[0] - before[0], after[1] - before[1], after[2] - before[2]);
    EXPECT_NEAR(moved.norm(), 0.045596, 1e-6);
    EXPECT_EQ(moved.x(), 0);
}

TEST(Kinematics, HeadMovesTheTipByItsPivotLength) {
    const Machine head =
        machine_of({usual('X'), usual('Y'), usual('Z'), rotary('B', Vector3d::UnitY(), {0, 0, 200})}, "XYZB");
    const Pose pose = made(head, 50).forward({{0, 0, 0, pi / 2, 0}});
    EXPECT_LT((pose.tip_in_workpiece_mm - Vector3d(-250, 0, 200)).norm(), 1e-12);
    EXPECT_LT((pose.axis_in_workpiece - Vector3d::UnitX()).norm(), 1e-15);
}

struct Order {
    const char *chain, *turning;
};
class Orders : public testing::TestWithParam<Order> {};

/// Every order of table, head and linear axes, also linear axes on both sides of a rotary one.
TEST_P(Orders, InverseUndoesForward) {
    const auto k = made(machine_of(GetParam().chain, GetParam().turning), 60);
    for (const double first : {-1.2, 0.4})
        for (const double second : {-0.7, 0.3}) {
            const AxisPosition q{{12, -34, 56, first, k.rotary_count() == 2 ? second : 0}};
            const Pose pose = k.forward(q);
            const auto linear = k.linear_for(pose.tip_in_workpiece_mm, {q[3], q[4]});
            for (std::size_t a = 0; a < 3; ++a) EXPECT_NEAR(linear[a], q[a], 1e-11);
            const auto solutions = k.rotary_for(pose.axis_in_workpiece);
            bool found = false;
            for (int b = 0; b < solutions.count; ++b)
                found =
                    found ||
                    std::abs(solutions.rotary_rad[b][0] - q[3]) + std::abs(solutions.rotary_rad[b][1] - q[4]) < 1e-13;
            EXPECT_TRUE(found);
        }
}

INSTANTIATE_TEST_SUITE_P(Kinematics, Orders,
                         testing::Values(Order{"CAXYZ", "AC"}, Order{"CBXYZ", "BC"}, Order{"ABXYZ", "AB"},
                                         Order{"BAXYZ", "AB"}, Order{"CXYZA", "AC"}, Order{"CXYZB", "BC"},
                                         Order{"AXYZB", "AB"}, Order{"XYZCA", "AC"}, Order{"XYZCB", "BC"},
                                         Order{"XYZAB", "AB"}, Order{"XYZBA", "AB"}, Order{"XCAYZ", "AC"},
                                         Order{"YCZAX", "AC"}, Order{"CXYAZ", "AC"}, Order{"XYZB", "B"},
                                         Order{"AXYZ", "A"}),
                         [](const auto& order) { return std::string(order.param.chain) + "_" + order.param.turning; });

TEST(Kinematics, SeriesOfMixedChainsUndoThoseOfForward) {
    const auto k = made(machine_of("XCYAZ", "AC"), 60);
    const VectorSeries linear{Taylor3(1, 2, 3, 4), Taylor3(-5, 1, 0.5, 2), Taylor3(30, -2, 1, 1)};
    const RotarySeries rotary{Taylor3(0.4, 0.3, -0.2, 0.1), Taylor3(-0.6, 0.1, 0.2, -0.3)};
    const auto found = k.linear_for(k.tip_for(linear, rotary), rotary);
    for (int a = 0; a < 3; ++a)
        for (int order = 0; order < 4; ++order) EXPECT_NEAR(found[a].c[order], linear[a].c[order], 1e-11);
}

TEST(Kinematics, LinearAxesThatComeToLieInAPlaneGiveNoNumber) {
    const auto k = made(machine_of("XCYZ", "C"));
    const auto linear = k.linear_for(Vector3d(1, 2, 3), {pi / 2, 0});
    EXPECT_FALSE(std::isfinite(linear[0]) && std::abs(linear[0]) < 1e12);
}

TEST(Kinematics, OneAxisReachesItsCircleOnly) {
    const auto k = made(machine_of("AXYZ", "A"));
    const auto on = k.rotary_for(Vector3d(0, -std::sin(0.4), std::cos(0.4)));
    ASSERT_EQ(on.count, 1);
    EXPECT_NEAR(on.rotary_rad[0][0], 0.4, 1e-15);
    EXPECT_EQ(k.rotary_for(Vector3d(1e-7, -std::sin(0.4), std::cos(0.4)).normalized()).count, 1);
    EXPECT_EQ(k.rotary_for(Vector3d(1e-5, -std::sin(0.4), std::cos(0.4)).normalized()).count, 0);
    EXPECT_EQ(k.rotary_for(Vector3d::UnitX()).count, 0);
}

TEST(Kinematics, NoAxisReachesTheSpindleOnly) {
    const auto k = made(machine_of("XYZ", ""));
    EXPECT_EQ(k.rotary_for(Vector3d::UnitZ()).count, 1);
    EXPECT_EQ(k.rotary_for(Vector3d(0, 1e-5, 1).normalized()).count, 0);
    EXPECT_EQ(k.rotary_nearest_workpiece(), -1);
    EXPECT_EQ(k.lever({}), 1);
}

TEST(Kinematics, OneAxisAlongTheToolTurnsThePartOnly) {
    const auto k = made(machine_of({usual('X'), usual('Y'), usual('Z'), rotary('C', Vector3d::UnitZ())}, "CXYZ"));
    const auto solutions = k.rotary_for(Vector3d::UnitZ());
    EXPECT_EQ(solutions.count, 1);
    EXPECT_TRUE(solutions.degenerate);
    EXPECT_EQ(k.rotary_for(Vector3d::UnitX()).count, 0);
    const auto kept = k.rotary_series({Taylor3(0), Taylor3(0), Taylor3(1)}, {7.5, 0});
    EXPECT_EQ(kept[0].value(), 7.5);
    const auto linear = k.linear_for(Vector3d(10, 0, 0), {pi / 2, 0});
    EXPECT_NEAR(linear[1], -10, 1e-12);  // C +90° of the tool about the part: the part's x is the machine's −y
}

TEST(Kinematics, SeriesChooseTheBranchNextToTheReference) {
    const auto k = made(machine_of("CAXYZ", "AC"));
    const Vector3d n = k.tool_axis(RotaryPosition{0.5, 1.0});
    const VectorSeries axis{Taylor3(n.x()), Taylor3(n.y()), Taylor3(n.z())};
    const auto same = k.rotary_series(axis, {0.0, 1.2}), other = k.rotary_series(axis, {0.0, 1.2 + pi});
    EXPECT_NEAR(same[0].value(), 0.5, 1e-15);
    EXPECT_NEAR(other[0].value(), -0.5, 1e-15);
    EXPECT_NEAR(other[1].value(), 1.0 + pi, 1e-14);
    const auto tie = k.rotary_series(axis, {-0.4, 1.0 + pi / 2});  // as far by C: then the nearer A
    EXPECT_NEAR(tie[0].value(), -0.5, 1e-15);
}

TEST(Kinematics, DirectionsNeedNotBeThoseOfTheFrame) {
    const double h = std::sqrt(0.5);
    const Machine slanted = machine_of({linear('X', {h, h, 0}), linear('Y', {-h, h, 0}), linear('Z', {0, 0.6, 0.8}),
                                        rotary('B', Vector3d(h, -h, 0)), usual('C')},
                                       "CXYZB");
    const auto k = made(slanted, 40);
    const AxisPosition q{{1, 2, 3, 0.4, -0.9}};
    const Pose pose = k.forward(q);
    const auto linear = k.linear_for(pose.tip_in_workpiece_mm, {q[3], q[4]});
    for (std::size_t a = 0; a < 3; ++a) EXPECT_NEAR(linear[a], q[a], 1e-12);
}

Machine with_rotary(const Vector3d& b, const Vector3d& c, const char* chain) {
    return machine_of({usual('X'), usual('Y'), usual('Z'), rotary('B', b.normalized(), {4, -5, 60}),
                       rotary('C', c.normalized(), {1, 2, 3})},
                      chain);
}

VectorSeries still(const Vector3d& axis) {
    return {Taylor3(axis.x()), Taylor3(axis.y()), Taylor3(axis.z())};
}

bool finite(const RotarySeries& rotary) {
    for (const auto& series : rotary)
        for (const double c : series.c)
            if (!std::isfinite(c)) return false;
    return true;
}

/// Swivel by B about an axis at 45°: sin(tilt/2) = sin 45° sin(B/2), and the tool swings sideways by atan(cos 45°
/// tan(B/2)).
TEST(InclinedAxes, TiltByTheNutatingFormula) {
    const auto k = made(with_rotary({0, -1, 1}, Vector3d::UnitZ(), "CBXYZ"));
    for (const double b : {0.3, 1.0, 2.5}) {
        const double tilt = 2 * std::asin(std::sqrt(0.5) * std::sin(b / 2));
        const double side = std::atan(std::sqrt(0.5) * std::tan(b / 2));
        const Vector3d n = k.tool_axis(RotaryPosition{b, 0});
        EXPECT_NEAR(std::acos(n.z()), tilt, 1e-14);
        const double heading = std::atan2(n.y(), n.x());
        EXPECT_NEAR(std::abs(std::remainder(heading, pi)), side, 1e-14);
        const auto solutions = k.rotary_for(n);
        ASSERT_EQ(solutions.count, 2);
        EXPECT_FALSE(solutions.degenerate);
        EXPECT_NEAR(std::abs(solutions.rotary_rad[0][0]), b, 1e-14);
        EXPECT_NEAR(solutions.rotary_rad[1][0], -solutions.rotary_rad[0][0], 1e-14);
    }
}

TEST(InclinedAxes, ReachAsFarAsBothConesTogether) {
    const auto k = made(with_rotary({0, 1, 1}, Vector3d::UnitZ(), "XYZCB"));  // up to 90° off Z
    const auto tilted = [](double rad) { return Vector3d(std::sin(rad) * 0.6, std::sin(rad) * 0.8, std::cos(rad)); };
    EXPECT_EQ(k.rotary_for(tilted(1.0)).count, 2);
    EXPECT_EQ(k.rotary_for(tilted(pi / 2 - 1e-4)).count, 2);
    EXPECT_EQ(k.rotary_for(tilted(pi / 2 + 1e-4)).count, 0);
    EXPECT_EQ(k.rotary_for(-Vector3d::UnitZ()).count, 0);
    EXPECT_FALSE(k.rotary_for(-Vector3d::UnitZ()).degenerate);
    const auto level = k.rotary_for(tilted(pi / 2 + 0.9e-6));  // the branches have met, B = 180°
    ASSERT_EQ(level.count, 1);
    EXPECT_FALSE(level.degenerate);
    EXPECT_EQ(std::abs(level.rotary_rad[0][0]), pi);
    EXPECT_NEAR((k.tool_axis(level.rotary_rad[0]) - tilted(pi / 2)).norm(), 0, 1e-15);
    EXPECT_EQ(k.rotary_for(tilted(pi / 2 + 1.1e-6)).count, 0);
    const auto up = k.rotary_for(Vector3d::UnitZ());
    EXPECT_EQ(up.count, 1);
    EXPECT_TRUE(up.degenerate);
}

/// A horizontal and, on it, an axis at 45° to it and to the tool: neither pole is ever reached.
TEST(InclinedAxes, MayLeaveAHoleAboutThePole) {
    const auto k = made(with_rotary(Vector3d::UnitX(), {0, 1, 1}, "BXYZC"));
    const auto from_x = [](double rad) { return Vector3d(std::cos(rad), std::sin(rad) * 0.6, std::sin(rad) * 0.8); };
    EXPECT_EQ(k.rotary_for(from_x(pi / 4 + 1e-4)).count, 2);
    EXPECT_EQ(k.rotary_for(from_x(pi / 4 - 1e-4)).count, 0);
    EXPECT_EQ(k.rotary_for(from_x(pi / 4 - 0.9e-6)).count, 1);
    EXPECT_EQ(k.rotary_for(from_x(3 * pi / 4 - 1e-4)).count, 2);
    EXPECT_EQ(k.rotary_for(from_x(3 * pi / 4 + 1e-4)).count, 0);
    for (const Vector3d& pole : {Vector3d(Vector3d::UnitX()), Vector3d(-Vector3d::UnitX())}) {
        EXPECT_EQ(k.rotary_for(pole).count, 0);
        const auto kept = k.rotary_series(still(pole), {7.5, 0.1});
        EXPECT_EQ(kept[0].c, (std::array<double, 4>{7.5, 0, 0, 0}));
        EXPECT_NEAR(std::acos(std::abs(k.tool_axis(RotaryPosition{7.5, kept[1].value()}).x())), pi / 4, 1e-12);
    }
}

/// Out of reach the tool goes where it comes nearest, and moves along the rim with the foot point: all stays finite.
TEST(InclinedAxes, OutOfReachTheFootPointOnTheRimIsTaken) {
    const auto k = made(with_rotary({0, 1, 1}, Vector3d::UnitZ(), "XYZCB"));
    for (const double beyond : {0.0, 1e-12, 1e-3, 0.7, 1.5}) {
        const double tilt = pi / 2 + beyond, heading = 0.4;
        const Vector3d along(std::cos(heading), std::sin(heading), 0);
        const Vector3d n = std::sin(tilt) * along + std::cos(tilt) * Vector3d::UnitZ();
        const Vector3d speed = 0.01 * along.cross(Vector3d::UnitZ()) + 0.02 * Vector3d::UnitZ();
        const VectorSeries axis{Taylor3(n.x(), speed.x(), 0, 0), Taylor3(n.y(), speed.y(), 0, 0),
                                Taylor3(n.z(), speed.z(), 0, 0)};
        const auto found = k.rotary_series(axis, {3.0, 0.5});
        ASSERT_TRUE(finite(found)) << beyond;
        EXPECT_NEAR((k.tool_axis(RotaryPosition{found[0].value(), found[1].value()}) - along).norm(), 0, 1e-7)
            << beyond;
        if (beyond < 1e-9) continue;
        EXPECT_EQ(found[0].d1(), 0);
        EXPECT_NEAR(found[1].d1(), -0.01 / std::sin(tilt), 1e-14);
    }
}

/// Beside the rim the branches lie close together; a step that turns the first axis farther than that stays on its
/// branch.
TEST(InclinedAxes, KeepTheBranchBesideTheRim) {
    const auto k = made(with_rotary({0, 1, 1}, Vector3d::UnitZ(), "XYZCB"));
    for (const double b : {0.9 * pi, -0.9 * pi})
        for (const double step : {-0.3, 0.3}) {
            const RotaryPosition near{b, 1.0}, there{b, 1.0 + step};
            const auto solutions = k.rotary_for(k.tool_axis(there));
            ASSERT_EQ(solutions.count, 2);
            EXPECT_LT(std::abs(std::remainder(solutions.rotary_rad[0][1] - solutions.rotary_rad[1][1], 2 * pi)), 0.5);
            const auto found = k.rotary_series(still(k.tool_axis(there)), near);
            EXPECT_NEAR(found[0].value(), there[0], 1e-13);
            EXPECT_NEAR(found[1].value(), there[1], 1e-13);
        }
}

TEST(InclinedAxes, AsTheOnlyOneReachItsConeOnly) {
    const Vector3d inclined = Vector3d(0, 1, 1).normalized();
    const auto k = made(machine_of({usual('X'), usual('Y'), usual('Z'), rotary('B', inclined)}, "XYZB"));
    for (const double b : {-3.0, -0.4, 0.0, 2.0}) {
        const Vector3d n = k.tool_axis(RotaryPosition{b, 0});
        const auto on = k.rotary_for(n);
        ASSERT_EQ(on.count, 1);
        EXPECT_FALSE(on.degenerate);
        EXPECT_NEAR(on.rotary_rad[0][0], b, 1e-15 * 3);
        const Vector3d off = (n + 1e-4 * inclined).normalized();  // on the same meridian: its nearest one is the same
        EXPECT_EQ(k.rotary_for(off).count, 0);
        EXPECT_NEAR(k.rotary_series(still(off), {b, 0})[0].value(), b, 1e-12);
    }
    EXPECT_EQ(k.rotary_for(inclined).count, 0);
    EXPECT_EQ(k.rotary_series(still(inclined), {0.7, 0})[0].value(), 0.7);
}

/// Directions may point either way, and count either way: the same machine.
TEST(InclinedAxes, PointEitherWay) {
    const Vector3d b(0.3, 0.8, 0.5), c(-0.2, 0.1, 0.9);
    const Vector3d n = Vector3d(0.2, 0.3, 0.9).normalized();
    const auto reference = made(with_rotary(b, c, "CXYZB")).rotary_for(n);
    ASSERT_EQ(reference.count, 2);
    for (const bool flip_b : {false, true})
        for (const bool flip_c : {false, true}) {
            Machine machine = with_rotary(flip_b ? -b : b, flip_c ? -c : c, "CXYZB");
            machine.axes[3].reversed = flip_b;
            machine.axes[4].reversed = flip_c;
            const auto solutions = made(machine).rotary_for(n);
            ASSERT_EQ(solutions.count, 2);
            for (int branch = 0; branch < 2; ++branch)
                for (std::size_t a = 0; a < 2; ++a)
                    EXPECT_NEAR(solutions.rotary_rad[branch][a], reference.rotary_rad[branch][a], 1e-14);
        }
}

TEST(KinematicsRefuses, LinearAxesThatDoNotSpanSpace) {
    EXPECT_EQ(code_of(machine_of({usual('X'), usual('Y'), linear('Z', {1, 1, 0})}, "XYZ")), "MACH0101");
    EXPECT_EQ(code_of(machine_of({usual('X'), usual('Z')}, "XZ")), "MACH0101");
    EXPECT_EQ(code_of(machine_of({usual('U'), usual('X'), usual('Y'), usual('Z')}, "UXYZ")), "MACH0101");
}

TEST(KinematicsRefuses, MoreThanTwoRotaryAxes) {
    EXPECT_EQ(code_of(machine_of({usual('X'), usual('Y'), usual('A'), usual('B'), usual('C')}, "CBAXY")), "MACH0102");
}

TEST(KinematicsRefuses, RotaryAxesThatDoNotTiltTheTool) {
    const auto with = [](const Vector3d& b, const Vector3d& c, const char* chain) {
        return machine_of({usual('X'), usual('Y'), usual('Z'), rotary('B', b), rotary('C', c)}, chain);
    };
    const Vector3d x = Vector3d::UnitX(), z = Vector3d::UnitZ(), inclined(0, 1, 1);
    EXPECT_EQ(code_of(with(inclined.normalized(), -inclined.normalized(), "CXYZB")), "MACH0103");  // parallel
    EXPECT_EQ(code_of(with(x, z, "BCXYZ")), "MACH0103");  // C next to the tool turns nothing
    EXPECT_EQ(code_of(with(x, z, "CBXYZ")), "");
    const auto tilted = [](double rad) { return Vector3d(std::sin(rad), 0, std::cos(rad)); };
    EXPECT_EQ(code_of(with(x, tilted(0.9e-3), "BCXYZ")), "MACH0103");
    EXPECT_EQ(code_of(with(x, tilted(1.1e-3), "BCXYZ")), "");
    EXPECT_EQ(code_of(with(tilted(0.1), tilted(0.1 + 0.9e-3), "BCXYZ")), "MACH0103");
    EXPECT_EQ(code_of(with(tilted(0.1), tilted(0.1 + 1.1e-3), "BCXYZ")), "");
    const auto refused = Kinematics::make(with(x, z, "BCXYZ"), {}, 0);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().text.find("next to the tool"), std::string::npos);
    EXPECT_FALSE(refused.error().hint.empty());
}

}  // namespace
