#include "trunnion/smoothing/smoothing.hpp"

#include <gtest/gtest.h>

#include "walk.hpp"

namespace trunnion::smoothing {
namespace {

using namespace test;
using path::OrientationLaw;
using path::StopCause;

SmoothingOptions tight() {
    SmoothingOptions o;
    o.tip_tolerance_mm = 0.01;
    return o;
}

std::vector<path::ToolPath> smoothed(const path::Run& run, const SmoothingOptions& options) {
    std::vector<path::ToolPath> out;
    smooth(run, options, out);
    return out;
}

Walk walked(const path::Run& run, const SmoothingOptions& o) {
    return walk(run, smoothed(run, o), o.flank_height_mm, o.controlled_height_mm);
}

/// What every smoothed run must keep, whatever it is.
void expect_lawful(const Walk& w, const SmoothingOptions& o) {
    expect_bounded(w, o);
    EXPECT_LE(w.jump, 1e-9) << "not C3";
    EXPECT_GT(w.least_speed, 0.05);
    EXPECT_LE(w.end_second, 1e-8);
}

double median(std::vector<float> use) {
    if (use.empty()) return 0;
    std::nth_element(use.begin(), use.begin() + static_cast<std::ptrdiff_t>(use.size() / 2), use.end());
    return use[use.size() / 2];
}

TEST(LoneCorner, UsesTheTipTolerance) {
    const auto run = upright({{0, 0, 0}, {60, 0, 0}, {60, 60, 0}});
    const Walk w = walked(run, tight());
    expect_lawful(w, tight());
    EXPECT_EQ(w.stretches, 1U);
    EXPECT_GE(w.tip_mm, 0.009);
    EXPECT_LE(w.bound_tip_mm, 1.02 * w.tip_mm);
    ASSERT_EQ(w.use.size(), 1U);
    EXPECT_GE(w.use[0], 0.9);
    EXPECT_LE(w.use[0], 1);
}

TEST(LoneCorner, UsesTheOrientationTolerance) {
    const std::vector<Pose> poses{{0, 0, 0, 0.1, 0.3}, {20, 0, 0, 0.6, 0.3}, {40, 0, 0, 0.1, 0.3}};
    const auto run = run_through(poses, OrientationLaw::rotary);
    SmoothingOptions o;
    o.tip_tolerance_mm = 1;  // a tool that lags behind its tip is a tip deviation at the place that fits the tool best
    const Walk w = walked(run, o);
    expect_lawful(w, o);
    EXPECT_GE(w.turn_rad, 0.9 * o.orientation_tolerance_rad);
    EXPECT_LT(w.tip_mm, 1e-9);
}

TEST(LoneCorner, UsesTheFlankTolerance) {
    SmoothingOptions o = tight();
    o.tip_tolerance_mm = 1;
    o.flank_tolerance_mm = 0.05;
    o.flank_height_mm = 40;
    const double s = std::sin(0.3), c = std::cos(0.3);
    const auto run =
        run_through({{0, 0, 0, s, 0, c}, {50, 0, 0, 0, 0, 1}, {50, 50, 0, 0, s, c}}, OrientationLaw::vector);
    const Walk w = walked(run, o);
    expect_lawful(w, o);
    EXPECT_GE(w.height_mm, 0.04);
    EXPECT_GE(w.use[0], 0.9);
}

TEST(LoneCorner, ControlledPointMayBeUpTheTool) {
    SmoothingOptions o = tight();
    o.controlled_height_mm = 20;
    o.orientation_tolerance_rad = 0.1;
    const double s = std::sin(0.3), c = std::cos(0.3);
    const auto run =
        run_through({{0, 0, 0, s, 0, c}, {50, 0, 0, 0, 0, 1}, {100, 0, 0, s, 0, c}}, OrientationLaw::vector);
    const Walk w = walked(run, o);
    expect_lawful(w, o);
    EXPECT_GE(w.tip_mm, 0.007);
    EXPECT_GE(w.use[0], 0.9);
}

TEST(LoneCorner, LargeToleranceIsUsedToo) {
    SmoothingOptions o;
    o.tip_tolerance_mm = 1;
    const Walk w = walked(upright({{0, 0, 0}, {60, 0, 0}, {60, 60, 0}}), o);
    expect_lawful(w, o);
    EXPECT_GE(w.tip_mm, 0.9);
}

TEST(LoneCorner, SlightCornerToo) {
    const double a = 2 * degree;
    const Walk w = walked(upright({{0, 0, 0}, {60, 0, 0}, {60 + 60 * std::cos(a), 60 * std::sin(a), 0}}), tight());
    expect_lawful(w, tight());
    EXPECT_GE(w.tip_mm, 0.009);
}

TEST(DenseCorner, IsRoundedAsACorner) {
    std::vector<std::array<double, 3>> points;
    for (int i = 0; i <= 300; ++i) points.push_back({0.1 * i, 0, 0});
    for (int i = 1; i <= 300; ++i) points.push_back({30, 0.1 * i, 0});
    const Walk w = walked(upright(points), tight());
    expect_lawful(w, tight());
    EXPECT_EQ(w.stretches, 1U);
    EXPECT_GE(w.tip_mm, 0.009);
    EXPECT_LT(w.pieces, 80U);
}

TEST(DenseCurve, RoundingNoiseIsSmoothedAway) {
    Random random(7);
    std::vector<std::array<double, 3>> points;
    const auto decimals = [](double x) { return std::round(x * 1000) / 1000; };
    for (int i = 0; i <= 600; ++i) {
        const double angle = i * 0.1 / 100;
        points.push_back({decimals(100 * std::sin(angle)), decimals(100 * (1 - std::cos(angle))), 0});
    }
    const auto run = upright(points);
    const auto paths = smoothed(run, tight());
    ASSERT_EQ(paths.size(), 1U);
    expect_lawful(walk(run, paths), tight());
    // The curvature of the smoothed path is that of the arc, though the blocks' directions jump by 0.01 rad.
    double worst = 0;
    for (const auto& piece : paths[0].pieces) {
        if (piece.begin_mm < 7 || piece.begin_mm > 53) continue;
        const Pose second = derivative(piece, 0.5 * piece.length_mm, 2);
        worst = std::max(worst, std::abs(std::hypot(second[0], second[1]) - 0.01));
    }
    EXPECT_LT(worst, 0.0005);
}

TEST(Straight, CollinearBlocksStayOneStraightStretch) {
    Random random(3);
    std::vector<std::array<double, 3>> points{{0, 0, 0}};
    while (points.size() < 2000) {
        const double step = random.uniform(0.05, 3);
        const auto& q = points.back();
        points.push_back({q[0] + step, q[1] + 2 * step, q[2] - step});
    }
    const auto run = upright(points);
    for (const Rounding rounding : {Rounding::smooth, Rounding::none}) {
        SmoothingOptions o = tight();
        o.rounding = rounding;
        const Walk w = walked(run, o);
        EXPECT_EQ(w.stretches, 1U);
        EXPECT_LT(w.tip_mm, 1e-9);
        EXPECT_LE(w.jump, 1e-9);
    }
}

TEST(Reversal, SplitsTheRun) {
    const auto run = upright({{0, 0, 0}, {50, 0, 0}, {10, 0, 0}, {10, 40, 0}});
    const auto paths = smoothed(run, tight());
    ASSERT_EQ(paths.size(), 2U);
    EXPECT_EQ(paths[0].stop, StopCause::reversal);
    EXPECT_EQ(paths[0].blocks.size(), 1U);
    EXPECT_EQ(paths[1].stop, run.stop);
    EXPECT_EQ(paths[1].blocks.front().run_block, 1U);
    expect_lawful(walk(run, paths), tight());
}

TEST(Reversal, MadeOfShortBlocksSplitsTheRun) {
    const auto run = upright({{0, 0, 0}, {50, 0, 0}, {50.0001, 0.0001, 0}, {50, 0.0002, 0}, {0, 0.0002, 0}});
    const auto paths = smoothed(run, tight());
    EXPECT_EQ(paths.size(), 2U);
    expect_lawful(walk(run, paths), tight());
}

TEST(Reversal, OfTheTipAloneGoesOnWhileTheToolTurns) {
    const auto run = run_through({{0, 0, 0, 0.1, 0}, {10, 0, 0, 0.9, 0}, {0, 0, 0, 1.7, 0}}, OrientationLaw::rotary);
    const auto paths = smoothed(run, tight());
    EXPECT_EQ(paths.size(), 1U);
    expect_lawful(walk(run, paths), tight());
}

TEST(Reversal, SharpCornerShortOfItGoesOn) {
    const double a = 160 * degree;
    const auto run = upright({{0, 0, 0}, {50, 0, 0}, {50 + 50 * std::cos(a), 50 * std::sin(a), 0}});
    const auto paths = smoothed(run, tight());
    EXPECT_EQ(paths.size(), 1U);
    expect_lawful(walk(run, paths), tight());
}

TEST(None, StopsExactlyAtEveryCorner) {
    SmoothingOptions o;
    o.rounding = Rounding::none;
    const auto run = upright({{0, 0, 0}, {10, 0, 0}, {20, 0, 0}, {20, 10, 0}, {20, 20, 1}});
    const auto paths = smoothed(run, o);
    ASSERT_EQ(paths.size(), 3U);
    EXPECT_EQ(paths[0].blocks.size(), 2U) << "a straight continuation is no corner";
    EXPECT_EQ(paths[0].stop, StopCause::corner);
    EXPECT_EQ(paths[2].stop, run.stop);
    const Walk w = walk(run, paths);
    EXPECT_LT(w.tip_mm, 1e-12);
    EXPECT_EQ(w.bound_tip_mm, 0);
}

TEST(None, VectorLawFollowsTheGreatCircle) {
    SmoothingOptions o;
    o.rounding = Rounding::none;
    const auto run =
        run_through({{0, 0, 0, 0, 0, 1}, {10, 0, 0, 1, 0, 0}, {10, 5, 3, 0, -0.6, 0.8}}, OrientationLaw::vector);
    const Walk w = walked(run, o);
    EXPECT_EQ(w.stretches, 2U);
    EXPECT_LT(w.turn_rad, 1e-10);
    EXPECT_LE(w.over_turn, 1e-14);
    EXPECT_LE(w.jump, 1e-9);
    EXPECT_GT(w.axis_length, 1 - 1e-9);
}

TEST(None, ToleranceOfNothingMeansNone) {
    SmoothingOptions o;
    o.tip_tolerance_mm = 0;
    EXPECT_EQ(smoothed(upright({{0, 0, 0}, {10, 0, 0}, {10, 10, 0}}), o).size(), 2U);
}

TEST(Rapid, IsKeptAsItIs) {
    path::Run run = upright({{0, 0, 0}, {100, 20, 5}});
    run.rapid = true;
    run.stop = StopCause::rapid;
    const auto paths = smoothed(run, tight());
    ASSERT_EQ(paths.size(), 1U);
    EXPECT_TRUE(paths[0].rapid);
    EXPECT_EQ(paths[0].stop, StopCause::rapid);
    EXPECT_EQ(paths[0].pieces.size(), 1U);
}

TEST(Blocks, KeepTheirNumbersBehindDoubledPoints) {
    const auto run = upright({{0, 0, 0}, {10, 0, 0}, {10, 0, 0}, {10, 0, 0}, {10, 20, 0}, {10, 20, 0}});
    const auto paths = smoothed(run, tight());
    ASSERT_EQ(paths.size(), 1U);
    ASSERT_EQ(paths[0].blocks.size(), 2U);
    EXPECT_EQ(paths[0].blocks[0].run_block, 0U);
    EXPECT_EQ(paths[0].blocks[1].run_block, 3U);
}

TEST(Blocks, AreCarriedAlong) {
    path::Run run = upright({{0, 0, 0}, {10, 0, 0}, {10, 20, 0}, {40, 20, 0}});
    run.blocks[1].feed = {program::FeedRule::block_time, 2.5};
    const auto paths = smoothed(run, tight());
    ASSERT_EQ(paths.size(), 1U);
    const auto& blocks = paths[0].blocks;
    ASSERT_EQ(blocks.size(), 3U);
    EXPECT_EQ(blocks[2].run_block, 2U);
    EXPECT_EQ(blocks[1].feed, run.blocks[1].feed);
    EXPECT_EQ(blocks[2].line, run.blocks[2].line);
    EXPECT_DOUBLE_EQ(blocks[1].begin_mm, 10);
    EXPECT_DOUBLE_EQ(blocks[1].end_mm, 30);
    EXPECT_DOUBLE_EQ(blocks[1].time_scale_mm, 20);
    EXPECT_EQ(blocks.back().end_mm, paths[0].length_mm());
}

TEST(MachineSpace, LinearAxesAloneMoveTheTipAsMuch) {
    const auto run = run_through({{0, 0, 0, 0.4, 1}, {30, 0, 0, 0.4, 1}, {30, 30, 0, 0.4, 1}}, OrientationLaw::rotary,
                                 path::Space::machine);
    const Walk w = walked(run, tight());
    expect_lawful(w, tight());
    EXPECT_GE(w.tip_mm, 0.009);
}

TEST(MachineSpace, RotaryAxesCountWithTheirArm) {
    const auto run =
        run_through({{200, 0, 0, 0, 0}, {200, 0, 0, 0.5, 0.2}, {200, 20, 0, 0.2, 0.8}, {180, 50, -5, 0.2, 0.8}},
                    OrientationLaw::rotary, path::Space::machine);
    const Walk w = walked(run, tight());
    expect_lawful(w, tight());
    EXPECT_GE(w.tip_mm, 0.002) << "far too careful";
}

TEST(Degenerate, OppositeVectorsStayFinite) {
    const auto run =
        run_through({{0, 0, 0, 0, 0, 1}, {10, 0, 0, 0, 0, -1}, {20, 1, 0, 0, 0, 1}}, OrientationLaw::vector);
    for (const Rounding rounding : {Rounding::smooth, Rounding::none}) {
        SmoothingOptions o = tight();
        o.rounding = rounding;
        const Walk w = walked(run, o);
        EXPECT_TRUE(w.finite);
        EXPECT_GT(w.axis_length, 0.9);
    }
}

TEST(Degenerate, DoubledPointsAreDropped) {
    path::Run run = upright({{0, 0, 0}, {10, 0, 0}, {10, 0, 0}, {10, 10, 0}, {10, 10, 0}});
    const auto paths = smoothed(run, tight());
    ASSERT_EQ(paths.size(), 1U);
    EXPECT_EQ(paths[0].blocks.size(), 2U);
    EXPECT_LE(paths[0].bound.tip_mm, 0.01);
    EXPECT_GE(paths[0].bound.tip_mm, 0.009);
}

TEST(Degenerate, NanometreBesideMetre) {
    const auto run = upright({{0, 0, 0}, {1000, 0, 0}, {1000, 1e-6, 0}, {1000 + 1e-6, 1e-6, 0}, {1000, 1000, 0}});
    const Walk w = walked(run, tight());
    expect_lawful(w, tight());
    EXPECT_GE(w.tip_mm, 0.009);
}

TEST(Degenerate, ManyTinyBlocksCostNoMoreThanOthers) {
    std::vector<std::array<double, 3>> points;
    for (int i = 0; i <= 20000; ++i) points.push_back({1e-4 * i, 1e-2 * std::sin(0.01 * i), 0});
    points.push_back({500, 0, 0});
    const Walk w = walked(upright(points), tight());
    expect_lawful(w, tight());
}

class Cases : public testing::Test {
  protected:
    void SetUp() override {
        if (!has_cases()) GTEST_SKIP() << "no case files in " << TRUNNION_SHARED_DIR;
    }
};

TEST_F(Cases, FilletUsesTheTolerance) {
    const auto run = run_from_case("fillet");
    const Walk w = walked(run, tight());
    expect_lawful(w, tight());
    EXPECT_EQ(w.stretches, 1U);
    EXPECT_GE(median(w.use), 0.8);
}

TEST_F(Cases, SineSurface) {
    const auto run = run_from_case("sine-10k");
    const Walk w = walk(run, smoothed(run, tight()), 30, 0, 4);
    expect_lawful(w, tight());
    EXPECT_EQ(w.stretches, 1U);
    EXPECT_LT(median(w.use), 0.1) << "a smooth surface needs next to nothing";
    EXPECT_LE(w.bound_tip_mm, 1.5 * w.tip_mm);
    EXPECT_LE(w.bound_turn_rad, 1.5 * w.turn_rad);
    EXPECT_LT(w.pieces, 4000U);
}

TEST_F(Cases, ConeOfVectors) {
    const auto run = run_from_case("cone");
    const Walk w = walked(run, tight());
    expect_lawful(w, tight());
    EXPECT_LE(w.bound_tip_mm, 1.5 * w.tip_mm);
    EXPECT_LE(w.bound_turn_rad, 1.5 * w.turn_rad);
}

TEST_F(Cases, PyramidAndPocketByFlankTolerance) {
    SmoothingOptions o;
    o.flank_tolerance_mm = 0.02;
    o.flank_height_mm = 50;
    const Walk pyramid = walked(run_from_case("pyramid"), o);
    expect_lawful(pyramid, o);
    EXPECT_GE(median(pyramid.use), 0.9);
    o.tip_tolerance_mm = o.flank_tolerance_mm = 3;
    o.flank_height_mm = 30;
    const Walk pocket = walked(run_from_case("pocket"), o);
    expect_lawful(pocket, o);
    EXPECT_GE(median(pocket.use), 0.9);
}

TEST_F(Cases, Others) {
    for (const char* name : {"corner", "pole", "gentle-0.2", "gentle-0.5", "gentle-1", "turn", "line"}) {
        SCOPED_TRACE(name);
        expect_lawful(walked(run_from_case(name), tight()), tight());
    }
}

TEST(Symmetry, BackwardsIsTheSamePath) {
    Random random(11);
    std::vector<Pose> poses;
    for (int i = 0; i < 200; ++i) {
        const double y = random.uniform(-0.002, 0.002) + (i > 100 ? 0.3 * (i - 100) : 0),
                     a = random.uniform(-1e-4, 1e-4);
        poses.push_back({0.4 * i, y, 0, 0.3 + 1e-3 * i + a, 0.2});
    }
    const auto there = smoothed(run_through(poses, OrientationLaw::rotary), tight());
    std::reverse(poses.begin(), poses.end());
    const auto back = smoothed(run_through(poses, OrientationLaw::rotary), tight());
    ASSERT_EQ(there.size(), 1U);
    ASSERT_EQ(back.size(), 1U);
    const auto &a = there[0].transition_use, &b = back[0].transition_use;
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[b.size() - 1 - i], 1e-3) << "10 nm";
}

/// The same blocks ten times as far from the start of the run are smoothed to the same shape.
TEST(Locality, SurroundingsFarAwayDoNotMatter) {
    const auto zigzag = [](int before) {
        std::vector<std::array<double, 3>> points{{0, 0, 0}};
        for (int i = 0; i < before; ++i) points.push_back({points.back()[0] + 10, 0, 0});
        for (const double y : {0.0, 3.0, 3.5, 1.0, 8.0}) points.push_back({points.back()[0] + 10, y, 0});
        return upright(points);
    };
    const auto near = smoothed(zigzag(4), tight()), far = smoothed(zigzag(40), tight());
    ASSERT_EQ(near.size(), 1U);
    ASSERT_EQ(far.size(), 1U);
    const auto& a = near[0].transition_use;
    const auto& b = far[0].transition_use;
    for (std::size_t i = 1; i <= 4; ++i) EXPECT_NEAR(a[a.size() - i], b[b.size() - i], 1e-6);
}

}  // namespace
}  // namespace trunnion::smoothing
