// What more of each limit is worth, and what calm costs: against plans that are made with it.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "trunnion/base/quantity.hpp"
#include "trunnion/path/rotary_stands.hpp"

#include "planned.hpp"

namespace trunnion::pipeline {
namespace {

/// X, Y and A move; corners, a rapid, a dwell, a block with its time.
constexpr const char* text =
    "G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG1 X40 F6000\nX40 Y30 A20\nX0\nG4 P0.2\nG0 X60\nG1 X20 Y0\nG93 X0 A0 F20\nM2\n";

PlanOptions asked() {
    PlanOptions out;
    out.worth = true;
    return out;
}

const Worth* find(const Summary& summary, std::string_view what) {
    const auto at = std::find_if(summary.worth.begin(), summary.worth.end(),
                                 [&](const Worth& worth) { return worth.what == what; });
    return at == summary.worth.end() ? nullptr : &*at;
}

void expect_saves(const Planned& base, const char* what, const char* change, const Planned& with) {
    const Worth* found = find(*base.summary, what);
    ASSERT_TRUE(found && found->saves_s) << what;
    ASSERT_TRUE(with.summary) << what;
    EXPECT_EQ(found->change, change) << what;
    EXPECT_NEAR(*found->saves_s, base.summary->cycle_time_s - with.summary->cycle_time_s, 1e-9) << what;
}

TEST(Worth, is_what_a_plan_with_more_of_the_limit_saves) {
    const Planned base(text, asked());
    ASSERT_TRUE(base.summary) << to_string(base.summary.error());
    const auto on_a_machine_with = [&](int axis, double machine::AxisLimits::* limit) {
        machine::Machine machine = base.machine;
        machine.axes[axis].feed.*limit *= 1.1;
        machine.axes[axis].rapid.*limit *= 1.1;
        return Planned(machine, text);
    };
    expect_saves(base, "X velocity", "+10 %", on_a_machine_with(0, &machine::AxisLimits::velocity));
    expect_saves(base, "Y acceleration", "+10 %", on_a_machine_with(1, &machine::AxisLimits::acceleration));
    expect_saves(base, "X jerk", "+10 %", on_a_machine_with(0, &machine::AxisLimits::jerk));
    expect_saves(base, "A jerk", "+10 %", on_a_machine_with(3, &machine::AxisLimits::jerk));
    PlanOptions faster, wider, turned, restless;
    faster.feed_override = 1.1;
    wider.smoothing.tip_tolerance_mm *= 2;
    turned.smoothing.orientation_tolerance_rad *= 2;
    restless.feed.calm = 0;
    expect_saves(base, "feed", "+10 %", Planned(text, faster));
    expect_saves(base, "tip tolerance", "x 2", Planned(text, wider));
    expect_saves(base, "orientation tolerance", "x 2", Planned(text, turned));
    expect_saves(base, "calm", "off", Planned(text, restless));
    EXPECT_GT(*find(*base.summary, "X jerk")->saves_s, 0.01);
    EXPECT_GT(*find(*base.summary, "feed")->saves_s, 0.01);
}

TEST(Worth, asks_for_what_can_matter_and_begins_with_what_saves_most) {
    const Planned base(text, asked());
    ASSERT_TRUE(base.summary);
    const auto& worth = base.summary->worth;
    EXPECT_EQ(worth.size(), 3u * 4 + 1 + 2 + 1);  // rotary moves turn the workpiece: Z moves too, C does not
    EXPECT_FALSE(find(*base.summary, "C jerk"));
    for (std::size_t k = 1; k < worth.size(); ++k) EXPECT_GE(*worth[k - 1].saves_s, *worth[k].saves_s);
    EXPECT_TRUE(find(*base.summary, "X jerk")->gradient_s);
    EXPECT_TRUE(find(*base.summary, "feed")->gradient_s);
    EXPECT_FALSE(find(*base.summary, "tip tolerance")->gradient_s);
    EXPECT_FALSE(find(*base.summary, "calm")->gradient_s);
    EXPECT_NE(base.summary->report().find("\nworth "), std::string::npos);
    const auto json = nlohmann::json::parse(to_json(*base.summary));
    ASSERT_EQ(json["worth"].size(), worth.size());
    EXPECT_EQ(json["worth"][0]["what"], worth[0].what);
    EXPECT_EQ(json["worth"][0]["saves_s"], *worth[0].saves_s);

    PlanOptions other = asked();
    other.smoothing.flank_tolerance_mm = 0.02;
    other.feed.calm = 0;
    other.feed.tip_jerk_mm_s3 = 1e5;
    const Planned flank(text, other);
    ASSERT_TRUE(flank.summary);
    EXPECT_TRUE(find(*flank.summary, "flank tolerance"));
    EXPECT_FALSE(find(*flank.summary, "orientation tolerance"));
    EXPECT_FALSE(find(*flank.summary, "calm"));
    EXPECT_TRUE(find(*flank.summary, "tip jerk"));
    EXPECT_FALSE(find(*flank.summary, "tip acceleration"));
    other.smoothing.rounding = smoothing::Rounding::none;
    const Planned exact(text, other);
    ASSERT_TRUE(exact.summary);
    EXPECT_FALSE(find(*exact.summary, "tip tolerance"));
}

TEST(Worth, changes_nothing_in_the_plan_and_is_the_same_on_two_threads) {
    PlanOptions two_threads = asked();
    two_threads.threads = 2;
    const Planned plain(text), base(text, asked()), two(text, two_threads);
    ASSERT_TRUE(plain.summary && base.summary && two.summary);
    EXPECT_TRUE(plain.summary->worth.empty());
    EXPECT_EQ(plain.summary->report().find("\nworth "), std::string::npos);
    EXPECT_EQ(plain.recorder.rows.size(), base.recorder.rows.size());
    EXPECT_EQ(plain.summary->cycle_time_s, base.summary->cycle_time_s);
    ASSERT_EQ(base.summary->worth.size(), two.summary->worth.size());
    for (std::size_t k = 0; k < base.summary->worth.size(); ++k) {
        EXPECT_EQ(base.summary->worth[k].what, two.summary->worth[k].what);
        EXPECT_EQ(base.summary->worth[k].saves_s, two.summary->worth[k].saves_s);
        EXPECT_EQ(base.summary->worth[k].gradient_s, two.summary->worth[k].gradient_s);
    }
}

TEST(Worth, tells_its_progress_and_can_be_cancelled) {
    for (const int threads : {1, 2}) {
        PlanOptions options = asked();
        options.threads = threads;
        const Planned whole(text, options), plain(text);
        ASSERT_TRUE(whole.summary && plain.summary);
        const auto& shares = whole.recorder.shares;
        EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
        EXPECT_GE(shares.front(), 0);
        EXPECT_DOUBLE_EQ(shares.back(), 1);
        ASSERT_GT(shares.size(), plain.recorder.shares.size() + 40);
        const auto late = static_cast<int>(plain.recorder.shares.size()) + 30;
        for (const int calls : {late, static_cast<int>(shares.size()) - 2}) {
            const Planned stopped(text, options, calls);
            ASSERT_FALSE(stopped.summary);
            EXPECT_EQ(stopped.summary.error().code, "PIPE0002");
            EXPECT_EQ(stopped.recorder.rows.size(), whole.recorder.rows.size());  // all were there before
        }
    }
}

TEST(Worth, a_change_that_cannot_be_planned_is_told) {
    // A corner just beyond the pole, then rotary words: with twice the tolerance rounding passes the pole on this side.
    auto machine = files::read_machine_file(TRUNNION_SOURCE_DIR "/data/machines/ucp710.toml");
    ASSERT_TRUE(machine);
    program::Program program;
    for (int k = -1; k <= 1; ++k) {
        program::Move move;
        move.position_mm = {10.0 * k, 0, 0};
        move.axis = Eigen::Vector3d(0.1 * k, k == 0 ? -2e-4 : 0.05, 1).normalized();
        move.feed = {program::FeedRule::tip_speed, 50};
        move.line = k + 2;
        program.moves.push_back(move);
    }
    const auto stands = path::choose_rotary_stands(program, *machine, {});
    ASSERT_TRUE(stands);
    program.rotary_letters = {'A', 'C'};
    program::Move words = program.moves.back();
    words.position_mm.x() += 10;
    words.law = program::OrientationLaw::rotary;
    words.rotary_rad = {stands->back().rotary_rad[0], stands->back().rotary_rad[1], 0};
    words.line = 4;
    program.moves.push_back(words);
    PlanOptions options = asked();
    options.smoothing.orientation_tolerance_rad = 0.008 * degree;
    Recorder recorder;
    const auto summary = plan(program, *machine, {}, options, recorder);
    ASSERT_TRUE(summary) << to_string(summary.error());
    const Worth* found = find(*summary, "orientation tolerance");
    ASSERT_TRUE(found);
    EXPECT_FALSE(found->saves_s);
    EXPECT_EQ(summary->worth.back().what, "orientation tolerance");
    const bool told = std::any_of(summary->diagnostics.begin(), summary->diagnostics.end(),
                                  [](const Diagnostic& d) { return d.code == "PIPE0103" && d.place.line == 4; });
    EXPECT_TRUE(told);
    EXPECT_TRUE(nlohmann::json::parse(to_json(*summary))["worth"].back()["saves_s"].is_null());
}

TEST(Calm, its_price_is_looked_for_where_it_can_be_felt) {
    PlanOptions strong, none, asked_strong = asked();
    strong.feed.calm = asked_strong.feed.calm = 0.5;
    none.feed.calm = 0;
    const Planned usual(text), calm(text, strong), restless(text, none), with_worth(text, asked_strong);
    ASSERT_TRUE(usual.summary && calm.summary && restless.summary && with_worth.summary);
    EXPECT_FALSE(usual.summary->calm.price_s);
    EXPECT_NE(usual.summary->report().find("less than 0.02 %"), std::string::npos);
    ASSERT_TRUE(calm.summary->calm.price_s);
    EXPECT_NEAR(*calm.summary->calm.price_s, calm.summary->cycle_time_s - restless.summary->cycle_time_s, 1e-9);
    EXPECT_GT(*calm.summary->calm.price_s, 0.01);
    EXPECT_TRUE(calm.summary->worth.empty());
    EXPECT_EQ(calm.summary->calm.price_s, with_worth.summary->calm.price_s);
    EXPECT_EQ(restless.summary->calm.price_s, 0);
    const auto json = nlohmann::json::parse(to_json(*calm.summary))["calm"];
    EXPECT_EQ(json["weight"], 0.5);
    EXPECT_NEAR(json["price_share"].get<double>(), *calm.summary->calm.price_s / calm.summary->cycle_time_s, 1e-12);
    EXPECT_TRUE(nlohmann::json::parse(to_json(*usual.summary))["calm"]["price_s"].is_null());
}

}  // namespace
}  // namespace trunnion::pipeline
