#include <gtest/gtest.h>

#include "trunnion/feed/plan_stretch.hpp"

#include "flank_path.hpp"
#include "reference_optimum.hpp"

/// The planner against the optimum found by another method.
namespace trunnion::test {
namespace {

TEST(Reference, KnowsTheLine) {
    const Stretch line =
        straight({100, 0, 0, 0, 0}, 100, {{{100, 1000, 20000}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}}});
    const auto optimum = reference::reference_optimum(*line.axis_path, {.nodes = 800});
    EXPECT_TRUE(optimum.converged);
    EXPECT_NEAR(optimum.time_s, 1.150, 0.0005 * 1.150);
}

TEST(Reference, AgreesOnTheFlankPath) {
    const auto flank = flank_path();
    if (!flank) GTEST_SKIP() << "no shared data";
    const auto optimum = reference::reference_optimum(*flank->axis_path, {.nodes = 1000});
    EXPECT_NEAR(optimum.time_s, 8.032, 0.003 * 8.032);
    const auto plan = feed::plan_stretch(*flank->axis_path, {});
    ASSERT_TRUE(plan);
    EXPECT_LE(plan->profile.duration_s(), 1.005 * optimum.time_s);
}

TEST(Reference, RandomCornersAreNearTheOptimum) {
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        const Stretch path = random_corners(seed, 3);
        const auto optimum = reference::reference_optimum(*path.axis_path, {.nodes = 800});
        const auto plan = feed::plan_stretch(*path.axis_path, {});
        ASSERT_TRUE(plan);
        const double ratio = plan->profile.duration_s() / optimum.time_s;
        EXPECT_TRUE(optimum.converged) << "seed " << seed;
        EXPECT_LE(ratio, 1.02) << "seed " << seed;
        EXPECT_GE(ratio, 0.98) << "seed " << seed << ": the reference is not at its optimum";
    }
}

}  // namespace
}  // namespace trunnion::test
