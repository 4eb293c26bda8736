#include <gtest/gtest.h>

#include "trunnion/smoothing/smoothing.hpp"

#include "walk.hpp"

/// Corners::beudaert: lone corners among others.
namespace trunnion::smoothing {
namespace {

using namespace test;
using path::OrientationLaw;

SmoothingOptions handing_over(bool over = true) {
    SmoothingOptions o;
    o.tip_tolerance_mm = 0.01;
    if (over) o.corners = Corners::beudaert;
    return o;
}

std::vector<path::ToolPath> smoothed(const path::Run& run, const SmoothingOptions& options) {
    std::vector<path::ToolPath> out;
    smooth(run, options, out);
    return out;
}

/// Straight in, a corner, straight, a quarter circle of short blocks, straight, a corner, straight.
path::Run corners_and_curve() {
    std::vector<Pose> poses{{0, -20, 0, 0.3, 0.1, 0}, {0, 0, 0, 0.3, 0.1, 0}, {30, 0, 0, 0.32, 0.1, 0}};
    for (int i = 1; i <= 50; ++i) {
        const double turn = i * 1.8 * degree;
        poses.push_back({30 + 10 * std::sin(turn), 10 - 10 * std::cos(turn), 0, 0.32 + 0.002 * i, 0.1, 0});
    }
    poses.push_back({40, 40, 0, 0.45, 0.1, 0});
    poses.push_back({70, 40, 10, 0.4, 0.1, 0});
    return run_through(poses, OrientationLaw::rotary);
}

void expect_lawful(const Walk& w, const SmoothingOptions& o) {
    expect_bounded(w, o);
    EXPECT_LE(w.jump_to_c2, 1e-8);
}

TEST(HandedCorners, AreRoundedWithinTheTolerances) {
    const auto run = corners_and_curve();
    const Walk w = walk(run, smoothed(run, handing_over()));
    expect_lawful(w, handing_over());
    EXPECT_EQ(w.stretches, 1U);
    EXPECT_GE(w.tip_mm, 0.009);
    EXPECT_EQ(w.use.size(), run.blocks.size() - 1);
}

TEST(HandedCorners, LeaveTheRestAsItIs) {
    const auto run = corners_and_curve();
    const auto with = smoothed(run, handing_over()), without = smoothed(run, handing_over(false));
    ASSERT_EQ(with.size(), 1U);
    ASSERT_EQ(without.size(), 1U);
    ASSERT_EQ(with[0].blocks.size(), run.blocks.size());
    EXPECT_NEAR(with[0].length_mm(), without[0].length_mm(), 1e-9);
    const auto at = [](const path::ToolPath& path, double p) {
        const auto piece =
            std::ranges::find_if(path.pieces, [&](const path::PathPiece& x) { return p <= x.begin_mm + x.length_mm; });
        return derivative(*piece, p - piece->begin_mm, 0);
    };
    double near_corner = 0, in_curve = 0;
    const double corner = with[0].blocks[0].end_mm;
    for (double p = corner - 0.2; p <= corner + 0.2; p += 0.01) {
        const Pose a = at(with[0], p), b = at(without[0], p);
        near_corner = std::max(near_corner, std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]));
    }
    for (double p = with[0].blocks[10].begin_mm; p <= with[0].blocks[40].begin_mm; p += 0.05) {
        const Pose a = at(with[0], p), b = at(without[0], p);
        in_curve = std::max(in_curve, std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]));
    }
    EXPECT_GT(near_corner, 1e-4);
    EXPECT_LT(in_curve, 2e-4);
}

TEST(HandedCorners, BetweenTurningVectorsAreC2) {
    const auto pose = [](double x, double y, double a_deg, double c_deg) {
        const double a = a_deg * degree, c = c_deg * degree;
        return Pose{x, y, 0, std::sin(a) * std::cos(c), std::sin(a) * std::sin(c), std::cos(a)};
    };
    const auto run = run_through({pose(0, 0, 9, -90), pose(60, 0, 14, -40), pose(60, 50, 11, 10), pose(10, 60, 15, 70)},
                                 OrientationLaw::vector);
    const Walk w = walk(run, smoothed(run, handing_over()));
    expect_lawful(w, handing_over());
    EXPECT_EQ(w.stretches, 1U);
}

TEST(HandedCorners, OfRandomRunsKeepTheTolerances) {
    Random random(20131);
    for (int k = 0; k < 60; ++k) {
        std::vector<Pose> poses;
        Eigen::Vector3d at = Eigen::Vector3d::Zero();
        double a = 0.4, c = 0.2;
        for (int i = 0; i < 30; ++i) {
            poses.push_back({at.x(), at.y(), at.z(), a, c, 0});
            const double scale = std::pow(10, random.uniform(-1, 1.5));
            for (int j = 0; j < 3; ++j) at[j] += scale * random.uniform(-0.2, 1);
            a += 0.02 * random.uniform(-1, 1);
            c += 0.05 * random.uniform(-1, 1);
        }
        const auto run = run_through(poses, OrientationLaw::rotary);
        expect_lawful(walk(run, smoothed(run, handing_over())), handing_over());
        if (::testing::Test::HasFailure()) FAIL() << "run " << k;
    }
}

}  // namespace
}  // namespace trunnion::smoothing
