#include "trunnion/feed/live_planner.hpp"

#include <gtest/gtest.h>

#include "flank_path.hpp"
#include "live_planner_drive.hpp"

namespace trunnion::test {
namespace {

using feed::LivePlanner;
using feed::LiveStatus;
using path::FeedRule;

constexpr double allowed = 1.0005;
constexpr double period = LiveDrive::period_s;

void expect_sound(const LiveDrive& drive) {
    EXPECT_FALSE(drive.failed());
    EXPECT_FALSE(drive.went_back());
    EXPECT_LE(drive.worst_difference(), allowed);
    EXPECT_LE(drive.worst_state(), allowed);
}

void expect_finished(const LiveDrive& drive, const Stretch& stretch) {
    expect_sound(drive);
    EXPECT_EQ(drive.state().status, LiveStatus::finished);
    EXPECT_NEAR(drive.p_mm(), stretch.axis_path->length_mm(), 1e-9);
    EXPECT_EQ(drive.state().speed_mm_s, 0);
}

/// The same path in blocks of random length, all under one feed.
void cut_into_blocks(Stretch& stretch, Random& random, double shortest, double longest) {
    const path::BlockSpan whole = stretch.tool_path.blocks.front();
    stretch.tool_path.blocks.clear();
    for (double p = 0; p < whole.end_mm;) {
        const double length = random.between(shortest, longest);
        const double end = p + 1.5 * length > whole.end_mm ? whole.end_mm : p + length;
        stretch.tool_path.blocks.push_back({p, end, whole.feed, 1, end - p});
        p = end;
    }
}

TEST(LivePlanner, WithoutCommandsItTakesThePlansTime) {
    const auto compare = [](const Stretch& path) {
        const auto plan = feed::plan_stretch(*path.axis_path, {});
        ASSERT_TRUE(plan);
        LiveDrive drive(path);
        while (drive.tick()) {}
        expect_finished(drive, path);
        const double took = static_cast<double>(drive.ticks()) * period;
        EXPECT_LE(took, 1.003 * plan->profile.duration_s() + period);
        EXPECT_GE(took, 0.997 * plan->profile.duration_s());
    };
    compare(straight({100, 0, 0, 0, 0}, 100, trunnion_limits()));
    compare(straight({100, 0, 0, 0, 0}, 100, trunnion_limits(), {FeedRule::tip_speed, 30}));
    compare(past_the_pole(1e-3));
    if (const auto flank = flank_path()) compare(*flank);
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        SCOPED_TRACE(seed);
        compare(random_corners(seed, seed == 12 ? 60 : 12));
    }
}

TEST(LivePlanner, AHoldOnALineTakesTheShortestStop) {
    int holds = 0, nearly_shortest = 0;
    for (std::uint64_t seed = 1; seed <= 100; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        const double along = random.between(20, 100);
        const double feed = random.unit() < 0.5 ? random.between(5, 150) : 1e4;
        const Stretch line =
            straight({along, 30, 0, 0, random.between(0, 0.2)}, 100, trunnion_limits(), {FeedRule::tip_speed, feed});
        LiveDrive drive(line);
        const int before = static_cast<int>(random.between(1, 1000));
        for (int k = 0; k < before && drive.tick(); ++k) {}
        drive.planner().hold();
        drive.tick();
        drive.tick();
        if (drive.state().status != LiveStatus::moving) continue;
        const double shortest = stopping_bound_s(line, drive.state());
        const auto from = drive.ticks();
        drive.run_until_standing();
        expect_sound(drive);
        // It stood somewhere in the last period.
        const double took = static_cast<double>(drive.ticks() - from) * period;
        EXPECT_GT(took, 0.99 * shortest);
        EXPECT_LT(took - period, 1.2 * shortest);
        nearly_shortest += took - period < 1.03 * shortest;
        ++holds;
    }
    EXPECT_GT(holds, 60);
    EXPECT_GE(nearly_shortest, 0.95 * holds);
}

TEST(LivePlanner, AHoldStandsUntilResumed) {
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        const Stretch path = random_corners(seed, 8);
        LiveDrive drive(path);
        for (int k = 0, n = static_cast<int>(random.between(1, 3000)); k < n && drive.tick(); ++k) {}
        if (drive.state().status == LiveStatus::finished) continue;
        drive.planner().hold();
        drive.run_until_standing();
        const double place = drive.p_mm();
        for (int k = 0; k < 50; ++k) drive.tick();
        EXPECT_EQ(drive.p_mm(), place);
        if (drive.state().status == LiveStatus::finished) continue;
        EXPECT_EQ(drive.state().status, LiveStatus::holding);
        drive.planner().resume();
        while (drive.tick()) {}
        expect_finished(drive, path);
    }
}

