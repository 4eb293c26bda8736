#include <gtest/gtest.h>

#include "live_planner_drive.hpp"

namespace trunnion::test {
namespace {

using feed::LivePlanner;
using feed::LiveState;
using feed::LiveStatus;

constexpr double period_s = LiveDrive::period_s;
constexpr std::size_t all_pieces = 31, short_pieces = 19, known_pieces = 15;

/// A path and its begin, which ends behind so many pieces.
struct TwoPaths {
    Stretch whole = random_corners(4, (all_pieces + 1) / 2), begin;
    TwoPaths() {
        begin.machine = whole.machine;
        begin.tool_path = whole.tool_path;
        begin.tool_path.pieces.resize(short_pieces);
        begin.tool_path.blocks[0].end_mm = begin.tool_path.length_mm();
        begin.close();
    }
    path::PathPlace known() const { return {known_pieces - 1, begin.tool_path.pieces[known_pieces - 1].length_mm}; }
    Result<std::optional<LivePlanner>> gone_on(const LivePlanner& from) const {
        return from.gone_on_along(*whole.axis_path, {}, {.same_pieces = known_pieces});
    }
};

std::vector<path::PathPlace> places_ahead(const LivePlanner& planner) {
    std::vector<path::PathPlace> out;
    for (std::size_t k = 0; k <= planner.periods_left(); ++k) out.push_back(planner.ahead(k).place);
    return out;
}

/// The first period at which two plans are not the same.
std::size_t first_difference(const std::vector<path::PathPlace>& a, const std::vector<path::PathPlace>& b) {
    std::size_t k = 0;
    while (k < std::min(a.size(), b.size()) && a[k].piece == b[k].piece && a[k].offset_mm == b[k].offset_mm) ++k;
    return k;
}

std::size_t ticks_to_the_end(LivePlanner& planner) {
    for (std::size_t k = 1; k < 100000; ++k)
        if (planner.tick()->status == LiveStatus::finished) return k;
    return 0;
}

LivePlanner moving(const Stretch& stretch, std::optional<path::PathPlace> end, int ticks) {
    auto out = *LivePlanner::make(*stretch.axis_path, {}, period_s);
    out.set_end(end);
    for (int k = 0; k < ticks; ++k) (void)out.tick();
    return out;
}

TEST(LiveTakeOver, LeadsOnlyAsFarAsItMayAndGoesOnWhenItMay) {
    const TwoPaths paths;
    LivePlanner planner = moving(paths.whole, paths.known(), 0);
    LiveState state;
    do state = *planner.tick();
    while (state.status == LiveStatus::moving);
    EXPECT_EQ(state.status, LiveStatus::holding);
    EXPECT_EQ(state.place.piece, paths.known().piece);
    EXPECT_NEAR(state.place.offset_mm, paths.known().offset_mm, 1e-9);
    for (int k = 0; k < 10; ++k) EXPECT_EQ(planner.tick()->status, LiveStatus::holding);
    planner.set_end({});
    EXPECT_GT(ticks_to_the_end(planner), 100u);
}

TEST(LiveTakeOver, APlanOnTheSamePiecesIsTakenOverAsItIs) {
    const TwoPaths paths;
    const LivePlanner before = moving(paths.begin, paths.known(), 200);
    const auto gone_on = paths.gone_on(before);
    ASSERT_TRUE(gone_on && *gone_on);
    EXPECT_EQ((**gone_on).plans(), before.plans());
    const auto was = places_ahead(before), is = places_ahead(**gone_on);
    EXPECT_EQ(first_difference(was, is), was.size());
}

/// With no more than half a percent of what it takes where the whole path is known from the begin.
TEST(LiveTakeOver, TheLongerPathTakesHardlyMoreTime) {
    const TwoPaths paths;
    auto gone_on = paths.gone_on(moving(paths.begin, paths.known(), 200));
    ASSERT_TRUE(gone_on && *gone_on);
    LivePlanner alone = moving(paths.whole, {}, 200);
    const auto wanted = static_cast<double>(ticks_to_the_end(alone));
    EXPECT_LE(static_cast<double>(ticks_to_the_end(**gone_on)), 1.005 * wanted);
}

TEST(LiveTakeOver, APlanThatLeadsFartherIsLeftBefore) {
    const TwoPaths paths;
    LivePlanner before = moving(paths.begin, {}, 1);
    while (before.ahead(before.periods_left()).place.piece < known_pieces) (void)before.tick();
    auto gone_on = paths.gone_on(before);
    ASSERT_TRUE(gone_on && *gone_on);
    EXPECT_EQ((**gone_on).plans(), before.plans() + 1);
    const std::size_t differs = first_difference(places_ahead(before), places_ahead(**gone_on));
    EXPECT_GE(differs, 2u);
    EXPECT_LT(before.ahead(differs - 1).place.piece, known_pieces);
    EXPECT_GT(ticks_to_the_end(**gone_on), 100u);
}

TEST(LiveTakeOver, AStandingMotionGoesOnToo) {
    const TwoPaths paths;
    const LivePlanner stands = moving(paths.begin, paths.known(), 20000);
    ASSERT_EQ(stands.periods_left(), 0u);
    auto gone_on = paths.gone_on(stands);
    ASSERT_TRUE(gone_on && *gone_on);
    EXPECT_GT(ticks_to_the_end(**gone_on), 100u);
}

TEST(LiveTakeOver, WhatCameTooLateIsTakenBackAndTriedFartherAhead) {
    const Stretch path = random_corners(4, 16);
    LivePlanner planner = moving(path, {}, 300);
    planner.keep();
    for (int late = 0; late < 3; ++late) {
        const auto kept = places_ahead(planner);
        const std::size_t plans = planner.plans();
        planner.hold();
        std::size_t ticks = 0;
        while (planner.plans() == plans && ticks < 100) (void)planner.tick(), ++ticks;
        const std::vector<path::PathPlace> rest(kept.begin() + static_cast<std::ptrdiff_t>(ticks), kept.end());
        const std::size_t differs = first_difference(rest, places_ahead(planner));
        EXPECT_LT(differs, rest.size());
        EXPECT_GE(differs, 100u * static_cast<std::size_t>(late));
        planner.take_back();
        const auto left = places_ahead(planner);
        EXPECT_EQ(first_difference(rest, left), left.size());
    }
}

TEST(LiveTakeOver, WithoutLeaveToPlanThePlanInHandIsFollowed) {
    const Stretch path = random_corners(4, 16);
    LivePlanner planner = moving(path, {}, 100);
    const auto ahead = places_ahead(planner);
    planner.hold();
    const std::size_t plans = planner.plans();
    for (std::size_t k = 1; k < ahead.size(); ++k) EXPECT_EQ(planner.tick(false)->place.offset_mm, ahead[k].offset_mm);
    EXPECT_EQ(planner.plans(), plans);
}

}  // namespace
}  // namespace trunnion::test
