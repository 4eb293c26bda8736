// A solver that is stopped at any moment, and windows that are left out: every path is finished inside its limits.
#include <gtest/gtest.h>

#include "trunnion/feed/feed_planner.hpp"

#include "dense_check.hpp"
#include "synthetic_paths.hpp"

namespace trunnion::test {
namespace {

constexpr double allowed = 1.0005;

void expect_whole(const Stretch& path, const feed::StretchPlan& plan) {
    EXPECT_LE(worst_ratio(*path.axis_path, plan.profile, 8), allowed);
    EXPECT_LE(worst_joint(*path.axis_path, plan.profile), 1e-9);
    const motion::ProfilePiece& last = plan.profile.pieces.back();
    EXPECT_EQ(last.kind, motion::ProfilePiece::Kind::rest_stop);
    EXPECT_NEAR(path.tool_path.pieces[last.path_piece].begin_mm + last.path_offset_mm + last.length_mm,
                path.tool_path.length_mm(), 1e-9 * path.tool_path.length_mm());
}

TEST(Budget, StoppedAnywhereEveryPathIsFinishedInsideItsLimits) {
    int fallbacks = 0;
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        SCOPED_TRACE(seed);
        const Stretch path = random_corners(seed, 25);
        Random random(seed);
        feed::FeedOptions options{.window = 100};
        options.budget = [&](int) { return static_cast<int>(random.between(0, 40)); };
        const auto plan = feed::plan_stretch(*path.axis_path, options);
        ASSERT_TRUE(plan) << to_string(plan.error());
        expect_whole(path, *plan);
        fallbacks += plan->fallbacks;
    }
    EXPECT_GT(fallbacks, 50);  // the budgets were felt
}

TEST(Budget, LeftOutWindowsCostTimeAlone) {
    double whole = 0, with_gaps = 0;
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
        SCOPED_TRACE(seed);
        const Stretch path = random_corners(seed, 40);
        Random random(seed + 100);
        feed::FeedOptions options{.window = 150};
        const auto all = feed::plan_stretch(*path.axis_path, options);
        options.budget = [&](int) { return random.unit() < 0.3 ? 0 : 1000; };
        const auto some = feed::plan_stretch(*path.axis_path, options);
        ASSERT_TRUE(all && some);
        expect_whole(path, *some);
        EXPECT_GT(some->fallbacks, 0);
        whole += all->profile.duration_s();
        with_gaps += some->profile.duration_s();
    }
    EXPECT_GT(with_gaps, whole);
    EXPECT_LT(with_gaps, 1.5 * whole);
}

TEST(Budget, NoIterationAtAllStillMoves) {
    const Stretch path = random_corners(4, 10);
    feed::FeedOptions options;
    options.budget = [](int) { return 0; };
    const auto plan = feed::plan_stretch(*path.axis_path, options);
    ASSERT_TRUE(plan) << to_string(plan.error());
    expect_whole(path, *plan);
}

}  // namespace
}  // namespace trunnion::test
