#include <gtest/gtest.h>

#include "made_motions.hpp"

namespace trunnion::verify::test {
namespace {

/// 100 mm in X at 100 mm/s, 1000 mm/s², 20 000 mm/s³: 1.15 s.
struct Line : testing::Test {
    Line() {
        machine.axes[0].feed = machine.axes[0].rapid = {100, 1000, 20000};
        const SevenPhases profile(100, 100, 1000, 20000);
        for (std::size_t n = 0; n <= 1150; ++n)
            rows.push_back(row(n, axes_for({profile.at(static_cast<double>(n) * period_s), 0, 0}, 0, 0), 2));
    }
    Verdict verdict() { return *check(*setpoint_table(rows), poses, machine, peer_setup(), {}); }

    machine::Machine machine = peer_trunnion();
    std::vector<ProgrammedPose> poses{pose({0, 0, 0}, 1), pose({100, 0, 0}, 2)};
    std::vector<motion::Setpoint> rows;
};

TEST_F(Line, TimeOptimalMotionUsesAllOfItsLimitsAndBreaksNone) {
    const auto v = verdict();
    EXPECT_TRUE(v.ok) << broken_things(v);
    EXPECT_EQ(v.rows, 1151u);
    EXPECT_NEAR(v.period_s, 0.001, 1e-15);
    EXPECT_NEAR(v.cycle_time_s, 1.15, 1e-12);
    EXPECT_NEAR(v.axes[0].velocity_ratio, 1, 1e-6);
    EXPECT_NEAR(v.axes[0].acceleration_ratio, 1, 1e-5);
    EXPECT_NEAR(v.axes[0].jerk_ratio, 1, 5e-4);
    EXPECT_EQ(v.axes[4].letter, 'C');
    EXPECT_EQ(v.axes[4].jerk_ratio, 0);
    EXPECT_LT(v.tip_deviation_mm, 1e-9);
    EXPECT_LT(v.tip_to_poses_mm, 1e-9);
    EXPECT_EQ(v.path_covered, 1);
}

TEST_F(Line, JerkSpikeIsFoundWhereItIs) {
    rows[500].position[0] += 2e-5;
    const auto v = verdict();
    EXPECT_TRUE(only_broken(v, {"axes.X.jerk_ratio"})) << broken_things(v);
    EXPECT_NEAR(v.axes[0].jerk_ratio, 3, 0.01);
    const auto* breach = v.first_of("axes.X.jerk_ratio");
    EXPECT_NEAR(breach->time_s, 0.501, 1e-9);  // δ/T³ is just 1.0 × the limit in the first of four
    EXPECT_EQ(breach->line, 2);
    EXPECT_NEAR(breach->value, 3, 0.01);
    EXPECT_NEAR(breach->limit, 1.001, 1e-12);
}

TEST_F(Line, EachLimitIsCheckedByItself) {
    const auto kept = machine.axes[0].feed;
    machine.axes[0].feed.velocity = kept.velocity * 0.99;
    auto v = verdict();
    EXPECT_TRUE(only_broken(v, {"axes.X.velocity_ratio"})) << broken_things(v);
    EXPECT_GT(v.first_of("axes.X.velocity_ratio")->time_s, 0.1);
    EXPECT_LT(v.first_of("axes.X.velocity_ratio")->time_s, 0.15);

    machine.axes[0].feed = kept;
    machine.axes[0].feed.acceleration *= 0.99;
    v = verdict();
    EXPECT_TRUE(only_broken(v, {"axes.X.acceleration_ratio"})) << broken_things(v);
    EXPECT_NEAR(v.first_of("axes.X.acceleration_ratio")->time_s, 0.051, 0.0011);

    machine.axes[0].feed = kept;
    machine.axes[0].feed.jerk *= 0.99;
    v = verdict();
    EXPECT_TRUE(only_broken(v, {"axes.X.jerk_ratio"})) << broken_things(v);
    EXPECT_NEAR(v.first_of("axes.X.jerk_ratio")->time_s, 0.003, 0.0011);
}

TEST_F(Line, StandstillBeforeAndAfterCounts) {
    const auto whole = rows;
    rows.erase(rows.begin(), rows.begin() + 30);  // begins in motion
    poses[0].tip_mm.x() = rows.front().position[0];
    auto v = verdict();
    EXPECT_FALSE(v.ok);
    ASSERT_TRUE(v.first_of("axes.X.jerk_ratio")) << broken_things(v);
    EXPECT_NEAR(v.first_of("axes.X.jerk_ratio")->time_s, 0.031, 1e-12);

    rows = whole;
    rows.resize(rows.size() - 30);  // ends in motion
    poses[0].tip_mm.x() = 0;
    poses[1].tip_mm.x() = rows.back().position[0];
    v = verdict();
    EXPECT_FALSE(v.ok);
    ASSERT_TRUE(v.first_of("axes.X.jerk_ratio")) << broken_things(v);
    EXPECT_NEAR(v.first_of("axes.X.jerk_ratio")->time_s, rows.back().time_s, 1e-12);
}

TEST_F(Line, RangeIsChecked) {
    machine.axes[0].range_max = 60;
    auto v = verdict();
    EXPECT_TRUE(only_broken(v, {"axes.X.range_excess"})) << broken_things(v);
    EXPECT_NEAR(v.axes[0].range_excess, 40, 1e-9);
    const auto* breach = v.first_of("axes.X.range_excess");
    EXPECT_GT(rows[static_cast<std::size_t>(std::lround(breach->time_s / period_s))].position[0], 60);
    EXPECT_LE(rows[static_cast<std::size_t>(std::lround(breach->time_s / period_s)) - 1].position[0], 60 + 1e-9);
    machine.axes[0].range_max = 100;
    EXPECT_TRUE(verdict().ok);
    machine.axes[0].range_min = 1;
    EXPECT_NEAR(verdict().axes[0].range_excess, 1, 1e-9);
}

TEST_F(Line, RapidLimitsCountOnRapidsAlone) {
    machine.axes[0].feed.acceleration = 500;
    EXPECT_FALSE(verdict().ok);
    poses[1].kind = PoseKind::rapid;
    poses[1].at_rapid = true;
    auto v = verdict();
    EXPECT_TRUE(v.ok) << broken_things(v);
    EXPECT_NEAR(v.axes[0].acceleration_ratio, 1, 1e-5);
    // the first half at feed: only its acceleration is a breach
    poses.insert(poses.begin() + 1, pose({50, 0, 0}, 2));
    v = verdict();
    EXPECT_TRUE(only_broken(v, {"axes.X.acceleration_ratio"})) << broken_things(v);
    EXPECT_NEAR(v.axes[0].acceleration_ratio, 2, 1e-5);
    EXPECT_LT(v.first_of("axes.X.acceleration_ratio")->time_s, 0.06);
}

TEST_F(Line, OneRowIsAMotion) {
    rows.resize(1);
    poses.resize(1);
    const auto v = verdict();
    EXPECT_TRUE(v.ok) << broken_things(v);
    EXPECT_EQ(v.cycle_time_s, 0);
    EXPECT_EQ(v.path_covered, 1);
}

}  // namespace
}  // namespace trunnion::verify::test
