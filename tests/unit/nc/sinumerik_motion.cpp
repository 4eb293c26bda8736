#include "sinumerik_reading.hpp"

namespace trunnion::nc {
namespace {

using program::EventKind;
using program::FeedRule;

TEST(Sinumerik, WholeProgram) {
    const auto p = read_bc(
        "%_N_PART_MPF\n"
        ";$PATH=/_N_MPF_DIR\n"
        "N10 G71 G17 G40 G90 G94 G64 ; start\n"
        "DEF REAL _Z=50\n"
        "T=\"MILL 8\"\n"
        "M6\n"
        "MSG(\"go\")\n"
        "TRAORI\n"
        "N20 G54 D1\n"
        "N30 G0 X0 Y0 Z=_Z B0 C0 S3500 M3\n"
        "N40 G1 X1.5 Y=-2 Z.5 B30 C111511 F600 M8\n"
        "X2\n"
        "G4 F2.5\n"
        "G9 Y4\n"
        "G60 Y5\n"
        "M30\n"
        "X99\n");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->dialect, "sinumerik");
    EXPECT_EQ(moves_of(p, 0),
              "R w 0 0 50 B0 C0\n"
              "F w 1.5 -2 0.5 B30 C111511\n"
              "F w 2 -2 0.5 B30 C111511\n"
              "F w 2 4 0.5 B30 C111511\n"
              "F w 2 5 0.5 B30 C111511\n");
    EXPECT_EQ(p->moves[1].feed, (program::Feed{FeedRule::tip_speed, 10}));
    EXPECT_EQ(p->moves[1].line, 11);
    EXPECT_FALSE(p->moves[2].exact_stop);
    EXPECT_TRUE(p->moves[3].exact_stop && p->moves[4].exact_stop);
    EXPECT_EQ(p->tools.at(p->moves[1].tool), "MILL 8");
    EXPECT_EQ(p->offsets.at(p->moves[1].offset), "G54");
    const std::vector<std::tuple<std::string, EventKind, bool, std::size_t>> expected = {
        {"T=\"MILL 8\"", EventKind::tool, false, 0}, {"M6", EventKind::tool, true, 0},
        {"MSG(\"go\")", EventKind::other, false, 0}, {"M3", EventKind::spindle, true, 0},
        {"S3500", EventKind::spindle, false, 0},     {"M8", EventKind::coolant, false, 1},
        {"G4 F2.5", EventKind::dwell, true, 3},      {"M30", EventKind::stop, true, 5}};
    ASSERT_EQ(p->events.size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
        const program::Event& e = p->events[i];
        EXPECT_EQ((std::tuple{e.word, e.kind, e.stops_motion, e.before_move}), expected[i]);
    }
    EXPECT_EQ(p->events[6].dwell_s, 2.5);
    ASSERT_EQ(p->diagnostics.size(), 1u);
    EXPECT_TRUE(told(*p, "NC0014"));
}

TEST(Sinumerik, WithoutTraoriTheAxesAreCountedFromTheOffset) {
    EXPECT_EQ(moves_after_start("X1\nG0 B90\nTRAORI\nX2 Y3\nZ4\nTRAFOOF\nZ9\nX1 Y1"),
              "F u 1 0 0 B-\n"
              "R u 1 0 0 B90\n"
              "R w 2 3 - B90\n"
              "R w 2 3 4 B90\n"
              "R u - - 9 B90\n"
              "R u 1 1 9 B90\n");
}

TEST(Sinumerik, SupaG53AndG153AreMachinePositions) {
    EXPECT_EQ(moves_after_start("SUPA G0 Z600 D0\nG53 X-300 Y200 B10\nG153 B20\nX5\nD1\nG54 Y6\nG500 Z1"),
              "R m - - 600 B-\n"
              "R m -300 200 600 B10\n"
              "R m -300 200 600 B20\n"
              "R u 5 - - B20\n"
              "R u - 6 - B20\n"
              "R u - - 1 B20\n");
}

TEST(Sinumerik, AToolWithItsLengthNeedsItsOffsetOffForZInSupa) {
    EXPECT_EQ(read_bc("T1 D1\nG0 X0 Y0 Z0\nSUPA Z5\n").error().code, "NC0616");
    EXPECT_EQ(read_bc("T1 D1\nG0 X0 Y0 Z0\nTRAORI\nSUPA X5\n").error().code, "NC0615");
    EXPECT_TRUE(read_bc("T1 D1\nG0 X0 Y0 Z0\nSUPA X5 Y5\n"));
    EXPECT_TRUE(read_bc("T1 D1\nG0 X0 Y0 Z0\nT0\nSUPA Z5\n")) << "no tool has no length";
}

TEST(Sinumerik, ToolsAndEdges) {
    const auto names = [](std::string_view text) {
        const auto p = read_bc(std::string("G0 X0 Y0 Z0\n").append(text));
        std::string out;
        for (std::size_t i = 1; p && i < p->moves.size(); ++i) out += '[' + p->tools.at(p->moves[i].tool) + ']';
        return p ? out : said(p);
    };
    EXPECT_EQ(names("T08\nX1\nM6\nX2\nD08\nX3\nD2\nX4\nD0\nX5\nD1\nX6"), "[][8][8][8 D2][8 D0][8]");
    EXPECT_EQ(names("T1 D2\nX1\nM06\nX2\nT9.\nX3\nD0\nX4\nM6\nX5"), "[ D2][1 D2][1 D2][1 D0][9]")
        << "T alone prepares; D0 is not of the next tool";
    EXPECT_EQ(names("T=\"A B\"\nX1\nT2 D3\nX2\nT0\nX3\n"), "[A B][2 D3][0 D0]")
        << "T itself changes where there is no M6";
    EXPECT_EQ(names("T5 ;M6\nX1"), "[5]") << "a comment is no M6";
    EXPECT_EQ(names("T=1+1\nX1\nT4 M6 D5\nX2"), "[][4 D5]");
    for (const char* bad : {"T-1", "T1.5", "D-1", "D1.5", "T2=5"}) {
        const auto p = read_bc(std::string("G0 X0 Y0 Z0\nX1\n").append(bad));
        EXPECT_EQ(p.error().code, "NC0614") << bad;
    }
}

TEST(Sinumerik, CountingOfAngles) {
    EXPECT_EQ(moves_after_start("G91 X1\nX1 Y=AC(5)\nG90 X=IC(2) B10 C350\nG91 B5\nG90 B=IC(-1)\nC=DC(10)\nC=ACN(20)\n"
                                "C=ACP(10)\nC=AC(0)\nC=DC(-170)"),
              "F u 1 0 0 B- C-\n"
              "F u 2 5 0 B- C-\n"
              "F u 4 5 0 B10 C350\n"
              "F u 4 5 0 B15 C350\n"
              "F u 4 5 0 B14 C350\n"
              "F u 4 5 0 B14 C370\n"
              "F u 4 5 0 B14 C20\n"
              "F u 4 5 0 B14 C370\n"
              "F u 4 5 0 B14 C0\n"
              "F u 4 5 0 B14 C-170\n");
}

TEST(Sinumerik, ShortestWayFromAnUnknownAngleIsTheAngleItself) {
    const auto p = read_bc("G71 G64 G0 X0 Y0 Z0\nC=DC(270)\nC=DC(10)\n");
    EXPECT_EQ(moves_of(p), "R u 0 0 0 C270\nR u 0 0 0 C370\n");
    EXPECT_EQ(told(*p, "NC0660")->count, 1);
}

TEST(Sinumerik, Units) {
    const auto x_and_feed = [](std::string_view unit, Units wanted = Units::none) {
        ReadOptions options;
        options.units = wanted;
        const auto p = read_bc(std::string(unit).append(" G0 X0 Y0 Z0\nG1 X1 F60\n"), options);
        return p ? fmt::format("{} {:.6g}", number(p->moves[1].position_mm.x()), p->moves[1].feed.value) : said(p);
    };
    EXPECT_EQ(x_and_feed("G70"), "25.4 1");
    EXPECT_EQ(x_and_feed("G700"), "25.4 25.4");
    EXPECT_EQ(x_and_feed("G71"), "1 1");
    EXPECT_EQ(x_and_feed("G710"), "1 1");
    EXPECT_EQ(x_and_feed("G71", Units::inch), "25.4 25.4");
    EXPECT_EQ(x_and_feed("G70", Units::mm), "1 1");
    EXPECT_TRUE(told(*read_bc("G70 G0 X0 Y0 Z0\nG1 X1 F60\n"), "NC0656"));
    EXPECT_TRUE(told(*read_bc("G0 X0 Y0 Z0\nG1 X1 F60\n"), "NC0011"));
    EXPECT_FALSE(told(*read_bc("G71 G0 X0 Y0 Z0\nG1 X1 F60\n"), "NC0011"));
}

program::Feed feed_after(std::string_view blocks) {
    const auto p = read_bc(std::string("G71 TRAORI\nG0 X0 Y0 Z0 B0 C0\n").append(blocks));
    EXPECT_TRUE(p) << said(p);
    return p ? p->moves.back().feed : program::Feed{};
}

TEST(Sinumerik, Feeds) {
    const program::Feed none{};
    EXPECT_EQ(feed_after("G0 X1 F60"), none);
    EXPECT_EQ(feed_after("G1 X1 B5 F120"), (program::Feed{FeedRule::tip_speed, 2}));
    EXPECT_EQ(feed_after("G1 X1 B5 F120 FB=60"), (program::Feed{FeedRule::tip_speed, 1}));
    EXPECT_EQ(feed_after("G93 G1 X1 B5 F120"), (program::Feed{FeedRule::block_time, 0.5}));
    EXPECT_EQ(feed_after("G95 S600 G1 X1 F.2"), (program::Feed{FeedRule::tip_speed, 2}));
    const program::Feed turning = feed_after("G1 B5 F60");
    EXPECT_EQ(turning.rule, FeedRule::rotary_rate);
    EXPECT_NEAR(turning.value, degree, 1e-15) << "60 degrees a minute";
    EXPECT_NEAR(feed_after("FGREF[B]=10 FGREF[C]=10\nG1 B5 F60").value, 1. / 10, 1e-15);
    EXPECT_EQ(feed_after("FGROUP(X,Y,Z)\nG1 X1 B5 F120"), (program::Feed{FeedRule::tip_speed, 2}));
    const program::Feed group = feed_after("FGROUP(X,Y,Z,B) FGREF[B]=180\nG1 X3 B=4/$PI F60");
    EXPECT_EQ(group.rule, FeedRule::block_time);
    EXPECT_NEAR(group.value, 5, 1e-12) << "3 mm and 4 mm across";
    EXPECT_TRUE(told(*read_bc("TRAORI\nG0 X0 Y0 Z0 B0\nG1 B5 F60"), "NC0651"));
    ReadOptions elsewhere;
    elsewhere.feed_given_elsewhere = true;
    EXPECT_TRUE(read_bc("G0 X0 Y0 Z0\nG1 X1\n", elsewhere));
}

TEST(Sinumerik, WordsOfTheMachineFile) {
    machine::Machine machine = machine_with("BC");
    machine.words = {.tcp_on = {"M128"}, .tcp_off = {"M129"}, .ignore = {"M64", "G812", "Q"}, .following = {"E"}};
    ReadOptions options;
    options.dialect = Dialect::sinumerik;
    const auto p = read_with(machine, "G0 X0 Y0 Z0\nM128\nX1 E5\nM129\nX2 M64 G812\n", options);
    EXPECT_EQ(moves_of(p), "R w 1 - -\nR u 2 - -\n");
    EXPECT_EQ(p->events.size(), 0u);
    EXPECT_TRUE(told(*p, "NC0012", "E"));
    machine.words = {};
    const auto q = read_with(machine, "G0 X0 Y0 Z0\nM428\nX1\nM777\n", options);
    EXPECT_EQ(moves_of(q), "R u 1 0 0\n") << "LinuxCNC's own words mean nothing here";
    ASSERT_EQ(q->events.size(), 2u);
    EXPECT_EQ(q->events[1].kind, EventKind::other);
}

TEST(Sinumerik, IgnoredWordsAreToldWithTheirCount) {
    const auto p = read_bc(
        "G71 G64 G0 X0 Y0 Z0\nSOFT\nCYCLE832(0.02,1,1) COMPCAD\nFFWON SOFT\nG1 X1 F60\nADIS=0.1 G641 "
        "X2\nSETMS(1)\nWAITM(1,1,2)\n"
        "STOPRE\nG62 FNORM G601 G450\n");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(told(*p, "NC0012", "SOFT")->count, 2);
    for (const char* word : {"COMPCAD", "FFWON", "ADIS", "SETMS", "WAITM", "STOPRE"})
        EXPECT_TRUE(told(*p, "NC0012", word)) << word;
    EXPECT_EQ(p->diagnostics.size(), 8u);
}

TEST(Sinumerik, Cycle832SwitchesToContinuousPath) {
    const auto p = read_bc("G71 G60 G0 X0 Y0 Z0\nG1 X1 F60\nCYCLE832(0.02,1,1)\nX2\nCYCLE832()\nX3\nG60 X4\n");
    ASSERT_TRUE(p) << said(p);
    EXPECT_TRUE(p->moves[1].exact_stop && p->moves[4].exact_stop);
    EXPECT_FALSE(p->moves[2].exact_stop || p->moves[3].exact_stop);
    EXPECT_EQ(told(*p, "NC0659")->count, 2);
}

TEST(Sinumerik, WhatIsAssumedIsTold) {
    const auto p = read_bc("G71 G0 X0 Y0 Z0\nG1 X1 F60\nB5\n");
    ASSERT_TRUE(p) << said(p);
    EXPECT_TRUE(told(*p, "NC0655", "B"));
    EXPECT_TRUE(told(*p, "NC0657"));
    EXPECT_FALSE(p->moves[1].exact_stop);
}

TEST(Sinumerik, StartsAtTheFirstPoseThatIsKnownWhole) {
    const auto p = read_bc("G71 G64\nSUPA G0 Z500 D0\nSUPA X1 Y2\nM3\nD1\nG54 X0 Y0 B0\nZ5\n");
    EXPECT_EQ(moves_of(p, 0), "R m 1 2 500 B-\nR u 0 0 - B0\nR u 0 0 5 B0\n");
    EXPECT_EQ(p->events[0].before_move, 1u);
    EXPECT_EQ(told(*p, "NC0013")->count, 1);
    EXPECT_EQ(read_bc("G0 X0 Y0\n").error().code, "NC0006");
    EXPECT_EQ(read_bc("G0 X0 Y0 Z0\nX0\n").error().code, "NC0005");
}

// ---------------------------------------------------------------------------------------------------------- circles

TEST(SinumerikCircles, ByCentreInEachPlane) {
    EXPECT_EQ(moves_after_start("G3 X10 Y10 I0 J10"), "F u 10 10 0 arc 90 (0 10 0) (0 0 1)\n");
    EXPECT_EQ(moves_after_start("G2 X10 Y10 I10 Z5"), "F u 10 10 5 arc -90 (10 0 0) (0 0 1)\n");
    EXPECT_EQ(moves_after_start("G18 G2 X10 Z10 I0 K10"), "F u 10 0 10 arc -90 (0 0 10) (0 1 0)\n");
    EXPECT_EQ(moves_after_start("G19 G3 Y10 Z10 K10"), "F u 0 10 10 arc 90 (0 0 10) (1 0 0)\n");
    EXPECT_EQ(moves_after_start("X10\nG3 I=AC(0) J=AC(5) X10 Y10"),
              "F u 10 0 0\nF u 10 10 0 arc 53.1301 (0 5 0) (0 0 1)\n");
    EXPECT_EQ(moves_after_start("G3 I=IC(5) J0"), "F u 0 0 0 arc 360 (5 0 0) (0 0 1)\n");
    EXPECT_EQ(moves_after_start("G91 G3 X10 I5\nX-10 I-5"),
              "F u 10 0 0 arc 180 (5 0 0) (0 0 1)\nF u 0 0 0 arc 180 (5 0 0) (0 0 1)\n");
}

TEST(SinumerikCircles, ByRadiusAngleAndTurns) {
    EXPECT_EQ(moves_after_start("G3 X10 Y10 CR=10"), "F u 10 10 0 arc 90 (0 10 0) (0 0 1)\n");
    EXPECT_EQ(moves_after_start("G3 X10 Y10 CR=-10"), "F u 10 10 0 arc 270 (10 0 0) (0 0 1)\n");
    EXPECT_EQ(moves_after_start("G3 X10 Y10 AR=90"), "F u 10 10 0 arc 90 (0 10 0) (0 0 1)\n");
    EXPECT_EQ(moves_after_start("G2 X10 Y10 AR=270"), "F u 10 10 0 arc -270 (0 10 0) (0 0 1)\n");
    EXPECT_EQ(moves_after_start("G3 I5 AR=180 Z2"), "F u 10 0 2 arc 180 (5 0 0) (0 0 1)\n");
    EXPECT_EQ(moves_after_start("G3 X10 Z-6 I5 TURN=2"), "F u 10 0 -6 arc 900 (5 0 0) (0 0 1)\n");
    EXPECT_EQ(moves_after_start("G2 Z-2 I5 TURN=1"), "F u 0 0 -2 arc -720 (5 0 0) (0 0 1)\n")
        << "ends that are the same are a whole turn, and TURN counts further ones";
}

TEST(SinumerikCircles, ThroughAPoint) {
    EXPECT_EQ(moves_after_start("CIP X10 Y10 I1=10 J1=0 K1=0"), "F u 10 10 0 arc 180 (5 5 0) (0 0 1)\n");
    EXPECT_EQ(moves_after_start("CIP X0 Y10 Z10 I1=0 J1=0 K1=10"), "F u 0 10 10 arc 180 (0 5 5) (-1 0 0)\n");
    EXPECT_EQ(moves_after_start("X10\nG91 CIP X10 Y10 I1=10 J1=0"),
              "F u 10 0 0\nF u 20 10 0 arc 180 (15 5 0) (0 0 1)\n");
    EXPECT_EQ(moves_after_start("X10\nG91 CIP X10 Y10 I1=AC(20) J1=AC(0)"),
              "F u 10 0 0\nF u 20 10 0 arc 180 (15 5 0) (0 0 1)\n");
}

TEST(SinumerikCircles, Tangential) {
    EXPECT_EQ(moves_after_start("X10\nCT X20 Y10\nX10 Y20\nX5 Y20\nX15 Y30 Z3"),
              "F u 10 0 0\n"
              "F u 20 10 0 arc 90 (10 10 0) (0 0 1)\n"
              "F u 10 20 0 arc 90 (10 10 0) (0 0 1)\n"
              "F u 5 20 0\n"
              "F u 15 30 3 arc -270 (5 30 0) (0 0 1)\n");
    EXPECT_EQ(read_bc("G0 X0 Y0 Z0\nCT X5 F60\n").error().code, "NC0622");
}

TEST(SinumerikCircles, WithTurningAxesUnderTraoriAndInMachinePositions) {
    EXPECT_EQ(moves_under_traori("G3 X10 Y10 J10 B20"), "F w 10 10 0 B20 C0 arc 90 (0 10 0) (0 0 1)\n");
    EXPECT_EQ(moves_under_traori("G3 X10 Y10 J10 A3=1"), "F w 10 10 0 <1 0 0> arc 90 (0 10 0) (0 0 1)\n");
    EXPECT_EQ(moves_after_start("D0\nSUPA X0 Y0\nSUPA G3 X10 Y10 J10"),
              "F m 0 0 -\nF m 10 10 - arc 90 (0 10 0) (0 0 1)\n");
}

TEST(SinumerikCircles, StayCirclesInFrames) {
    EXPECT_EQ(moves_after_start("AROT Y90\nG3 X10 Y10 J10"), "F u 0 10 -10 arc 90 (0 10 0) (1 0 0)\n");
    EXPECT_EQ(moves_after_start("TRANS X100\nMIRROR X0\nG3 X10 Y10 J10"), "F u -10 10 0 arc 90 (0 10 0) (0 0 -1)\n")
        << "MIRROR takes the place of TRANS";
    EXPECT_EQ(moves_after_start("SCALE X2 Y2\nG3 X10 Y10 J10 Z4"), "F u 20 20 4 arc 90 (0 20 0) (0 0 1)\n");
    EXPECT_EQ(moves_after_start("AROT X30\nCIP X10 Y10 I1=10 J1=0 K1=0"),
              "F u 10 8.66025 5 arc 180 (5 4.33013 2.5) (0 -0.5 0.866025)\n");
}

}  // namespace
}  // namespace trunnion::nc
