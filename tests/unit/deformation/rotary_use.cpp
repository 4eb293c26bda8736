#include "trunnion/deformation/rotary_use.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "pole_cases.hpp"

namespace trunnion::deformation {
namespace {

using Eigen::Vector3d;

/// On a cone of 30° about Z, once around: C turns evenly, A stands still.
DualPath around_cone(int poses) {
    std::vector<Pose> out;
    for (int i = 0; i <= poses; ++i) {
        const double turn = 360 * degree * i / poses;
        out.push_back({Vector3d(20 * std::cos(turn), 20 * std::sin(turn), 0),
                       Vector3d(0.5 * std::cos(turn), 0.5 * std::sin(turn), std::sqrt(0.75))});
    }
    return fit_dual_path(out).value().path;
}

TEST(RotaryUse, of_a_turn_about_c_is_known) {
    const Workshop shop(shipped_machine("ucp710"), 3000);
    const auto use = rotary_use(around_cone(90), shop.machining());
    ASSERT_TRUE(use) << to_string(use.error());
    const double way = 2 * std::numbers::pi * 20, seconds = way / 50, rate = 2 * std::numbers::pi / seconds;
    EXPECT_NEAR(use->travel_rad, 2 * std::numbers::pi, 1e-4);
    EXPECT_NEAR(use->velocity[1], rate, 1e-3 * rate);
    EXPECT_LE(use->velocity[0], 1e-3 * rate);
    EXPECT_NEAR(use->time_at_feed_s, seconds, 1e-4 * seconds);
    const double limit = 120 * degree;
    EXPECT_NEAR(use->velocity_ratio, rate / limit, 1e-3);
    EXPECT_NEAR(use->velocity_limited_time_s, 2 * std::numbers::pi / limit, 1e-3) << "C is slower than the feed";
}

TEST(RotaryUse, of_a_pure_turn_counts_at_the_reference_height) {
    const Workshop shop(shipped_machine("ucp710"), 600);
    std::vector<Pose> poses;
    for (int i = 0; i <= 20; ++i)
        poses.push_back({Vector3d::Zero(), Vector3d(0, -std::sin((10 + i) * degree), std::cos((10 + i) * degree))});
    const auto use = rotary_use(fit_dual_path(poses).value().path, shop.machining());
    ASSERT_TRUE(use) << to_string(use.error());
    EXPECT_NEAR(use->time_at_feed_s, 30 * 20 * degree / 10, 1e-4);
    EXPECT_NEAR(use->travel_rad, 20 * degree, 1e-6);
}

TEST(RotaryUse, begins_where_it_is_told) {
    Workshop shop(shipped_machine("ucp710"), 3000);
    Machining machining = shop.machining();
    const DualPath path = around_cone(90);
    const auto by_itself = rotary_use(path, machining);
    ASSERT_TRUE(by_itself);
    machining.begin_rad = by_itself->begin_rad;
    (*machining.begin_rad)[1] += 4 * std::numbers::pi;
    const auto wound = rotary_use(path, machining);
    ASSERT_TRUE(wound);
    EXPECT_NEAR(wound->begin_rad[1] - by_itself->begin_rad[1], 4 * std::numbers::pi, 1e-9);
    EXPECT_NEAR(wound->travel_rad, by_itself->travel_rad, 1e-9);
}

TEST(RotaryUse, finds_the_peak_beside_a_pole) {
    const Workshop shop(shipped_machine("ucp710"), 3000);
    const auto use = rotary_use(path_past_pole(0.05), shop.machining());
    ASSERT_TRUE(use);
    // dC/dt = tilt rate / sin(0.05°), on the circle that the tool axis turns on.
    const double peak = 0.5 * degree * 50 / std::tan(0.05 * degree);
    EXPECT_NEAR(use->velocity[1], peak, 1e-4 * peak);
}

TEST(RotaryUse, refuses_what_the_machine_cannot_follow) {
    auto machine = shipped_machine("ucp710");
    machine.axes[3].range_max = 5 * degree;
    machine.axes[3].range_min = -5 * degree;
    const auto refused = rotary_use(around_cone(90), Workshop(machine, 3000).machining());
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, "PATH0102");
    EXPECT_EQ(rotary_use(around_cone(90), Workshop(shipped_machine("ucp710"), -1).machining()).error().code,
              "DEFO0202");
}

}  // namespace
}  // namespace trunnion::deformation
