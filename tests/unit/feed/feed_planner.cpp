#include "trunnion/feed/feed_planner.hpp"

#include <gtest/gtest.h>

namespace trunnion::test {
namespace {

using feed::FeedPlanner;
using feed::Interval;
using motion::ProfilePiece;

feed::LimitSet one_axis() {
    feed::LimitSet limits;

    limits.of[0] = {100, 1000, 20000};
    return limits;
}

/// Intervals of one axis along p, graded towards both ends.
std::vector<Interval> line(double length) {
    std::vector<double> half;
    for (double p = 0, h = 0.1; p < length / 2; p += h, h = std::min({2.0, 0.15 * p, length / 2 - p})) {
        if (h < 1e-9) break;
        half.push_back(h);
    }
    std::vector<double> sizes = half;
    sizes.insert(sizes.end(), half.rbegin(), half.rend());
    std::vector<Interval> out;
    double p = 0;
    for (const double h : sizes) {
        Interval interval;
        interval.begin = {0, p};
        interval.length_mm = h;
        for (auto& sample : interval.samples) sample.q1[0] = 1;
        out.push_back(interval);
        p += h;
    }
    return out;
}

TEST(FeedPlanner, CommitsWhileIntervalsCome) {
    std::vector<ProfilePiece> pieces;
    FeedPlanner planner(one_axis(), {.window = 100},
                        [&](const Interval&, const ProfilePiece& piece) { pieces.push_back(piece); });
    std::size_t early = 0, most_waiting = 0, pushed = 0;
    for (const Interval& interval : line(2000)) {
        planner.push(interval);
        ++pushed;
        early = pieces.size();
        most_waiting = std::max(most_waiting, pushed - pieces.size());
    }
    EXPECT_GT(early, pushed / 2);
    EXPECT_LE(most_waiting, 8u * 150);
    ASSERT_TRUE(planner.finish());
    EXPECT_EQ(pieces.size(), pushed);
    EXPECT_EQ(planner.counts().intervals, pushed);
    const double exact = 2000.0 / 100 + 100.0 / 1000 + 1000.0 / 20000;
    EXPECT_NEAR(pieces.back().begin_s + pieces.back().duration_s, exact, 0.002 * exact);
    for (std::size_t k = 1; k + 1 < pieces.size(); ++k)
        EXPECT_EQ(pieces[k].kind, ProfilePiece::Kind::cubic) << "a stop inside, at " << k;
}

TEST(FeedPlanner, RefusesTooFewIntervals) {
    FeedPlanner planner(one_axis(), {}, [](const Interval&, const ProfilePiece&) {});
    planner.push(line(10)[0]);
    const auto done = planner.finish();
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().code, "FEED0003");
}

TEST(FeedPlanner, SaysWhenNothingCanBePlanned) {
    FeedPlanner planner(one_axis(), {}, [](const Interval&, const ProfilePiece&) {});
    for (Interval interval : line(10)) {
        interval.samples[1].q2[0] = std::numeric_limits<double>::quiet_NaN();
        planner.push(interval);
    }
    const auto done = planner.finish();
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().code, "FEED0002");
}

TEST(FeedPlanner, GoesOnFromAStartSpeed) {
    std::vector<ProfilePiece> pieces;
    FeedPlanner planner(one_axis(), {.start_speed_mm_s = 60, .start_acceleration_mm_s2 = 200},
                        [&](const Interval&, const ProfilePiece& piece) { pieces.push_back(piece); });
    for (const Interval& interval : line(200)) planner.push(interval);
    ASSERT_TRUE(planner.finish());
    EXPECT_EQ(pieces.front().kind, ProfilePiece::Kind::cubic);
    const motion::PathState start = motion::state_at(pieces.front(), 0);
    EXPECT_NEAR(start.speed_mm_s, 60, 1e-9);
    EXPECT_NEAR(start.acceleration_mm_s2, 200, 1e-9);
    EXPECT_LT(pieces.back().begin_s + pieces.back().duration_s, 2.15);
}

TEST(FeedPlanner, RefusesAStartSpeedThatCannotBeStopped) {
    FeedPlanner planner(one_axis(), {.start_speed_mm_s = 100}, [](const Interval&, const ProfilePiece&) {});
    for (const Interval& interval : line(3)) planner.push(interval);  // 100 mm/s take 7.5 mm to stop
    const auto done = planner.finish();
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().code, "FEED0007");
}

TEST(FeedPlanner, RefusesAStartWithoutMeaning) {
    const double nan = std::numeric_limits<double>::quiet_NaN(), infinite = std::numeric_limits<double>::infinity();
    for (const auto& [speed, acceleration] : {std::pair{nan, 0.0}, {-1.0, 0.0}, {infinite, 0.0}, {10.0, nan}}) {
        FeedPlanner planner(one_axis(), {.start_speed_mm_s = speed, .start_acceleration_mm_s2 = acceleration},
                            [](const Interval&, const ProfilePiece&) {});
        for (const Interval& interval : line(100)) planner.push(interval);
        const auto done = planner.finish();
        ASSERT_FALSE(done);
        EXPECT_EQ(done.error().code, "FEED0001");
    }
}

TEST(FeedPlanner, RefusesALimitOfZero) {
    feed::LimitSet limits = one_axis();
    limits.of[0].jerk = 0;
    FeedPlanner planner(limits, {}, [](const Interval&, const ProfilePiece&) {});
    for (const Interval& interval : line(10)) planner.push(interval);
    const auto done = planner.finish();
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().code, "FEED0006");
}

}  // namespace
}  // namespace trunnion::test