/// Where the axes turn no closed form tells the shortest stop. Every place on the way is tried as a block's end at
/// which the machine is made to stop: the planner's own search for the place is not used.
double shortest_stop_by_trying(const Stretch& path, int before, double nearest_mm, double farthest_mm) {
    double best = 1e9;
    constexpr int places = 30;
    for (int k = 0; k <= places; ++k) {
        const double place = nearest_mm * std::pow(farthest_mm / nearest_mm, static_cast<double>(k) / places);
        Stretch cut;
        cut.machine = path.machine;
        cut.tool_path = path.tool_path;
        path::BlockSpan first = cut.tool_path.blocks.front(), second = first;
        cut.close();
        LiveDrive drive(cut);
        for (int i = 0; i < before; ++i) drive.tick();
        const double end = drive.p_mm() + place;
        if (end >= first.end_mm) break;
        first.end_mm = second.begin_mm = end;
        cut.tool_path.blocks = {first, second};
        drive.planner().set_single_block(true);
        drive.tick();
        drive.tick();
        const auto from = drive.ticks();
        drive.run_until_standing();
        if (std::abs(drive.p_mm() - end) < 1e-6)
            best = std::min(best, static_cast<double>(drive.ticks() - from) * period);
    }
    return best;
}

TEST(LivePlanner, AHoldInCornersTakesNearlyTheShortestStop) {
    int compared = 0;
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        const Stretch path = random_corners(seed, 4);
        const int before = static_cast<int>(random.between(100, 900));
        LiveDrive drive(path);
        for (int k = 0; k < before; ++k) drive.tick();
        const double here = drive.p_mm();
        drive.planner().hold();
        drive.tick();
        drive.tick();
        if (drive.state().status != LiveStatus::moving) continue;
        const auto from = drive.ticks();
        const double bound = stopping_bound_s(path, drive.state());
        drive.run_until_standing();
        expect_sound(drive);
        const double took = static_cast<double>(drive.ticks() - from) * period, way = drive.p_mm() - here;
        EXPECT_GE(took, 0.99 * bound);
        const double shortest = shortest_stop_by_trying(path, before, 0.3 * way, 1.1 * way);
        EXPECT_LE(took - period, 1.2 * shortest);
        compared += shortest < 10 * bound;  // some place was found
    }
    EXPECT_GE(compared, 5);
}

TEST(LivePlanner, OverrideZeroHoldsUntilItIsRaised) {
    const Stretch path = straight({100, 0, 0, 0, 0}, 100, trunnion_limits(), {FeedRule::tip_speed, 40});
    LiveDrive drive(path);
    for (int k = 0; k < 700; ++k) drive.tick();
    ASSERT_TRUE(drive.planner().set_feed_override(0));
    drive.run_until_standing();
    EXPECT_EQ(drive.state().status, LiveStatus::holding);
    drive.planner().resume();  // is no cause to move
    for (int k = 0; k < 20; ++k) drive.tick();
    EXPECT_EQ(drive.state().status, LiveStatus::holding);
    ASSERT_TRUE(drive.planner().set_feed_override(0.5));
    double fastest = 0;
    while (drive.tick()) fastest = std::max(fastest, drive.state().speed_mm_s);
    expect_finished(drive, path);
    EXPECT_NEAR(fastest, 20, 0.02);
}

TEST(LivePlanner, ARaisedOverrideIsReached) {
    const Stretch path = straight({100, 0, 0, 0, 0}, 100, trunnion_limits(), {FeedRule::tip_speed, 20});
    LiveDrive drive(path);
    for (int k = 0; k < 500; ++k) drive.tick();
    EXPECT_NEAR(drive.tip_feed(), 20, 0.02);
    ASSERT_TRUE(drive.planner().set_feed_override(2));
    // 20 mm/s more at 5000 mm/s³: 2 √(20/5000) = 0.126 s.
    for (int k = 0; k < 135; ++k) drive.tick();
    EXPECT_NEAR(drive.tip_feed(), 40, 0.05);
    while (drive.tick()) {
        EXPECT_LE(drive.tip_feed(), allowed * 40);
    }
    expect_finished(drive, path);
}

