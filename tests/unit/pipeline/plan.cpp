#include "trunnion/pipeline/plan.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "trunnion/base/quantity.hpp"

#include "planned.hpp"

namespace trunnion::pipeline {
namespace {

TEST(Plan, a_line_takes_the_time_that_theory_says) {
    const Planned p("G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG1 X100 F60000\n");
    ASSERT_TRUE(p.summary) << to_string(p.summary.error());
    // 100 mm, no speed limit reached: jerk 20000, acceleration 2500: t = 0.125 s of jerk, then a plateau
    const double tj = 2500.0 / 20000, v = (-2500 * tj + std::sqrt(2500 * tj * 2500 * tj + 4 * 2500 * 100.0)) / 2;
    EXPECT_NEAR(p.summary->cycle_time_s, 2 * (v / 2500 + tj), 1e-3);
    EXPECT_TRUE(p.summary->usable());
    EXPECT_EQ(p.summary->exact_stops.total, 0);
    EXPECT_NEAR(p.summary->path_length_mm, 100, 1e-9);
}

TEST(Plan, rows_are_one_period_apart_and_begin_and_end_at_rest) {
    const Planned p("G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG1 X10 F6000\nX10 Y10 A10\nG4 P0.25\nX0\nM2\n");
    ASSERT_TRUE(p.summary) << to_string(p.summary.error());
    const auto& rows = p.recorder.rows;
    ASSERT_EQ(rows.size(), p.summary->setpoints);
    for (std::size_t k = 0; k < rows.size(); ++k) EXPECT_DOUBLE_EQ(rows[k].time_s, 0.001 * static_cast<double>(k));
    EXPECT_EQ(rows.front().feed_mm_s, 0);
    EXPECT_EQ(rows.back().feed_mm_s, 0);
    EXPECT_GE(rows.back().time_s, p.summary->cycle_time_s);
    EXPECT_LT(rows.back().time_s, p.summary->cycle_time_s + 0.001 + 1e-12);
    EXPECT_NEAR(rows.back().position[0], rows.front().position[0], 1e-12);
    for (std::size_t k = 1; k < rows.size(); ++k) EXPECT_GE(rows[k].path_length_mm, rows[k - 1].path_length_mm);
}

TEST(Plan, a_dwell_holds_the_axes_for_its_time) {
    const Planned with("G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG1 X10 F6000\nG4 P0.25\nX20\nM2\n");
    const Planned without("G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG1 X10 F6000\nG4 P0.0001\nX20\nM2\n");
    ASSERT_TRUE(with.summary && without.summary);
    EXPECT_NEAR(with.summary->cycle_time_s - without.summary->cycle_time_s, 0.25 - 0.0001, 1e-9);
    EXPECT_DOUBLE_EQ(with.summary->dwell_time_s, 0.25);
    EXPECT_EQ(with.summary->exact_stops.total, 1);
    EXPECT_EQ(with.summary->exact_stops.dwells, 1);
    int still = 0;
    const auto& rows = with.recorder.rows;
    for (std::size_t k = 1; k < rows.size(); ++k) still += rows[k].position == rows[k - 1].position;
    EXPECT_GE(still, 248);
    EXPECT_LE(still, 252);
}

TEST(Plan, events_keep_their_place_and_order) {
    const Planned p("G21 G90 G94\nS1000 M3\nG0 X0 Y0 Z0 A0 C0\nG1 X10 F6000\nM8\nX20\nM9\nX30\nM5\nX40\nM2\n");
    ASSERT_TRUE(p.summary) << to_string(p.summary.error());
    std::vector<std::string> words;
    for (const auto& e : p.recorder.events) words.push_back(e.event->word);
    const std::vector<std::string> want{"S1000", "M3", "M8", "M9", "M5", "M2"};
    std::sort(words.begin(), words.begin() + 2);  // S and M3 of one block
    auto sorted = want;
    std::sort(sorted.begin(), sorted.begin() + 2);
    EXPECT_EQ(words, sorted);
    const auto& e = p.recorder.events;
    for (std::size_t k = 1; k < e.size(); ++k) EXPECT_GE(e[k].time_s, e[k - 1].time_s);
    EXPECT_NEAR(e[2].s_mm, 10, 0.05);
    EXPECT_NEAR(e[3].s_mm, 20, 0.05);
    EXPECT_NEAR(e[4].s_mm, 30, 1e-9);
    EXPECT_NEAR(e[5].time_s, p.summary->cycle_time_s, 1e-9);
    EXPECT_EQ(p.summary->exact_stops.events, 1);  // M5 alone stops between motions
}

TEST(Plan, rounding_none_stops_at_every_corner) {
    PlanOptions options;
    options.smoothing.rounding = smoothing::Rounding::none;
    const char* text = "G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG1 X10 F6000\nX10 Y10\nX20\nX30\nM2\n";
    const Planned stopped(text, options), rounded(text);
    ASSERT_TRUE(stopped.summary && rounded.summary);
    EXPECT_EQ(stopped.summary->exact_stops.corners, 2);  // X20 → X30 is straight on
    EXPECT_EQ(rounded.summary->exact_stops.total, 0);
    EXPECT_LT(rounded.summary->cycle_time_s, stopped.summary->cycle_time_s);
    EXPECT_LE(stopped.summary->tip_deviation_mm, 1e-12);
    EXPECT_GT(rounded.summary->tip_deviation_mm, 0.01);
    EXPECT_LE(rounded.summary->tip_deviation_mm, 0.02);
}

TEST(Plan, feed_options_change_the_feed) {
    const char* text = "G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG1 X100 F1000\nM2\n";
    PlanOptions half, other;
    half.feed_override = 0.5;
    other.feed_mm_s = 25;
    const Planned plain(text), slow(text, half), replaced(text, other);
    const auto top = [](const Planned& p) {
        double v = 0;
        for (const auto& row : p.recorder.rows) v = std::max(v, row.feed_mm_s);
        return v * 60;
    };
    EXPECT_NEAR(top(plain), 1000, 1);
    EXPECT_NEAR(top(slow), 500, 0.5);
    EXPECT_NEAR(top(replaced), 1500, 1.5);
    PlanOptions inverse;
    inverse.feed_override = 2;
    const Planned timed("G21 G90 G93\nG0 X0 Y0 Z0 A0 C0\nG1 X100 F6\nM2\n"),
        faster("G21 G90 G93\nG0 X0 Y0 Z0 A0 C0\nG1 X100 F6\nM2\n", inverse);
    EXPECT_NEAR(timed.summary->cycle_time_s, 10, 0.2);
    EXPECT_NEAR(faster.summary->cycle_time_s, 5, 0.2);
}

TEST(Plan, machine_coordinates_are_taken_literally) {
    const Planned p(
        "G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG1 X10 A30 C20 F6000\nM429\nG1 X50 Y60 Z70 A30 C20\nM428\nG1 X0 Y0 Z0 A0 "
        "C0\nM2\n");
    ASSERT_TRUE(p.summary) << to_string(p.summary.error());
    EXPECT_TRUE(p.summary->usable());
    const bool there = std::any_of(p.recorder.rows.begin(), p.recorder.rows.end(), [](const motion::Setpoint& row) {
        return std::abs(row.position[0] - 50) < 1e-3 && std::abs(row.position[1] - 60) < 1e-3 &&
               std::abs(row.position[2] - 70) < 1e-3;
    });
    EXPECT_TRUE(there);
}

TEST(Plan, the_free_axis_turns_in_place_where_a_stretch_leaves_the_pole_another_way) {
    const Planned p(
        "UNITS/MM\nMULTAX/ON\nRAPID\nGOTO/0,0,50,0,0,1\nFEDRAT/2000,MMPM\nGOTO/0,0,5,0,0,1\nGOTO/10,0,0,0.1,0.05,0.99\n"
        "RAPID\nGOTO/20,0,50,0,0,1\nRAPID\nGOTO/0,20,50,0,0,1\nGOTO/0,20,5,0,0,1\nGOTO/10,20,0,-0.1,0.05,0.99\nFINI\n");
    ASSERT_TRUE(p.summary) << to_string(p.summary.error());
    EXPECT_TRUE(p.summary->usable()) << p.summary->report();
    EXPECT_EQ(p.summary->exact_stops.total, 3);
    const auto& rows = p.recorder.rows;
    double turned = 0;
    for (std::size_t k = 1; k < rows.size(); ++k) {
        const double step = std::abs(rows[k].position[4] - rows[k - 1].position[4]);
        EXPECT_LE(step, 120 * degree * 1e-3 * 1.001) << "row " << k;
        turned += step;
    }
    EXPECT_GT(turned, 45 * degree);
}

TEST(Plan, path_samples_are_there_when_asked_for) {
    PlanOptions options;
    options.path_samples = true;
    const char* text = "G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG1 X10 A10 F6000\nX10 Y10 A0 C30\nM2\n";
    const Planned p(text, options), quiet(text);
    EXPECT_TRUE(quiet.recorder.samples.empty());
    const auto& s = p.recorder.samples;
    ASSERT_GT(s.size(), 100u);
    for (std::size_t k = 1; k < s.size(); ++k) {
        const double h = s[k].p_mm - s[k - 1].p_mm;
        ASSERT_GE(h, 0);
        for (int i = 0; i < 5; ++i) {  // cubic interpolation of the value from both ends' derivatives
            const double step = s[k].axes[i].value() - s[k - 1].axes[i].value();
            EXPECT_NEAR(step,
                        h / 2 * (s[k].axes[i].d1() + s[k - 1].axes[i].d1()) +
                            h * h / 12 * (s[k - 1].axes[i].d2() - s[k].axes[i].d2()),
                        1e-5);
        }
        EXPECT_LE(s[k].speed_mm_s, s[k].speed_limit_mm_s * 1.0005 + 1e-9);
    }
}

TEST(Plan, a_move_shorter_than_a_micrometre_is_planned_over_a_longer_parameter) {
    PlanOptions options;
    options.path_samples = true;
    const auto expect_takes = [&](const char* move, double time_s, double at_most_s) {
        const Planned p(std::string("G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\n") + move + "\nM2\n", options);
        ASSERT_TRUE(p.summary) << move << to_string(p.summary.error());
        EXPECT_TRUE(p.summary->usable()) << move << p.summary->report();
        const auto& samples = p.recorder.samples;
        ASSERT_FALSE(samples.empty());
        EXPECT_GE(samples.back().p_mm - samples.front().p_mm, 1e-3) << move;
        EXPECT_LE(samples.back().p_mm - samples.front().p_mm, 1.01e-3) << move;
        EXPECT_NEAR(p.recorder.rows.back().position[0], 0.0004, 1e-15) << move;
        EXPECT_NEAR(p.summary->path_length_mm, 0.0004, 1e-12) << move;
        EXPECT_GE(p.summary->cycle_time_s, time_s * 0.9999) << move;
        EXPECT_LE(p.summary->cycle_time_s, at_most_s) << move;
        for (const PathSample& sample : samples) EXPECT_LE(sample.speed_mm_s, sample.speed_limit_mm_s * 1.001) << move;
    };
    const double by_jerk = 4 * std::cbrt(0.0004 / (2 * 20000));
    expect_takes("G1 X0.0004 F6000", by_jerk, by_jerk * 1.01);
    expect_takes("G1 X0.0004 F0.6", 0.04, 0.0415);         // feed of the tip: 0.01 mm/s
    expect_takes("G93 G1 X0.0004 F600", 0.1, 0.1 * 1.01);  // the block's time
}

TEST(Plan, feed_drops_say_where_rounding_uses_its_tolerance_up) {
    const auto first_drop_inside = [](const char* text, const PlanOptions& options = {}) {
        const Planned p(text, options);
        EXPECT_TRUE(p.summary && !p.summary->feed_drops.empty()) << text;
        const auto& drops = p.summary->feed_drops;
        const auto inside = std::find_if(drops.begin(), drops.end(), [&](const FeedDrop& drop) {
            return drop.s_from_mm > 1 && drop.s_to_mm < p.summary->path_length_mm - 1;
        });
        return inside == drops.end() ? FeedDrop{.line = -1} : *inside;
    };
    // A corner is slow because of its small radius; so is a circle, but no tolerance would help that.
    const FeedDrop corner = first_drop_inside("G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG1 X50 F6000\nX50 Y50\nM2\n");
    EXPECT_NE(corner.line, -1);
    EXPECT_TRUE(corner.at_tolerance);
    const FeedDrop circle =
        first_drop_inside("G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG1 X100 F18000\nG3 X100 Y40 I0 J20\nG1 X0\nM2\n");
    EXPECT_NE(circle.line, -1);
    EXPECT_FALSE(circle.at_tolerance);
    PlanOptions exact;
    exact.smoothing.rounding = smoothing::Rounding::none;
    const Planned stops("G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG1 X50 F6000\nX50 Y50\nM2\n", exact);
    ASSERT_TRUE(stops.summary);
    for (const FeedDrop& drop : stops.summary->feed_drops) EXPECT_FALSE(drop.at_tolerance);
    const auto json = nlohmann::json::parse(to_json(*stops.summary));
    EXPECT_TRUE(json["feed_drops"][0]["at_tolerance"].is_boolean());
}

TEST(Plan, can_be_cancelled) {
    const Planned p("G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG1 X10 F6000\nG0 X20\nG1 X30\nM2\n", {}, 1);
    ASSERT_FALSE(p.summary);
    EXPECT_EQ(p.summary.error().code, "PIPE0002");
}

TEST(Plan, of_no_tolerance_stands_still_at_corners_and_says_so) {
    PlanOptions options;
    options.smoothing.tip_tolerance_mm = 0;
    const Planned p("G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG1 X10 F6000\nY10\n", options);
    ASSERT_TRUE(p.summary);
    EXPECT_TRUE(p.summary->usable());
    EXPECT_EQ(p.summary->exact_stops.corners, 1U);
    EXPECT_TRUE(std::ranges::any_of(p.summary->diagnostics, [](const Diagnostic& d) { return d.code == "PIPE0104"; }));
}

TEST(Plan, refuses_options_without_meaning) {
    const char* text = "G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG1 X10 F6000\n";
    for (int k = 0; k < 5; ++k) {
        PlanOptions options;
        if (k == 0) options.period_s = 0;
        if (k == 1) options.feed_override = -1;
        if (k == 2) options.feed_mm_s = std::nan("");
        if (k == 3) options.smoothing.tip_tolerance_mm = -0.01;
        if (k == 4) options.smoothing.flank_height_mm = -30;
        const Planned p(text, options);
        ASSERT_FALSE(p.summary) << k;
        EXPECT_EQ(p.summary.error().code, "PIPE0001") << k;
    }
}

TEST(Summary, json_has_what_other_programs_rely_on) {
    const Planned p("G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG1 X100 F60000\nX100 Y100\nM2\n");
    const auto json = nlohmann::json::parse(to_json(*p.summary));
    for (const char* key : {"program",
                            "machine",
                            "controller",
                            "options",
                            "cycle_time_s",
                            "cut_time_s",
                            "rapid_time_s",
                            "dwell_time_s",
                            "path_length_mm",
                            "setpoints",
                            "period_s",
                            "jerk_free_bound_s",
                            "tip_deviation_mm",
                            "orientation_deviation_deg",
                            "height_deviation_mm",
                            "tolerance_used",
                            "exact_stops",
                            "axes",
                            "calm",
                            "feed_drops",
                            "worth",
                            "windows",
                            "fallbacks",
                            "work",
                            "diagnostics"})
        EXPECT_TRUE(json.contains(key)) << key;
    EXPECT_EQ(json["axes"].size(), 5u);
    EXPECT_GT(json["axes"]["X"]["jerk_ratio"].get<double>(), 0.9);
    ASSERT_FALSE(json["feed_drops"].empty());
    EXPECT_NEAR(json["feed_drops"][0]["programmed_feed_mm_min"].get<double>(), 60000, 1e-6);
    EXPECT_NE(p.summary->report().find("cycle time"), std::string::npos);
}

}  // namespace
}  // namespace trunnion::pipeline
