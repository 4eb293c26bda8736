#include "heidenhain_reading.hpp"

namespace trunnion::nc {
namespace {

using program::EventKind;
using program::Feed;
using program::FeedRule;

TEST(Heidenhain, WholeProgram) {
    const auto p = read_klartext(
        "0 BEGIN PGM PART MM\r\n"
        "1 BLK FORM 0.1 Z X+0 Y+0 Z-20\r\n"
        "2 BLK FORM 0.2 X+100 Y+100 Z+0\r\n"
        "3 TOOL CALL \"MILL 8\" Z S3500 F500 DL+0 DR+0.5 ; the tool\r\n"
        "* - structure\r\n"
        "4 L X+0 Y+0 Z+50 R0 FMAX M3\r\n"
        "5 L M128\r\n"
        "6 L X+1,5 Y-2 Z+.5 B+30 C+111511 F600 M8\r\n"
        "7 L X+2\r\n"
        "8 CYCL DEF 9.0 DWELL TIME\r\n"
        "9 CYCL DEF 9.1 DWELL 2.5\r\n"
        "10 L IY+4 FMAX M9\r\n"
        "11 L Z+1\r\n"
        "12 STOP M2\r\n"
        "13 L X+99\r\n"
        "14 END PGM PART MM\r\n");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->dialect, "heidenhain");
    EXPECT_EQ(moves_of(p, 0),
              "R u 0 0 50 B- C-\n"
              "F w 1.5 -2 0.5 B30 C111511\n"
              "F w 2 -2 0.5 B30 C111511\n"
              "R w 2 2 0.5 B30 C111511\n"
              "F w 2 2 1 B30 C111511\n");
    EXPECT_EQ(p->moves[1].feed, (Feed{FeedRule::tip_speed, 10})) << "the tip's speed";
    EXPECT_EQ(p->moves[4].feed, (Feed{FeedRule::tip_speed, 10})) << "FMAX is of its block alone";
    EXPECT_EQ(p->moves[1].line, 8);
    EXPECT_EQ(p->tools.at(p->moves[1].tool), "MILL 8");
    const std::vector<std::tuple<std::string, EventKind, bool, std::size_t>> expected = {
        {"S3500", EventKind::spindle, false, 0},
        {"TOOL CALL MILL 8", EventKind::tool, true, 0},
        {"M3", EventKind::spindle, true, 0},
        {"M8", EventKind::coolant, false, 1},
        {"CYCL DEF 9 2.5", EventKind::dwell, true, 3},
        {"M9", EventKind::coolant, false, 4},
        {"STOP", EventKind::stop, true, 5},
        {"M2", EventKind::stop, true, 5}};
    ASSERT_EQ(p->events.size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
        const program::Event& e = p->events[i];
        EXPECT_EQ((std::tuple{e.word, e.kind, e.stops_motion, e.before_move}), expected[i]);
    }
    EXPECT_EQ(p->events[4].dwell_s, 2.5);
    EXPECT_TRUE(told(*p, "NC0012", "DR"));
    EXPECT_TRUE(told(*p, "NC0755"));
}

TEST(Heidenhain, WithoutM128TheAxesAreCountedFromTheDatum) {
    EXPECT_EQ(klartext("L X+1\nL B+90 FMAX\nL M128\nL X+2 Y+3 FMAX\nL Z+4 FMAX\nL M129\nL Z+9 FMAX\nL X+1 Y+1 FMAX"),
              "F u 1 0 0 B-\n"
              "R u 1 0 0 B90\n"
              "R w 2 3 - B90\n"
              "R w 2 3 4 B90\n"
              "R u - - 9 B90\n"
              "R u 1 1 9 B90\n");
}

TEST(Heidenhain, M129ActsBehindItsBlock) {
    EXPECT_EQ(klartext_m128("L X+5 M129\nL X+6"), "F w 5 0 0 B0 C0\nF u 6 - - B0 C0\n");
}

TEST(Heidenhain, M91IsOfMachinePositionsInItsBlock) {
    EXPECT_EQ(klartext("L Z+600 R0 FMAX M91\nL X-300 Y+200 B+10 FMAX M91\nL X+5 FMAX\nL Y+6 FMAX"),
              "R m - - 600 B-\n"
              "R m -300 200 600 B10\n"
              "R u 5 - - B10\n"
              "R u 5 6 - B10\n");
    EXPECT_EQ(code_of(under_m128("L Z+5 FMAX M91")), "NC0712");
}

TEST(Heidenhain, IncrementalWords) {
    EXPECT_EQ(klartext("L IX+1 IY-2\nL IX+1 B+10\nL IB+5 IZ+3"), "F u 1 -2 0 B-\nF u 2 -2 0 B10\nF u 2 -2 3 B15\n");
    EXPECT_EQ(code_of(after_start("L M128\nL IX+1 FMAX")), "NC0709");
    EXPECT_EQ(code_of(after_start("L IB+1 FMAX")), "NC0709");
}

TEST(Heidenhain, ShorterWayAndReducedCount) {
    EXPECT_EQ(klartext("L C+350 FMAX\nL C+10 FMAX\nL M126\nL C+350 FMAX\nL C+10 M127\nL C+350 FMAX"),
              "R u 0 0 0 C350\nR u 0 0 0 C10\nR u 0 0 0 C-10\nF u 0 0 0 C10\nR u 0 0 0 C350\n");
    EXPECT_EQ(klartext("L C+538 FMAX\nL C+180 FMAX M94 C\nL C+0 FMAX"),
              "R u 0 0 0 C538\nR u 0 0 0 C540\nR u 0 0 0 C360\n")
        << "178 after M94, so that 180 is two degrees away";
    EXPECT_EQ(klartext("L C+538 B+400 FMAX\nL C+180 B+41 FMAX M94\n"), "R u 0 0 0 B400 C538\nR u 0 0 0 B401 C540\n");
    EXPECT_TRUE(told(*after_start("L C+10 FMAX M126"), "NC0759"));
}

TEST(Heidenhain, FeedOfRotations) {
    const auto p = under_m128("L B+90 F360\nL X+1 B+0\nL M129\nL M116\nL C+90\nL C+0 M117\nL C+90");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->moves[1].feed.rule, FeedRule::rotary_rate);
    EXPECT_NEAR(p->moves[1].feed.value, 6 * degree, 1e-12);
    EXPECT_EQ(p->moves[2].feed, (Feed{FeedRule::tip_speed, 6}));
    EXPECT_EQ(p->moves[3].feed, (Feed{FeedRule::tip_speed, 6})) << "M116: at the tool's tip";
    EXPECT_EQ(p->moves[5].feed.rule, FeedRule::rotary_rate);
    EXPECT_TRUE(told(*p, "NC0751"));
}

