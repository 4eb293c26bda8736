// Axes that go along: extruders in absolute and relative counting, retractions, and back as text.
#include <algorithm>
#include <array>
#include <filesystem>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "trunnion/nc/following.hpp"
#include "trunnion/nc/write.hpp"

#include "random.hpp"
#include "reading.hpp"

namespace trunnion::nc {
namespace {

using program::EventKind;
using program::Program;

constexpr std::string_view start = "G21 G90 G0 X0 Y0 Z0 F600\n";

Result<Program> after_start(std::string_view text) {
    return read_ac(std::string(start) + std::string(text));
}

/// Where E is behind every move, and what stands between: "0 2 [E-1 0.1s] 4"; or the code.
std::string way_of(const Program& p) {
    std::string out;
    std::size_t event = 0;
    for (std::size_t k = 0; k <= p.moves.size(); ++k) {
        for (; event < p.events.size() && p.events[event].before_move == k; ++event) {
            const program::Event& what = p.events[event];
            const std::string time = what.kind == EventKind::dwell ? fmt::format(" {:g}s", what.dwell_s) : "";
            out += fmt::format("{}[{}{}{}]", out.empty() ? "" : " ", what.word, time, what.stops_motion ? "!" : "");
        }
        if (k == p.moves.size()) break;
        out += out.empty() ? "" : " ";
        for (std::size_t i = 0; i < p.following_letters.size(); ++i)
            out += fmt::format("{}{:g}", i > 0 ? "," : "", p.following[k * p.following_letters.size() + i]);
    }
    return out;
}

std::string way_of(std::string_view text) {
    const auto p = after_start(text);
    return p ? way_of(*p) : p.error().code;
}

TEST(Following, IsCountedFromZeroOrFromWhereItIs) {
    EXPECT_EQ(way_of("G1 X1 E2\nX2 E3.5\nX3\n"), "0 2 3.5 3.5");
    EXPECT_EQ(way_of("M83\nG1 X1 E2\nX2 E3.5\nX3\n"), "0 [M83] 2 5.5 5.5");
    EXPECT_EQ(way_of("M83\nG1 X1 E2\nM82\nX2 E3.5\n"), "0 [M83] 2 [M82] 3.5");
    EXPECT_EQ(way_of("G91\nG1 X1 E2\nX1 E2\n"), "0 2 4") << "neither M82 nor M83: as G91 says";
    EXPECT_EQ(way_of("M83\nG91 G1 X1 E2\nG90 X2 E1\n"), "0 [M83] 2 3") << "G90 and G91 leave M83 as it is";
    EXPECT_EQ(way_of("G20\nG1 X1 E1\n"), "0 25.4") << "a length, in the unit in force";
    EXPECT_EQ(way_of("G0 X1 E2\nG2 X3 I1 E5\n"), "0 2 5") << "with rapids and arcs too";
    EXPECT_EQ(way_of("G93 G1 X1 E2 F30\n"), "0 2");
}

TEST(Following, AbsoluteUnderG91IsTold) {
    const auto p = after_start("M82\nG91 G1 X1 E2\nX1 E3\n");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(way_of(*p), "0 [M82] 2 3");
    EXPECT_EQ(told(*p, "NC0353", "E")->count, 2);
    EXPECT_FALSE(told(*after_start("M82\nG1 X1 E2\n"), "NC0353"));
}

TEST(Following, G92SetsWhatItCounts) {
    EXPECT_EQ(way_of("G1 X1 E2\nG92 E0\nX2 E3\n"), "0 2 [G92 E0] 5") << "totals run on";
    EXPECT_EQ(way_of("G92 E10\nG1 X1 E12\n"), "0 [G92 E10] 2");
    EXPECT_EQ(way_of("G1 X1 E2\nG92 X0 E0\nX2 E3\n"), "0 2 [G92 E0] 5") << "beside axes";
    EXPECT_EQ(way_of("G92 E5\nG92.1\nG1 X1 E1\n"), "0 [G92 E5] [G92 E0] 1");
    EXPECT_EQ(way_of("G92 E5\nG92.2\nG92.3\nG1 X1 E6\n"), "0 [G92 E5] [G92 E0] [G92 E5] 1");
    const auto p = after_start("G1 X1 E2\nG92 X0 E0\nX2\n");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->moves.back().position_mm.x(), 3);
}

TEST(Following, AloneThePathStands) {
    EXPECT_EQ(way_of("G1 X1 E2\nE1 F1200\nX2\n"), "0 2 [E-1 0.05s!] 1");
    EXPECT_EQ(way_of("M83\nG1 X1 E2\nG0 E-1 F1200\nX5\nG1 E1\nX6 E1\n"), "0 [M83] 2 [E-1 0.05s!] 1 [E1 0.05s!] 3")
        << "G0 takes F too";
    EXPECT_EQ(way_of("M83\nG1 X1 E2\nX1 E1\nX2\n"), "0 [M83] 2 [E1 0.1s!] 3") << "the axes stay where they are";
    EXPECT_EQ(way_of("G1 X1 E2\nE2\nX2\n"), "0 2 2") << "it is there already";
    EXPECT_EQ(way_of("G93 G1 X1 E2 F30\nE1 F120\nX2 F30\n"), "0 2 [E-1 0.5s!] 1");
    EXPECT_EQ(way_of("G20\nG1 X1 F60\nE1 F60\nX2\n"), "0 0 [E25.4 1s!] 25.4");
    const auto p = read_ac("G21\nF600\nG1 E5\nG0 X1\nX0 Y0 Z0\nG1 X1 E6\n");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(way_of(*p), "[E5 0.5s!] 5 6") << "before the start too";
}

TEST(Following, SeveralAxes) {
    machine::Machine machine = machine_with("BC");
    machine.words.following = {"A", "D"};
    const auto p = read_with(machine, "G21 G0 X0 Y0 Z0 B0 F60\nG1 X1 A1\nX2 D4\nA4 D8\nX3 A5\n");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->following_letters, (std::vector<char>{'A', 'D'}));
    EXPECT_EQ(p->rotary_letters, std::vector<char>{'B'});
    EXPECT_EQ(way_of(*p), "0,0 1,0 1,4 [A3 D4 5s!] 5,8");
}

