// What is held beside the axes' own limits, that it is held between samples too, and what more of it is worth.
#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "dense_check.hpp"
#include "flank_path.hpp"
#include "synthetic_paths.hpp"

namespace trunnion::test {
namespace {

using feed::FeedOptions;
using feed::plan_stretch;
using feed::StretchPlan;

constexpr double allowed = 1.0005;

StretchPlan planned(const Stretch& stretch, const FeedOptions& options = {}) {
    EXPECT_TRUE(stretch.axis_path);
    auto plan = plan_stretch(*stretch.axis_path, options);
    EXPECT_TRUE(plan) << (plan ? "" : to_string(plan.error()));
    return plan ? *plan : StretchPlan{};
}

std::string code(const Result<StretchPlan>& plan) {
    return plan ? "none" : plan.error().code;
}

/// Calls look(sample, state) at many places of every profile piece.
template <class Look>
void walk(const path::AxisPath& path, const motion::FeedProfile& profile, const Look& look, int points = 32) {
    for (const motion::ProfilePiece& piece : profile.pieces)
        for (int k = 0; k <= points; ++k) {
            const double delta = piece.length_mm * k / points;
            path::AxisSample at;
            path.evaluate({piece.path_piece, piece.path_offset_mm + delta}, at);
            look(at, motion::state_at(piece, delta));
        }
}

std::set<std::string> causes(const Stretch& stretch, const StretchPlan& plan) {
    std::set<std::string> out;
    for (const feed::Cause& cause : plan.causes) out.insert(feed::name_of(cause, stretch.machine));
    return out;
}

TEST(Limits, ReportedPeaksAreBoundsAndClose) {
    for (const std::uint64_t seed : {1, 2, 3, 4, 5, 6}) {
        SCOPED_TRACE(seed);
        const Stretch path = random_corners(seed, 12);
        const StretchPlan plan = planned(path);
        std::array<feed::AxisPeaks, machine::max_axes> reached{};
        walk(*path.axis_path, plan.profile, [&](const path::AxisSample& at, const motion::PathState& s) {
            const double v = s.speed_mm_s, a = s.acceleration_mm_s2;
            for (int i = 0; i < 5; ++i) {
                const Taylor3& q = at.axes[i];
                const machine::AxisLimits& limit = path.machine.axes[i].feed;
                const auto raise = [](double& to, double load) { to = std::max(to, std::abs(load)); };
                raise(reached[i].velocity, q.d1() * v / limit.velocity);
                raise(reached[i].acceleration, (q.d2() * v * v + q.d1() * a) / limit.acceleration);
                raise(reached[i].jerk, (q.d3() * v * v * v + 3 * q.d2() * v * a + q.d1() * s.jerk_mm_s3) / limit.jerk);
            }
        });
        for (int i = 0; i < 5; ++i) {
            const feed::AxisPeaks &bound = plan.peaks[i], &most = reached[i];
            EXPECT_LE(most.velocity, bound.velocity * (1 + 1e-5));
            EXPECT_LE(most.acceleration, bound.acceleration + 1e-5);
            EXPECT_LE(most.jerk, bound.jerk + 1e-5);
            EXPECT_LE(std::max({bound.velocity, bound.acceleration, bound.jerk}), 1.0004 + 1e-12);
            EXPECT_LE(bound.velocity, most.velocity + 1e-3);
            EXPECT_LE(bound.acceleration, most.acceleration + 1e-3);
            EXPECT_LE(bound.jerk, most.jerk + 1e-3);
        }
    }
}

TEST(Limits, OfTheTipAreHeldAndUsed) {
    const Stretch path = straight({60, 80, 0, 0, 0.3}, 100, trunnion_limits());
    const FeedOptions options{.tip_acceleration_mm_s2 = 500, .tip_jerk_mm_s3 = 3000};
    const StretchPlan plan = planned(path, options);
    double acceleration = 0, jerk = 0;
    walk(*path.axis_path, plan.profile, [&](const path::AxisSample& at, const motion::PathState& s) {
        acceleration = std::max(acceleration, at.feed_rate * std::abs(s.acceleration_mm_s2));
        jerk = std::max(jerk, at.feed_rate * std::abs(s.jerk_mm_s3));
    });
    EXPECT_LE(acceleration, allowed * 500);
    EXPECT_LE(jerk, allowed * 3000);
    EXPECT_GE(jerk, 0.99 * 3000);
    EXPECT_GT(plan.profile.duration_s(), 1.05 * planned(path).profile.duration_s());
    EXPECT_TRUE(causes(path, plan).contains("tip jerk"));
}

TEST(Limits, OfTheToolsTurnAreHeldAndUsed) {
    const Stretch path = straight({20, 0, 0, 0.6, 0.8}, 100, trunnion_limits());
    const StretchPlan plan = planned(path, {.turn_velocity_rad_s = 0.5});
    double turn = 0;
    walk(*path.axis_path, plan.profile, [&](const path::AxisSample& at, const motion::PathState& s) {
        turn = std::max(turn, at.turn_rate * s.speed_mm_s);
    });
    EXPECT_LE(turn, allowed * 0.5);
    EXPECT_GE(turn, 0.999 * 0.5);
    EXPECT_TRUE(causes(path, plan).contains("tool velocity"));
}

TEST(Limits, OfTheChordErrorAreHeldAndUsed) {
    const Stretch path = random_corners(3, 12);
    const FeedOptions options{.chord_error_mm = 1e-5, .period_s = 1e-3};
    const StretchPlan plan = planned(path, options);
    double worst = 0;
    walk(*path.axis_path, plan.profile, [&](const path::AxisSample& at, const motion::PathState& s) {
        const Eigen::Vector3d r1(at.tip[0].d1(), at.tip[1].d1(), at.tip[2].d1()),
            r2(at.tip[0].d2(), at.tip[1].d2(), at.tip[2].d2());
        const double step = s.speed_mm_s * options.period_s;  // of p; the sagitta of an arc over it is κ s²/8
        worst = std::max(worst, r1.cross(r2).norm() / r1.norm() * step * step / 8);
    });
    EXPECT_LE(worst, allowed * options.chord_error_mm);
    EXPECT_LE(worst_ratio(*path.axis_path, plan.profile), allowed);
    EXPECT_GE(worst, 0.9 * options.chord_error_mm);
    EXPECT_TRUE(causes(path, plan).contains("chord"));
    EXPECT_GT(plan.profile.duration_s(), 1.005 * planned(path).profile.duration_s());
}

/// With all limits in the right proportion a motion is the same, only faster: Σ (V + 2A + 3J) dT/d(ln limit) = −T.
TEST(Limits, WorthOfAllOfThemTogetherIsTheTime) {
    const auto flank = flank_path();
    if (!flank) GTEST_SKIP() << "no shared data";
    const StretchPlan plan = planned(*flank, {.calm = 0});
    double sum = 0;
    for (const feed::LimitWorth& worth : plan.worth) {
        EXPECT_LE(std::max({worth.velocity_s, worth.acceleration_s, worth.jerk_s}), 1e-6);
        sum += worth.velocity_s + 2 * worth.acceleration_s + 3 * worth.jerk_s;
    }
    EXPECT_NEAR(sum / plan.profile.duration_s(), -1, 0.01);
}

TEST(Limits, WorthOfALineIsThatOfItsOnlyLimit) {
    const std::array<machine::AxisLimits, 5> limits{{{1e6, 1e6, 5000}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}}};
    const StretchPlan plan = planned(straight({100, 0, 0, 0, 0}, 100, limits), {.calm = 0});
    const double time_s = std::cbrt(32 * 100.0 / 5000);  // of a move that jerk alone limits
    EXPECT_NEAR(plan.profile.duration_s(), time_s, 2e-4 * time_s);
    EXPECT_NEAR(plan.worth[0].jerk_s, -time_s / 3, 0.01 * time_s);
    EXPECT_NEAR(plan.worth[0].velocity_s, 0, 0.003 * time_s);
    EXPECT_NEAR(plan.worth[0].acceleration_s, 0, 0.003 * time_s);
}

TEST(Limits, WorthTellsWhatALittleMoreWouldSave) {
    const auto flank = flank_path();
    if (!flank) GTEST_SKIP() << "no shared data";
    const StretchPlan plan = planned(*flank, {.calm = 0});
    for (const int axis : {3, 4}) {
        FeedOptions more{.calm = 0}, less{.calm = 0};
        more.factors[axis].acceleration = 1.01;
        less.factors[axis].acceleration = 0.99;
        const double measured =
            (planned(*flank, more).profile.duration_s() - planned(*flank, less).profile.duration_s()) /
            (std::log(1.01) - std::log(0.99));
        EXPECT_NEAR(measured, plan.worth[axis].acceleration_s, 0.05 * std::abs(measured) + 0.02) << axis;
    }
}

TEST(Limits, BadOnesAreRefused) {
    const auto with = [](auto&& change) {
        Stretch path = straight({100, 0, 0, 0, 0.1}, 100, trunnion_limits());
        change(path.machine.axes[4].feed);
        return code(plan_stretch(*path.axis_path, {}));
    };
    constexpr double infinite = std::numeric_limits<double>::infinity();
    for (const double bad : {0.0, -1.0, infinite, std::nan("")}) {
        SCOPED_TRACE(bad);
        EXPECT_EQ(with([=](machine::AxisLimits& limit) { limit.velocity = bad; }), "FEED0006");
        EXPECT_EQ(with([=](machine::AxisLimits& limit) { limit.acceleration = bad; }), "FEED0006");
        EXPECT_EQ(with([=](machine::AxisLimits& limit) { limit.jerk = bad; }), "FEED0006");
    }
    const Stretch path = straight({100, 0, 0, 0, 0}, 100, trunnion_limits());
    for (const FeedOptions& bad :
         {FeedOptions{.chord_error_mm = 0}, FeedOptions{.period_s = -1}, FeedOptions{.tip_acceleration_mm_s2 = 0},
          FeedOptions{.tip_jerk_mm_s3 = std::nan("")}, FeedOptions{.turn_velocity_rad_s = -2}})
        EXPECT_EQ(code(plan_stretch(*path.axis_path, bad)), "FEED0001");
}

TEST(Limits, PathsThatCannotBeFollowedAreRefused) {
    const Stretch dot = straight({1e-4, 0, 0, 0, 0}, 1e-4, trunnion_limits());
    EXPECT_EQ(code(plan_stretch(*dot.axis_path, {})), "FEED0005");
    Stretch jump = straight({100, 0, 0, 0, 0}, 100, trunnion_limits());
    path::PathPiece second = jump.tool_path.pieces[0];
    second.begin_mm = 100;
    second.coefficient[0][0] = 100.001;
    jump.tool_path.pieces.push_back(second);
    jump.tool_path.blocks[0].end_mm = 200;
    jump.close();
    ASSERT_TRUE(jump.axis_path);
    EXPECT_EQ(code(plan_stretch(*jump.axis_path, {})), "FEED0009");
    jump.tool_path.pieces[1].coefficient[0][0] = 100;
    jump.close();
    EXPECT_EQ(code(plan_stretch(*jump.axis_path, {})), "none");
}

}  // namespace
}  // namespace trunnion::test
