#include "trunnion/geometry/helix.hpp"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "trunnion/geometry/rotation.hpp"

namespace trunnion::geometry {
namespace {

constexpr double pi = std::numbers::pi;

TEST(Helix, GoesFromStartToEndAboutItsLine) {
    const Eigen::Vector3d normal = Eigen::Vector3d(1, 2, 2) / 3, centre(4, -3, 2),
                          spoke = Eigen::Vector3d(2, 1, -2) * 5;
    const double angle = -4.5 * pi, climb = 12;
    const Eigen::Vector3d start = centre + spoke + 3 * normal;
    const Eigen::Vector3d end = centre + rotation_about(normal, angle) * spoke + (3 + climb) * normal;
    const Helix helix(start, end, centre, normal, angle);
    EXPECT_LT((helix.at(0) - start).norm(), 1e-13);
    EXPECT_LT((helix.at(1) - end).norm(), 1e-12);
    for (const double w : {0.1, 0.37, 0.9}) {
        const Eigen::Vector3d on = centre + rotation_about(normal, w * angle) * spoke + (3 + w * climb) * normal;
        EXPECT_LT((helix.at(w) - on).norm(), 1e-12);
    }
    EXPECT_NEAR(helix.length(), std::hypot(4.5 * pi * 15, climb), 1e-10);
}

TEST(Helix, SpiralChangesItsRadiusInProportion) {
    const Helix spiral({10, 0, 0}, {0, 12, 0}, {0, 0, 5}, {0, 0, 1}, pi / 2);
    EXPECT_NEAR(spiral.at(0.5).norm(), 11, 1e-12);
    EXPECT_LT((spiral.at(1) - Eigen::Vector3d(0, 12, 0)).norm(), 1e-12);
    double way = 0;
    for (int i = 0; i < 10000; ++i) way += (spiral.at((i + 1) / 1e4) - spiral.at(i / 1e4)).norm();
    EXPECT_NEAR(spiral.length(), way, 1e-3 * way);
}

TEST(Helix, SeriesAreItsDerivatives) {
    const Helix helix({10, 0, 0}, {-10.5, 0, 3}, {0, 0, 0}, {0, 0, 1}, 3 * pi);
    const double w = 0.3, h = 1e-3;
    const auto series = helix.at(Taylor3{w, 1, 0, 0});
    for (int k = 0; k < 3; ++k) {
        const auto f = [&](int n) { return helix.at(w + n * h)[k]; };
        EXPECT_NEAR(series[k].value(), f(0), 1e-12);
        EXPECT_NEAR(series[k].d1(), (8 * (f(1) - f(-1)) - f(2) + f(-2)) / (12 * h), 1e-5);
        EXPECT_NEAR(series[k].d2(), (16 * (f(1) + f(-1)) - 30 * f(0) - f(2) - f(-2)) / (12 * h * h), 1e-3);
        EXPECT_NEAR(series[k].d3(), (f(2) - 2 * f(1) + 2 * f(-1) - f(-2)) / (2 * h * h * h), 1);
    }
}

TEST(Helix, ChordErrorIsTheLargestDistanceFromChords) {
    const Helix circle({20, 0, 0}, {20, 0, 0}, {0, 0, 0}, {0, 0, 1}, 2 * pi);
    const int parts = 50;
    const Eigen::Vector3d middle = 0.5 * (circle.at(0) + circle.at(1.0 / parts));
    EXPECT_NEAR(circle.chord_error(parts), 20 - middle.norm(), 1e-12);
}

}  // namespace
}  // namespace trunnion::geometry