TEST(Following, ProgramsWithoutItHaveNoRows) {
    const auto p = after_start("G92 E0\nG1 X1\nX2 E0\n");
    ASSERT_TRUE(p) << said(p);
    EXPECT_TRUE(p->following_letters.empty());
    EXPECT_TRUE(p->following.empty());
}

/// What belongs to an output or a heater does not move the extruder, and lasers switch while the path goes on.
TEST(Following, WordsBeside) {
    EXPECT_EQ(way_of("G1 X1 E2\nM67 E0 Q0.5\nX2\n"), "0 2 [M67 E0 Q0.5] 2");
    EXPECT_EQ(way_of("M109 S205 T1\nM104 S0\nM106 S2 P1\nG1 X1 E2\n"), "0 [M109 S205 T1!] [M104 S0] [M106 P1 S2] 2");
    EXPECT_EQ(way_of("M204 S100\nG1 X1 E2\n"), "0 [M204 S100] 2");
    EXPECT_EQ(way_of("M3 S100\nG1 X1 E1\nX2 S200 E2\n"), "0 [S100] [M3!] 1 [S200] 2");
    const auto p = after_start("M204 S100\nG1 X1 E2\n");
    EXPECT_TRUE(told(*p, "NC0012", "M204"));
}

TEST(Following, Refusals) {
    EXPECT_EQ(read_ac("G21 G0 X0 Y0 Z0\nG1 E1\n").error().code, "NC0205");
    EXPECT_EQ(way_of("G93\nG1 E1\n"), "NC0205");
    EXPECT_EQ(way_of("G80\nE1\n"), "NC0308");
    EXPECT_EQ(way_of("G81 X1 Z-1 R1 E1\n"), "NC0313");
    EXPECT_EQ(way_of("G52 E1\n"), "NC0313");
    EXPECT_EQ(way_of("M83\nG20 G1 X1 E" + std::string(308, '9') + "\n"), "NC0201");
    machine::Machine machine = machine_with("BC");
    machine.words.following.clear();
    const auto undeclared = read_with(machine, "G21 G0 X0 Y0 Z0\nG1 X1 E1 F60\n");
    EXPECT_EQ(undeclared.error().code, "NC0313");
    EXPECT_TRUE(undeclared.error().hint.contains("following"));
    for (const char* const letter : {"B", "X", "S", "F", "AB", ""}) {
        machine.words.following = {letter};
        EXPECT_EQ(read_with(machine, "G21 G0 X0 Y0 Z0\nX1\n").error().code, "NC0007") << letter;
    }
    ReadOptions feed_elsewhere;
    feed_elsewhere.feed_given_elsewhere = true;
    const auto timeless = read_ac("G21 G0 X0 Y0 Z0\nG1 E1\nX1\n", feed_elsewhere);
    ASSERT_TRUE(timeless) << said(timeless);
    EXPECT_TRUE(told(*timeless, "NC0354"));
}

