#include "trunnion/pipeline/expand_surfaces.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <ranges>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "trunnion/nc/read.hpp"
#include "trunnion/nc/write.hpp"
#include "trunnion/surfacing/machined_surface.hpp"

#include "planned.hpp"

namespace trunnion::pipeline {
namespace {

using program::Move;
using program::MoveKind;
using program::Program;

const machine::Machine& table() {
    static const machine::Machine machine = files::read_machine(test_table, "table.toml").value();
    return machine;
}

machine::Setup shop() {
    machine::Setup setup;
    setup.tools["1"] = {.kind = machine::ToolKind::flat, .diameter_mm = 6, .length_mm = 50};
    setup.tools["2"] = {.kind = machine::ToolKind::torus, .diameter_mm = 10, .corner_radius_mm = 2, .length_mm = 60};
    setup.tools["3"] = {.kind = machine::ToolKind::taper, .diameter_mm = 6};
    setup.tools["4"] = {};
    return setup;
}

Program read(const std::string& text) {
    nc::ReadOptions options;
    options.machine = &table();
    auto program = nc::read_program(text, "surfaces.ngc", options);
    EXPECT_TRUE(program) << to_string(program.error());
    return program ? std::move(*program) : Program{};
}

const std::string plane = "G321 P1 I1 J1\nX0 Y0 Z3\nX0 Y24 Z0\nX30 Y0 Z0\nX0 Y0 Z0\nG322\n";
const std::string start = "G21 G90 T1 M6 S900 M3\nG0 X-20 Y0 Z60 A0 C0\n";

bool is_in(const Move& move, int line) {
    return move.line == line;
}

TEST(ExpandSurfaces, PassesTakeThePlaceOfTheMachiningBlock) {
    const Program before = read(start + plane + "M8 (line 9)\nG324 P1 R0.01 Q2 F600 M4\nM9\nG0 Z70\nX-20\nM30\n");
    ASSERT_EQ(before.surface_jobs.size(), 1u);
    const int line = before.surface_jobs[0].line;
    const auto p = expand_surfaces(before, shop());
    ASSERT_TRUE(p) << to_string(p.error());
    EXPECT_TRUE(p->surface_jobs.empty() && p->surfaces.empty());
    ASSERT_GT(p->moves.size(), 12u);
    EXPECT_EQ(p->moves[0].position_mm, Eigen::Vector3d(-20, 0, 60));
    const auto is_pass = [&](const Move& move) { return is_in(move, line); };
    EXPECT_TRUE(std::ranges::all_of(p->moves.begin() + 1, p->moves.end() - 2, is_pass));
    EXPECT_EQ(p->moves[p->moves.size() - 2].position_mm.z(), 70);
    EXPECT_NEAR(p->moves[1].position_mm.z(), 23, 1e-9) << "the retract level above the first pass";
    EXPECT_EQ(p->moves[1].kind, MoveKind::rapid);
    EXPECT_NEAR(p->moves[p->moves.size() - 3].position_mm.z(), 23, 1e-9);
    double lowest = 100;
    for (const Move& move : std::ranges::filter_view(p->moves, is_pass)) {
        lowest = std::min(lowest, move.position_mm.z());
        EXPECT_EQ(move.law, program::OrientationLaw::vector);
        EXPECT_EQ(p->tools[move.tool], "1");
        EXPECT_EQ(p->offsets[move.offset], "G54");
        if (move.kind == MoveKind::rapid) continue;
        EXPECT_EQ(move.feed, (program::Feed{program::FeedRule::tip_speed, 10}));
    }
    EXPECT_NEAR(lowest, 3, 1e-9);
    std::vector<std::string> first, last;
    for (const program::Event& event : p->events) {
        EXPECT_FALSE(event.word.starts_with("G")) << event.word;
        (event.before_move <= 1 ? first : last).push_back(event.word);
    }
    EXPECT_EQ(first.back(), "M4");
    EXPECT_EQ((p->events.end() - 2)->before_move, p->moves.size() - 2) << "M9 stands behind the passes";
    EXPECT_EQ(last, (std::vector<std::string>{"M9", "M30"}));
}

TEST(ExpandSurfaces, AFlatToolLeavesAPlaneWithPassesADiameterApart) {
    const auto p = expand_surfaces(read(start + plane + "G323 Q0\nG324 P1 R0.01 Q2 F600\n"), shop());
    ASSERT_TRUE(p) << to_string(p.error());
    std::vector<double> rows;
    for (const Move& move : p->moves)
        if (move.position_mm.z() == 3 && (rows.empty() || std::abs(rows.back() - move.position_mm.y()) > 1e-6))
            rows.push_back(move.position_mm.y());
    ASSERT_GE(rows.size(), 4u);
    for (std::size_t i = 2; i + 1 < rows.size(); ++i) EXPECT_NEAR(rows[i] - rows[i - 1], 6, 1e-6);
}

TEST(ExpandSurfaces, TwoJobsBesideEachOtherKeepTheirOrderAndTools) {
    const Program before = read(start + plane + "G324 P1 R0.01 Q2 F600\nM9\nT2 M6\nG324 P1 R0.02 Q3 J5 F300\nM5\n");
    const auto p = expand_surfaces(before, shop());
    ASSERT_TRUE(p) << to_string(p.error());
    const auto second = std::ranges::find(p->moves, before.surface_jobs[1].line, &Move::line);
    ASSERT_NE(second, p->moves.end());
    EXPECT_EQ(p->tools[second->tool], "2");
    EXPECT_EQ(p->tools[(second - 1)->tool], "1");
    const auto where = [&](std::string_view word) {
        return std::ranges::find(p->events, word, &program::Event::word)->before_move;
    };
    EXPECT_EQ(where("M9"), static_cast<std::size_t>(second - p->moves.begin()));
    EXPECT_EQ(where("M5"), p->moves.size());
}

TEST(ExpandSurfaces, AProgramWithoutSurfacesIsNotCopied) {
    Program before = read(start + "G1 X0 F100\n");
    const Move* moves = before.moves.data();
    const auto p = expand_surfaces(std::move(before), shop());
    ASSERT_TRUE(p);
    EXPECT_EQ(p->moves.data(), moves);
}

TEST(ExpandSurfaces, AFeedThatIsNotKnownStaysSo) {
    Program before = read(start + plane + "G324 P1 R0.01 Q2 F600\n");
    before.surface_jobs[0].feed_mm_s = 0;
    const auto p = expand_surfaces(before, shop());
    ASSERT_TRUE(p) << to_string(p.error());
    for (const Move& move : p->moves) EXPECT_EQ(move.feed.value, 0);
}

TEST(ExpandSurfaces, FollowingAxesStandStill) {
    Program before = read(start + plane + "G1 X0 F100\nG324 P1 R0.01 Q2 F600\nG0 Z80\n");
    before.following_letters = {'E'};
    before.following = {1, 2, 3};
    const auto p = expand_surfaces(before, shop());
    ASSERT_TRUE(p) << to_string(p.error());
    ASSERT_EQ(p->following.size(), p->moves.size());
    EXPECT_EQ(p->following[0], 1);
    EXPECT_EQ(p->following.back(), 3);
    EXPECT_TRUE(std::all_of(p->following.begin() + 1, p->following.end() - 1, [](double e) { return e == 2; }));
}

/// A bent surface, hollow nowhere.
const std::string roof =
    "G320 P1 I2 J2 K3 L3\nX0 Y0 Z0\nX0 Y15 Z6\nX0 Y30 Z0\nX20 Y0 Z5\nX20 Y15 Z12\nX20 Y30 Z5\nX40 Y0 Z0\nX40 Y15 Z6\n"
    "X40 Y30 Z0\nG322\n";

/// The poses of its moves at feed, rapids left out.
std::vector<std::vector<surfacing::CutterPose>> cuts(const Program& program) {
    std::vector<std::vector<surfacing::CutterPose>> out;
    for (std::size_t i = 1; i < program.moves.size(); ++i) {
        const Move &from = program.moves[i - 1], &to = program.moves[i];
        if (to.kind == MoveKind::rapid) continue;
        if (from.kind == MoveKind::rapid) out.push_back({{from.position_mm, from.axis}});
        out.back().push_back({to.position_mm, to.axis});
    }
    return out;
}

TEST(ExpandSurfaces, RidgesAreAsHighAsTheProgramAllows) {
    const Program before = read(start + roof + "T2 M6\nG324 P1 R0.02 J8 F600\n");
    const program::Surface& s = before.surfaces.at(0);
    const auto surface =
        geometry::BsplineSurface::make({s.degree_u, s.knots_u}, {s.degree_v, s.knots_v}, s.position_mm).value();
    const auto p = expand_surfaces(before, shop());
    ASSERT_TRUE(p) << to_string(p.error());
    const surfacing::MachinedSurface left(surfacing::Cutter::make(shop().tools["2"]).value(), cuts(*p));
    double highest = -1, lowest = 1;
    for (int i = 0; i <= 60; ++i)
        for (int k = 0; k <= 60; ++k) {
            const auto at = surface.evaluate(0.1 + 0.8 * i / 60, 0.1 + 0.8 * k / 60);
            const double height = left.height_mm(at.at, at.by_u.cross(at.by_v).normalized(), 1);
            highest = std::max(highest, height);
            lowest = std::min(lowest, height);
        }
    EXPECT_LT(highest, 0.0201);
    EXPECT_GT(highest, 0.017);
    EXPECT_GT(lowest, -0.001);
}

TEST(ExpandSurfaces, TheWholeWayToSetpoints) {
    const auto p = expand_surfaces(read(start + roof + "T2 M6\nG324 P1 R0.05 J8 F1200\nG0 Z90\n"), shop());
    ASSERT_TRUE(p) << to_string(p.error());
    Recorder recorder;
    const auto summary = plan(*p, table(), shop(), {}, recorder);
    ASSERT_TRUE(summary) << to_string(summary.error());
    EXPECT_TRUE(summary->usable());
    EXPECT_GT(recorder.rows.size(), 1000u);
}

/// The bottom of a pocket, 40 mm wide, and the longer wall beside it.
std::string pocket(const std::string& wall) {
    return "G321 P1 I1 J1\nX8 Y0 Z0\nX0 Y40 Z0\nX32 Y0 Z0\nX0 Y0 Z0\nG322\n" + wall + "G322\n";
}
const std::string wall = "G320 P2 I1 J1 K2 L2\nX0 Y-30 Z0\nX0 Y70 Z0\nX0 Y-30 Z40\nX0 Y70 Z40\n";
const std::string wall_seen_from_behind = "G320 P2 I1 J1 K2 L2\nX0 Y70 Z0\nX0 Y-30 Z0\nX0 Y70 Z40\nX0 Y-30 Z40\n";

machine::Setup shop_with_balls() {
    machine::Setup out = shop();
    out.tools["5"] = {.kind = machine::ToolKind::ball, .diameter_mm = 10, .corner_radius_mm = 5, .length_mm = 120};
    return out;
}

/// The least x that the tool's axis reaches on the moves of a line, `up_mm` above its tip.
double least_x(const Program& program, int line, double up_mm) {
    double least = 1e9;
    for (const Move& move : program.moves)
        if (is_in(move, line) && move.kind != MoveKind::rapid)
            least = std::min(least, move.position_mm.x() + up_mm * move.axis.x());
    return least;
}

const std::string towards_the_wall = "T5 M6\nG0 X20 Y20 Z90 A0 C0\n";
const std::string machining = "G324 P1 R0.1 Q2 J15 F600\n";

TEST(ExpandSurfaces, PassesAreFreedOfGougesWhereTheProgramAsksForIt) {
    constexpr double shank_mm = 35, radius_mm = 5;
    const auto x_of = [&](const std::string& words, const std::string& beside) {
        const Program before = read(start + pocket(beside) + towards_the_wall + words + machining);
        const auto p = expand_surfaces(before, shop_with_balls());
        EXPECT_TRUE(p) << to_string(p.error());
        return p ? least_x(*p, before.surface_jobs.at(0).line, shank_mm) : 0;
    };
    EXPECT_LT(x_of("G323 D.002\n", wall), radius_mm - 4) << "as it is told: the shank goes into the wall";
    EXPECT_LT(x_of("G323 D.002 P1\n", wall), radius_mm - 4) << "nothing is known of its shank";
    EXPECT_GT(x_of("G323 D.002 P1 J40\n", wall), radius_mm - 0.01);
    EXPECT_GT(x_of("G323 D.002 P1 J40\n", wall_seen_from_behind), radius_mm - 0.01) << "a sheet has no side";
}

TEST(ExpandSurfaces, ThatPassesLeanIsToldOnce) {
    const std::string two = machining + "G0 Z90\nX20 Y20 A0 C0\n" + machining;
    const auto p =
        expand_surfaces(read(start + pocket(wall) + towards_the_wall + "G323 D.002 P1 J40\n" + two), shop_with_balls());
    ASSERT_TRUE(p) << to_string(p.error());
    ASSERT_EQ(p->diagnostics.size(), 1u);
    EXPECT_EQ(p->diagnostics[0].code, "PIPE0124");
    EXPECT_EQ(p->diagnostics[0].severity, Severity::note);
    EXPECT_EQ(p->diagnostics[0].place.line,
              read(start + pocket(wall) + towards_the_wall + "G323 D.002 P1 J40\n" + two).surface_jobs[0].line);
    EXPECT_GE(p->diagnostics[0].count, 4);
    EXPECT_EQ(p->diagnostics[0].count % 2, 0) << "as many of both";
}

/// Away from a wall that hangs over a rounded tool leans across its feed, which makes its ridges higher.
TEST(ExpandSurfaces, HigherRidgesOfPassesThatLeanAreTold) {
    const std::string overhang = "G320 P2 I1 J1 K2 L2\nX0 Y-30 Z0\nX0 Y70 Z0\nX6 Y-30 Z40\nX6 Y70 Z40\n";
    const auto p = expand_surfaces(
        read(start + pocket(overhang) + "T2 M6\nG0 X20 Y20 Z90 A0 C0\nG323 D.002 P1 J30\nG324 P1 R0.05 Q3 J4 F600\n"),
        shop());
    ASSERT_TRUE(p) << to_string(p.error());
    ASSERT_EQ(p->diagnostics.size(), 2u);
    EXPECT_EQ(p->diagnostics[0].code, "PIPE0124");
    EXPECT_EQ(p->diagnostics[1].code, "PIPE0123");
    EXPECT_EQ(p->diagnostics[1].severity, Severity::warning);
    EXPECT_EQ(p->diagnostics[1].limit, "50 um");
}

struct RefusedTool {
    std::string words, code;
};

TEST(ExpandSurfaces, RefusalsPointAtTheMachiningBlock) {
    const RefusedTool cases[] = {
        {"T9 M6\nG324 P1 R0.01 F600\n", "PIPE0120"}, {"T3 M6\nG324 P1 R0.01 F600\n", "SURF0201"},
        {"T4 M6\nG324 P1 R0.01 F600\n", "SURF0201"}, {"G43 H0\nG324 P1 R0.01 F600\n", "SURF0201"},
        {"\nG324 P1 R5 F600\n", "SURF0202"},         {"G323 D1\nG324 P1 R.1 F600\n", "SURF0202"},
    };
    for (const RefusedTool& each : cases) {
        const auto p = expand_surfaces(read(start + plane + each.words), shop());
        ASSERT_FALSE(p) << each.words;
        EXPECT_EQ(p.error().code, each.code) << to_string(p.error());
        EXPECT_EQ(p.error().place.line, 10) << to_string(p.error());
        EXPECT_EQ(p.error().place.file, "surfaces.ngc");
    }
    const auto without_table = expand_surfaces(read("G21\nG0 X0 Y0 Z60 A0 C0\n" + plane + "G324 P1 R0.01 F600\n"), {});
    ASSERT_FALSE(without_table);
    EXPECT_EQ(without_table.error().code, "SURF0201") << "the tool of a program that names none";
}

TEST(ExpandSurfaces, AProgramThatIsReadMeanwhile) {
    std::string text = start + plane + "F600\n";
    for (int i = 0; i < 3; ++i) {
        for (int k = 1; k <= 7; ++k) text += fmt::format("G1 X{} Y{} Z60 A0 C0\n", k, i);
        text += "M3\nG324 P1 R0.01 Q2\nM5\nG0 Z60\nG0 X0 Y0 A0 C0\nG0 X1\n";
    }
    const auto path = std::filesystem::temp_directory_path() / fmt::format("trunnion_surfaces_{}.ngc", ::getpid());
    std::ofstream(path) << text;
    nc::ReadOptions options;
    options.machine = &table();
    options.parts = {.to_rapid = 5, .to_stop = 9, .most = 1'000'000};
    const machine::Setup setup = shop();
    auto opened = nc::open_program_file(path, options);
    ASSERT_TRUE(opened);
    const auto parts = expand_surfaces(std::move(*opened), setup);
    Program part;
    std::vector<Eigen::Vector3d> tips;
    std::vector<std::string> events;
    std::size_t count = 0;
    for (;; ++count) {
        const auto more = parts->next(part);
        ASSERT_TRUE(more) << to_string(more.error());
        if (!*more) break;
        EXPECT_TRUE(part.surface_jobs.empty());
        for (std::size_t i = count == 0 ? 0 : 1; i < part.moves.size(); ++i) tips.push_back(part.moves[i].position_mm);
        for (const program::Event& event : part.events) events.push_back(event.word);
    }
    std::filesystem::remove(path);
    EXPECT_GT(count, 2u);
    const auto whole = expand_surfaces(read(text), setup);
    ASSERT_TRUE(whole);
    ASSERT_EQ(tips.size(), whole->moves.size());
    for (std::size_t i = 0; i < tips.size(); ++i)
        for (int k = 0; k < 3; ++k)
            EXPECT_TRUE(tips[i][k] == whole->moves[i].position_mm[k] ||
                        (std::isnan(tips[i][k]) && std::isnan(whole->moves[i].position_mm[k])));
    ASSERT_EQ(events.size(), whole->events.size());
    for (std::size_t i = 0; i < events.size(); ++i) EXPECT_EQ(events[i], whole->events[i].word);
}

/// Diagnostics come with the last part, also those of passes that were laid in the first one.
TEST(ExpandSurfaces, WhatIsToldOfOnePartComesWithTheLast) {
    std::string text = start + pocket(wall) + towards_the_wall + "G323 D.002 P1 J40\n" + machining;
    for (int i = 0; i < 30; ++i) text += fmt::format("G1 X{} Y{} Z90 A0 C0\nG0 Y70\n", i, i);
    const auto path = std::filesystem::temp_directory_path() / fmt::format("trunnion_told_{}.ngc", ::getpid());
    std::ofstream(path) << text;
    nc::ReadOptions options;
    options.machine = &table();
    options.parts = {.to_rapid = 5, .to_stop = 9, .most = 1'000'000};
    const machine::Setup setup = shop_with_balls();
    const auto parts = expand_surfaces(nc::open_program_file(path, options).value(), setup);
    Program part;
    std::vector<Diagnostic> told;
    int count = 0;
    for (; parts->next(part).value(); ++count) told = part.diagnostics;
    std::filesystem::remove(path);
    EXPECT_GT(count, 2);
    ASSERT_EQ(std::ranges::count(told, "PIPE0124", &Diagnostic::code), 1);
}

TEST(ExpandSurfaces, SurfacesAreNotWrittenBeforeTheirPasses) {
    const auto written = nc::write_text(read(start + plane + "G324 P1 R0.01 F600\n"), &table(), {});
    ASSERT_FALSE(written);
    EXPECT_EQ(written.error().code, "NC0068");
}

}  // namespace
}  // namespace trunnion::pipeline
