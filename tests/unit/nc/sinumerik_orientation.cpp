#include "sinumerik_reading.hpp"

namespace trunnion::nc {
namespace {

TEST(SinumerikVectors, TurnInAPlaneAndKeepTheLaw) {
    EXPECT_EQ(moves_under_traori("X1 A3=0 B3=0 C3=1\nX2 A3=1 C3=1\nX3\nB3=2\nG0 Z9\nX4 B10\nX5 C20\nX6"),
              "F w 1 0 0 <0 0 1>\n"
              "F w 2 0 0 <0.707107 0 0.707107>\n"
              "F w 3 0 0 <0.707107 0 0.707107>\n"
              "F w 3 0 0 <0 1 0>\n"
              "R w 3 0 9 <0 1 0>\n"
              "R w 4 0 9 B10 C-\n"
              "R w 5 0 9 B10 C20\n"
              "R w 6 0 9 B10 C20\n")
        << "components that are not said are 0; where C stands after vectors path building knows";
}

TEST(SinumerikVectors, MachinePositionsBetween) {
    EXPECT_EQ(moves_under_traori("X1 A3=1\nTRAFOOF\nSUPA G0 Z500 D0\nB0 C0\nTRAORI\nX1 Y2 Z3 D1 A3=0 C3=1"),
              "F w 1 0 0 <1 0 0>\n"
              "R m - - 500 B- C-\n"
              "R u - - - B0 C0\n"
              "R w 1 2 3 <0 0 1>\n");
}

TEST(SinumerikVectors, CountInTheFrame) {
    EXPECT_EQ(moves_under_traori("AROT X90\nX1 Y2 Z3 C3=1"), "F w 1 -3 2 <0 -1 0>\n");
    EXPECT_EQ(moves_under_traori("MIRROR X0\nX1 A3=1 C3=1"), "F w -1 0 0 <-0.707107 0 0.707107>\n");
    EXPECT_EQ(moves_under_traori("AROT X90\nX1 Y2 Z3 B5"), "F w 1 -3 2 B5 C0\n") << "rotary words do not";
}

TEST(SinumerikVectors, Angles) {
    EXPECT_EQ(moves_under_traori("ORIEULER\nX1 A2=90 B2=30"), "F w 1 0 0 <0.5 0 0.866025>\n");
    EXPECT_EQ(moves_under_traori("ORIRPY\nX1 A2=0 B2=30 C2=90"), "F w 1 0 0 <0 0.5 0.866025>\n");
    EXPECT_EQ(moves_under_traori("ORIRPY\nX1 A2=30 B2=0 C2=0"), "F w 1 0 0 <0 -0.5 0.866025>\n");
}

TEST(SinumerikVectors, Refused) {
    const std::pair<const char*, const char*> cases[] = {
        {"TRAFOOF\nX1 A3=1", "NC0617"},
        {"X1 A3=1 B5", "NC0617"},
        {"ORIAXES\nX1 A3=1", "NC0617"},
        {"ORIMKS\nX1 A3=1", "NC0617"},
        {"X1 A2=1 B2=1", "NC0617"},
        {"ORIRPY\nX1 A2=1 B2=1", "NC0617"},
        {"ORIEULER\nX1 A3=1 B2=1", "NC0617"},
        {"X1 A3=0 B3=0 C3=0", "NC0618"},
        {"SCALE X2\nX1 A3=1 C3=1", "NC0620"},
        {"X1 LEAD=5 TILT=3", "NC0638"},
        {"X1 A4=1 B4=0 C4=0", "NC0638"},
        {"TRAORI(1,0,1,0)\nX1", "NC0617"},
        {"ORIRESET(0)", "NC0601"},
    };
    for (const auto& [blocks, code] : cases)
        EXPECT_TRUE(moves_under_traori(blocks).contains(code)) << blocks << moves_under_traori(blocks);
    EXPECT_EQ(moves_under_traori("ORIVECT ORIWKS\nX1 A3=1\nORIAXES\nX2 A3=1\nB7"),
              "F w 1 0 0 <1 0 0>\nF w 2 0 0 <1 0 0>\nF w 2 0 0 B7 C-\n")
        << "a vector that turns nothing is the same under ORIAXES";
}

// ----------------------------------------------------------------------------------------------------------- frames

TEST(SinumerikFrames, Translations) {
    EXPECT_EQ(moves_after_start("TRANS X10 Y=5\nX1\nATRANS X1 Z2\nZ0\nTRANS\nX1 Y1 Z1"),
              "F u 11 0 0\nF u 11 0 2\nF u 1 1 1\n")
        << "what is not said stays where it stands";
    EXPECT_EQ(moves_after_start("TRANS X10\nG91 X1\nG90 X=IC(1)"), "F u 1 0 0\nF u 2 0 0\n");
}

TEST(SinumerikFrames, RotationsAreZThenTheNewYThenTheNewX) {
    EXPECT_EQ(moves_after_start("ROT Z90\nX10"), "F u 0 10 0\n");
    EXPECT_EQ(moves_after_start("ROT Z90 Y90\nX10"), "F u 0 0 -10\n");
    EXPECT_EQ(moves_after_start("ROT Z90 X90\nZ10"), "F u 10 0 0\n");
    EXPECT_EQ(moves_after_start("ROT X90\nAROT Z90\nX10"), "F u 0 0 10\n");
    EXPECT_EQ(moves_after_start("TRANS X5\nAROT RPL=90\nX10 Y0 Z0"), "F u 5 10 0\n");
    EXPECT_EQ(moves_after_start("G18\nROT RPL=90\nZ10"), "F u 10 0 0\n");
    EXPECT_EQ(moves_after_start("ROT X90\nROT\nZ10"), "F u 0 0 10\n");
}

TEST(SinumerikFrames, KnownPositionsAreKnownInANewFrame) {
    EXPECT_EQ(moves_after_start("X10 Y20 Z30\nAROT X30\nX11\nZ=IC(10)"),
              "F u 10 20 30\nF u 11 20 30\nF u 11 15 38.6603\n");
}

TEST(SinumerikFrames, ScalesAndMirrors) {
    EXPECT_EQ(moves_after_start("SCALE X2\nX10 Y10\nASCALE X2 Y3\nX10 Y10"), "F u 20 10 0\nF u 40 30 0\n");
    EXPECT_EQ(moves_after_start("TRANS X5\nAMIRROR X0\nX10 Y10\nMIRROR\nX1"), "F u -5 10 0\nF u 1 10 0\n");
}

TEST(SinumerikFrames, RapidsWaitForAWholePoseInATurnedFrame) {
    const auto p = read_bc("G71 G64 G0 X0 Y0 Z9\nTRAORI\nAROT X30\nX1 Y2\nZ3\nG1 X4 F60\nTRANS\n");
    EXPECT_EQ(moves_of(p), "R w 1 0.232051 3.59808\nF w 4 0.232051 3.59808\n");
    EXPECT_EQ(told(*p, "NC0652")->count, 1);
    EXPECT_EQ(read_bc("G0 X0 Y0 Z9\nTRAORI\nAROT X30\nG1 X1 Y2 F60\n").error().code, "NC0612");
    EXPECT_EQ(read_bc("G0 X0 Y0 Z9\nTRAORI\nAROT X30\nX1 Y2\nG1 Z2 F60\n").error().code, "NC0612");
    EXPECT_EQ(moves_of(read_bc("G0 X0 Y0 Z9\nTRAORI\nAROT Z30\nZ5\nAROT X90\nX1 Y1 Z2\n")),
              "R w - - 5\nR w 1.86603 -1.23205 1\n")
        << "a turn about Z leaves Z alone";
}

TEST(SinumerikFrames, StillInForceAtTheEndIsTold) {
    EXPECT_TRUE(told(*read_bc("G0 X0 Y0 Z0\nTRANS X1\nX5\nM30\n"), "NC0654"));
    EXPECT_FALSE(told(*read_bc("G0 X0 Y0 Z0\nTRANS X1\nX5\nTRANS\nM30\n"), "NC0654"));
}

TEST(SinumerikFrames, Refused) {
    const std::pair<const char*, const char*> cases[] = {
        {"TRANS C30", "NC0619"},
        {"ROT B30", "NC0619"},
        {"SCALE X0", "NC0619"},
        {"SCALE X-1", "NC0619"},
        {"ROT X30 RPL=20", "NC0619"},
        {"TRANS X=AC(5)", "NC0619"},
        {"ROTS X10 Y20", "NC0601"},
        {"TOFRAME", "NC0601"},
        {"G58 X5", "NC0601"},
        {"TRANS F5 I3", "NC0613"},
        {"SCALE X2\nG2 X5 CR=9", "NC0620"},
        {"TRANS X1 CYCLE800()", "NC0606"},
        {"X5 RPL=20", "NC0613"},
    };
    for (const auto& [blocks, code] : cases)
        EXPECT_TRUE(moves_after_start(blocks).contains(code)) << blocks << moves_after_start(blocks);
}

// --------------------------------------------------------------------------------------------------------- CYCLE800

TEST(SinumerikSwivel, TurnsTheToolAcrossThePlane) {
    const auto p = read_bc(
        "G71 G64 G0 X0 Y0 Z100\n"
        "CYCLE800(0,\"TC1\",0,57,10,20,30,0,90,0,0,0,5,-1)\n"
        "G0 X1 Y2\nZ3\nG1 Z2 F60\n"
        "G3 X1 Y4 J1\n"
        "CYCLE800()\n"
        "SUPA G0 Z500 D0\nB0 C0\nM30\n");
    EXPECT_EQ(moves_of(p),
              "R w 18 22 29 <1 0 0>\n"
              "F w 17 22 29 <1 0 0>\n"
              "F w 17 24 29 <1 0 0> arc 180 (17 23 29) (1 0 0)\n"
              "R m - - 500 B- C-\n"
              "R u - - - B0 C0\n");
    EXPECT_EQ(told(*p, "NC0652")->count, 1);
    EXPECT_TRUE(told(*p, "NC0658"));
    EXPECT_FALSE(told(*p, "NC0654"));
    EXPECT_FALSE(told(*p, "NC0653"));
}

/// The tool's axis after CYCLE800 with a mode, three angles and a state.
std::string axis_after(int state, int mode, std::string_view angles, std::string_view before = "") {
    const auto p = read_bc(fmt::format("G0 X0 Y0 Z0\n{}CYCLE800(1,\"T\",{},{},0,0,0,{},0,0,0,-1,100)\nX1 Y1 Z1\n",
                                       before, state, mode, angles));
    return p ? triple(p->moves.back().axis) : said(p);
}

TEST(SinumerikSwivel, ModesAndStates) {
    EXPECT_EQ(axis_after(0, 57, "30,0,0"), "0 -0.5 0.866025");
    EXPECT_EQ(axis_after(0, 57, "0,30,0"), "0.5 0 0.866025");
    EXPECT_EQ(axis_after(0, 57, "90,90,0"), "1 0 0") << "X, then the new Y, then the new Z";
    EXPECT_EQ(axis_after(0, 27, "90,30,0"), "0 0.5 0.866025") << "Z, then the new Y, then the new X";
    EXPECT_EQ(axis_after(0, 39, "90,30,0"), "0.5 0 0.866025") << "Z, then the new X";
    EXPECT_EQ(axis_after(0, 64, "90,30,0"), "0 0.5 0.866025");
    EXPECT_EQ(axis_after(1, 57, "0,30,0", "CYCLE800(0,\"T\",0,57,0,0,0,0,30,0,0,0,0,-1)\n"), "0.866025 0 0.5");
    EXPECT_EQ(axis_after(0, 57, "0,30,0", "CYCLE800(0,\"T\",0,57,0,0,0,0,30,0,0,0,0,-1)\n"), "0.5 0 0.866025");
    EXPECT_EQ(axis_after(100010, 57, "0,30,0"), "0.5 0 0.866025");
    EXPECT_TRUE(told(*read_bc("G0 X0 Y0 Z0\nCYCLE800(1,\"T\",0,57,0,0,0,0,30,0,0,0,0,1)\nX1 Y1 Z1"), "NC0653"));
}

TEST(SinumerikSwivel, FramesOnTopAndTheWayBack) {
    EXPECT_EQ(moves_after_start(
                  "CYCLE800(0,\"T\",0,57,0,0,0,0,90,0,0,0,0,-1)\nG0 X0 Y0 Z10\nTRANS X5\nX1\nSUPA X0\nX2 Y0 Z10\n"
                  "CYCLE800(0,\"0\")\nX1 Y1 Z1"),
              "R w 10 0 0 <1 0 0>\n"
              "R w 10 0 -6 <1 0 0>\n"
              "R m 0 - -\n"
              "R w 10 0 -7 <1 0 0>\n"
              "R u 1 1 1\n");
}

TEST(SinumerikSwivel, AShiftAloneTurnsNothing) {
    EXPECT_EQ(moves_after_start("CYCLE800(0,\"\",0,57,0,0,5,0,0,0,0,0,0,0)\nG0 X1 Z1\nCYCLE800()\nX2 Z1"),
              "R u 1 0 6\nR u 2 0 1\n");
}

TEST(SinumerikSwivel, Refused) {
    const std::pair<const char*, const char*> cases[] = {
        {"CYCLE800(0,\"T\",0,192,0,0,0,0,30,0,0,0,0,-1)", "NC0623"},
        {"CYCLE800(0,\"T\",0,128,0,0,0,0,30,0,0,0,0,-1)", "NC0623"},
        {"CYCLE800(0,\"T\",0,57,0,0,0,0,30,0,0,0,0,0)", "NC0623"},
        {"CYCLE800(0,\"T\",2,57,0,0,0,0,30,0,0,0,0,-1)", "NC0623"},
        {"CYCLE800(0,\"T\",100,57,0,0,0,0,30,0,0,0,0,-1)", "NC0623"},
        {"CYCLE800(0,\"T\",0,64,0,0,0,0,30,5,0,0,0,-1)", "NC0623"},
        {"G18\nCYCLE800(0,\"T\",0,57,0,0,0,0,30,0,0,0,0,-1)", "NC0623"},
        {"TRANS X1\nCYCLE800(0,\"T\",1,57,0,0,0,0,30,0,0,0,0,-1)", "NC0623"},
        {"CYCLE800(0,\"T\",0,57,0,0,0,0,30,0,0,0,0,-1)\nG0 X1 Y1 Z1 B5", "NC0624"},
        {"CYCLE800(0,\"T\",0,57,0,0,0,0,30,0,0,0,0,-1)\nTRAORI\nX1 Y1 Z1 B5\nTRAFOOF\nX2", "NC0624"},
        {"CYCLE800(0,\"T\",0,57,0,0,0,0,30,0,0,0,0,-1)\nG1 Z5", "NC0612"},
    };
    for (const auto& [blocks, code] : cases)
        EXPECT_TRUE(moves_after_start(blocks).contains(code)) << blocks << moves_after_start(blocks);
}

}  // namespace
}  // namespace trunnion::nc
