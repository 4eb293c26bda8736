#include "trunnion/deformation/avoid_pole.hpp"

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "pole_cases.hpp"

namespace trunnion::deformation {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

PoleAvoidance within(double tolerance_deg, std::optional<PolePassing> passing = {}) {
    return {.orientation_tolerance_rad = tolerance_deg * degree, .passing = passing};
}

/// A may not go below 0: no way through the pole.
machine::Machine one_sided() {
    auto machine = shipped_machine("ucp710");
    machine.axes[3].range_min = 0;
    return machine;
}

/// What every deformation keeps.
void expect_kept(const DualPath& before, const PoleAvoided& led, const Workshop& shop, double tolerance_rad) {
    EXPECT_LE(led.change.orientation_deviation_rad, tolerance_rad);
    EXPECT_LE(sampled_deviation_rad(before, led.path), led.change.orientation_deviation_rad * (1 + 1e-9));
    const double height = shop.tool.controlled_height_mm();
    EXPECT_LE(sampled_distance_mm(before, led.path, height), height > 0 ? 1e-4 : 1e-9);
    EXPECT_LE(largest_jump(led.path), 1e-6);
    for (const double u : {before.begin(), before.end()}) {
        EXPECT_LE((before.at(u).axis_in_workpiece - led.path.at(u).axis_in_workpiece).norm(), 1e-12);
        EXPECT_LE((before.at(u).tip_in_workpiece_mm - led.path.at(u).tip_in_workpiece_mm).norm(), 1e-12);
    }
    EXPECT_LE(led.after.velocity_ratio, 1);
}

TEST(AvoidPole, goes_through_it_where_that_is_the_least_change) {
    const Workshop shop(shipped_machine("ucp710"), 3000);
    const DualPath path = path_past_pole(0.05);
    const auto led = avoid_pole(path, shop.machining(), within(0.06));
    ASSERT_TRUE(led) << to_string(led.error());
    expect_kept(path, *led, shop, 0.06 * degree);
    ASSERT_EQ(led->passages.size(), 1U);
    EXPECT_EQ(led->passages[0].passing, PolePassing::through);
    EXPECT_NEAR(led->passages[0].distance_before_rad, 0.05 * degree, 1e-6 * degree);
    EXPECT_NEAR(led->change.orientation_deviation_rad, 0.05 * degree, 1e-4 * degree) << "the least there is";
    const Vector3d there = led->path.at(led->passages[0].u).axis_in_workpiece;
    EXPECT_LE(std::hypot(there.x(), there.y()), 1e-12);
    ASSERT_TRUE(led->before);
    EXPECT_GT(led->before->velocity_ratio, 100);
    EXPECT_LE(led->after.travel_rad, 0.12 * led->before->travel_rad);
    EXPECT_LE(led->after.velocity_limited_time_s, 0.5 * led->before->velocity_limited_time_s);
    EXPECT_NEAR(led->after.velocity_limited_time_s, led->after.time_at_feed_s, 1e-9) << "the feed is kept everywhere";
}

TEST(AvoidPole, goes_around_it_where_the_ranges_leave_nothing_else) {
    const Workshop shop(one_sided(), 250);
    const DualPath path = path_past_pole(0.05);
    const auto led = avoid_pole(path, shop.machining(), within(1));
    ASSERT_TRUE(led) << to_string(led.error());
    expect_kept(path, *led, shop, 1 * degree);
    ASSERT_EQ(led->passages.size(), 1U);
    EXPECT_EQ(led->passages[0].passing, PolePassing::near_side);
    EXPECT_GE(led->after.velocity_ratio, 0.99) << "no farther than needed";
    // Half angle of the cone: the tool turns at 0.5 deg/mm, C at 120 deg/s.
    const double cone = std::asin(0.5 * 250 / 60 / 120);
    EXPECT_NEAR(led->passages[0].distance_after_rad, cone, 0.01 * cone);
    EXPECT_NEAR(led->change.orientation_deviation_rad, cone - 0.05 * degree, 0.02 * cone);
    EXPECT_GE(led->after.begin_rad[0], 0);
    EXPECT_GE(led->after.end_rad[0], 0);
    EXPECT_GT(led->before->velocity_ratio, 10);
}

TEST(AvoidPole, may_be_told_the_side) {
    const Workshop shop(shipped_machine("ucp710"), 250);
    const DualPath path = path_past_pole(0.05);
    const auto near = avoid_pole(path, shop.machining(), within(1.5, PolePassing::near_side));
    const auto far = avoid_pole(path, shop.machining(), within(1.5, PolePassing::far_side));
    ASSERT_TRUE(near && far);
    expect_kept(path, *near, shop, 1.5 * degree);
    expect_kept(path, *far, shop, 1.5 * degree);
    EXPECT_NEAR(far->change.orientation_deviation_rad - near->change.orientation_deviation_rad, 0.1 * degree,
                0.003 * degree);
    const auto turn = [](const RotaryUse& use) { return use.end_rad[1] - use.begin_rad[1]; };
    EXPECT_LT(turn(near->after) * turn(far->after), 0) << "C turns the other way";
}

TEST(AvoidPole, the_range_of_the_free_axis_decides_on_the_side) {
    auto machine = one_sided();
    const DualPath path = path_past_pole(0.05);
    const Workshop endless(machine, 250);
    const auto near = avoid_pole(path, endless.machining(), within(1.5));
    ASSERT_TRUE(near);
    const double begin = near->after.begin_rad[1], end = near->after.end_rad[1];
    // A quarter turn is left on the side to which it turned, enough on the other one.
    machine.axes[4].range_min = begin < end ? begin - 1.2 * std::numbers::pi : begin - std::numbers::pi / 2;
    machine.axes[4].range_max = begin < end ? begin + std::numbers::pi / 2 : begin + 1.2 * std::numbers::pi;
    const Workshop limited(machine, 250);
    const auto far = avoid_pole(path, limited.machining(), within(1.5));
    ASSERT_TRUE(far) << to_string(far.error());
    EXPECT_EQ(far->passages[0].passing, PolePassing::far_side);
    expect_kept(path, *far, limited, 1.5 * degree);
}

TEST(AvoidPole, a_path_through_the_pole_is_left_alone) {
    const Workshop shop(shipped_machine("ucp710"), 3000);
    const DualPath path = path_past_pole(0);
    const auto led = avoid_pole(path, shop.machining(), within(0.06));
    ASSERT_TRUE(led) << to_string(led.error());
    EXPECT_TRUE(led->passages.empty());
    EXPECT_EQ(led->change.orientation_deviation_rad, 0);
    EXPECT_EQ(led->path.spline.top().control_points_mm(), path.spline.top().control_points_mm());
    EXPECT_NEAR(led->after.travel_rad, 20 * degree, 1e-6);
}

TEST(AvoidPole, a_path_through_the_pole_is_led_around_where_the_ranges_want_it) {
    const Workshop shop(one_sided(), 250);
    const DualPath path = path_past_pole(0);
    const auto led = avoid_pole(path, shop.machining(), within(1.2));
    ASSERT_TRUE(led) << to_string(led.error());
    EXPECT_FALSE(led->before) << "A would have to leave its range";
    ASSERT_EQ(led->passages.size(), 1U);
    expect_kept(path, *led, shop, 1.2 * degree);
}

TEST(AvoidPole, a_slow_path_beside_the_pole_is_left_alone) {
    const Workshop shop(shipped_machine("ucp710"), 10);
    const DualPath path = path_past_pole(0.05);
    const auto led = avoid_pole(path, shop.machining(), within(0.06));
    ASSERT_TRUE(led);
    EXPECT_TRUE(led->passages.empty());
    EXPECT_LE(led->after.velocity_ratio, 1);
}

TEST(AvoidPole, wherever_the_cone_lies) {
    const Matrix3d onto_x = geometry::rotation_about(Vector3d::UnitY(), std::numbers::pi / 2);
    const Matrix3d lying = geometry::rotation_about(Vector3d(1, 2, 0.5), 1.1);
    struct Case {
        const char* machine;
        machine::Frame frame;
        Matrix3d pole_frame;  // turns Z onto the pole in the workpiece
    };
    for (const Case& at :
         {Case{"xyzab-tdr", {}, onto_x}, Case{"generic-5axis", {{1, 2, 3}, lying}, lying.transpose()},
          Case{"nutating-table", {}, Matrix3d::Identity()}, Case{"dmu70evo", {}, Matrix3d::Identity()},
          Case{"head-head", {}, Matrix3d::Identity()}, Case{"nutating-head", {}, Matrix3d::Identity()}}) {
        SCOPED_TRACE(at.machine);
        const DualPath path = path_past_pole(0.05, at.pole_frame);
        const auto machine = shipped_machine(at.machine);
        const Workshop unhurried(machine, 60, ball(10, true), at.frame);
        const auto& kinematics = unhurried.kinematics;
        const auto free = static_cast<std::size_t>(machine.linear_count() + kinematics.rotary_nearest_workpiece());
        // A feed at which the cone has a half angle of 0.7°; the ball's centre goes farther than the tip.
        const double turn_per_mm = 0.5 * degree / (1 + 5 * 0.5 * degree);
        const double feed = 60 * std::sin(0.7 * degree) * machine.axes[free].feed.velocity / turn_per_mm;
        const Workshop shop(machine, feed, ball(10, true), at.frame);
        for (const PolePassing passing : {PolePassing::near_side, PolePassing::far_side}) {
            const auto led = avoid_pole(path, shop.machining(), within(1, passing));
            ASSERT_TRUE(led) << to_string(led.error());
            ASSERT_EQ(led->passages.size(), 1U);
            expect_kept(path, *led, shop, 1 * degree);
            EXPECT_NEAR(led->passages[0].distance_after_rad, 0.7 * degree, 0.01 * degree);
            EXPECT_LE(led->change.surface_mm, 1e-3) << "a ball about its centre";
            EXPECT_GT(led->before->velocity_ratio, 10);
        }
    }
}

TEST(AvoidPole, the_surface_moves_as_the_shape_of_the_tool_says) {
    using machine::ToolKind;
    const DualPath path = path_past_pole(0.05);
    const double turn = 2 * std::sin(0.025 * degree);
    const auto surface = [&](machine::Tool tool) {
        const Workshop shop(shipped_machine("ucp710"), 3000, tool);
        return avoid_pole(path, shop.machining(), within(0.06)).value().change.surface_mm;
    };
    EXPECT_LE(surface(ball(10, true)), 1e-6);
    EXPECT_NEAR(surface(ball(10, false)), 5 * turn, 1e-2 * 5 * turn) << "about the tip the centre moves";
    EXPECT_NEAR(surface({ToolKind::torus, 10, 1, 0, true}), 4 * turn, 1e-2 * 4 * turn);
    EXPECT_NEAR(surface({ToolKind::flat, 10, 0, 0, false}), 5 * turn, 1e-2 * 5 * turn);
}

TEST(AvoidPole, sparse_control_points_get_company) {
    const Workshop shop(one_sided(), 250);
    std::vector<Pose> few;
    const auto all = poses_past_pole(0.05);
    for (std::size_t i = 0; i < all.size(); i += 10) few.push_back(all[i]);
    const DualPath path = fit_dual_path(few, {.distance_tolerance_mm = 1}).value().path;
    const auto led = avoid_pole(path, shop.machining(), within(1.2));
    ASSERT_TRUE(led) << to_string(led.error());
    expect_kept(path, *led, shop, 1.2 * degree);
    EXPECT_GT(led->path.spline.top().control_points_mm().size(), path.spline.top().control_points_mm().size());
}

/// Over the pole and back, 0.05° to the left and 0.03° to the right of it.
DualPath there_and_back() {
    std::vector<Pose> poses;
    for (int i = 0; i <= 80; ++i) {
        const double along = 10 * degree * std::sin(std::numbers::pi * (i - 20) / 40.0),
                     beside = (i < 40 ? 0.05 : -0.03) * degree;
        const double share = std::abs(i - 40) < 10 ? (40 - i) / 10.0 : (i < 40 ? 1 : -1);
        const double y = i < 40 ? beside * std::abs(share) : beside * std::abs(share);
        poses.push_back(
            {Vector3d(0.5 * i, 0, 0), Vector3d(std::sin(along), std::sin(y), std::cos(along)).normalized()});
    }
    return fit_dual_path(poses, {.distance_tolerance_mm = 1}).value().path;
}

TEST(AvoidPole, one_passage_after_the_other) {
    const Workshop shop(shipped_machine("ucp710"), 2000);
    const DualPath path = there_and_back();
    const auto led = avoid_pole(path, shop.machining(), within(0.06));
    ASSERT_TRUE(led) << to_string(led.error());
    ASSERT_EQ(led->passages.size(), 2U);
    for (const auto& passage : led->passages) EXPECT_EQ(passage.passing, PolePassing::through);
    expect_kept(path, *led, shop, 0.06 * degree);
    EXPECT_LT(led->after.travel_rad, 0.2 * led->before->travel_rad);
}

TEST(AvoidPole, random_passages_keep_what_is_promised) {
    const std::uint32_t seed = 20261122;
    std::mt19937 generator(seed);
    const auto uniform = [&](double from, double to) {
        return from + (to - from) * static_cast<double>(generator()) / 4294967295.0;
    };
    SCOPED_TRACE("seed " + std::to_string(seed));
    int led_around = 0, led_through = 0;
    for (int round = 0; round < 40; ++round) {
        SCOPED_TRACE("round " + std::to_string(round));
        const double beside = uniform(-0.8, 0.8) * degree, bend = uniform(-0.02, 0.02), from = uniform(-0.25, -0.1);
        const double to = uniform(0.1, 0.25), heading = uniform(0, 6);
        const double feed = uniform(50, 400);
        std::vector<Pose> poses;
        for (int i = 0; i <= 60; ++i) {
            const double x = from + (to - from) * i / 60, y = beside + bend * x * x / 0.04;
            const Vector3d axis(std::cos(heading) * x - std::sin(heading) * y,
                                std::sin(heading) * x + std::cos(heading) * y, 1);
            poses.push_back({Vector3d(0.7 * i, 3 * std::sin(0.1 * i), 0), axis.normalized()});
        }
        const DualPath path = fit_dual_path(poses).value().path;
        const Workshop shop(round % 2 ? one_sided() : shipped_machine("ucp710"), feed, ball(6, round % 3 == 0));
        const auto led = avoid_pole(path, shop.machining(), within(3));
        ASSERT_TRUE(led) << to_string(led.error());
        expect_kept(path, *led, shop, 3 * degree);
        for (const auto& passage : led->passages)
            ++(passage.passing == PolePassing::through ? led_through : led_around);
        if (led->before) {
            EXPECT_LE(led->after.velocity_limited_time_s, led->before->velocity_limited_time_s * 1.001);
        }
    }
    EXPECT_GT(led_through, 5);
    EXPECT_GT(led_around, 5);
}

TEST(AvoidPole, poses_keep_their_controlled_point) {
    const Workshop shop(shipped_machine("ucp710"), 3000, ball(10, true));
    const auto poses = poses_past_pole(0.05);
    const auto led = avoid_pole(poses, {}, shop.machining(), within(0.06));
    ASSERT_TRUE(led) << to_string(led.error());
    ASSERT_EQ(led->poses.size(), poses.size());
    double largest = 0;
    for (std::size_t i = 0; i < poses.size(); ++i) {
        const auto centre = [](const Pose& pose) -> Vector3d {
            return pose.tip_in_workpiece_mm + 5 * pose.axis_in_workpiece;
        };
        EXPECT_LE((centre(poses[i]) - centre(led->poses[i])).norm(), 1e-9);
        largest = std::max(largest, (poses[i].axis_in_workpiece - led->poses[i].axis_in_workpiece).norm());
    }
    EXPECT_NEAR(largest, 0.05 * degree, 1e-4 * degree);
}

std::string code_of(const Result<PoleAvoided>& result) {
    return result ? "" : result.error().code;
}

TEST(AvoidPole, refuses_a_tolerance_that_cannot_be_met_and_says_which_could) {
    const Workshop shop(shipped_machine("ucp710"), 3000);
    const DualPath path = path_past_pole(0.05);
    const auto refused = avoid_pole(path, shop.machining(), within(0.04));
    ASSERT_EQ(code_of(refused), "DEFO0203");
    const double would = std::stod(refused.error().limit);
    EXPECT_NEAR(would, 0.05, 0.001);
    EXPECT_TRUE(avoid_pole(path, shop.machining(), within(would)));
    const Workshop around(one_sided(), 250);
    const auto too_small = avoid_pole(path, around.machining(), within(0.5));
    ASSERT_EQ(code_of(too_small), "DEFO0203");
    EXPECT_TRUE(avoid_pole(path, around.machining(), within(std::stod(too_small.error().limit))));
}

TEST(AvoidPole, refuses_a_cone_that_cannot_be_left) {
    const DualPath path = path_past_pole(0.05);
    const Workshop fast(one_sided(), 3000);  // the cone is wider than the path is long
    EXPECT_EQ(code_of(avoid_pole(path, fast.machining(), within(20))), "DEFO0204");
    auto machine = one_sided();
    machine.axes[4].range_min = -100 * degree;  // C cannot turn by half a turn
    machine.axes[4].range_max = 60 * degree;
    EXPECT_EQ(code_of(avoid_pole(path, Workshop(machine, 250).machining(), within(1.5))), "DEFO0204");
}

TEST(AvoidPole, refuses_what_makes_no_sense) {
    const DualPath path = path_past_pole(0.05);
    const Workshop shop(shipped_machine("ucp710"), 3000), standing(shipped_machine("ucp710"), 0);
    EXPECT_EQ(code_of(avoid_pole(path, shop.machining(), within(0))), "DEFO0202");
    EXPECT_EQ(code_of(avoid_pole(path, shop.machining(), within(NAN))), "DEFO0202");
    EXPECT_EQ(code_of(avoid_pole(path, standing.machining(), within(1))), "DEFO0202");
    const auto& knots = path.spline.bottom().knots();
    const std::vector<double> weights(path.spline.bottom().control_points_mm().size(), 1);
    const auto weighted = geometry::BsplineCurve::make(3, knots, path.spline.bottom().control_points_mm(), weights);
    const DualPath rational{geometry::DualSpline::make(*weighted, path.spline.top()).value(), 50};
    EXPECT_EQ(code_of(avoid_pole(rational, shop.machining(), within(1))), "DEFO0201");
    auto loose = knots;
    loose.front() -= 1;
    const auto unclamped = geometry::BsplineCurve::make(3, loose, path.spline.bottom().control_points_mm());
    const DualPath open{geometry::DualSpline::make(*unclamped, *unclamped).value(), 50};
    EXPECT_EQ(code_of(avoid_pole(open, shop.machining(), within(1))), "DEFO0201");
    EXPECT_EQ(avoid_pole(std::span<const Pose>{}, {}, shop.machining(), within(1)).error().code, "DEFO0101");
    auto opposite = poses_past_pole(0.05);
    opposite[20].axis_in_workpiece *= -1;
    EXPECT_EQ(avoid_pole(opposite, {}, shop.machining(), within(1)).error().code, "DEFO0103");
}

TEST(AvoidPole, a_machine_without_a_pole_has_nothing_to_avoid) {
    std::vector<Pose> poses;
    for (int i = 0; i < 10; ++i) poses.push_back({Vector3d(i, 0, 0), Vector3d::UnitZ()});
    const DualPath upright = fit_dual_path(poses).value().path;
    const auto led = avoid_pole(upright, Workshop(shipped_machine("three-axis"), 3000).machining(), within(0.06));
    ASSERT_TRUE(led) << to_string(led.error());
    EXPECT_TRUE(led->passages.empty());
    EXPECT_EQ(led->after.travel_rad, 0);
}

TEST(AvoidPole, what_has_nothing_to_do_with_the_pole_keeps_its_own_code) {
    auto machine = shipped_machine("ucp710");
    for (const std::size_t linear : {0U, 1U}) {  // the path is 40 mm long
        machine.axes[linear].range_min = -10;
        machine.axes[linear].range_max = 10;
    }
    const DualPath path = path_past_pole(0);
    const auto refused = avoid_pole(path, Workshop(machine, 10).machining(), within(0.06));
    EXPECT_EQ(code_of(refused), "PATH0102");
}

}  // namespace
}  // namespace trunnion::deformation
