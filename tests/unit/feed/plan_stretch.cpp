#include "trunnion/feed/plan_stretch.hpp"

#include <map>

#include <gtest/gtest.h>

#include "dense_check.hpp"
#include "flank_path.hpp"
#include "synthetic_paths.hpp"

namespace trunnion::test {
namespace {

using feed::plan_stretch;
using path::FeedRule;

constexpr double allowed = 1.0005;
const std::array<machine::AxisLimits, 5> line_limits{
    {{100, 1000, 20000}, {100, 1000, 20000}, {100, 1000, 20000}, {1, 10, 200}, {1, 10, 200}}};

feed::StretchPlan planned(const Stretch& stretch, const feed::FeedOptions& options = {}) {
    EXPECT_TRUE(stretch.axis_path);
    auto plan = plan_stretch(*stretch.axis_path, options);
    EXPECT_TRUE(plan) << (plan ? "" : to_string(plan.error()));
    return plan ? *plan : feed::StretchPlan{};
}

void expect_sound(const Stretch& stretch, const feed::StretchPlan& plan) {
    EXPECT_LE(worst_ratio(*stretch.axis_path, plan.profile), allowed);
    EXPECT_LE(worst_joint(*stretch.axis_path, plan.profile), 1e-9);
    EXPECT_EQ(plan.causes.size(), plan.profile.pieces.size());
    EXPECT_GE(plan.profile.duration_s(), plan.jerk_free_bound_s * 0.9995);
    EXPECT_EQ(plan.profile.pieces.front().kind, motion::ProfilePiece::Kind::rest_start);
    EXPECT_EQ(plan.profile.pieces.back().kind, motion::ProfilePiece::Kind::rest_stop);
}

// V/A + A/J + L/V with a trapezoid of acceleration: 1.150 s exactly.
TEST(PlanStretch, LineTakesItsKnownTime) {
    const Stretch line = straight({100, 0, 0, 0, 0}, 100, line_limits);
    const auto plan = planned(line);
    expect_sound(line, plan);
    EXPECT_NEAR(plan.profile.duration_s(), 1.150, 0.0005 * 1.150);
    EXPECT_NEAR(plan.jerk_free_bound_s, 1.1, 0.001);
    EXPECT_EQ(plan.fallbacks, 0);
}

TEST(PlanStretch, RotaryTwinOfTheLineTakesTheSameTime) {
    const Stretch turn = straight({0, 0, 0, 0, 1}, 30, line_limits);
    const auto plan = planned(turn);
    expect_sound(turn, plan);
    EXPECT_NEAR(plan.profile.duration_s(), 1.150, 0.0005 * 1.150);
}

TEST(PlanStretch, LineTellsWhatLimitsIt) {
    const Stretch line = straight({100, 0, 0, 0, 0}, 100, line_limits);
    const auto plan = planned(line);
    std::map<std::string, double> share;
    for (std::size_t k = 0; k < plan.causes.size(); ++k)
        share[feed::name_of(plan.causes[k], line.machine)] += plan.profile.pieces[k].duration_s;
    EXPECT_NEAR(share["X velocity"], 0.85, 0.1);
    EXPECT_NEAR(share["X jerk"], 0.2, 0.05);
    EXPECT_NEAR(share["X acceleration"], 0.1, 0.05);
    EXPECT_EQ(share.count("Y jerk"), 0u);
}

TEST(PlanStretch, FlankPathIsAtItsKnownOptimum) {
    const auto flank = flank_path();
    if (!flank) GTEST_SKIP() << "no shared data";
    const auto plan = planned(*flank);
    expect_sound(*flank, plan);
    EXPECT_NEAR(plan.profile.duration_s(), 8.032, 0.003 * 8.032);
    EXPECT_NEAR(plan.jerk_free_bound_s, 7.10, 0.03);
}

TEST(PlanStretch, WithHugeJerkTheTimeIsTheJerkFreeBound) {
    const auto flank = flank_path(100);
    if (!flank) GTEST_SKIP() << "no shared data";
    const auto plan = planned(*flank);
    expect_sound(*flank, plan);
    EXPECT_NEAR(plan.profile.duration_s() / plan.jerk_free_bound_s, 1, 0.0012);
}

TEST(PlanStretch, RandomCornersHoldAllLimits) {
    int fallbacks = 0, windows = 0;
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
        SCOPED_TRACE(seed);
        const Stretch path = random_corners(seed, 12);
        const auto plan = planned(path);
        expect_sound(path, plan);
        fallbacks += plan.fallbacks;
        windows += plan.windows;
    }
    EXPECT_LE(fallbacks, windows / 20);
}

TEST(PlanStretch, WindowsLoseNextToNothing) {
    const Stretch path = random_corners(7, 60);
    const auto whole = planned(path, {.window = 8000}), windows = planned(path);
    expect_sound(path, windows);
    EXPECT_GT(windows.windows, 6);
    EXPECT_LE(windows.profile.duration_s(), 1.001 * whole.profile.duration_s());
}

TEST(PlanStretch, AnyLengthWorks) {
    for (const double length : {1e-3, 0.1, 10.0, 1000.0, 30000.0}) {
        SCOPED_TRACE(length);
        const Stretch path = straight({0.7 * length, 0.3 * length, 0, 0, length / 3000}, length, trunnion_limits());
        expect_sound(path, planned(path));
    }
}

TEST(PlanStretch, AnyFeedWorksAndIsReached) {
    for (const double feed : {1e-3, 0.1, 10.0, 200.0, 1e4}) {
        SCOPED_TRACE(feed);
        const Stretch path = straight({100, 0, 0, 0, 0}, 100, trunnion_limits(), {FeedRule::tip_speed, feed});
        const auto plan = planned(path);
        expect_sound(path, plan);
        if (feed <= 10) {
            EXPECT_LE(plan.profile.duration_s(), 1.01 * 100 / feed + 0.2);
        }
    }
}

TEST(PlanStretch, FeedThatChangesAlongAStraightIsFollowed) {
    Stretch path = straight({300, 0, 0, 0, 0}, 300, trunnion_limits());
    path.tool_path.blocks.clear();
    double ideal = 0;
    for (const double feed : {10.0, 100.0, 1.0, 400.0, 50.0, 200.0}) {
        const double begin = 50.0 * static_cast<double>(path.tool_path.blocks.size());
        path.tool_path.blocks.push_back({begin, begin + 50, {FeedRule::tip_speed, feed}, 1, 50});
        ideal += 50 / feed;
    }
    const auto plan = planned(path);
    EXPECT_GE(plan.profile.duration_s(), ideal);
    EXPECT_LE(plan.profile.duration_s(), ideal + 3);
    for (const auto& piece : plan.profile.pieces) {
        const std::size_t block = static_cast<std::size_t>((piece.path_offset_mm + piece.length_mm / 2) / 50);
        for (const double part : {0.0, 0.5, 1.0})
            EXPECT_LE(motion::state_at(piece, part * piece.length_mm).speed_mm_s,
                      allowed * path.tool_path.blocks[block].feed.value);
    }
}

TEST(PlanStretch, InverseTimeAndRotaryFeedsAreHeld) {
    const Stretch timed = straight({100, 0, 0, 0, 0}, 100, trunnion_limits(), {FeedRule::block_time, 20});
    EXPECT_NEAR(planned(timed).profile.duration_s(), 20, 0.2);
    const Stretch turn = straight({0, 0, 0, 0, 3}, 90, trunnion_limits(), {FeedRule::rotary_rate, 0.5});
    EXPECT_NEAR(planned(turn).profile.duration_s(), 6, 0.3);
}

TEST(PlanStretch, RapidsUseTheirOwnLimits) {
    Stretch path = straight({100, 0, 0, 0, 0}, 100, line_limits);
    for (auto& axis : path.machine.axes) axis.rapid = {400, 4000, 80000};
    path.tool_path.rapid = true;
    const auto plan = planned(path);
    expect_sound(path, plan);
    EXPECT_LT(plan.profile.duration_s(), 0.6);
}

TEST(PlanStretch, JerkMarginIsLeftUnused) {
    const Stretch path = straight({100, 0, 0, 0, 0}, 100, line_limits);
    const auto plan = planned(path, {.jerk_margin = 0.5});
    EXPECT_NEAR(plan.peaks[0].jerk, 0.5, 0.002);
    EXPECT_GT(plan.profile.duration_s(), 1.19);
}

TEST(PlanStretch, PassesThePole) {
    for (const double distance : {1e-1, 1e-3, 1e-5}) {
        SCOPED_TRACE(distance);
        const Stretch path = past_the_pole(distance);
        const auto plan = planned(path);
        expect_sound(path, plan);
        EXPECT_LT(plan.profile.duration_s(), 4);
    }
}

TEST(PlanStretch, CalmTradesTimeForJerk) {
    const Stretch path = straight({100, 0, 0, 0, 0}, 100, line_limits);
    const auto rms = [&](double calm) {
        double sum = 0;
        for (const auto& piece : planned(path, {.calm = calm}).profile.pieces) {
            const double jerk = motion::state_at(piece, piece.length_mm / 2).jerk_mm_s3 / 20000;
            sum += jerk * jerk * piece.duration_s;
        }
        return std::sqrt(sum);
    };
    EXPECT_LT(rms(0.3), 0.85 * rms(0.001));
    EXPECT_LT(planned(path, {.calm = 0.3}).profile.duration_s(), 1.012 * 1.15);
}

/// What is handed over while the rest is planned is what the whole plan begins with, and it is there early.
TEST(StretchPlanner, ShowsAPlanThatGrowsAndStaysAsItIs) {
    const Stretch path = random_corners(7, 12);
    const feed::FeedOptions options{.window = 32};
    auto intervals = feed::IntervalStream::make(*path.axis_path, options).value();
    feed::StretchPlanner planner(*path.axis_path, options);
    feed::Interval interval;
    std::vector<motion::ProfilePiece> seen;
    std::size_t pushed = 0, pushed_when_first_seen = 0;
    for (; intervals.next(interval).value(); ++pushed) {
        planner.push(interval);
        const auto& pieces = planner.planned().pieces;
        seen.insert(seen.end(), pieces.begin() + static_cast<std::ptrdiff_t>(seen.size()), pieces.end());
        if (pushed_when_first_seen == 0 && !seen.empty()) pushed_when_first_seen = pushed + 1;
    }
    const auto plan = planner.finish();
    ASSERT_TRUE(plan) << to_string(plan.error());
    EXPECT_LE(pushed_when_first_seen, 48u);
    EXPECT_GT(pushed, 200u);
    EXPECT_GT(seen.size(), pushed / 2);
    const auto whole = planned(path, options).profile.pieces;
    ASSERT_EQ(plan->profile.pieces.size(), whole.size());
    for (std::size_t k = 0; k < seen.size(); ++k) {
        ASSERT_EQ(seen[k].begin_s, whole[k].begin_s) << k;
        ASSERT_EQ(seen[k].x0, whole[k].x0) << k;
        ASSERT_EQ(seen[k].length_mm, whole[k].length_mm) << k;
    }
}

TEST(PlanStretch, BadInputIsRefused) {
    const Stretch path = straight({100, 0, 0, 0, 0}, 100, line_limits);
    const auto code = [](const auto& result) { return result ? std::string("none") : result.error().code; };
    EXPECT_EQ(code(plan_stretch(*path.axis_path, {.calm = -1})), "FEED0001");
    EXPECT_EQ(code(plan_stretch(*path.axis_path, {.jerk_margin = 1})), "FEED0001");
    EXPECT_EQ(code(plan_stretch(*path.axis_path, {.jerk_margin = std::nan("")})), "FEED0001");
    Stretch broken = straight({100, 0, 0, 0, 0}, 100, line_limits);
    broken.tool_path.pieces[0].coefficient[0][3] = std::nan("");
    EXPECT_EQ(code(plan_stretch(*broken.axis_path, {})), "FEED0002");
    const Stretch no_feed = straight({100, 0, 0, 0, 0}, 100, line_limits, {FeedRule::tip_speed, 0});
    EXPECT_EQ(code(plan_stretch(*no_feed.axis_path, {})), "FEED0008");
    Stretch empty = straight({100, 0, 0, 0, 0}, 100, line_limits);
    empty.tool_path.pieces[0].length_mm = 0;
    EXPECT_EQ(code(plan_stretch(*empty.axis_path, {})), "FEED0005");
}

}  // namespace
}  // namespace trunnion::test
