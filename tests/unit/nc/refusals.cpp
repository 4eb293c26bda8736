#include <filesystem>

#include <gtest/gtest.h>

#include "reading.hpp"

namespace trunnion::nc {
namespace {

struct Refusal {
    std::string_view text, code;
    int line, column;
};

void expect_refused(const Refusal& r, const Result<program::Program>& result) {
    ASSERT_FALSE(result) << r.code << " wanted of:\n" << r.text;
    EXPECT_EQ(result.error().code, r.code) << r.text << "\n" << said(result);
    EXPECT_EQ(result.error().place.line, r.line) << r.text;
    EXPECT_EQ(result.error().place.column, r.column) << r.text;
    EXPECT_EQ(result.error().place.file, "test");
    EXPECT_FALSE(result.error().text.empty());
}

TEST(Refusals, Texts) {
    const Refusal refusals[] = {
        {"", "NC0002", 0, 0},
        {"\n \t\n", "NC0002", 0, 0},
        {std::string_view("G0 X0\n\0\x7f", 8), "NC0003", 2, 0},
        {"\x89PNG\r\n\x1a\n", "NC0004", 1, 1},
        {"<html>", "NC0004", 1, 1},
    };
    for (const Refusal& r : refusals) expect_refused(r, read_ac(r.text));
}

TEST(Refusals, Rs274) {
    const Refusal refusals[] = {
        {"(nothing)\nM30\n", "NC0005", 0, 0},
        {"G21 G0 X0 Y0 Z0\n", "NC0005", 0, 0},
        {"G21 G0 X0 Z0\nX1\n", "NC0006", 0, 0},
        // numbers and characters
        {"G0 X", "NC0201", 1, 4},
        {"G0 X0 Y0 Z0\nG1 X1 Y-", "NC0201", 2, 7},
        {"G0 XNAN", "NC0201", 1, 4},
        {"G0 Xinf", "NC0201", 1, 4},
        {"G0 X--1", "NC0201", 1, 4},
        {"G0 X1 . 2 . 3", "NC0201", 1, 4},
        {"G0 X1.2.3", "NC0202", 1, 8},
        {"G0 X1 $", "NC0202", 1, 7},
        {"G0 X1 \xff", "NC0202", 1, 7},
        {"G0 X=5", "NC0201", 1, 4},
        {"G0 X0 (open\nY0\n", "NC0203", 1, 7},
        {"G0 X0 (a (b) c)\n", "NC0203", 1, 7},
        // words
        {"G0 X0\nG12 X1\n", "NC0204", 2, 1},
        {"G0.5\n", "NC0204", 1, 1},
        {"G1.55\n", "NC0204", 1, 1},
        {"G43.4 H1\n", "NC0204", 1, 1},
        {"G-1\n", "NC0204", 1, 1},
        {"M1000000\n", "NC0204", 1, 1},
        {"G0 X0 Y0 Z0 M77\n", "NC0204", 1, 13},
        {"G41 D1\n", "NC0302", 1, 1},
        {"G43.1 Z1\n", "NC0302", 1, 1},
        {"G43.2 H1\n", "NC0302", 1, 1},
        {"G33 K1\n", "NC0302", 1, 1},
        {"G38.2 Z1\n", "NC0302", 1, 1},
        {"G68\n", "NC0302", 1, 1},
        {"G87 Z1 R1\n", "NC0302", 1, 1},
        {"G96 S1\n", "NC0302", 1, 1},
        {"G0 X[1+2\n", "NC0320", 1, 9},
        {"G0 X#[1\n", "NC0320", 1, 8},
        {"G0 Y1 XFOO[1]\n", "NC0321", 1, 8},
        {"G0 X#6000\n", "NC0322", 1, 5},
        {"G0 X#<a>\n", "NC0323", 1, 5},
        {"G0\nX[1/0]\n", "NC0325", 2, 4},
        {"G0\no100 sob\n", "NC0331", 2, 6},
        {"G0\no100 sub\n", "NC0332", 2, 1},
        {"G0\no100 call\n", "NC0333", 2, 1},
        {"G0 X0 Y0 Z0\nM98 P1\n", "NC0333", 2, 1},
        {"G0 X1 Y1 Z1\nG10 L2 P1 X1\n", "NC0341", 2, 1},
        {"G92 X1\n", "NC0342", 1, 5},
        {"G0 G1 X1\n", "NC0304", 1, 4},
        {"G90 X0 G91\n", "NC0304", 1, 8},
        {"G20 G21\n", "NC0304", 1, 5},
        {"M3 M4\n", "NC0304", 1, 4},
        {"G4 G53 P1\n", "NC0304", 1, 4},
        {"G0G0G0G0\n", "NC0304", 1, 3},
        {"G0 X1 X2\n", "NC0305", 1, 7},
        {"F1 F2\n", "NC0305", 1, 4},
        {"G0 X1 B2\n", "NC0306", 1, 7},
        {"G0 X1 U2\n", "NC0306", 1, 7},
        {"X1 Y1 Z1\n", "NC0308", 1, 1},
        {"G0 X1 Y1 Z1\nG80 X2\n", "NC0308", 2, 5},
        {"G91 G0 X1\n", "NC0309", 1, 8},
        {"G0 X1 Y1 Z1\nG91 A5\n", "NC0309", 2, 5},
        // feeds
        {"G0 X0 Y0 Z0\nG1 X1\n", "NC0205", 2, 4},
        {"G0 X0 Y0 Z0\nG93 G1 X1 F1\nG94 X2\n", "NC0205", 3, 5},
        {"F0\n", "NC0206", 1, 1},
        {"G1 F-5\n", "NC0206", 1, 4},
        {"G0 X0 Y0 Z0\nG93 G1 X1 F1\nX2\n", "NC0310", 3, 1},
        // frames
        {"G0 X0 Y0 Z0\nG53 G0 Z5\nG91 X1\n", "NC0309", 3, 5},
        {"G0 X0 Y0 Z0\nG91 G53 X0\n", "NC0315", 2, 5},
        // parameters
        {"G4\n", "NC0312", 1, 1},
        {"G0 G4 P-1\n", "NC0312", 1, 4},
        {"G0 X1 P1\n", "NC0313", 1, 7},
        {"G0 X1 N5\n", "NC0313", 1, 7},
        {"T-1\n", "NC0314", 1, 1},
        {"T1.5\n", "NC0314", 1, 1},
        {"S-5\n", "NC0314", 1, 1},
        {"G43 H-1\n", "NC0314", 1, 5},
        {"G43 H1.5\n", "NC0314", 1, 5},
        {"G49 H1\n", "NC0313", 1, 5},
        {"G0 X0 H1\n", "NC0313", 1, 7},
        {"G1 X0 I1\n", "NC0313", 1, 7},
        // arcs
        {"G0 X0 Y0 Z0\nG2 X1 F1\n", "NC0316", 2, 4},
        {"G0 X0 Y0 Z0\nG2 F1\n", "NC0316", 2, 1},
        {"G0 X0 Y0 Z0\nG2 X1 I.5 R.5 F1\n", "NC0316", 2, 11},
        {"G0 X0 Y0 Z0\nG2 X1 I.5 K1 F1\n", "NC0316", 2, 11},
        {"G0 X0 Y0 Z0\nG18 G3 X1 J.5 F1\n", "NC0316", 2, 11},
        {"G0 X0 Y0 Z0\nG19 G3 Y1 I.5 F1\n", "NC0316", 2, 11},
        {"G0 X0 Y0 Z0\nG90.1 G2 X1 I.5 F1\n", "NC0316", 2, 10},
        {"G0 X0 Z0\nG2 X1 I.5 F1\n", "NC0317", 2, 4},
        {"G0 X0 Y0 Z0\nM429\nG2 X1 I.5 F1\n", "NC0317", 3, 4},
        {"G0 X0 Y0 Z0\nG53 G2 X1 I.5 F1\n", "NC0317", 2, 8},
        {"G0 X0 Y0 Z0\nG55\nG2 X1 I.5 F1\n", "NC0317", 3, 4},
        {"G0 X0 Y0 Z0\nG43 H3\nG2 X1 I.5 F1\n", "NC0317", 3, 4},
        {"G0 X0 Y0 Z0\nG2 X1 I.5 P0 F1\n", "NC0318", 2, 11},
        {"G0 X0 Y0 Z0\nG2 X1 I.5 P1.5 F1\n", "NC0318", 2, 11},
        {"G0 X0 Y0 Z0\nG2 X1 I.5 P5000 F1\n", "NC0212", 2, 4},
        {"G0 X0 Y0 Z0\nG2 X1 I.51 F1\n", "NC0207", 2, 4},
        {"G0 X0 Y0 Z0\nG2 X1 R.4 F1\n", "NC0208", 2, 4},
        {"G0 X0 Y0 Z0\nG2 X1 R-.4 F1\n", "NC0208", 2, 4},
        {"G0 X0 Y0 Z0\nG2 X1 R0 F1\n", "NC0209", 2, 4},
        {"G0 X0 Y0 Z0\nG2 X1 I0 F1\n", "NC0209", 2, 4},
        {"G0 X0 Y0 Z0\nG2 X1 I1 F1\n", "NC0209", 2, 4},
        {"G0 X0 Y0 Z0\nG2 X0 R1 F1\n", "NC0210", 2, 4},
        {"G0 X0 Y0 Z0\nG2 X1 I.5\n", "NC0205", 2, 4},
        {"G0 X0 Y0 Z0\nG2 X1 I.5 F1\nG1 X2 I.5\n", "NC0313", 3, 7},
        {"G0 X0 Y0 Z0\nG2 X1 L.5 F1\n", "NC0313", 2, 7},
        {"G0 X0 Y0 Z0\nG2 G4 P2 X1 I.5 F1\n", "NC0313", 2, 7},
    };
    ReadOptions options;
    options.dialect = Dialect::rs274;
    for (const Refusal& r : refusals) expect_refused(r, read_ac(r.text, options));
}

TEST(Refusals, Rs274NumbersTooLarge) {
    const std::string digits(400, '9');
    expect_refused({"a number of 400 digits", "NC0201", 1, 4}, read_ac("G0 X" + digits));
    expect_refused({"a number of 400 digits and a blank", "NC0201", 1, 4}, read_ac("G0 X" + digits + " 1"));
    expect_refused({"inches that overflow", "NC0201", 1, 8}, read_ac("G20 G0 X1" + std::string(308, '0')));
}

TEST(Refusals, AxesOfTheMachine) {
    expect_refused({"no machine", "NC0307", 1, 7}, read_program("G0 X0 A5", "test", {}));
    expect_refused({"three axes", "NC0306", 1, 7}, read_with(machine_with(""), "G0 X0 A5"));
    EXPECT_TRUE(read_with(machine_with("BV"), "G21 G0 X0 Y0 Z0 B0 V0\nV5"));
    machine::Machine bad = machine_with("AC");
    bad.words.tcp_on = {"TRAORI"};
    const auto result = read_with(bad, "G0 X0");
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, "NC0007");
}

TEST(Refusals, ExponentIsNoNumberInGCode) {
    expect_refused({"E without a machine that has it", "NC0313", 1, 6}, read_program("G0 X1e999", "test", {}));
}

TEST(Refusals, Apt) {
    const Refusal refusals[] = {
        {"PARTNO x\nFINI\n", "NC0005", 0, 0},
        {"GOTO/1,2,3\n", "NC0005", 0, 0},
        {"GOTO/1,2\n", "NC0401", 1, 1},
        {"GOTO/1,2,3,4\n", "NC0401", 1, 1},
        {"GOTO/1,2,3,0,0,1,0\n", "NC0401", 1, 1},
        {"FROM/1,2,3,4\n", "NC0401", 1, 1},
        {"GOTO/1,2,3,\n0,0,1\n", "NC0201", 1, 12},
        {"GOTO/1,2,3\n0,0,1\n", "NC0413", 2, 1},
        {"GOTO/1,2,3,$\n", "NC0411", 1, 1},
        {"GOTO/1,2,3,$\n 0,0", "NC0401", 1, 1},
        {"GOTO/1,2,3,$\n 0,x,1\n", "NC0201", 2, 4},
        {"GOTO/\n", "NC0201", 1, 6},
        {"GOTO\n", "NC0201", 1, 5},
        {"GOTO/1,nan,3\n", "NC0201", 1, 8},
        {"GOTO/1,inf,3\n", "NC0201", 1, 8},
        {"GOTO/1,1e999,3\n", "NC0201", 1, 8},
        {"UNITS/INCHES\nGOTO/1e308,0,0\n", "NC0201", 2, 1},
        {"GOTO/1 2,3\n", "NC0202", 1, 8},
        {"GOTO/1,2,3;\n", "NC0202", 1, 11},
        {"GOTO/1,2,3,0,0,0\n", "NC0402", 1, 1},
        {"GOTO/1,2,3,1e200,1e200,0\n", "NC0402", 1, 1},
        {"FEDRAT/1\nGOTO/0,0,0,0,0,1\nGOTO/1,0,0,0,0,-1\n", "NC0403", 3, 1},
        {"FEDRAT/1\nGOTO/0,0,0,0,.6,.8\nGOTO/0,0,0,0,-.6,-.8\n", "NC0403", 3, 1},
        {"GOTO/0,0,0\nGOTO/1,0,0\n", "NC0205", 2, 1},
        {"GOTO/0,0,0\nRAPID\nGOTO/1,0,0\nGOTO/2,0,0\n", "NC0205", 4, 1},
        {"FEDRAT/0\n", "NC0206", 1, 1},
        {"FEDRAT/-5,IPM\n", "NC0206", 1, 1},
        {"FEDRAT/\n", "NC0201", 1, 1},
        {"FEDRAT/MMPM\n", "NC0201", 1, 1},
        {"FEDRAT/1,2\n", "NC0201", 1, 1},
        {"FEDRAT/0.1,MMPR\nGOTO/0,0,0\nGOTO/1,0,0\n", "NC0406", 3, 1},
        {"SPINDL/500,SFM\nFEDRAT/IPR,0.1\nGOTO/0,0,0\nGOTO/1,0,0\n", "NC0406", 4, 1},
        {"SPINDL/500\nSPINDL/OFF\nFEDRAT/IPR,0.1\nGOTO/0,0,0\nGOTO/1,0,0\n", "NC0406", 5, 1},
        {"FEDRAT/1,FURLONG\n", "NC0407", 1, 1},
        {"FEDRAT/1,IPM,IPM\n", "NC0412", 1, 1},
        {"UNITS/CUBITS\n", "NC0407", 1, 1},
        {"UNITS\n", "NC0407", 1, 1},
        {"GOTO/0,0,0\nFROM/1,0,0\n", "NC0408", 2, 1},
        {"FEDRAT/1\nMULTAX/OFF\nGOTO/0,0,0\nGOTO/1,0,0,1,0,0\n", "NC0409", 4, 1},
        {"MULTAX/MAYBE\n", "NC0412", 1, 1},
        {"MSYS/0,0,0,1,0,0,1,0,0\n", "NC0410", 1, 1},
        {"MSYS/0,0,0,2,0,0,0,1,0\n", "NC0410", 1, 1},
        {"MSYS/0,0,0,1,0,0,0,1,0,0,0,-1\n", "NC0410", 1, 1},
        {"MSYS/0,0,0,1,0,0\n", "NC0401", 1, 1},
        {"GOTO/1,2,3\nMSYS/0,0,0,1,0,0,0,1,0\n", "NC0410", 2, 1},
        {"DELAY/5,REV\n", "NC0412", 1, 1},
        {"DELAY/-5\n", "NC0412", 1, 1},
        {"LOADTL\n", "NC0412", 1, 1},
        {"GODLTA/1,0,0\n", "NC0423", 1, 1},
        {"GOTO/0,0,0\nFEDRAT/1\nGODLTA/1,0\n", "NC0401", 3, 1},
        {"TRANS/1,0,0\n", "NC0404", 1, 1},
        {"ROTABL/90\n", "NC0404", 1, 1},
        {"ROTABL/\n", "NC0404", 1, 1},
        {"ROTABL/0,WORLD\n", "NC0404", 1, 1},
        {"CYCLE/DRILL,1\n", "NC0404", 1, 1},
        {"CUTCOM/ON\n", "NC0404", 1, 1},
        {"INSERT G0 X5\n", "NC0204", 1, 1},
        {"CIRCLE/0,0,0,0,0,1,5\n", "NC0415", 1, 1},
        {"MOVARC/0,0,0,0,0,1,5\n", "NC0415", 1, 1},
        {"FEDRAT/1\nGOTO/5,0,0\nCIRCLE/0,0,0,0,0,1\n", "NC0401", 3, 1},
        {"FEDRAT/1\nGOTO/5,0,0\nCIRCLE/0,0,0,0,0,1,5,1,2,3,4,5\n", "NC0401", 3, 1},
        {"FEDRAT/1\nGOTO/5,0,0\nMOVARC/0,0,0,0,0,1,5,1\n", "NC0401", 3, 1},
        {"FEDRAT/1\nGOTO/5,0,0\nCIRCLE/0,0,0,0,0,0,5\n", "NC0402", 3, 1},
        {"FEDRAT/1\nGOTO/5,0,0\nCIRCLE/0,0,x,0,0,1,5\n", "NC0412", 3, 12},
        {"FEDRAT/1\nGOTO/5,0,0\nCIRCLE/0,0,,0,0,1,5\n", "NC0201", 3, 12},
        {"FEDRAT/1\nGOTO/5,0,0\nCIRCLE/0,0,nan,0,0,1,5\n", "NC0412", 3, 12},
        {"FEDRAT/1\nGOTO/5,0,0\nCIRCLE/0,0,1e999,0,0,1,5\n", "NC0201", 3, 12},
        {"FEDRAT/1\nGOTO/5,0,0\nCIRCLE/0,0,0,0,0,1,5,.1,.5,1,0,TWICE,2\n", "NC0412", 3, 32},
        {"FEDRAT/1\nGOTO/5,0,0\nCIRCLE/0,0,0,0,0,1,5,.1,.5,1,0,TIMES,2\nGOTO/0,5,9\n", "NC0414", 4, 1},
        {"FEDRAT/1\nGOTO/5,0,0\nCIRCLE/0,0,0,0,0,1,5\n", "NC0415", 3, 1},
        {"FEDRAT/1\nGOTO/5,0,0\nCIRCLE/0,0,0,0,0,1,5\nCIRCLE/0,0,0,0,0,1,5\n", "NC0415", 4, 1},
        {"FEDRAT/1\nGOTO/5,0,0\nCIRCLE/0,0,0,0,0,1,6\nGOTO/0,5,0\n", "NC0207", 4, 1},
        {"FEDRAT/1\nGOTO/5,0,0\nCIRCLE/0,0,0,0,0,1,5\nGOTO/0,5.02,0\n", "NC0207", 4, 1},
        {"FEDRAT/1\nGOTO/5,0,0\nCIRCLE/5,0,0,0,0,1,5\nGOTO/0,5,0\n", "NC0207", 4, 1},
        {"FEDRAT/1\nGOTO/5,0,0\nCIRCLE/0,0,0,0,0,1,5\nRAPID\nGOTO/0,5,0\n", "NC0416", 5, 1},
        {"FEDRAT/1\nGOTO/5,0,0\nMOVARC/0,0,0,0,0,1,5,ANGLE,80\nGOTO/0,5,0\n", "NC0414", 4, 1},
        {"FEDRAT/1\nGOTO/5,0,0\nMOVARC/0,0,0,0,0,1,5,ANGLE,0\nGOTO/0,5,0\n", "NC0414", 4, 1},
        {"FEDRAT/1\nGOTO/5,0,0\nMOVARC/0,0,0,0,0,1,5,ANGLE\n", "NC0201", 3, 22},
        {"FEDRAT/1\nGOTO/5,0,0\nCIRCLE/0,0,0,0,0,1,5\nGOTO/0,5,0\nGOTO/3,4,0\n", "NC0414", 5, 1},
        {"FEDRAT/1\nGOTO/5,0,0\nCIRCLE/0,0,0,0,0,1,5\nGOTO/-3,4,0\nGOTO/-3,-4,0\nGOTO/5,0,0\nGOTO/4,3,0\n", "NC0414", 7,
         1},
        {"FEDRAT/1\nGOTO/5,0,0\nTLON,GOFWD/(CIRCLE/0,0,0,5),ON,(LINE/0,0,0,0,5,0)\n", "NC0414", 3, 1},
        {"FEDRAT/1\nGOTO/5,0,0\nINDIRV/1,0,0\nTLON,GOFWD/(CIRCLE/0,0,0,5),ON,(LINE/0,0,0,0,5,0)\n", "NC0414", 4, 1},
        {"FEDRAT/1\nGOTO/5,0,0\nINDIRV/0,-1,0\nTLON,GOFWD/(CIRCLE/0,0,0,5),ON,(LINE/0,0,0,0,5,0)\n", "NC0414", 4, 1},
        {"FEDRAT/1\nGOTO/5,0,0\nINDIRV/0,1,0\nTLON,GOFWD/(CIRCLE/0,0,0,5),ON,2,INTOF,(LINE/0,0,0,0,5,0)\n", "NC0414", 4,
         1},
        {"FEDRAT/1\nGOTO/5,0,0\nINDIRV/0,1,0\nTLON,GOFWD/(CIRCLE/0,0,0,5),ON,(LINE/0,0,0,0,5,1)\n", "NC0414", 4, 1},
        {"FEDRAT/1\nGOTO/5,0,0\nINDIRV/0,1,0\nTLON,GOFWD/(CIRCLE/0,0,0,5),ON,(LINE/0,0,0,0,6,0)\n", "NC0207", 4, 1},
        {"FEDRAT/1\nGOTO/5,0,0\nINDIRV/0,1,0\nTLON,GOFWD/(CIRCLE/0,0,0,6),ON,(LINE/0,0,0,0,5,0)\n", "NC0207", 4, 1},
        {"FEDRAT/1\nGOTO/5,0,0\nINDIRV/0,1,0\nRAPID\nTLON,GOFWD/(CIRCLE/0,0,0,5),ON,(LINE/0,0,0,0,5,0)\n", "NC0416", 5,
         1},
        {"FEDRAT/1\nGOTO/5,0,0\nINDIRV/0,1,0\nTLON,GOFWD/(CIRCLE/0,0,0,5),ON,(LINE/1,0,0,0,5,0)\n", "NC0417", 4, 1},
        {"FEDRAT/1\nGOTO/5,0,0\nINDIRV/0,1,0\nTLON,GOFWD/(CIRCLE/0,0,0,5),TO,(LINE/0,0,0,0,5,0)\n", "NC0417", 4, 1},
        {"FEDRAT/1\nGOTO/5,0,0\nINDIRV/0,1,0\nTLON,GOFWD/(CIRCLE/0,0,0,5),ON,(PLANE/0,0,1,0)\n", "NC0417", 4, 1},
        {"INDIRV/0,1,0\nTLON,GOFWD/(CIRCLE/0,0,0,5),ON,(LINE/0,0,0,0,5,0)\n", "NC0415", 2, 1},
        {"FEDRAT/1\nGOTO/5,0,0\nINDIRV/0,0,0\n", "NC0402", 3, 1},
        {"FEDRAT/1\nGOTO/5,0,0\nINDIRV/0,0\n", "NC0401", 3, 1},
        {"GOFWD/L1\n", "NC0405", 1, 1},
        {"GOTO/0,0,0\nBEGIN NURBS_SIEMENS;\n", "NC0421", 2, 1},
        {"GOTO/0,0,0\nBEGIN NURBS_SIEMENS(D=4,F=1,AXIS=0,0,1);\n", "NC0421", 2, 1},
        {"GOTO/0,0,0\nBEGIN NURBS_SIEMENS(D=3,F=1,AXIS=0,0);\n", "NC0421", 2, 1},
        {"GOTO/0,0,0\nBEGIN NURBS_SIEMENS(D=3,F=0,AXIS=0,0,1);\n", "NC0206", 2, 1},
        {"GOTO/0,0,0\nRAPID\nBEGIN NURBS_SIEMENS(D=3,F=1,AXIS=0,0,1);\n", "NC0420", 3, 1},
        {"GOTO/0,0,0\nBEGIN NURBS_SIEMENS(D=3,F=1,AXIS=0,0,1);\nGOTO/1,0,0\n", "NC0421", 3, 1},
        {"GOTO/0,0,0\nBEGIN NURBS_SIEMENS(D=3,F=1,AXIS=0,0,1);\nN0,XT=1,YT=0,ZT=0,W=1;\n", "NC0421", 3, 1},
        {"GOTO/0,0,0\nBEGIN NURBS_SIEMENS(D=3,F=1,AXIS=0,0,1);\nN0,XT=1,YT=0,ZT=0,DK=0,W=0;\n", "NC0421", 3, 1},
        {"GOTO/0,0,0\nBEGIN NURBS_SIEMENS(D=3,F=1,AXIS=0,0,1);\nN0,XT=1,YT=0,ZT=0,DK=0,W=1;\nEND NURBS;\n", "NC0418", 2,
         1},
        {"NURBS/\n", "NC0420", 1, 1},
        {"GOTO/0,0,0\nRAPID\nNURBS/\n", "NC0420", 3, 1},
        {"FEDRAT/1\nGOTO/5,0,0\nCIRCLE/0,0,0,0,0,1,5\nNURBS/\n", "NC0420", 4, 1},
        {"GOTO/0,0,0\nNURBS/3\n", "NC0418", 2, 1},
        {"KNOT/1\n", "NC0422", 1, 1},
        {"CNTRL/1,2,3\n", "NC0422", 1, 1},
        {"GOTO/0,0,0\nNURBS/\nCNTRL/1,2,3\nKNOT/1\n", "NC0418", 4, 1},
        {"GOTO/0,0,0\nNURBS/\nKNOT/1\nCNTRL/1,2,3\nCNTRL/1,2,3\nFINI\n", "NC0418", 2, 1},
        {"GOTO/0,0,0\nNURBS/\nKNOT/1\nCNTRL/1,2,3,0,0,1\n", "NC0401", 4, 1},
        {"GOTO/0,0,0\nNURBS/\nKNOT/.5,.4\n", "NC0419", 3, 9},
        {"GOTO/0,0,0\nNURBS/\nKNOT/-.5\n", "NC0419", 3, 6},
        {"GOTO/0,0,0\nNURBS/\nKNOT/.5,A\n", "NC0201", 3, 9},
        {"FEDRAT/1\nGOTO/0,0,0\nNURBS/\nKNOT/0\nCNTRL/1,0,0\nCNTRL/2,0,0\nCNTRL/3,0,0\n", "NC0419", 3, 1},
        {"FEDRAT/1\nGOTO/0,0,0\nNURBS/\nKNOT/1,1\nCNTRL/1,0,0\nCNTRL/2,0,0\nCNTRL/3,0,0\nCNTRL/4,0,0\n", "NC0419", 3,
         1},
        {"GOTO/0,0,0\nNURBS/\nKNOT/1\nCNTRL/1,0,0\nCNTRL/2,0,0\nCNTRL/3,0,0\nGOTO/4,0,0\n", "NC0205", 7, 1},
        {"PARTNO a\nFOOBAR/1\n", "NC0204", 2, 1},
        {"PARTNO a\npl1=plane/1,0,0,0\n", "NC0204", 2, 1},
        {"$$ a\n  go/to,pl1\n", "NC0204", 2, 3},
        // bare poses
        {"0,0,0\n1,0,0\n", "NC0205", 2, 1},
        {"0,0,0\n1,0\n", "NC0401", 2, 1},
        {"0 0 0 0 0 1\n1 0 0 0 0 0\n", "NC0402", 2, 1},
        {"0 0 0\n1 0 x\n", "NC0201", 2, 5},
    };
    for (const Refusal& r : refusals) expect_refused(r, read_ac(r.text));
}

TEST(Refusals, Files) {
    const auto missing = read_program_file("/nowhere/at/all.ngc", {});
    ASSERT_FALSE(missing);
    EXPECT_EQ(missing.error().code, "NC0001");
    EXPECT_EQ(missing.error().place.file, "/nowhere/at/all.ngc");
    const auto folder = read_program_file(std::filesystem::temp_directory_path(), {});
    ASSERT_FALSE(folder);
    EXPECT_EQ(folder.error().code, "NC0001");
}

}  // namespace
}  // namespace trunnion::nc
