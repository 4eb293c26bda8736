#include <cmath>

#include <gtest/gtest.h>

#include "made_programs.hpp"

/// Curves of a program as chords, against curves written down by hand.
namespace trunnion::verify::test {
namespace {

/// The parabola (10 u, 8 u², 0) for u from 0 to 1, then on to u = 2, as two Bézier pieces of one quadratic spline.
Program parabola() {
    auto out = program_of({by_vector({0, 0, 0}, {0.3, 0, 1}, 1), by_vector({10, 8, 0}, {0.3, 0.2, 1}, 2),
                           by_vector({20, 32, 0}, {0.3, 0.4, 1}, 3)});
    program::Curve curve;
    curve.degree = 2;
    curve.knots = {0, 0, 0, 1, 2, 2, 2};
    curve.position_mm = {{0, 0, 0}, {5, 0, 0}, {15, 16, 0}, {20, 32, 0}};
    curve.axis = {{0.3, 0, 1}, {0.3, 0.1, 1}, {0.3, 0.3, 1}, {0.3, 0.4, 1}};  // (0.3, 0.2 u, 1)
    out.curves = {curve};
    out.curve_parts = {{0, 0, 1}, {0, 1, 2}};
    out.moves[1].curve_part = 0;
    out.moves[2].curve_part = 1;
    return out;
}

TEST(ProgrammedCurves, AreChordsWithinTheTolerance) {
    const auto poses = poses_of(parabola());
    ASSERT_GT(poses.size(), 50u);
    double worst = 0;
    for (std::size_t n = 0; n < poses.size(); ++n) {
        const double u = poses[n].tip_mm.x() / 10;
        EXPECT_NEAR(poses[n].tip_mm.y(), 8 * u * u, 1e-12);
        EXPECT_LT((poses[n].axis - Eigen::Vector3d(0.3, 0.2 * u, 1).normalized()).norm(), 1e-12);
        if (n == 0) continue;
        const Eigen::Vector3d middle = 0.5 * (poses[n].tip_mm + poses[n - 1].tip_mm);
        const double at = middle.x() / 10;
        worst = std::max(worst, std::abs(middle.y() - 8 * at * at));
    }
    EXPECT_LE(worst, chord_tolerance_mm);
    EXPECT_GT(worst, 0.3 * chord_tolerance_mm);
}

TEST(ProgrammedCurves, WithWeightsAreRound) {
    auto program = program_of({by_vector({10, 0, 0}, {0, 0, 1}, 1), by_vector({0, 10, 0}, {0, 0, 1}, 2)});
    program::Curve curve;
    curve.degree = 2;
    curve.knots = {0, 0, 0, 1, 1, 1};
    curve.position_mm = {{10, 0, 0}, {10, 10, 0}, {0, 10, 0}};
    curve.weights = {1, std::sqrt(0.5), 1};
    program.curves = {curve};
    program.curve_parts = {{0, 0, 1}};
    program.moves[1].curve_part = 0;
    for (const auto& pose : poses_of(program)) EXPECT_NEAR(pose.tip_mm.norm(), 10, 1e-12);
}

TEST(ProgrammedCurves, TurnByTheirWords) {
    auto program = program_of({by_words({0, 0, 0}, 0.1, 0, 1), by_words({20, 0, 0}, 0.5, 0.4, 2)});
    program::Curve curve;
    curve.degree = 2;
    curve.knots = {0, 0, 0, 1, 1, 1};
    curve.position_mm = {{0, 0, 0}, {10, 0, 0}, {20, 0, 0}};
    curve.rotary_rad = {{0.1, 0, 0}, {0.1, 0.4, 0}, {0.5, 0.4, 0}};
    program.curves = {curve};
    program.curve_parts = {{0, 0, 1}};
    program.moves[1].curve_part = 0;
    const auto poses = poses_of(program);
    ASSERT_GT(poses.size(), 10u);
    for (const auto& pose : poses) {
        const double u = pose.tip_mm.x() / 20;
        EXPECT_NEAR(pose.rotary_rad[0], 0.1 + 0.4 * u * u, 1e-12);
        EXPECT_NEAR(pose.rotary_rad[1], 0.8 * u - 0.4 * u * u, 1e-12);
        EXPECT_LT((pose.axis - axis_of(pose.rotary_rad[0], pose.rotary_rad[1])).norm(), 1e-12);
    }
    EXPECT_TRUE(poses.back().literal);
    EXPECT_FALSE(poses[1].literal);
}

template <class Spoil>
void expect_refused(const Spoil& spoil) {
    auto program = parabola();
    spoil(program);
    const auto poses = programmed_poses(program, peer_trunnion(), peer_setup());
    ASSERT_FALSE(poses);
    EXPECT_EQ(poses.error().code, "VER0112") << poses.error().text;
}

TEST(ProgrammedCurves, ThatAreNoneAreRefused) {
    expect_refused([](Program& p) { p.moves[1].curve_part = 2; });
    expect_refused([](Program& p) { p.moves[1].curve_part = -7; });
    expect_refused([](Program& p) { p.curve_parts[0].curve = 1; });
    expect_refused([](Program& p) { p.curves[0].degree = 8; });
    expect_refused([](Program& p) { p.curves[0].knots.pop_back(); });
    expect_refused([](Program& p) { p.curves[0].weights = {1, 0, 1, 1}; });
    expect_refused([](Program& p) { p.curves[0].axis.pop_back(); });
    expect_refused([](Program& p) { p.curves[0].position_mm[1].x() = NAN; });
    expect_refused([](Program& p) { p.curve_parts[0].from_u = 1; });
    expect_refused([](Program& p) { p.curve_parts[0].to_u = 1.5; });
    expect_refused([](Program& p) { p.curve_parts[1].to_u = 2.5; });
    expect_refused([](Program& p) { p.moves[0].position_mm.x() = 2e-3; });
    expect_refused([](Program& p) { p.moves[2].position_mm.x() += 2e-3; });
    expect_refused([](Program& p) { p.moves[2].axis = Eigen::Vector3d(0.3, 0.41, 1).normalized(); });
    expect_refused([](Program& p) {
        p.moves[1].arc = 0;
        p.arcs.push_back({});
    });
}

}  // namespace
}  // namespace trunnion::verify::test