TEST(Heidenhain, FeedOfAllAxes) {
    const auto p =
        under_m128("FUNCTION TCPM F CONT AXIS POS PATHCTRL AXIS\nL X+3 B+4 F300\nL Y+5\nFUNCTION RESET TCPM");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->moves[1].feed.rule, FeedRule::block_time);
    EXPECT_NEAR(p->moves[1].feed.value, 1, 1e-12) << "5 of millimetres and degrees at 5 a second";
    EXPECT_NEAR(p->moves[2].feed.value, 1, 1e-12);
    EXPECT_EQ(code_of(after_start("FUNCTION TCPM F CONT AXIS POS PATHCTRL AXIS\nL X+1 B+1")), "NC0723");
}

TEST(Heidenhain, OtherFeeds) {
    const auto p = after_start(
        "TOOL CALL 1 Z S1000 F300\nL X+1 FAUTO\nL X+2 FU0.12\nL X+3 F AUTO\nL M136\nL X+4 F.3\n"
        "L M137\nL X+5 F60\nL X+6 F MAX");
    ASSERT_TRUE(p) << said(p);
    const double speeds[] = {5, 2, 5, 5, 1};
    for (std::size_t i = 0; i < std::size(speeds); ++i) EXPECT_NEAR(p->moves[i + 1].feed.value, speeds[i], 1e-12) << i;
    EXPECT_EQ(p->moves[6].kind, program::MoveKind::rapid);
    EXPECT_EQ(code_of(after_start("L X+1 FU0.1")), "NC0723");
    EXPECT_EQ(code_of(after_start("L X+1 FZ0.1")), "NC0723");
    EXPECT_EQ(code_of(after_start("L X+1 F0")), "NC0206");
    EXPECT_EQ(code_of(read_klartext("BEGIN PGM A MM\nL X+0 Y+0 Z+0 FMAX\nL X+1\n")), "NC0205");
}

