#include "trunnion/geometry/great_circle.hpp"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace {

using namespace trunnion;
using namespace trunnion::geometry;
using Eigen::Vector3d;

Vector3d tilted(double angle) {
    return {std::sin(angle), 0, std::cos(angle)};
}

TEST(AngleBetween, IsAccurateAtBothEnds) {
    EXPECT_NEAR(angle_between(tilted(0), 3 * tilted(1e-9)) / 1e-9, 1, 1e-15);
    EXPECT_NEAR(angle_between(tilted(0), tilted(1.25)), 1.25, 1e-15);
    EXPECT_EQ(angle_between(tilted(0), -tilted(0)), std::numbers::pi);
    EXPECT_EQ(angle_between(tilted(0.3), tilted(0.3)), 0);
}

TEST(GreatCircle, TurnsInProportion) {
    for (const double angle : {1e-12, 1e-7, 1e-3, 0.5, 2.0, 3.0}) {
        const GreatCircle circle(tilted(0.2), tilted(0.2 + angle));
        EXPECT_NEAR(circle.angle_rad(), angle, 2e-16 + 1e-15 * angle);
        for (const double w : {0.0, 0.25, 0.5, 1.0, 1.5})
            EXPECT_LT((circle.at(w) - tilted(0.2 + w * angle)).norm(), 3e-16 + 2e-15 * angle) << angle << " " << w;
    }
}

TEST(GreatCircle, OfEqualVectorsStandsStill) {
    const Vector3d n = Vector3d(1, 2, 3).normalized();
    EXPECT_EQ(slerp(n, n, 0.7), n);
}

TEST(GreatCircle, StaysUnitInItsPlane) {
    const Vector3d a = Vector3d(1, 2, 3).normalized(), b = Vector3d(-2, 1, 0.5).normalized();
    for (const double w : {0.1, 0.5, 0.9}) {
        const Vector3d n = slerp(a, b, w);
        EXPECT_NEAR(n.norm(), 1, 1e-15);
        EXPECT_NEAR(n.dot(a.cross(b)), 0, 1e-15);
        EXPECT_NEAR(angle_between(a, n), w * angle_between(a, b), 1e-15);
    }
}

TEST(GreatCircle, SeriesAreItsDerivatives) {
    const GreatCircle circle(tilted(0), tilted(0.8));
    const auto n = circle.at(Taylor3(0.25, 1, 0, 0));  // (sin 0.8w, 0, cos 0.8w)
    const double s = std::sin(0.2), c = std::cos(0.2);
    EXPECT_NEAR(n[0].value(), s, 1e-15);
    EXPECT_NEAR(n[0].d1(), 0.8 * c, 1e-15);
    EXPECT_NEAR(n[2].d2(), -0.64 * c, 1e-15);
    EXPECT_NEAR(n[2].d3(), 0.512 * s, 1e-15);
}

}  // namespace
