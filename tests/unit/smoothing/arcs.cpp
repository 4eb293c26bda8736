#include <gtest/gtest.h>

#include "trunnion/smoothing/smoothing.hpp"

#include "walk.hpp"

namespace trunnion::smoothing {
namespace {

using namespace test;
using path::OrientationLaw;

constexpr double pi = std::numbers::pi;

std::vector<path::ToolPath> smoothed(const path::Run& run, const SmoothingOptions& options) {
    std::vector<path::ToolPath> out;
    smooth(run, options, out);
    return out;
}

void expect_kept(const Walk& w, const SmoothingOptions& o) {
    EXPECT_TRUE(w.finite);
    EXPECT_LE(w.over_tip, 1e-9) << "the bound does not hold";
    EXPECT_LE(w.over_turn, 1e-9);
    EXPECT_LE(w.bound_tip_mm, o.tip_tolerance_mm);
    EXPECT_LE(w.bound_turn_rad, o.orientation_tolerance_rad);
    EXPECT_LE(w.jump, 1e-9) << "not C3";
    EXPECT_LE(w.end_miss, 1e-9);
}

/// 30 mm straight, a quarter of radius r, 30 mm straight, all tangent.
path::Run quarter(double r, OrientationLaw law = OrientationLaw::vector, Pose turned = {0, 0, 0, 0, 0, 1}) {
    std::vector<Pose> poses(4, turned);
    const double xy[4][2] = {{-30, 0}, {0, 0}, {r, r}, {r, r + 30}};
    for (int i = 0; i < 4; ++i) poses[i][0] = xy[i][0], poses[i][1] = xy[i][1], poses[i][2] = 0;
    path::Run run = run_through(poses, law);
    make_arc(run, 1, {0, r, 7}, Eigen::Vector3d::UnitZ(), pi / 2);
    return run;
}

TEST(Arc, BetweenTangentLinesIsOneStretchWithinTolerance) {
    for (const double r : {0.5, 2.0, 10.0, 200.0}) {
        const auto run = quarter(r);
        const SmoothingOptions options;
        const Walk w = walk(run, smoothed(run, options));
        expect_kept(w, options);
        EXPECT_EQ(w.stretches, 1U);
        EXPECT_GE(w.tip_mm, r < 100 ? 0.3 * options.tip_tolerance_mm : 0) << "r = " << r;
    }
}

TEST(Arc, StaysAnArcAwayFromItsEnds) {
    for (const double r : {1.0, 4.0, 30.0}) {
        auto run = run_through({{-30, 0, 0, 0, 0, 1}, {0, 0, 0, 0, 0, 1}, {0, 0, 0, 0, 0, 1}}, OrientationLaw::vector);
        make_arc(run, 1, {0, r, 0}, Eigen::Vector3d::UnitZ(), 2 * pi);
        const SmoothingOptions options;
        const auto paths = smoothed(run, options);
        ASSERT_EQ(paths.size(), 1U);
        expect_kept(walk(run, paths), options);
        for (const auto& piece : paths[0].pieces) {
            const double from_middle = std::abs(piece.begin_mm + 0.5 * piece.length_mm - 30 - pi * r);
            if (from_middle > 0.25 * pi * r) continue;
            for (int k = 0; k <= 8; ++k) {
                const double offset = piece.length_mm * k / 8;
                const Pose c = derivative(piece, offset, 0), bend = derivative(piece, offset, 2),
                           change = derivative(piece, offset, 3);
                EXPECT_NEAR(std::hypot(c[0], c[1] - r), r, options.tip_tolerance_mm / 20);
                EXPECT_NEAR(std::hypot(bend[0], bend[1]) * r, 1, 1e-3);
                EXPECT_NEAR(std::hypot(change[0], change[1]) * r * r, 1, 1e-2);
            }
        }
    }
}

TEST(Arc, FullTurnsOfAHelixWhileTheVectorTurns) {
    std::vector<Pose> poses{{10, 0, 0, 0, 0, 1}, {10, 0, -6, 0, std::sin(0.4), std::cos(0.4)}, {10, 20, -6, 0, 0, 1}};
    auto run = run_through(poses, OrientationLaw::vector);
    make_arc(run, 0, {0, 0, 0}, Eigen::Vector3d::UnitZ(), 6 * pi);
    const SmoothingOptions options;
    const auto paths = smoothed(run, options);
    expect_kept(walk(run, paths), options);
    EXPECT_NEAR(paths[0].length_mm(), run.blocks[0].length_mm + run.blocks[1].length_mm, 1e-9);
    EXPECT_GT(run.blocks[0].length_mm, 60 * pi);
}

TEST(Arc, RotaryAxesTurnAlongIt) {
    std::vector<Pose> poses{{10, 0, 0, 0.2, 0, 0}, {-10, 0, 0, 0.5, 2.0, 0}, {-10, -20, 0, 0.2, 2.2, 0}};
    auto run = run_through(poses, OrientationLaw::rotary);
    make_arc(run, 0, {0, 0, 0}, Eigen::Vector3d::UnitZ(), -pi);
    const SmoothingOptions options;
    const auto paths = smoothed(run, options);
    expect_kept(walk(run, paths), options);
    ASSERT_EQ(paths.size(), 1U);
    EXPECT_LT(derivative(paths[0].pieces[paths[0].pieces.size() / 4], 0, 0)[1], 0) << "clockwise seen from +Z";
}

TEST(Arc, InATiltedPlaneAndInMachineSpace) {
    const Eigen::Vector3d normal = Eigen::Vector3d(1, 2, 2) / 3;
    const Eigen::Vector3d spoke = Eigen::Vector3d(2, 1, -2) / 3 * 15, side = normal.cross(spoke);
    const Eigen::Vector3d before = spoke - 4 * side;
    const auto pose = [](const Eigen::Vector3d& x) { return Pose{x.x(), x.y(), x.z(), 0, 0, 0}; };
    auto run = run_through({pose(before), pose(spoke), pose(-spoke), pose(-spoke + 3 * side)}, OrientationLaw::rotary,
                           path::Space::machine);
    make_arc(run, 1, {0, 0, 0}, normal, -pi);
    const SmoothingOptions options;
    expect_kept(walk(run, smoothed(run, options)), options);
    EXPECT_NEAR(run.blocks[1].length_mm, 15 * pi, 1e-9);
}

TEST(Arc, AloneOrWithoutRoundingItIsExact) {
    const auto run = quarter(25);
    SmoothingOptions options;
    options.rounding = Rounding::none;
    const auto paths = smoothed(run, options);
    ASSERT_EQ(paths.size(), 3U) << "curvature jumps at both ends of the arc: exact stops";
    const Walk w = walk(run, paths);
    EXPECT_LE(w.bound_tip_mm, 1e-8);
    EXPECT_LE(w.tip_mm, 1e-8);
    EXPECT_LE(w.jump, 1e-9);
}

TEST(Arc, ManySmallOnesAreSmoothedTogether) {
    std::vector<Pose> poses{{0, 0, 0, 0, 0, 1}};
    for (int i = 1; i <= 40; ++i) poses.push_back({2.0 * i, 0, 0, 0, 0, 1});
    auto run = run_through(poses, OrientationLaw::vector);
    for (std::size_t i = 0; i < 40; ++i)
        make_arc(run, i, {2.0 * static_cast<double>(i) + 1, i % 2 ? 5.0 : -5.0, 0}, Eigen::Vector3d::UnitZ(),
                 (i % 2 ? 2 : -2) * std::asin(1 / std::hypot(1.0, 5.0)));
    const SmoothingOptions options;
    const auto paths = smoothed(run, options);
    const Walk w = walk(run, paths);
    expect_kept(w, options);
    EXPECT_EQ(w.stretches, 1U);
}

}  // namespace
}  // namespace trunnion::smoothing