TEST(LivePlanner, ALoweredOverrideHoldsAsSoonAsTheLimitsAllow) {
    for (const double factor : {0.9, 0.5, 0.1, 0.01}) {
        SCOPED_TRACE(factor);
        const Stretch path = straight({100, 0, 0, 0, 0}, 100, trunnion_limits(), {FeedRule::tip_speed, 60});
        LiveDrive drive(path);
        for (int k = 0; k < 900; ++k) drive.tick();
        EXPECT_NEAR(drive.tip_feed(), 60, 0.06);
        ASSERT_TRUE(drive.planner().set_feed_override(factor));
        const double shortest = 2 * std::sqrt(60 * (1 - factor) / 5000);
        for (int k = 0; k < 2 + static_cast<int>(1.15 * shortest / period); ++k) {
            drive.tick();
            EXPECT_LE(drive.tip_feed(), allowed * 60);
        }
        for (int k = 0; k < 100; ++k) {
            drive.tick();
            EXPECT_LE(drive.tip_feed(), allowed * 60 * factor);
        }
        EXPECT_NEAR(drive.tip_feed(), 60 * factor, factor * 0.6);
        expect_sound(drive);
    }
}

TEST(LivePlanner, ALargestSpeedCountsAsSoonAsTheLimitsAllow) {
    const Stretch path = straight({100, 0, 0, 0, 0}, 100, trunnion_limits(), {FeedRule::tip_speed, 60});
    LiveDrive drive(path);
    for (int k = 0; k < 700; ++k) drive.tick();
    const std::size_t plans = drive.planner().plans();
    ASSERT_TRUE(drive.planner().set_largest_speed(70));  // changes nothing
    drive.tick();
    EXPECT_EQ(drive.planner().plans(), plans);
    ASSERT_TRUE(drive.planner().set_largest_speed(15));
    const double shortest = 2 * std::sqrt(45 / 5000.0);
    for (int k = 0; k < 2 + static_cast<int>(1.15 * shortest / period); ++k) drive.tick();
    for (int k = 0; k < 100; ++k) {
        drive.tick();
        EXPECT_LE(drive.tip_feed(), allowed * 15);
    }
    EXPECT_NEAR(drive.tip_feed(), 15, 0.15);
    ASSERT_TRUE(drive.planner().set_feed_override(2));  // the tip stays below
    for (int k = 0; k < 100; ++k) drive.tick();
    EXPECT_NEAR(drive.tip_feed(), 15, 0.15);
    ASSERT_TRUE(drive.planner().set_largest_speed(0));
    drive.run_until_standing();
    EXPECT_EQ(drive.state().status, LiveStatus::holding);
    ASSERT_TRUE(drive.planner().set_largest_speed(90));
    double fastest = 0;
    while (drive.tick()) fastest = std::max(fastest, drive.tip_feed());
    EXPECT_NEAR(fastest, 90, 0.1);
    expect_finished(drive, path);
}

TEST(LivePlanner, ALargestSpeedHoldsForRapidsAndBlockTimesAndNotForTurns) {
    const auto fastest = [](Stretch path, bool rapid) {
        path.tool_path.rapid = rapid;
        LiveDrive drive(path);
        EXPECT_TRUE(drive.planner().set_largest_speed(30));
        double out = 0;
        while (drive.tick()) out = std::max(out, drive.state().speed_mm_s);
        expect_finished(drive, path);
        return out;
    };
    EXPECT_NEAR(fastest(straight({300, 0, 0, 0, 0}, 300, trunnion_limits()), true), 30, 0.03);
    EXPECT_NEAR(fastest(straight({300, 0, 0, 0, 0}, 300, trunnion_limits(), {FeedRule::block_time, 2}), false), 30,
                0.03);
    EXPECT_GT(fastest(straight({0, 0, 0, 1, 0}, 60, trunnion_limits(), {FeedRule::rotary_rate, 3}), false), 31);
}

