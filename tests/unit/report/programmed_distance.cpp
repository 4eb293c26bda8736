#include "detail/programmed_distance.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace trunnion::report::detail {
namespace {

std::vector<verify::ProgrammedPose> corner() {
    std::vector<verify::ProgrammedPose> poses(3);
    poses[1].tip_mm = {10, 0, 0};
    poses[1].line = 1;
    poses[2].tip_mm = {10, 10, 0};
    poses[2].line = 2;
    return poses;
}

TEST(ProgrammedDistance, OnAndBesideTheProgrammedPath) {
    ProgrammedDistance distance(corner());
    const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
    EXPECT_NEAR(distance.at({2, 0, 0}, up, 1, 0), 0, 1e-15);
    EXPECT_NEAR(distance.at({5, 0.02, 0}, up, 1, 0), 0.02, 1e-15);
    EXPECT_NEAR(distance.at({9.9, 0.1, 0}, up, 1, 0), 0.1, 1e-15);
    EXPECT_NEAR(distance.at({9.99, 5, 0}, up, 2, 0), 0.01, 1e-15);
}

TEST(ProgrammedDistance, OfTheControlledPoint) {
    ProgrammedDistance distance(corner());
    const Eigen::Vector3d tilted = Eigen::Vector3d(0, std::sin(0.1), std::cos(0.1));
    EXPECT_NEAR(distance.at({5, 0, 0}, tilted, 1, 4), 4 * 2 * std::sin(0.05), 1e-12);
}

TEST(ProgrammedDistance, ThereAndBackIsNotConfused) {
    std::vector<verify::ProgrammedPose> poses(101);
    for (int i = 0; i <= 100; ++i) {
        poses[i].tip_mm = Eigen::Vector3d(i <= 50 ? i : 100 - i, i <= 50 ? 0 : 0.001, 0);
        poses[i].line = i;
    }
    ProgrammedDistance distance(poses);
    const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
    for (int i = 1; i <= 50; ++i) EXPECT_NEAR(distance.at({i - 0.5, 0, 0}, up, i, 0), 0, 1e-12) << i;
    for (int i = 52; i <= 100; ++i) EXPECT_NEAR(distance.at({100.5 - i, 0.001, 0}, up, i, 0), 0, 1e-12) << i;
}

TEST(ProgrammedDistance, WithoutAProgramNotKnown) {
    EXPECT_TRUE(std::isnan(ProgrammedDistance({}).at({0, 0, 0}, Eigen::Vector3d::UnitZ(), 1, 0)));
}

}  // namespace
}  // namespace trunnion::report::detail