TEST(Heidenhain, Inches) {
    const auto p = read_klartext("BEGIN PGM A INCH\nL X+0 Y+0 Z+1 FMAX\nL X+2 B+10 F100\nL B+20\nEND PGM A INCH\n");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(moves_of(p), "F u 50.8 0 25.4 B10\nF u 50.8 0 25.4 B20\n");
    EXPECT_NEAR(p->moves[1].feed.value, 254.0 / 60, 1e-12) << "F counts in tenths of an inch";
    EXPECT_NEAR(p->moves[2].feed.value, 100.0 / 60 * degree, 1e-12) << "degrees are no inches";
    EXPECT_TRUE(told(*p, "NC0756"));
    EXPECT_EQ(p->moves.front().position_mm.z(), 25.4);
    const auto mm = read_klartext("BEGIN PGM A IN\nL X+0 Y+0 Z+1 FMAX\nL X+2 F100\n", {.units = Units::mm});
    ASSERT_TRUE(mm) << said(mm);
    EXPECT_EQ(moves_of(mm), "F u 2 0 1\n");
    EXPECT_TRUE(told(*mm, "NC0018"));
    EXPECT_EQ(code_of(read_klartext("BEGIN PGM A CM\nL X+0 Y+0 Z+1 FMAX\n")), "NC0749");
}

TEST(Heidenhain, Vectors) {
    EXPECT_EQ(
        klartext_m128("LN X+1 Y+2 Z+3 TX+0 TY+0.6 TZ+0.8 F100\nL X+5\nLN X+6 Y+2 Z+3 NX+0 NY+0 NZ+1 TX+1 TY+0 TZ+0\n"
                      "LN X+7 Y+2 Z+3 NX+0.6 NY+0 NZ+0.8\nL X+8 B+30"),
        "F w 1 2 3 <0 0.6 0.8>\n"
        "F w 5 2 3 <0 0.6 0.8>\n"
        "F w 6 2 3 <1 0 0>\n"
        "F w 7 2 3 <0.6 0 0.8>\n"
        "F w 8 2 3 B30 C-\n")
        << "without T the tool stands along N";
    EXPECT_TRUE(told(*under_m128("LN X+6 NX+0 NY+0 NZ+1 TX+1 TY+0 TZ+0"), "NC0012", "NX NY NZ"));
    EXPECT_TRUE(told(*under_m128("LN X+6 TX+0 TY+3 TZ+4"), "NC0015"));
    const auto off = after_start("LN X+6 NX+0 NY+0 NZ+1 TX+1 TY+0 TZ+0");
    EXPECT_EQ(moves_of(off), "F u 6 0 0\n") << "without M128 the control does not turn the tool";
    EXPECT_TRUE(told(*off, "NC0012", "TX TY TZ without M128"));
    EXPECT_EQ(code_of(under_m128("LN X+6 TX+1 TY+0")), "NC0713");
    EXPECT_EQ(code_of(under_m128("LN X+6 TX+0 TY+0 TZ+0")), "NC0713");
    EXPECT_EQ(code_of(under_m128("LN X+6 B+5 TX+0 TY+0 TZ+1")), "NC0714");
    EXPECT_EQ(code_of(under_m128("L X+6 TX+0 TY+0 TZ+1")), "NC0711");
}