TEST(LivePlanner, RapidsFollowTheirOwnOverride) {
    Stretch path = straight({300, 0, 0, 0, 0}, 300, trunnion_limits());
    path.tool_path.rapid = true;
    LiveDrive drive(path);
    ASSERT_TRUE(drive.planner().set_feed_override(0));
    ASSERT_TRUE(drive.planner().set_rapid_override(0.25));
    double fastest = 0;
    while (drive.tick()) fastest = std::max(fastest, drive.state().speed_mm_s);
    expect_finished(drive, path);
    EXPECT_NEAR(fastest, 125, 0.2);
}

TEST(LivePlanner, SingleBlockStandsAtEveryBlocksEnd) {
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        Stretch path = random_corners(seed, 5);
        cut_into_blocks(path, random, seed < 3 ? 0.02 : 1, seed < 3 ? 1 : 12);
        LiveDrive drive(path);
        drive.planner().set_single_block(true);
        for (const path::BlockSpan& block : path.tool_path.blocks) {
            drive.run_until_standing();
            ASSERT_NEAR(drive.p_mm(), block.end_mm, 1e-6);
            for (int k = 0; k < 5; ++k) drive.tick();
            ASSERT_NEAR(drive.p_mm(), block.end_mm, 1e-6);
            drive.planner().resume();
        }
        expect_finished(drive, path);
    }
}

TEST(LivePlanner, SingleBlockSwitchedOnInMotionStopsAtABlocksEndThatCanBeMet) {
    for (std::uint64_t seed = 1; seed <= 30; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        Stretch path = straight({100, 20, 0, 0, 0}, 100, trunnion_limits(), {FeedRule::tip_speed, 50});
        cut_into_blocks(path, random, 1, 15);
        LiveDrive drive(path);
        for (int k = 0, n = static_cast<int>(random.between(200, 1500)); k < n; ++k) drive.tick();
        drive.planner().set_single_block(true);
        drive.tick();
        drive.tick();
        const double here = drive.p_mm();
        // On a line at a steady speed v the shortest stop takes v √(v/j), j = that of the path.
        const double jerk = 5000 / 1.0, v = drive.state().speed_mm_s;
        const double shortest = v * std::sqrt(v / jerk);
        drive.run_until_standing();
        expect_sound(drive);
        const auto& blocks = path.tool_path.blocks;
        const auto met = std::find_if(blocks.begin(), blocks.end(), [&](const path::BlockSpan& block) {
            return std::abs(block.end_mm - drive.p_mm()) < 1e-6;
        });
        ASSERT_NE(met, blocks.end()) << "stands at " << drive.p_mm();
        if (std::abs(drive.state().acceleration_mm_s2) > 0) continue;
        EXPECT_LE(met->begin_mm, here + 1.1 * shortest) << "a block's end nearer by could have been met";
        drive.planner().set_single_block(false);
        drive.planner().resume();
        while (drive.tick()) {}
        expect_finished(drive, path);
    }
}

TEST(LivePlanner, SingleBlockSwitchedOffInMotionStopsNoMore) {
    Stretch path = straight({100, 20, 0, 0, 0}, 100, trunnion_limits(), {FeedRule::tip_speed, 50});
    Random random(1);
    cut_into_blocks(path, random, 10, 20);
    for (const double before_end : {8.0, 0.01}) {  // the latter: when it brakes already
        LiveDrive drive(path);
        drive.planner().set_single_block(true);
        while (drive.tick() && drive.p_mm() < path.tool_path.blocks[0].end_mm - before_end) {}
        drive.planner().set_single_block(false);
        for (int k = 0; k < 20000 && drive.tick(); ++k) {}
        expect_finished(drive, path);
    }
}

/// Any command at any time.
void command(LivePlanner& planner, Random& random) {
    const double which = random.unit(), factor = random.between(0, 2);
    if (which < 0.35)
        ASSERT_TRUE(planner.set_feed_override(factor));
    else if (which < 0.45)
        ASSERT_TRUE(planner.set_feed_override(which < 0.38 ? 0 : 1));
    else if (which < 0.5)
        ASSERT_TRUE(planner.set_largest_speed(100 * factor));
    else if (which < 0.6)
        planner.hold();
    else if (which < 0.85)
        planner.resume();
    else
        planner.set_single_block(which < 0.92);
}