/// The text, without its head and end.
std::string written(std::string_view text, const WriteOptions& options = {}) {
    const auto p = after_start(text);
    if (!p) return p.error().code;
    const machine::Machine machine = machine_with("AC");
    const auto out = write_text(*p, &machine, options);
    if (!out) return out.error().code;
    const std::size_t begin = out->find("G0 X0"), end = out->rfind("M2");
    return out->substr(begin, end - begin);
}

TEST(Following, IsWrittenAsItWasCounted) {
    EXPECT_EQ(written("G1 X1 E2\nX2 E3.5\n"), "G0 X0 Y0 Z0\nG1 X1 E2 F600\nX2 E3.5\n");
    EXPECT_EQ(written("M83\nG1 X1 E2\nX2 E3.5\n"), "G0 X0 Y0 Z0\nM83\nG1 X1 E2 F600\nX2 E3.5\n");
    EXPECT_EQ(written("G1 X1 E2\nG92 E0\nX2 E3\n"), "G0 X0 Y0 Z0\nG1 X1 E2 F600\nG92 E0\nX2 E3\n");
    EXPECT_EQ(written("G1 X1 E2\nE1 F1200\nG0 X2\nG1 X3 E2 F600\n"),
              "G0 X0 Y0 Z0\nG1 X1 E2 F600\nE1 F1200\nG0 X2\nG1 X3 E2 F600\n");
    EXPECT_EQ(written("G1 X1 F60\nX2 E2.54\nE0\n", {.units = Units::inch}),
              "G0 X0 Y0 Z0\nG1 X0.03937 F2.362205\nX0.07874 E0.1\nE0\n");
    EXPECT_EQ(written("G2 X2 I1 E1\n"), "G0 X0 Y0 Z0\nG2 X2 I1 J0 E1 F600\n");
}

TEST(Following, OtherDialectsHaveNone) {
    for (const Dialect dialect : {Dialect::apt, Dialect::heidenhain, Dialect::sinumerik, Dialect::fanuc}) {
        EXPECT_EQ(written("G1 X1 E2\n", {.dialect = dialect}), "NC0920") << name_of(dialect);
        const auto p = after_start("G1 X1\n");
        const auto plain = write_text(*p, nullptr, {.dialect = dialect});
        EXPECT_TRUE(plain || plain.error().code != "NC0920") << name_of(dialect);
    }
    EXPECT_EQ(written("G1 X1 E1000000000\n", {.precision_mm = 1e-10}), "NC0904");
}