TEST(Heidenhain, M128SaidAgainChangesNothing) {
    EXPECT_EQ(klartext_m128("LN X+1 Y+2 Z+3 TX+0 TY+0.6 TZ+0.8 M128\nL X+5 M128"),
              "F w 1 2 3 <0 0.6 0.8>\nF w 5 2 3 <0 0.6 0.8>\n");
}

TEST(Heidenhain, KindsOfTcpm) {
    EXPECT_EQ(klartext_m128("FUNCTION TCPM F TCP AXIS SPAT PATHCTRL VECTOR REFPNT TIP-TIP\nL X+1 A+0 B+90 C+0\nL C+90\n"
                            "L A+0 B+0 C+0 X+2"),
              "F w 1 0 0 <1 0 0>\nF w 1 0 0 <0 1 0>\nF w 2 0 0 <0 0 1>\n");
    EXPECT_EQ(code_of(under_m128("FUNCTION TCPM F TCP AXIS SPAT PATHCTRL AXIS\nL X+1 B+90")), "NC0714");
    EXPECT_EQ(code_of(under_m128("FUNCTION TCPM F TCP AXIS POS PATHCTRL VECTOR\nL X+1 B+90")), "NC0714");
    EXPECT_EQ(code_of(under_m128("FUNCTION TCPM F TCP AXIS POS PATHCTRL VECTOR\nL X+1 B+90 FMAX")), "read");
    EXPECT_EQ(code_of(under_m128("FUNCTION TCPM F TCP F CONT AXIS POS\nL X+1")), "NC0706");
    EXPECT_EQ(code_of(under_m128("FUNCTION TCPM F TCP AXIS POS REFPNT CENTER-CENTER\nL X+1")), "NC0701");
    EXPECT_EQ(klartext_m128("FUNCTION RESET TCPM\nL X+1 FMAX"), "R u 1 - - B0 C0\n");
}

TEST(Heidenhain, Circles) {
    EXPECT_EQ(klartext("CC X+5 Y+0\nC X+10 Y+0 DR-"), "F u 10 0 0 arc -180 (5 0 0) (0 0 1)\n");
    EXPECT_EQ(klartext("CC IX+5 IY+0\nC DR+"), "F u 0 0 0 arc 360 (5 0 0) (0 0 1)\n");
    EXPECT_EQ(klartext("L X+5\nCC\nL X+10\nC X+5 Y+5 DR+"),
              "F u 5 0 0\nF u 10 0 0\nF u 5 5 0 arc 90 (5 0 0) (0 0 1)\n");
    EXPECT_EQ(klartext("CR X+10 Y+0 R+5 DR+"), "F u 10 0 0 arc 180 (5 0 0) (0 0 1)\n");
    EXPECT_EQ(klartext("CR X+5 Y+5 R-5 DR+"), "F u 5 5 0 arc 270 (5 0 0) (0 0 1)\n");
    EXPECT_EQ(klartext("CR X+5 Y+5 R+5 DR-"), "F u 5 5 0 arc -90 (5 0 0) (0 0 1)\n");
    EXPECT_EQ(klartext("L X+5\nCT X+10 Y+5"), "F u 5 0 0\nF u 10 5 0 arc 90 (5 5 0) (0 0 1)\n");
    EXPECT_EQ(klartext("L X+10\nCC X+5 Y+0 Z+5\nC X+10 Y+0 Z+10 DR-"),
              "F u 10 0 0\nF u 10 0 10 arc -90 (5 0 5) (0 1 0)\n")
        << "a circle in the plane of Z and X, as all its places have one Y";
}

