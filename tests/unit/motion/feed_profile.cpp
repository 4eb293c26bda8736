#include "trunnion/motion/feed_profile.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace trunnion::motion {
namespace {

ProfilePiece rest(ProfilePiece::Kind kind, double length, double jerk) {
    ProfilePiece out;
    out.kind = kind;
    out.length_mm = length;
    out.jerk_mm_s3 = jerk;
    return out;
}

ProfilePiece cubic(double length, double x0, double d0, double e0, double e1) {
    ProfilePiece out;
    out.length_mm = length;
    out.x0 = x0;
    out.d0 = d0;
    out.e0 = e0;
    out.e1 = e1;
    return out;
}

TEST(FeedProfile, RestArcsHaveConstantJerk) {
    const auto start = rest(ProfilePiece::Kind::rest_start, 1, 6);
    EXPECT_DOUBLE_EQ(time_to(start, 1), 1);
    EXPECT_NEAR(distance_at(start, 0.5), 0.125, 1e-15);
    const PathState middle = state_at(start, 0.125);
    EXPECT_NEAR(middle.speed_mm_s, 0.75, 1e-14);
    EXPECT_NEAR(middle.acceleration_mm_s2, 3, 1e-14);
    EXPECT_DOUBLE_EQ(middle.jerk_mm_s3, 6);
    EXPECT_EQ(state_at(start, 0).speed_mm_s, 0);
}

TEST(FeedProfile, StopMirrorsStart) {
    const auto stop = rest(ProfilePiece::Kind::rest_stop, 1, 6);
    EXPECT_NEAR(distance_at(stop, 0.5), 0.875, 1e-15);
    EXPECT_NEAR(time_to(stop, 0.875), 0.5, 1e-15);
    EXPECT_LT(state_at(stop, 0.5).acceleration_mm_s2, 0);
    EXPECT_EQ(state_at(stop, 1).speed_mm_s, 0);
    EXPECT_DOUBLE_EQ(state_at(stop, 1).jerk_mm_s3, 6);
}

// x linear in p is constant acceleration: t = 2(√x1 − √x0)/x′.
TEST(FeedProfile, LinearSquareIsConstantAcceleration) {
    for (const double ratio : {1.01, 2.0, 10.0, 1e4}) {
        const auto piece = cubic(3, 4, 4 * (ratio - 1) / 3, 0, 0);
        for (const double part : {0.1, 0.5, 1.0}) {
            const double x1 = 4 + piece.d0 * 3 * part, exact = 2 * (std::sqrt(x1) - 2) / piece.d0;
            EXPECT_NEAR(time_to(piece, 3 * part) / exact, 1, ratio < 1.1 ? 1e-12 : 2e-13) << ratio << ' ' << part;
        }
    }
}

TEST(FeedProfile, DistanceInvertsTime) {
    for (const auto& piece : {cubic(2, 100, 30, -20, 15), cubic(1e-7, 1e-6, 3, 1e6, -1e6), cubic(5, 1e4, -1900, 0, 0),
                              cubic(3, 1, 20, -8, 4)})
        for (int k = 0; k <= 20; ++k) {
            const double delta = piece.length_mm * k / 20;
            EXPECT_NEAR(distance_at(piece, time_to(piece, delta)), delta, 1e-13 * piece.length_mm);
        }
}

TEST(FeedProfile, DistanceStaysInThePiece) {
    const auto piece = cubic(2, 100, 30, -20, 15);
    EXPECT_EQ(distance_at(piece, -1), 0);
    EXPECT_EQ(distance_at(piece, 1e9), 2);
    EXPECT_EQ(distance_at(rest(ProfilePiece::Kind::rest_stop, 1, 6), 1e9), 1);
}

TEST(FeedProfile, StateIsTheDerivativeOfTheMotion) {
    const auto piece = cubic(2, 100, 30, -20, 15);
    const double t = time_to(piece, 0.9), h = 1e-3;
    double p[5];
    for (int k = 0; k < 5; ++k) p[k] = distance_at(piece, t + (k - 2) * h);
    const PathState s = state_at(piece, p[2]);
    EXPECT_NEAR((p[3] - p[1]) / (2 * h), s.speed_mm_s, 1e-3);
    EXPECT_NEAR((p[3] - 2 * p[2] + p[1]) / (h * h), s.acceleration_mm_s2, 1e-2);
    EXPECT_NEAR((p[4] - 2 * p[3] + 2 * p[1] - p[0]) / (2 * h * h * h), s.jerk_mm_s3, 0.01 * std::abs(s.jerk_mm_s3) + 1);
}

}  // namespace
}  // namespace trunnion::motion