/// Random programs: moves, arcs, retractions, both ways of counting, G92; totals come back within a step, roundings do
/// not add up.
TEST(Following, ComesBackAsWritten) {
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
        SCOPED_TRACE(testing::Message() << "seed " << seed);
        Random random{seed * 0x9E3779B97F4A7C15u + 1};
        const auto number = [&] { return static_cast<double>(random.below(2'000'000)) * 1e-6 - 0.5; };
        std::string text;
        const std::size_t lines = 20 + random.below(60);
        for (std::size_t k = 0; k < lines; ++k) {
            const std::size_t kind = random.below(12);
            const double e = number(), x = 10 * number();
            if (kind == 0) text += "M82\n";
            if (kind == 1) text += "M83\n";
            if (kind == 2) text += fmt::format("G92 E{:.7f}\n", e);
            if (kind == 3) text += fmt::format("G1 E{:.7f} F900\n", e);
            if (kind == 4) text += fmt::format("G0 X{:.3f} A{:.3f}\n", x, e);
            if (kind == 5) text += fmt::format("G3 X{:.3f} R50 E{:.7f}\n", x, e);
            if (kind > 5) text += fmt::format("G1 X{:.3f} E{:.7f} F600\n", x, e);
        }
        const auto p = after_start(text + "G1 X100 E1\n");
        ASSERT_TRUE(p) << said(p);
        const machine::Machine machine = machine_with("AC");
        const WriteOptions options;
        const auto out = write_text(*p, &machine, options);
        ASSERT_TRUE(out) << to_string(out.error());
        const auto read = read_with(machine, *out);
        ASSERT_TRUE(read) << said(read);
        ASSERT_EQ(read->following_letters, p->following_letters);
        ASSERT_EQ(read->moves.size(), p->moves.size());
        ASSERT_EQ(read->following.size(), p->following.size());
        for (std::size_t i = 0; i < p->following.size(); ++i)
            ASSERT_NEAR(read->following[i], p->following[i], 0.011 * options.precision_mm) << "move " << i;
        for (std::size_t i = 0; i < p->moves.size(); ++i)
            ASSERT_NEAR(following_at_begin(*read, i, 0), following_at_begin(*p, i, 0), 0.011 * options.precision_mm);
    }
}

/// Sums by a count of the words of these files alone; blocks that say nothing else, or no other place, stand.
TEST(Following, RealFiles) {
    const std::filesystem::path folder = std::filesystem::path(TRUNNION_SHARED_DIR) / "data/nc/additive";
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no shared folder";
    struct File {
        const char *name, *rotary, *letter;
        double total_mm;
        int standing;
    };
    for (const File& file :
         {File{"mastercam_klipper_b_axis", "BC", "E", 1239.787, 603},
          File{"mastercam_klipper_c_axis", "BC", "E", 1423.125, 3},
          File{"mastercam_klipper_pp_test", "BC", "E", 2232.46533, 0},
          File{"mastercam_klipper_propeller", "BC", "E", 1755.48541, 0}, File{"model_1_bc", "BC", "E", 7466.48, 94},
          File{"ring_bc", "BC", "A", 25722.86, 613}, File{"open5x_uv_propeller", "UV", "E", 1097.28241, 5015}}) {
        SCOPED_TRACE(file.name);
        machine::Machine machine = machine_with(file.rotary);
        machine.words.following = {file.letter};
        ReadOptions options;
        options.machine = &machine;
        options.feed_given_elsewhere = true;
        const auto p = read_program_file(folder / (std::string(file.name) + ".gcode"), options);
        ASSERT_TRUE(p) << said(p);
        ASSERT_EQ(p->following.size(), p->moves.size());
        EXPECT_NEAR(following_at_begin(*p, p->moves.size(), 0), file.total_mm, 1e-6);
        std::array<double, 1> ignored{};
        EXPECT_EQ(
            std::ranges::count_if(p->events, [&](const auto& what) { return add_following_travel(*p, what, ignored); }),
            file.standing);
        const auto text = write_text(*p, &machine, {});
        ASSERT_TRUE(text) << to_string(text.error());
        const auto back = read_with(machine, *text, options);
        ASSERT_TRUE(back) << said(back);
        ASSERT_EQ(back->following.size(), p->following.size());
        for (std::size_t i = 0; i < p->following.size(); ++i)
            ASSERT_NEAR(back->following[i], p->following[i], 1e-6) << "move " << i;
    }
}

TEST(Following, WordsOfEvents) {
    constexpr std::array<char, 2> letters{'E', 'D'};
    EXPECT_EQ(following_word(letters, std::array{-0.8, 0.0}), "E-0.8");
    EXPECT_EQ(following_word(letters, std::array{1e-7, 2.0}), "E1e-07 D2");
    std::array<double, 2> sum{1, 1};
    EXPECT_TRUE(add_following_word(letters, "E1e-07 D2", sum));
    EXPECT_EQ(sum, (std::array{1 + 1e-7, 3.0}));
    for (const char* const other : {"", "G4 P2", "E", "E1 X2", "D", "EE"})
        EXPECT_FALSE(add_following_word(letters, other, sum)) << other;
    EXPECT_EQ(sum, (std::array{1 + 1e-7, 3.0}));
}

}  // namespace
}  // namespace trunnion::nc
