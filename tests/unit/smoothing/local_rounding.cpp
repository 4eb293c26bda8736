#include <gtest/gtest.h>

#include "trunnion/smoothing/smoothing.hpp"

#include "walk.hpp"

/// Rounding::beudaert: every corner on its own.
namespace trunnion::smoothing {
namespace {

using namespace test;
using path::OrientationLaw;
using path::StopCause;

SmoothingOptions local(Link link = Link::optimised) {
    SmoothingOptions o;
    o.rounding = Rounding::beudaert;
    o.link = link;
    o.tip_tolerance_mm = 0.02;
    return o;
}

SmoothingOptions flank() {
    SmoothingOptions o = local();
    o.flank_tolerance_mm = 0.02;
    o.flank_height_mm = 50;
    return o;
}

std::vector<path::ToolPath> rounded(const path::Run& run, const SmoothingOptions& options) {
    std::vector<path::ToolPath> out;
    smooth(run, options, out);
    return out;
}

/// `c2`: pieces a thousandth as long as their corner feel the rounding of coordinates.
Walk expect_lawful(const path::Run& run, const SmoothingOptions& o, double c2 = 1e-9) {
    const Walk w = walk(run, rounded(run, o), o.flank_height_mm, o.controlled_height_mm, 24);
    expect_bounded(w, o);
    EXPECT_LE(w.jump_to_c2, c2) << "not C2";
    EXPECT_LE(w.end_second, 1e-8);
    return w;
}

Pose leaning(double x, double y, double z, double a_deg, double towards_deg) {
    const double a = a_deg * degree, c = towards_deg * degree;
    return {x, y, z, std::sin(a) * std::cos(c), std::sin(a) * std::sin(c), std::cos(a)};
}

path::Run pocket_corner() {
    return run_through({leaning(0, 0, 0, 9, -90), leaning(70, 0, 5, 14, -40), leaning(75, 55, 0, 11, 10)},
                       OrientationLaw::vector);
}

path::Run rotary_corner() {
    return run_through({{0, 0, 0, 0.3, 0.1, 0}, {40, 0, 0, 0.35, 0.2, 0}, {40, 30, 5, 0.5, 0.25, 0}},
                       OrientationLaw::rotary);
}

TEST(LocalRounding, UsesTheToleranceOfALoneCorner) {
    for (const auto& run : {pocket_corner(), rotary_corner(), upright({{0, 0, 0}, {60, 0, 0}, {60, 60, 0}})}) {
        const Walk w = expect_lawful(run, local());
        EXPECT_EQ(w.stretches, 1U);
        EXPECT_GE(w.tip_mm, 0.018);
    }
}

TEST(LocalRounding, HoldsTheFlankTolerance) {
    const Walk w = expect_lawful(pocket_corner(), flank());
    EXPECT_GE(w.height_mm, 0.01);
}

TEST(LocalRounding, HoldsTheControlledPoint) {
    SmoothingOptions o = local();
    o.controlled_height_mm = 5;
    expect_lawful(pocket_corner(), o);
}

TEST(LocalRounding, TakesAtMostHalfOfTheShorterBlock) {
    const auto paths = rounded(upright({{0, 0, 0}, {1, 0, 0}, {1, 0.3, 0}, {2, 0.3, 0}}), [] {
        SmoothingOptions o = local();
        o.tip_tolerance_mm = 5;
        return o;
    }());
    ASSERT_EQ(paths.size(), 1U);
    for (const auto& piece : paths[0].pieces) {
        const auto at = path::evaluate(piece, 0.5 * piece.length_mm);
        const double curved = std::abs(at[0].c[2]) + std::abs(at[1].c[2]);
        const double p = piece.begin_mm + 0.5 * piece.length_mm;
        if (p > 0.85 && p < 1.45) continue;
        EXPECT_LT(curved, 1e-9) << p;
    }
}

TEST(LocalRounding, OfCollinearBlocksLeavesThePathStraight) {
    std::vector<Pose> poses;
    for (int i = 0; i <= 40; ++i) poses.push_back({0.25 * i, 0.1 * i, 0, 0.3 + 0.01 * i, 0.1, 0});
    const auto run = run_through(poses, OrientationLaw::rotary);
    const Walk w = expect_lawful(run, local());
    EXPECT_LT(w.tip_mm, 1e-9);
    EXPECT_LT(w.turn_rad, 1e-9);
}

TEST(LocalRounding, OfEqualBlocksLeavesNoSlivers) {
    std::vector<Pose> poses;
    for (int i = 0; i <= 20; ++i) {
        const double a = 0.1 * i;
        poses.push_back({10 * std::sin(a), 10 * std::cos(a), std::round(1e9 * 0.01 * a) * 1e-9, 0.3 + 0.02 * i, 0, 0});
    }
    const auto paths = rounded(run_through(poses, OrientationLaw::rotary), local());
    ASSERT_EQ(paths.size(), 1U);
    for (const auto& piece : paths[0].pieces) EXPECT_GT(piece.length_mm, 1e-3);
}

TEST(LocalRounding, DividesBlocksThatTurnFar) {
    expect_lawful(run_through({leaning(0, 0, 0, 5, 0), leaning(30, 0, 0, 60, 20), leaning(30, 40, 0, 10, 90)},
                              OrientationLaw::vector),
                  local());
}

TEST(LocalRounding, KeepsArcsWithinTheTolerance) {
    path::Run run = upright({{0, 0, 0}, {20, 0, 0}, {20, 20, 0}, {0, 20, 0}});
    make_arc(run, 1, {20, 10, 0}, {0, 0, 1}, std::numbers::pi);
    expect_lawful(run, local());
}

TEST(LocalRounding, InMachineSpaceCountsTheArm) {
    const auto run = run_through({{0, 0, 0, 0.3, 0.1, 0}, {40, 0, 0, 0.35, 0.2, 0}, {40, 30, 5, 0.5, 0.25, 0}},
                                 OrientationLaw::rotary, path::Space::machine);
    expect_lawful(run, local());
}

TEST(LocalRounding, OfRotaryWordsAtThePoleKeepsTheTolerances) {
    const auto run =
        run_through({{0, 0, 0, 0, 0, 0}, {20, 0, 0, 0, 0.8, 0}, {20, 20, 0, 0, 0.5, 0}, {40, 20, 0, 0.1, 0.5, 0}},
                    OrientationLaw::rotary);
    const Walk w = expect_lawful(run, local());
    EXPECT_EQ(w.stretches, 1U);
}

TEST(LocalRounding, StandsStillAtReversalsAndWhereTheTipDoes) {
    const auto back = rounded(upright({{0, 0, 0}, {50, 0, 0}, {10, 0, 0}}), local());
    ASSERT_EQ(back.size(), 2U);
    EXPECT_EQ(back[0].stop, StopCause::reversal);
    const auto turn = rounded(
        run_through({{0, 0, 0, 0.3, 0, 0}, {40, 0, 0, 0.3, 0, 0}, {40, 0, 0, 0.6, 0, 0}}, OrientationLaw::rotary),
        local());
    ASSERT_EQ(turn.size(), 2U);
    EXPECT_EQ(turn[0].stop, StopCause::corner);
    EXPECT_EQ(turn[1].blocks.front().run_block, 1U);
}

TEST(LinearLink, StandsStillWhereTheTurningSpeedJumps) {
    const auto run = pocket_corner();
    const auto paths = rounded(run, local(Link::linear));
    ASSERT_EQ(paths.size(), 3U);
    EXPECT_EQ(paths[0].stop, StopCause::corner);
    EXPECT_EQ(paths[1].stop, StopCause::corner);
    EXPECT_EQ(paths[2].stop, run.stop);
    EXPECT_EQ(paths[0].blocks.size(), 1U);
    EXPECT_EQ(paths[1].blocks.size(), 2U);
    EXPECT_EQ(paths[2].blocks.front().run_block, 1U);
    double length = 0;
    for (const auto& path : paths) length += path.length_mm();
    EXPECT_NEAR(length, run.blocks[0].length_mm + run.blocks[1].length_mm, 1e-9);
}

TEST(LinearLink, GoesThroughWhereTheToolDoesNotTurn) {
    EXPECT_EQ(rounded(upright({{0, 0, 0}, {60, 0, 0}, {60, 60, 0}}), local(Link::linear)).size(), 1U);
}

TEST(LocalRounding, OfRandomCornersIsC2WithinTheTolerances) {
    Random random(20130509);
    for (int k = 0; k < 150; ++k) {
        std::vector<Pose> poses;
        Eigen::Vector3d at = Eigen::Vector3d::Zero();
        double a = 0.4, c = 0;
        const double scale = std::pow(10, random.uniform(-1.5, 1.5));
        for (int i = 0; i < 8; ++i) {
            poses.push_back(k % 2 == 0 ? leaning(at.x(), at.y(), at.z(), a / degree, c / degree)
                                       : Pose{at.x(), at.y(), at.z(), a, c, 0});
            for (int j = 0; j < 3; ++j) at[j] += scale * random.uniform(-1, 1);
            a += 0.1 * random.uniform(-1, 1);
            c += 0.2 * random.uniform(-1, 1);
        }
        const auto run = run_through(poses, k % 2 == 0 ? OrientationLaw::vector : OrientationLaw::rotary);
        expect_lawful(run, k % 3 == 0 ? flank() : local(), 1e-8);
        if (::testing::Test::HasFailure()) FAIL() << "run " << k;
    }
}

}  // namespace
}  // namespace trunnion::smoothing