void drive_under_random_commands(const Stretch& path, std::uint64_t seed, double between) {
    Random random(seed);
    LiveDrive drive(path);
    const path::Feed feed = path.tool_path.blocks.front().feed;
    for (int k = 0; k < 30 && drive.state().status != LiveStatus::finished; ++k) {
        command(drive.planner(), random);
        for (int n = static_cast<int>(random.between(0, between)); n >= 0 && drive.tick(); --n) {
            if (feed.rule == FeedRule::tip_speed) {
                EXPECT_LE(drive.tip_feed(), 2 * allowed * feed.value);
            }
        }
    }
    drive.planner().set_single_block(false);
    ASSERT_TRUE(drive.planner().set_feed_override(1));
    ASSERT_TRUE(drive.planner().set_largest_speed(std::numeric_limits<double>::infinity()));
    for (int k = 0; k < 1000000 && drive.state().status != LiveStatus::finished; ++k) {
        if (drive.state().status == LiveStatus::holding) drive.planner().resume();
        drive.planner().resume();
        if (!drive.tick()) break;
    }
    expect_finished(drive, path);
}

TEST(LivePlanner, RandomCommandsBreakNoLimit) {
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        SCOPED_TRACE(seed);
        Random random(seed);
        Stretch path = random_corners(seed, 8);
        cut_into_blocks(path, random, 0.5, 10);
        drive_under_random_commands(path, seed, seed % 3 == 0 ? 20 : 200);
    }
}

TEST(LivePlanner, RandomCommandsNearThePoleBreakNoLimit) {
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
        SCOPED_TRACE(seed);
        const Stretch path = past_the_pole(seed % 2 ? 1e-1 : 1e-3);
        drive_under_random_commands(path, seed, 150);
    }
}

TEST(LivePlanner, TheSameCommandsGiveTheSameMotion) {
    const Stretch path = random_corners(5, 8);
    const auto run = [&] {
        std::vector<double> places;
        Random random(3);
        LiveDrive drive(path);
        for (int k = 0; k < 15; ++k) {
            command(drive.planner(), random);
            for (int n = 0; n < 80; ++n) {
                drive.tick();
                places.push_back(drive.p_mm());
            }
        }
        return places;
    };
    EXPECT_EQ(run(), run());
}

TEST(LivePlanner, BadInputIsRefused) {
    const Stretch path = straight({100, 0, 0, 0, 0}, 100, trunnion_limits());
    const auto code = [](const auto& result) { return result ? std::string("none") : result.error().code; };
    const double nan = std::nan("");
    EXPECT_EQ(code(LivePlanner::make(*path.axis_path, {}, 0)), "FEED0011");
    EXPECT_EQ(code(LivePlanner::make(*path.axis_path, {}, nan)), "FEED0011");
    EXPECT_EQ(code(LivePlanner::make(*path.axis_path, {}, -1e-3)), "FEED0011");
    EXPECT_EQ(code(LivePlanner::make(*path.axis_path, {.calm = -1}, 1e-3)), "FEED0001");
    auto planner = LivePlanner::make(*path.axis_path, {}, 1e-3);
    ASSERT_TRUE(planner);
    for (const double factor : {nan, -0.01, 2.01, std::numeric_limits<double>::infinity()}) {
        EXPECT_EQ(code(planner->set_feed_override(factor)), "FEED0010");
        EXPECT_EQ(code(planner->set_rapid_override(factor)), "FEED0010");
    }
    EXPECT_EQ(code(planner->set_rapid_override(1.01)), "FEED0010");
    EXPECT_EQ(code(planner->set_largest_speed(-1)), "FEED0010");
    EXPECT_EQ(code(planner->set_largest_speed(nan)), "FEED0010");
    EXPECT_EQ(code(planner->set_feed_override(2)), "none");
    const Stretch no_feed = straight({100, 0, 0, 0, 0}, 100, trunnion_limits(), {FeedRule::tip_speed, 0});
    EXPECT_EQ(code(LivePlanner::make(*no_feed.axis_path, {}, 1e-3)), "FEED0008");
}

}  // namespace
}  // namespace trunnion::test