TEST(Heidenhain, PolarCoordinatesAndHelices) {
    EXPECT_EQ(klartext("CC X+0 Y+0\nLP PR+10 PA+0\nLP PA+90\nLP IPA+90\nLP IPR+5"),
              "F u 10 0 0\nF u 0 10 0\nF u -10 0 0\nF u -15 0 0\n");
    EXPECT_EQ(klartext("CC X+5 Y+0\nCP IPA+720 IZ+3 DR+"), "F u 0 0 3 arc 720 (5 0 0) (0 0 1)\n");
    EXPECT_EQ(klartext("CC X+5 Y+0\nCP PA+90 DR-"), "F u 5 5 0 arc -90 (5 0 0) (0 0 1)\n");
    EXPECT_EQ(klartext("CC X+5 Y+0\nCP PA+180 Z+1 DR-"), "F u 0 0 1 arc -360 (5 0 0) (0 0 1)\n");
    EXPECT_EQ(code_of(after_start("LP PR+1 PA+0")), "NC0709");
    EXPECT_EQ(code_of(after_start("CC X+5 Y+0\nCP IPA-90 DR+")), "NC0717");
}

TEST(Heidenhain, CirclesThatDoNotFit) {
    EXPECT_EQ(code_of(after_start("CC X+5 Y+0\nC X+10 Y+0")), "NC0717");
    EXPECT_EQ(code_of(after_start("C X+10 Y+0 DR+")), "NC0709");
    EXPECT_EQ(code_of(after_start("CC X+5 Y+0\nC X+11 Y+0 DR+")), "NC0207");
    EXPECT_EQ(code_of(after_start("CR X+11 Y+0 R+5 DR+")), "NC0208");
    EXPECT_EQ(code_of(after_start("CR X+11 Y+0 DR+")), "NC0717");
    EXPECT_EQ(code_of(after_start("CT X+11 Y+0")), "NC0718");
    EXPECT_EQ(code_of(after_start("L X+5 DR+")), "NC0711");
    EXPECT_EQ(code_of(after_start("CC X+5 Y+0 F100")), "NC0711");
}

TEST(Heidenhain, Roundings) {
    const auto p = after_start("L X+10\nRND R2 F120\nL Y+10\nRND R3\nL X+0");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(moves_of(p),
              "F u 8 0 0\n"
              "F u 10 2 0 arc 90 (8 2 0) (0 0 1)\n"
              "F u 10 7 0\n"
              "F u 7 10 0 arc 90 (7 7 0) (0 0 1)\n"
              "F u 0 10 0\n");
    EXPECT_NEAR(p->moves[2].feed.value, 2, 1e-12) << "F of the corner alone";
    EXPECT_NEAR(p->moves[3].feed.value, 10, 1e-12);
    EXPECT_EQ(p->moves[2].line, 5);
    EXPECT_EQ(klartext("L X+5\nRND R2\nL X+10"), "F u 5 0 0\nF u 10 0 0\n");
    const auto turned = after_start("L C+30\nL X+10\nRND R2 F120\nL Y+10");
    EXPECT_TRUE(turned) << "a rotary axis that was said stays where it is";
    EXPECT_EQ(code_of(after_start("L C+30\nL X+10\nRND R2\nL Y+10 C+40")), "NC0719") << "it turns meanwhile";
    EXPECT_EQ(code_of(after_start("L X+1\nRND R2\nL Y+10")), "NC0719") << "too large";
    EXPECT_EQ(code_of(after_start("L X+10\nRND R2\nL Z+10")), "NC0719") << "not in the plane";
    EXPECT_EQ(code_of(after_start("L X+10\nRND R2\nL Y+10 FMAX")), "NC0719");
    EXPECT_EQ(code_of(after_start("L X+10\nRND R2\nCC X+5 Y+0\nC X+0 Y+0 DR+")), "NC0719");
    EXPECT_EQ(code_of(after_start("L X+10\nRND R2\n")), "NC0719");
    EXPECT_EQ(code_of(after_start("L X+10\nRND R0\nL Y+10")), "NC0719");
    EXPECT_EQ(code_of(after_start("L X+10\nCHF 2\nL Y+10")), "NC0719");
}

