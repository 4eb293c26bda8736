#include "trunnion/geometry/rotation.hpp"

#include <numbers>

#include <Eigen/LU>
#include <gtest/gtest.h>

namespace {

using namespace trunnion::geometry;
using Eigen::Vector3d;

TEST(RotationAbout, IsRightHandedAndTakesAnyLengthOfAxis) {
    const auto quarter = rotation_about({0, 0, 1e-200}, std::numbers::pi / 2);
    EXPECT_LT((quarter * Vector3d::UnitX() - Vector3d::UnitY()).norm(), 1e-15);
    EXPECT_LT((quarter * Vector3d::UnitZ() - Vector3d::UnitZ()).norm(), 1e-15);
}

TEST(RotationAbout, IsARotation) {
    const auto r = rotation_about({1, -2, 3}, 2.5);
    EXPECT_LT((r * r.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-15);
    EXPECT_NEAR(r.determinant(), 1, 1e-15);
    EXPECT_NEAR(r.trace(), 1 + 2 * std::cos(2.5), 1e-15);
}

}  // namespace
