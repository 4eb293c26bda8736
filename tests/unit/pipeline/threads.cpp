// One thread or two: the same bits, the same errors.
#include <bit>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "planned.hpp"

namespace trunnion::pipeline {
namespace {

/// Rows over a wavy surface, the tool leaning: thousands of intervals in one stretch.
std::string wavy_rows(int blocks, std::string_view end) {
    std::string text = "G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG1 F3000\n";
    for (int k = 1; k <= blocks; ++k)
        text += fmt::format("X{:.6f} Y{:.6f} Z{:.6f} A{:.6f} C{:.6f}\n", 0.2 * k, 3 * std::sin(0.07 * k),
                            2 * std::cos(0.05 * k) - 2, 12 + 9 * std::cos(0.04 * k), 20 * std::sin(0.03 * k));
    return text + std::string(end);
}

struct Program {
    const char* name;
    std::string text;
};

std::vector<Program> programs() {
    std::string many_stops = "G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG1 F3000\n";
    for (int k = 1; k <= 150; ++k)
        many_stops += fmt::format("X{} Y{} A{}\nM{}\nG4 P0.0{}\n", k % 7, k % 5, k % 9, k % 2 ? 8 : 9, 1 + k % 3);
    return {
        {"moves, events and dwells",
         "G21 G90 G94\nS1000 M3\nG0 X0 Y0 Z0 A0 C0\nG1 X10 F6000\nX10 Y10 A10\nM8\nG4 P0.25\nX0 C40\nG0 "
         "Z20\nX50\nG93\nG1 "
         "X60 A20 F30\nX70 Y20 F60\nM9\nM2\n"},
        {"with TCP off",
         "G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG1 X10 A30 C20 F6000\nM429\nG1 X50 Y60 Z70 A30 C20\nM428\nG1 X0 "
         "Y0 Z0 A0 C0\nM2\n"},
        {"turning in place at the pole",
         "UNITS/MM\nMULTAX/ON\nRAPID\nGOTO/0,0,50,0,0,1\nFEDRAT/2000,MMPM\nGOTO/0,0,5,0,0,1\nGOTO/"
         "10,0,0,0.1,0.05,0.99\nRAPID\nGOTO/20,0,50,0,0,1\nRAPID\nGOTO/0,20,50,0,0,1\nGOTO/0,20,5,0,0,1\nGOTO/"
         "10,20,0,-0.1,0.05,0.99\nFINI\n"},
        {"many stops", many_stops},
        {"one long stretch", wavy_rows(700, "M2\n")},
        {"a range left late", wavy_rows(300, "G0 Z50\nG1 X2000\nM2\n")},
    };
}

Planned planned(const std::string& text, int threads, int cancel = -1) {
    PlanOptions options;
    options.threads = threads;
    options.path_samples = true;
    return Planned(text, options, cancel);
}

bool same_bits(double a, double b) {
    return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

bool same_bits(const motion::Setpoint& a, const motion::Setpoint& b) {
    bool same = a.line == b.line && same_bits(a.time_s, b.time_s) && same_bits(a.path_length_mm, b.path_length_mm) &&
                same_bits(a.feed_mm_s, b.feed_mm_s);
    for (int i = 0; i < machine::max_axes; ++i) same = same && same_bits(a.position[i], b.position[i]);
    return same;
}

bool same_bits(const PathSample& a, const PathSample& b) {
    bool same = same_bits(a.p_mm, b.p_mm) && same_bits(a.s_mm, b.s_mm) && same_bits(a.speed_mm_s, b.speed_mm_s) &&
                same_bits(a.speed_limit_mm_s, b.speed_limit_mm_s);
    for (int i = 0; i < machine::max_axes; ++i) same = same && same_bits(a.axes[i].d3(), b.axes[i].d3());
    return same;
}

bool same_bits(const EventRow& a, const EventRow& b) {
    return same_bits(a.time_s, b.time_s) && same_bits(a.s_mm, b.s_mm) && a.event->word == b.event->word;
}

template <class Row>
void expect_same(const std::vector<Row>& a, const std::vector<Row>& b, const char* what) {
    ASSERT_EQ(a.size(), b.size()) << what;
    for (std::size_t k = 0; k < a.size(); ++k) ASSERT_TRUE(same_bits(a[k], b[k])) << what << " " << k;
}

/// The summary without the work that it took.
nlohmann::json results_of(const Summary& summary) {
    auto json = nlohmann::json::parse(to_json(summary));
    json.erase("work");
    json["options"].erase("threads");
    return json;
}

void expect_same(const Planned& one, const Planned& two) {
    expect_same(one.recorder.rows, two.recorder.rows, "row");
    expect_same(one.recorder.events, two.recorder.events, "event");
    expect_same(one.recorder.samples, two.recorder.samples, "path sample");
    EXPECT_EQ(one.recorder.shares, two.recorder.shares);
    ASSERT_EQ(one.summary.has_value(), two.summary.has_value());
    if (one.summary)
        EXPECT_EQ(results_of(*one.summary), results_of(*two.summary));
    else
        EXPECT_EQ(to_string(one.summary.error()), to_string(two.summary.error()));
}

TEST(Threads, give_the_same_bits_and_the_same_errors) {
    for (const Program& program : programs()) {
        SCOPED_TRACE(program.name);
        const Planned one = planned(program.text, 1), two = planned(program.text, 2);
        expect_same(one, two);
        EXPECT_GT(one.recorder.rows.size(), 100u);
    }
}

TEST(Threads, the_error_comes_behind_what_was_planned_before_it) {
    const Planned two = planned(programs().back().text, 2);
    ASSERT_FALSE(two.summary);
    EXPECT_EQ(two.summary.error().code, "PATH0102");
    EXPECT_EQ(two.summary.error().place.line, 305);
    ASSERT_FALSE(two.recorder.rows.empty());
    EXPECT_EQ(two.recorder.rows.back().line, 304);
}

TEST(Threads, the_planner_s_error_is_the_same_however_far_the_path_is_ahead) {
    for (const int threads : {1, 2}) {
        PlanOptions options;
        options.threads = threads;
        options.feed.calm = -1;
        const Planned p(programs().front().text, options);
        ASSERT_FALSE(p.summary);
        EXPECT_EQ(p.summary.error().code, "FEED0001");
        EXPECT_EQ(p.summary.error().place.line, 4);
    }
}

TEST(Threads, can_be_cancelled_anywhere) {
    for (const Program& program : programs())
        for (const int calls : {0, 1, 7, 40}) {
            SCOPED_TRACE(fmt::format("{}, cancelled at call {}", program.name, calls));
            const Planned one = planned(program.text, 1, calls), two = planned(program.text, 2, calls);
            expect_same(one, two);
            if (one.recorder.shares.size() != static_cast<std::size_t>(calls) + 1) continue;  // it ended before
            ASSERT_FALSE(two.summary);
            EXPECT_EQ(two.summary.error().code, "PIPE0002");
        }
}

struct Thrower : PlanObserver {
    int rows_left = 50;
    void setpoint(const motion::Setpoint&) override {
        if (rows_left-- == 0) throw std::runtime_error("no room");
    }
};

TEST(Threads, end_when_the_observer_throws) {
    for (const int threads : {1, 2}) {
        const Planned read("G21 G90 G94\nG0 X0 Y0 Z0 A0 C0\nG1 X1 F600\nM2\n");
        nc::ReadOptions reading;
        reading.machine = &read.machine;
        const auto program = nc::read_program(programs()[3].text, "test.ngc", reading);
        ASSERT_TRUE(program);
        PlanOptions options;
        options.threads = threads;
        Thrower thrower;
        EXPECT_THROW(EXPECT_FALSE(plan(*program, read.machine, {}, options, thrower)), std::runtime_error) << threads;
    }
}

TEST(Threads, other_counts_are_refused) {
    for (const int threads : {-1, 0, 3, 64}) {
        const Planned p = planned(programs().front().text, threads);
        ASSERT_FALSE(p.summary) << threads;
        EXPECT_EQ(p.summary.error().code, "PIPE0001") << threads;
    }
}

}  // namespace
}  // namespace trunnion::pipeline