TEST(Heidenhain, Tools) {
    const auto names = [](std::string_view blocks) {
        const auto p = after_start(blocks);
        std::string out;
        for (std::size_t i = 1; p && i < p->moves.size(); ++i) out += '[' + p->tools.at(p->moves[i].tool) + ']';
        return p ? out : said(p);
    };
    EXPECT_EQ(
        names("TOOL CALL 5 Z S100\nL X+1\nTOOL DEF 6 L+20 R+3\nL X+2\nTOOL CALL S200\nL X+3\nTOOL CALL 0 Z\nL X+4\n"
              "Q1=7\nTOOL CALL Q1 Z\nL X+5\nTOOL CALL 5.1 Z\nL X+6"),
        "[5][5][5][0 D0][7][5.1]");
    EXPECT_EQ(code_of(after_start("TOOL CALL 5 Z DL+0.1")), "NC0722");
    EXPECT_EQ(code_of(after_start("TOOL CALL 5 Y")), "NC0722");
    EXPECT_EQ(code_of(after_start("TOOL CALL -5 Z")), "NC0204");
    EXPECT_EQ(code_of(after_start("TOOL CALL \"A Z")), "NC0711");
}

TEST(Heidenhain, RetractsAlongTheTool) {
    machine::Machine table = machine_with("BC");
    table.chain = {4, 3, 0, 1, 2};
    table.axes[2].range_max = 400;
    const auto on = [&](const machine::Machine& machine, std::string_view blocks) {
        return moves_of(read_with(machine, std::string("BEGIN PGM T MM\nL X+0 Y+0 Z+0 FMAX\nL F600\n").append(blocks),
                                  {.dialect = Dialect::heidenhain}));
    };
    EXPECT_EQ(on(table, "L M140 MB MAX\nL X+5"), "R m - - 400\nF u 5 - -\n");
    EXPECT_EQ(on(table, "L M140 MB50 F60\nL X+5"), "F u 0 0 50\nF u 5 0 50\n");
    EXPECT_EQ(on(table, "M128\nLN X+1 Y+0 Z+0 TX+0.6 TY+0 TZ+0.8\nL M140 MB10"),
              "F w 1 0 0 <0.6 0 0.8>\nR w 7 0 8 <0.6 0 0.8>\n");
    EXPECT_TRUE(on(table, "M128\nL X+1 B+5\nL M140 MB10").find("NC0724") != std::string::npos);
    machine::Machine head = table;
    head.chain = {4, 0, 1, 2, 3};
    EXPECT_EQ(on(head, "L M140 MB MAX\nL X+5"), "F u 5 0 0\n") << "Z is not along the tool: left out and told";
    EXPECT_TRUE(on(head, "L B+90\nL M140 MB10").find("NC0724") != std::string::npos);
    EXPECT_TRUE(told(*after_start("L M140 MB MAX\nL X+5"), "NC0753"));
    EXPECT_EQ(code_of(after_start("L M140")), "NC0724");
}

TEST(Heidenhain, WordsThatAreIgnoredOrEvents) {
    const auto p = after_start("L X+1 M57 M36\nM128 F1000\nL X+2 M118 X1 Y1\nL X+3 M124 M98\nL X+4 M120 LA5\nM13");
    ASSERT_TRUE(p) << said(p);
    EXPECT_TRUE(told(*p, "NC0012", "M118"));
    EXPECT_TRUE(told(*p, "NC0012", "M120"));
    EXPECT_TRUE(told(*p, "NC0012", "M128 F"));
    ASSERT_EQ(p->events.size(), 4u);
    EXPECT_EQ(p->events[0].word, "M57");
    EXPECT_EQ(p->events[3].word, "M13");
    EXPECT_EQ(p->moves.back().position_mm.x(), 4);
}

}  // namespace
}  // namespace trunnion::nc
