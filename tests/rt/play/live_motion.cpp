#include "trunnion/pipeline/live_motion.hpp"

#include <gtest/gtest.h>

#include "trunnion/pipeline/plan.hpp"

#include "play_planner.hpp"
#include "player.hpp"

namespace trunnion::test {
namespace {

using pipeline::LiveMotion;
using pipeline::LiveMotionStatus;
using pipeline::LiveRow;

constexpr double allowed = 1.001;

struct Moving {
    machine::Machine machine = peer_machine();
    machine::Setup setup;
    OnePart parts;
    pipeline::PlanOptions options;
    Result<LiveMotion> motion;
    RowCheck check{machine};
    std::vector<LiveRow> rows;
    LiveMotionStatus status = LiveMotionStatus::standing;
    std::vector<program::Event> events;

    explicit Moving(const std::string& text, double longest_plan_s = 6)
        : parts(text, machine), motion(LiveMotion::make(parts, machine, setup, options, longest_plan_s)) {
        if (motion) note(motion->begin());
    }
    void note(const LiveRow& row) {
        rows.push_back(row);
        check.note(app::row_of(row, machine));
    }
    /// One tick; waits for the thread that makes the stretches.
    bool tick() {
        for (;;) {
            const auto state = motion->tick();
            if (!state) {
                ADD_FAILURE() << to_string(state.error());
                return false;
            }
            status = state->status;
            events.insert(events.end(), state->events.begin(), state->events.end());
            if (status == LiveMotionStatus::waiting) continue;
            if (status == LiveMotionStatus::moving) note(state->row);
            return status == LiveMotionStatus::moving || status == LiveMotionStatus::standing;
        }
    }
    void run() {
        while (tick()) {}
    }
    void ticks(int count) {
        for (int k = 0; k < count && tick(); ++k) {}
    }
};

/// The time of plan(), which knows nothing of the live one.
double planned_time_s(const std::string& text) {
    const auto machine = peer_machine();
    OnePart parts(text, machine);
    pipeline::PlanObserver nobody;
    return pipeline::plan(parts, machine, {}, {}, nobody)->cycle_time_s;
}

TEST(LiveMotion, TakesTheTimeOfThePlanWithoutCommands) {
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        SCOPED_TRACE(seed);
        const std::string text = random_program(seed, 3);
        Moving moving(text);
        ASSERT_TRUE(moving.motion) << to_string(moving.motion.error());
        moving.run();
        EXPECT_EQ(moving.status, LiveMotionStatus::finished);
        moving.check.stand();
        EXPECT_LE(moving.check.worst(), allowed);
        const double took_s = static_cast<double>(moving.rows.size()) * period_s, planned_s = planned_time_s(text);
        EXPECT_LE(took_s, 1.01 * planned_s + 0.02);
        EXPECT_GE(took_s, 0.995 * planned_s);
    }
}

TEST(LiveMotion, TheRowsAheadAreThoseThatCome) {
    Moving moving(random_program(5, 2));
    std::vector<LiveRow> ahead;
    std::size_t plan = 0, begin = 0, compared = 0, plans = 0;
    for (int k = 0; moving.tick(); ++k) {
        if (k == 700) moving.motion->hold();
        if (k == 1200) moving.motion->resume();
        if (k == 1500) (void)moving.motion->set_feed_override(0.3);
        if (moving.motion->plan() == plan) {
            const std::size_t at = moving.rows.size() - 1 - begin;
            if (at < 1 || moving.status != LiveMotionStatus::moving) continue;
            ASSERT_LE(at, ahead.size());
            ASSERT_EQ(moving.rows.back(), ahead[at - 1]) << k;
            ++compared;
            continue;
        }
        ++plans;
        plan = moving.motion->plan();
        begin = moving.rows.size() - 1;
        moving.motion->rows_ahead(ahead);
        // Whoever plays them alone comes to rest inside all limits.
        RowCheck alone = moving.check;
        for (const LiveRow& row : ahead) alone.note(app::row_of(row, moving.machine));
        alone.stand();
        ASSERT_LE(alone.worst(), allowed);
    }
    EXPECT_GT(compared, 1000u);
    EXPECT_GT(plans, 10u);
}

TEST(LiveMotion, TheSameCommandsGiveTheSameRows) {
    const auto drive = [] {
        Moving moving(random_program(6, 2));
        moving.ticks(400);
        moving.motion->hold();
        moving.ticks(600);
        moving.motion->resume();
        (void)moving.motion->set_feed_override(1.4);
        (void)moving.motion->set_rapid_override(0.5);
        moving.run();
        return moving.rows;
    };
    EXPECT_EQ(drive(), drive());
}

TEST(LiveMotion, PlansAreNoLongerThanAsked) {
    // 100 mm at 0.5 mm/s take 200 s.
    Moving moving("G21 G90 G94\nG0 X0 Y0 Z60 A0 C0\nG1 X100 F30\nM2\n", 3);
    std::vector<LiveRow> ahead;
    for (int k = 0; k < 20000 && moving.tick(); ++k)
        if (k % 100 == 0) {
            moving.motion->rows_ahead(ahead);
            ASSERT_LE(ahead.size(), 3000u);
        }
    ASSERT_EQ(moving.rows.size(), 20001u);
    EXPECT_NEAR(moving.rows.back().position[0], 10, 0.1);  // at the programmed feed all the same
    EXPECT_LE(moving.check.worst(), allowed);
}

TEST(LiveMotion, EventsThatStopWaitForAnAnswer) {
    Moving moving("G21 G90 G94\nG0 X0 Y0 Z60 A0 C0\nM3 S600\nG1 X10 F3000\nM0\nG1 X20\nG4 P0.3\nG1 X30\nM2\n");
    for (const double at : {0, 10}) {  // M3, M0
        moving.run();
        EXPECT_EQ(moving.status, LiveMotionStatus::event);
        EXPECT_NEAR(moving.rows.back().position[0], at, 1e-9);
        moving.motion->resume();
    }
    const std::size_t rows = moving.rows.size();
    moving.run();
    EXPECT_EQ(moving.status, LiveMotionStatus::finished);
    EXPECT_NEAR(moving.rows.back().position[0], 30, 1e-9);
    const auto stood =
        std::ranges::count_if(moving.rows, [](const LiveRow& row) { return std::abs(row.position[0] - 20) < 1e-12; });
    EXPECT_GE(stood, 300);
    EXPECT_LE(stood, 310);
    EXPECT_GT(moving.rows.size(), rows);
    std::string words;
    for (const auto& event : moving.events) words += event.word + " ";
    EXPECT_NE(words.find("M0"), std::string::npos);
    EXPECT_NE(words.find("M3"), std::string::npos);
    moving.check.stand();
    EXPECT_LE(moving.check.worst(), allowed);
}

TEST(LiveMotion, StopEndsItInsideAllLimits) {
    Moving moving(random_program(7, 2));
    moving.ticks(500);
    moving.motion->stop();
    moving.run();
    EXPECT_EQ(moving.status, LiveMotionStatus::stopped);
    moving.check.stand();
    EXPECT_LE(moving.check.worst(), allowed);
    moving.motion->resume();
    const std::size_t rows = moving.rows.size();
    moving.ticks(10);
    EXPECT_EQ(moving.rows.size(), rows);
}

TEST(LiveMotion, SingleBlockStandsBehindEachStretch) {
    Moving moving("G21 G90 G94\nG0 X0 Y0 Z60 A0 C0\nG1 X10 F3000\nG0 X20\nG1 X30\nM2\n");
    moving.motion->set_single_block(true);
    std::vector<double> stops;
    for (int k = 0; k < 20 && moving.status != LiveMotionStatus::finished; ++k) {
        for (int t = 0; t < 3000 && moving.tick(); ++t) {}
        if (stops.empty() || std::abs(stops.back() - moving.rows.back().position[0]) > 1e-9)
            stops.push_back(moving.rows.back().position[0]);
        moving.motion->resume();
    }
    ASSERT_EQ(moving.status, LiveMotionStatus::finished);
    ASSERT_EQ(stops.size(), 3u);
    EXPECT_NEAR(stops[0], 10, 1e-9);
    EXPECT_NEAR(stops[1], 20, 1e-9);
    EXPECT_NEAR(stops[2], 30, 1e-9);
}

TEST(LiveMotion, APlanThatCameTooLateIsTakenBackAndTriedAgain) {
    Moving moving(random_program(8, 1));
    moving.ticks(300);
    moving.motion->keep_plan(0);
    std::vector<LiveRow> kept;
    moving.motion->rows_ahead(kept);
    const std::size_t plan = moving.motion->plan();
    moving.motion->hold();
    std::size_t ticks = 0;
    for (; moving.motion->plan() == plan; ++ticks) moving.tick();
    moving.motion->take_back_plan(0);
    std::vector<LiveRow> left;
    moving.motion->rows_ahead(left);
    ASSERT_LT(ticks, kept.size());
    EXPECT_EQ(left, std::vector<LiveRow>(kept.begin() + static_cast<std::ptrdiff_t>(ticks), kept.end()));
    moving.ticks(50);
    moving.motion->resume();
    moving.run();
    EXPECT_EQ(moving.status, LiveMotionStatus::finished);
    moving.check.stand();
    EXPECT_LE(moving.check.worst(), allowed);
}

TEST(LiveMotion, BadInputIsRefused) {
    Moving moving(random_program(1, 1));
    for (const double bad : {-0.1, 2.1, std::nan("")}) {
        const auto set = moving.motion->set_feed_override(bad);
        ASSERT_FALSE(set);
        EXPECT_EQ(set.error().code, "PIPE0141");
    }
    EXPECT_EQ(moving.motion->set_rapid_override(1.1).error().code, "PIPE0141");
    const auto machine = peer_machine();
    OnePart parts("G21 G90 G94\nG0 X0 Y0 Z60 A0 C0\nG1 X10 F3000\nG1 X9000\nM2\n", machine);
    const auto way = pipeline::check_way(parts, machine, {}, {}, [](double) { return true; });
    ASSERT_FALSE(way);
    EXPECT_EQ(way.error().code, "PATH0102");
    OnePart good(random_program(1, 1), machine);
    EXPECT_TRUE(pipeline::check_way(good, machine, {}, {}, [](double) { return true; }));
    OnePart cancelled(random_program(1, 1), machine);
    EXPECT_EQ(pipeline::check_way(cancelled, machine, {}, {}, [](double) { return false; }).error().code, "PIPE0002");
}

}  // namespace
}  // namespace trunnion::test
