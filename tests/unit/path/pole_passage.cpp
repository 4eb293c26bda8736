#include "trunnion/path/pole_passage.hpp"

#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "trunnion/geometry/great_circle.hpp"

#include "trunnion_table.hpp"

namespace trunnion::path {
namespace {

Eigen::Matrix3d turned(const Eigen::Vector3d& about, double angle_rad) {
    return Eigen::AngleAxisd(angle_rad, about.normalized()).toRotationMatrix();
}

TEST(PolePassage, poles_are_where_the_axis_nearest_to_the_workpiece_is_free) {
    const machine::Frame frame{{1, 2, 3}, turned({1, 2, -1}, 0.7)};
    auto machine = trunnion_table();
    const auto right_angled = machine::Kinematics::make(machine, frame, 50);
    ASSERT_TRUE(right_angled);
    EXPECT_EQ(poles_of(*right_angled).size(), 2U);
    for (const auto& pole : poles_of(*right_angled)) {
        EXPECT_NEAR(std::abs(pole.dot(frame.rotation.transpose() * Eigen::Vector3d::UnitZ())), 1, 1e-15);
        EXPECT_TRUE(right_angled->rotary_for(pole).degenerate);
    }
    machine.axes[3].direction = Eigen::Vector3d(1, 0, 1).normalized();  // inclined: one pole, the other is out of reach
    const auto inclined = machine::Kinematics::make(machine, frame, 50);
    ASSERT_TRUE(inclined);
    ASSERT_EQ(poles_of(*inclined).size(), 1U);
    EXPECT_TRUE(inclined->rotary_for(poles_of(*inclined)[0]).degenerate);
    machine.axes[4].direction = Eigen::Vector3d(0, 1, 4).normalized();  // unequal cones: a hole round the axis
    const auto without = machine::Kinematics::make(machine, frame, 50);
    ASSERT_TRUE(without);
    EXPECT_TRUE(poles_of(*without).empty());
}

TEST(PolePassage, nearest_place_of_a_great_circle_is_nearer_than_all_others) {
    const Eigen::Vector3d pole = turned({3, 1, 0}, 0.4) * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d across = pole.unitOrthogonal();
    struct Ends {
        double from_deg, to_deg, aside_deg;
    };
    for (const Ends& ends :
         {Ends{-10, 14, 0.05}, Ends{-1, -0.2, 0.1}, Ends{0.3, 40, 1e-4}, Ends{-80, 60, 3}, Ends{5, 5, 0}}) {
        const auto at = [&](double deg) -> Eigen::Vector3d {
            const Eigen::Vector3d aside = turned(across, ends.aside_deg * degree) * pole;
            return turned(aside.cross(across), deg * degree) * aside;
        };
        const auto from = at(ends.from_deg), to = at(ends.to_deg);
        const auto nearest = nearest_to_pole(from, to, pole);
        EXPECT_NEAR(nearest.beside.dot(pole), 0, 1e-15);
        for (int k = 0; k <= 1000; ++k)
            EXPECT_GE(beside_pole(geometry::slerp(from, to, k / 1000.0), pole).norm(), nearest.distance() - 1e-15);
        EXPECT_NEAR((geometry::slerp(from, to, nearest.share) - pole * nearest.height - nearest.beside).norm(), 0,
                    1e-15);
    }
    EXPECT_GT(nearest_to_pole(-pole, -pole, pole).distance(), 1) << "the other end of the axis is not this pole";
}

TEST(PolePassage, shift_is_whole_then_falls_smoothly) {
    EXPECT_EQ(shift_share(0), 1);
    EXPECT_EQ(shift_share(level_share), 1);
    EXPECT_EQ(shift_share(1), 0);
    EXPECT_EQ(shift_share(7), 0);
    constexpr double h = 1e-3;
    for (double t = 0; t < 1.1; t += h) EXPECT_GE(shift_share(t), shift_share(t + h));
    for (const double border : {level_share, 1.0}) {
        const double third = shift_share(border + 2 * h) - 3 * shift_share(border + h) + 3 * shift_share(border) -
                             shift_share(border - h);
        EXPECT_LT(std::abs(third) / (h * h * h), 5) << "the fourth derivative times a step";
    }
}

}  // namespace
}  // namespace trunnion::path
