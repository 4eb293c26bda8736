#include <algorithm>

#include "heidenhain_reading.hpp"

namespace trunnion::nc {
namespace {

TEST(HeidenhainFrames, DatumShift) {
    EXPECT_EQ(klartext("CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+10\nCYCL DEF 7.2 IY+5\nL X+1 Y+1 Z+1\n"
                       "CYCL DEF 7.1 IX+5\nL Y+2\nL X+0\nCYCL DEF 7.1 X+0\nCYCL DEF 7.2 Y+0\nL X+1 Y+1"),
              "F u 11 6 1\nF u 11 7 1\nF u 15 7 1\nF u 1 1 1\n")
        << "the axes stand where they stand";
    EXPECT_EQ(klartext("TRANS DATUM AXIS X+10 Y+5\nL X+1 Y+1\nTRANS DATUM RESET\nL X+1"), "F u 11 6 0\nF u 1 6 0\n");
    EXPECT_EQ(code_of(after_start("CYCL DEF 7.1 #5\nL X+1")), "NC0715");
    EXPECT_TRUE(told(*after_start("CYCL DEF 7.1 X+1\nL X+5"), "NC0754"));
}

TEST(HeidenhainFrames, MirrorRotationScale) {
    EXPECT_EQ(
        klartext("CYCL DEF 7.1 X+10\nCYCL DEF 8.0 MIRROR IMAGE\nCYCL DEF 8.1 X\nL X+1 Y+1\nCC X+1 Y+2\nC X+2 Y+2 DR+\n"
                 "CYCL DEF 8.0\nCYCL DEF 8.1\nL X+1 Y+1"),
        "F u 9 1 0\nF u 8 2 0 arc 90 (9 2 0) (0 0 -1)\nF u 11 1 0\n");
    EXPECT_EQ(klartext("CYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 ROT+90\nL X+1 Y+0\nCYCL DEF 10.1 IROT+90\nL X+1 Y+0\n"
                       "CYCL DEF 10.1 ROT+0\nL X+1 Y+0"),
              "F u 0 1 0\nF u -1 0 0\nF u 1 0 0\n");
    EXPECT_EQ(klartext("CYCL DEF 11.0 SCALING\nCYCL DEF 11.1 SCL 0.5\nL X+1 Y+2 Z+4"), "F u 0.5 1 2\n");
    EXPECT_EQ(klartext("CYCL DEF 26.0 AXIS-SPECIFIC SCALING\nCYCL DEF 26.1 X 2 Y 0.5 CCX+10 CCY+0\nL X+11 Y+2"),
              "F u 12 1 0\n");
    EXPECT_EQ(code_of(after_start("CYCL DEF 26.1 X 2 Y 0.5\nCC X+5 Y+0\nC X+10 Y+0 DR+")), "NC0716");
    EXPECT_EQ(code_of(under_m128("CYCL DEF 26.1 X 2\nLN X+1 TX+1 TY+0 TZ+1")), "NC0716");
}

TEST(HeidenhainFrames, OrdersThatWouldMatterAreRefused) {
    for (const char* blocks :
         {"CYCL DEF 10.1 ROT+5\nCYCL DEF 7.1 X+1", "CYCL DEF 10.1 ROT+5\nCYCL DEF 8.1 X",
          "CYCL DEF 10.1 ROT+5\nCYCL DEF 26.1 X2", "CYCL DEF 26.1 X2\nCYCL DEF 10.1 ROT+5", "CYCL DEF 11.1 SCL 0",
          "CYCL DEF 8.1 A", "CYCL DEF 10.1 ROT+5\nPLANE SPATIAL SPA+1 SPB+0 SPC+0 STAY",
          "CYCL DEF 7.1 X+5\nPLANE SPATIAL SPA+1 SPB+0 SPC+0 STAY\nCYCL DEF 7.1 X+1",
          "PLANE SPATIAL SPA+1 SPB+0 SPC+0 STAY\nCYCL DEF 7.1 X+1\nPLANE SPATIAL SPA+2 SPB+0 SPC+0 STAY",
          "CYCL DEF 10.1", "CYCL DEF 247 DATUM Q338=1", "CYCL DEF 247 DATUM", "CYCL DEF 247 Q339=-1", "TRANS MIRROR"})
        EXPECT_EQ(code_of(after_start(blocks)), "NC0715") << blocks;
    EXPECT_EQ(klartext("CYCL DEF 7.1 X+5\nCYCL DEF 10.1 ROT+90\nCYCL DEF 7.1 X+0\nL X+1 Y+0"), "F u 0 1 0\n")
        << "its end has one meaning";
}

TEST(HeidenhainFrames, Datums) {
    const auto p =
        after_start("CYCL DEF 247 DATUM SETTING ~\n  Q339=+1 ;DATUM NUMBER\nL X+1 FMAX\nCYCL DEF 247 ~\nQ339=7\nL X+1");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(moves_of(p), "R u 1 - -\nF u 1 - -\n");
    EXPECT_EQ(p->offsets.at(p->moves[1].offset), "G54");
    EXPECT_EQ(p->offsets.at(p->moves[2].offset), "DATUM 7");
}

TEST(HeidenhainFrames, TiltedPlane) {
    EXPECT_EQ(klartext("CYCL DEF 7.1 X+10\nPLANE SPATIAL SPA+0 SPB+90 SPC+0 TURN FMAX SEQ- COORD ROT\nL X+1 FMAX\n"
                       "L Y+2 Z+3 FMAX\nL X+4\nCC X+5 Y+2\nC X+6 Y+2 DR-\nL Z+100 FMAX M91\nL X+1 Y+1 Z+1 FMAX\n"
                       "PLANE RESET STAY\nL X+9 FMAX"),
              "R w 13 2 -1 <1 0 0>\n"
              "F w 13 2 -4 <1 0 0>\n"
              "F w 13 2 -6 <1 0 0> arc -180 (13 2 -5) (1 0 0)\n"
              "R m - - 100\n"
              "R w 11 1 -1 <1 0 0>\n"
              "R u 19 - -\n");
    const auto p =
        after_start("PLANE SPATIAL SPA+0 SPB+90 SPC+0 TURN FMAX SEQ- COORD ROT\nL X+1 FMAX\nL X+1 Y+2 Z+3 FMAX");
    ASSERT_TRUE(p) << said(p);
    EXPECT_TRUE(told(*p, "NC0752"));
    EXPECT_TRUE(told(*p, "NC0757", "SEQ"));
    EXPECT_TRUE(told(*p, "NC0757", "COORD ROT"));
    EXPECT_TRUE(told(*p, "NC0754"));
    EXPECT_EQ(code_of(after_start("PLANE SPATIAL SPA+0 SPB+90 SPC+0 TURN FMAX\nL X+1 F100")), "NC0710");
}

TEST(HeidenhainFrames, KindsOfPlanes) {
    const auto axis = [](std::string_view plane) {
        const auto p = after_start(std::string(plane) + " TURN FMAX\nL X+1 Y+0 Z+0 FMAX\nPLANE RESET STAY");
        return p ? triple(p->moves.back().axis) + " x " + triple(p->moves.back().position_mm) : said(p);
    };
    EXPECT_EQ(axis("PLANE SPATIAL SPA+90 SPB+0 SPC+90"), "1 0 0 x 0 1 0") << "about the fixed X, then the fixed Z";
    EXPECT_EQ(axis("PLANE EULER EULPR+90 EULNU+90 EULROT+0"), "1 0 0 x 0 1 0");
    EXPECT_EQ(axis("PLANE VECTOR BX+1 BY+1 BZ+0 NX+0 NY+5 NZ+0"), "0 1 0 x 1 0 0");
    EXPECT_EQ(axis("PLANE RELATIV SPB+90"), "1 0 0 x 0 0 -1");
    EXPECT_EQ(axis("PLANE SPATIAL SPA+0 SPB+90 SPC+0 STAY\nPLANE RELATIV SPA+90"), "0 -1 0 x 0 0 -1");
    for (const char* bad : {"PLANE AXIAL B+90", "PLANE PROJECTED PROPR+0 PROMIN+0 ROT+0", "PLANE SPATIAL SPA+0 SPB+90",
                            "PLANE SPATIAL SPA+0 SPA+90 SPC+0", "PLANE VECTOR BX+1 BY+0 BZ+0 NX+1 NY+0 NZ+0",
                            "PLANE VECTOR BX+1 BY+0 BZ+0 NX+0 NY+0 NZ+0", "PLANE RELATIV B+4"})
        EXPECT_EQ(code_of(after_start(bad)), "NC0720") << bad;
}

TEST(HeidenhainFrames, APlaneThatStaysKeepsTheToolWhereItStands) {
    EXPECT_EQ(klartext("PLANE SPATIAL SPA+0 SPB+90 SPC+0 STAY\nL B+90 C+0 FMAX\nL X+1 Y+2 Z+3 FMAX\nL X+2"),
              "R u - - - B90 C0\nR w 3 2 -1 B90 C0\nF w 3 2 -2 B90 C0\n");
    EXPECT_EQ(klartext("L B+90 C+0 FMAX\nPLANE SPATIAL SPA+0 SPB+90 SPC+0 STAY\nL X+1 Y+2 Z+3 FMAX"),
              "R u 0 0 0 B90 C0\nR w 3 2 -1 B90 C0\n");
    EXPECT_EQ(klartext("PLANE SPATIAL SPA+0 SPB+90 SPC+0 STAY\nL B+Q121 C+Q122 FMAX\nL X+1 Y+2 Z+3 FMAX"),
              "R w 3 2 -1 <1 0 0>\n")
        << "the control's own positions for the plane";
    EXPECT_EQ(code_of(after_start("L B+Q121 C+Q122 FMAX")), "NC0721");
    EXPECT_EQ(code_of(after_start("PLANE SPATIAL SPA+0 SPB+90 SPC+0 STAY\nL B+Q121 C+5 FMAX")), "NC0721");
    EXPECT_EQ(code_of(after_start("PLANE SPATIAL SPA+0 SPB+90 SPC+0 STAY\nL B+Q122 FMAX")), "NC0732");
    EXPECT_EQ(code_of(after_start("PLANE SPATIAL SPA+0 SPB+90 SPC+0 STAY\nL X+1 B+5 FMAX")), "NC0721");
}

TEST(HeidenhainFrames, TheEndOfAPlaneMayTurnTheAxesBack) {
    EXPECT_EQ(
        klartext("L B+90 C+45 FMAX\nPLANE SPATIAL SPA+0 SPB+90 SPC+0 STAY\nL X+1 Y+2 Z+3 FMAX\nPLANE RESET TURN F5000\n"
                 "L X+0 FMAX"),
        "R u 0 0 0 B90 C45\nR w 3 2 -1 B90 C45\nF u - - - B0 C0\nR u 0 - - B0 C0\n");
    EXPECT_EQ(klartext("L B+90 C+45 FMAX\nPLANE RESET MOVE DIST 10 FMAX"), "R u 0 0 0 B90 C45\nR w - - - B0 C0\n");
    EXPECT_EQ(code_of(read_program("BEGIN PGM A MM\nL X+0 Y+0 Z+0 FMAX\nPLANE RESET TURN FMAX\n", "test", {})),
              "NC0707");
}

TEST(HeidenhainFrames, Cycle19) {
    EXPECT_EQ(klartext("CYCL DEF 19.0 WORKING PLANE\nCYCL DEF 19.1 A+0 B+90 C+0 F2000 ABST 50\nL X+1 Y+2 Z+3 FMAX\n"
                       "CYCL DEF 19.0\nCYCL DEF 19.1\nL X+9 FMAX"),
              "R w 3 2 -1 <1 0 0>\nR u 9 - -\n");
    EXPECT_EQ(klartext("CYCL DEF 19.1 B+90\nL B+90 C+0 FMAX\nL X+1 Y+2 Z+3 FMAX"),
              "R u - - - B90 C0\nR w 3 2 -1 B90 C0\n");
    EXPECT_EQ(code_of(after_start("CYCL DEF 19.1 X+90")), "NC0720");
}

TEST(HeidenhainFrames, M128InAPlane) {
    EXPECT_EQ(
        klartext("PLANE SPATIAL SPA+0 SPB+90 SPC+0 TURN FMAX\nM128\nL X+1 Y+2 Z+3 FMAX\nLN X+1 Y+2 Z+4 TX+1 TY+0 TZ+0\n"
                 "L X+2 B+10 C+5"),
        "R w 3 2 -1 <1 0 0>\nF w 4 2 -1 <0 0 -1>\nF w 4 2 -2 B10 C5\n");
}

TEST(HeidenhainCycles, Drilling) {
    EXPECT_EQ(
        klartext(
            "CYCL DEF 200 DRILLING ~\n Q200=+2 ;SET-UP ~\n Q201=-10 ;DEPTH ~\n Q206=+120 ~\n Q202=+4 ~\n Q210=0 ~\n"
            " Q203=+5 ~\n Q204=+50 ~\n Q211=0.5\nL Z+60 FMAX\nL X+10 Y+5 FMAX M99"),
        "R u 0 0 60\nR u 10 5 60\nR u 10 5 7\nF u 10 5 1\nR u 10 5 7\nR u 10 5 3\nF u 10 5 -3\nR u 10 5 7\n"
        "R u 10 5 -1\nF u 10 5 -5\nR u 10 5 55\n");
    const auto p = after_start("CYCL DEF 200 Q200=2 Q201=-10 Q206=120 Q202=10 Q203=0 Q204=2 Q211=0.5\nCYCL CALL M3");
    ASSERT_TRUE(p) << said(p);
    EXPECT_NEAR(p->moves[2].feed.value, 2, 1e-12);
    ASSERT_EQ(p->events.size(), 2u);
    EXPECT_EQ(p->events[1].dwell_s, 0.5);
    EXPECT_EQ(p->events[1].before_move, 3u);
}

/// Lines of their own behind the cycle say its feeds as the cycle itself would.
TEST(HeidenhainCycles, FeedsBehindTheCycle) {
    const std::string cycle = "CYCL DEF 200 Q200=2 Q201=-10 Q202=10 Q203=0 Q204=2\n";
    const auto plunge = [&](const std::string& feed) { return after_start("TOOL CALL 5 Z S1000 F240\n" + feed); };
    for (const char* feed : {"Q206=FAUTO\n", "Q206 = AUTO\n", "Q206=240\n"}) {
        const auto p = plunge(cycle + feed + "L X+1 Y+0 Z+2 FMAX\nCYCL CALL");
        ASSERT_TRUE(p) << feed << said(p);
        const auto down =
            std::ranges::find(p->moves.rbegin(), p->moves.rend(), program::MoveKind::feed, &program::Move::kind);
        ASSERT_NE(down, p->moves.rend()) << feed;
        EXPECT_NEAR(down->feed.value, 4, 1e-12) << feed;
    }
    const auto rapid = plunge(cycle + "Q206=FMAX\nL X+1 Y+0 Z+2 FMAX\nCYCL CALL");
    ASSERT_TRUE(rapid) << said(rapid);
    EXPECT_EQ(std::ranges::count(rapid->moves, program::MoveKind::feed, &program::Move::kind), 0);
    EXPECT_EQ(code_of(after_start(cycle + "Q206=FAUTO\nCYCL CALL")), "NC0705") << "TOOL CALL says no feed";
    EXPECT_EQ(code_of(after_start("Q206=FEED")), "NC0731");
}

TEST(HeidenhainCycles, Calls) {
    const std::string cycle = "CYCL DEF 240 CENTERING Q200=1 Q343=0 Q201=-2 Q206=60 Q203=0 Q204=1\n";
    EXPECT_EQ(klartext(cycle + "L X+1 FMAX M89\nL X+2 FMAX\nL X+3 FMAX M99\nL X+4 FMAX"),
              "R u 1 0 0\nR u 1 0 1\nF u 1 0 -2\nR u 1 0 1\nR u 2 0 1\nF u 2 0 -2\nR u 2 0 1\nR u 3 0 1\nF u 3 0 -2\n"
              "R u 3 0 1\nR u 4 0 1\n");
    EXPECT_EQ(klartext(cycle + "CYCL CALL POS X+5 Y+6 Z+10 FMAX"), "R u 0 0 11\nR u 5 6 11\nF u 5 6 8\nR u 5 6 11\n");
    EXPECT_EQ(klartext(cycle + "Q201=-3\nCYCL CALL"), "R u 0 0 1\nF u 0 0 -3\nR u 0 0 1\n")
        << "parameters are read at the call";
    EXPECT_EQ(code_of(after_start("CYCL CALL")), "NC0705");
    EXPECT_EQ(code_of(after_start(cycle + "CYCL CALL PAT")), "NC0704");
    EXPECT_EQ(code_of(after_start(cycle + "L X+1 FMAX M91 M99")), "NC0705");
}

TEST(HeidenhainCycles, ReamingTappingPecking) {
    EXPECT_EQ(klartext("CYCL DEF 201 Q200=2 Q201=-10 Q206=60 Q208=120 Q203=0 Q204=20\nCYCL CALL"),
              "R u 0 0 2\nF u 0 0 -10\nF u 0 0 2\nR u 0 0 20\n");
    const auto p =
        after_start("TOOL CALL 1 Z S600\nCYCL DEF 207 Q200=2 Q201=-10 Q239=+1.5 Q203=0 Q204=2\nL X+1 FMAX M99");
    ASSERT_TRUE(p) << said(p);
    EXPECT_NEAR(p->moves[3].feed.value, 15, 1e-12);
    EXPECT_NEAR(p->moves[4].feed.value, 15, 1e-12);
    EXPECT_EQ(klartext("CYCL DEF 206 Q200=2 Q201=-10 Q206=60 Q211=0 Q203=0 Q204=2\nCYCL CALL"),
              "R u 0 0 2\nF u 0 0 -10\nF u 0 0 2\n");
    EXPECT_EQ(klartext("CYCL DEF 203 Q200=2 Q201=-10 Q206=60 Q202=6 Q210=0 Q203=0 Q204=2 Q212=2 Q213=1 Q205=1 Q211=0 "
                       "Q208=600 Q256=0.5\nCYCL CALL"),
              "R u 0 0 2\nF u 0 0 -6\nF u 0 0 -5.5\nF u 0 0 -10\nF u 0 0 2\n");
    EXPECT_EQ(klartext("CYCL DEF 205 Q200=2 Q201=-10 Q206=60 Q202=6 Q203=0 Q204=2 Q258=0.5 Q259=0.5 Q257=0\nCYCL CALL"),
              "R u 0 0 2\nF u 0 0 -6\nR u 0 0 2\nR u 0 0 -5.5\nF u 0 0 -10\nR u 0 0 2\n");
    EXPECT_EQ(klartext("CYCL DEF 1.0 PECKING\nCYCL DEF 1.1 SET UP2\nCYCL DEF 1.2 DEPTH-10\nCYCL DEF 1.3 PECKG6\n"
                       "CYCL DEF 1.4 DWELL0\nCYCL DEF 1.5 F60\nL Z+2 FMAX M99"),
              "R u 0 0 2\nF u 0 0 -6\nR u 0 0 2\nR u 0 0 -5.4\nF u 0 0 -10\nR u 0 0 2\n");
}

TEST(HeidenhainCycles, InATiltedPlaneTheyGoAlongTheTool) {
    EXPECT_EQ(klartext("PLANE SPATIAL SPA+0 SPB+90 SPC+0 TURN FMAX\nCYCL DEF 240 Q200=1 Q201=-2 Q206=60 Q203=0 Q204=1\n"
                       "L X+1 Y+2 Z+30 FMAX M99\nPLANE RESET STAY"),
              "R w 30 2 -1 <1 0 0>\nR w 1 2 -1 <1 0 0>\nF w -2 2 -1 <1 0 0>\nR w 1 2 -1 <1 0 0>\n");
}

TEST(HeidenhainCycles, Refused) {
    const std::string good = "CYCL DEF 200 Q200=2 Q201=-10 Q206=120 Q202=10 Q203=0 Q204=2\n";
    for (const char* change : {"Q201=10", "Q206=0", "Q200=-1", "Q202=0.0001", "Q395=1"})
        EXPECT_EQ(code_of(after_start(good + change + "\nCYCL CALL")), "NC0705") << change;
    EXPECT_EQ(code_of(after_start("CYCL DEF 200 Q200=2 Q201=-10\nCYCL CALL")), "NC0705");
    EXPECT_EQ(code_of(after_start("CYCL DEF 240 Q200=2 Q201=-1 Q343=1 Q206=9 Q203=0 Q204=2\nCYCL CALL")), "NC0705");
    EXPECT_EQ(code_of(after_start("CYCL DEF 207 Q200=2 Q201=-1 Q239=1 Q203=0 Q204=2\nCYCL CALL")), "NC0705") << "no S";
    for (const char* cycle : {"CYCL DEF 208 BORE MILLING", "CYCL DEF 251 POCKET", "CYCL DEF 12.0 PGM CALL",
                              "CYCL DEF 4.0 POCKET", "CYCL DEF 220 POLAR PATTERN", "CYCL DEF X"})
        EXPECT_EQ(code_of(after_start(cycle)), "NC0704") << cycle;
}

TEST(HeidenhainCycles, ToleranceIsTold) {
    EXPECT_TRUE(told(
        *after_start("CYCL DEF 32.0 TOLERANCE\nCYCL DEF 32.1 T0.05\nCYCL DEF 32.2 HSC-MODE:0 TA0.5\nL X+1"), "NC0758"));
}

}  // namespace
}  // namespace trunnion::nc
