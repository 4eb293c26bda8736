#include "mutation.hpp"
#include "sinumerik_reading.hpp"

namespace trunnion::nc {
namespace {

constexpr std::string_view seeds[] = {
    "G71 G17 G90 G94 G64\nT=\"A\"\nM6\nTRAORI\nG54 D1\nG0 X0 Y0 Z9 B0 C0 S100 M3\nG1 X1 B30 F60\nG3 X3 Y2 I1 J1 "
    "TURN=1\n"
    "G1 A3=1 B3=0 C3=1 X5\nORIRPY\nA2=1 B2=2 C2=3\nTRAFOOF\nSUPA G0 Z5 D0\nB0 C0\nB=DC(10)\nG93 G1 X4 F3\nM30\n",
    "G0 X0 Y0 Z9\nTRANS X5 Y=2\nAROT X30 Z5\nX1 Y1 Z1\nSCALE X2 Y2 Z2\nG1 X2 F9\nMIRROR Y0\nG2 X5 Y5 CR=9\nROT RPL=20\n"
    "CIP X0 Y0 Z0 I1=3 J1=9 K1=1\nCT X3 Y9\nTRANS\nG18 G3 X1 Z1 AR=90\nG1 G91 X1 Z=AC(4)\nG4 F2\n",
    "G0 X0 Y0 Z50\nF120 S99\nMCALL "
    "CYCLE81(10,0,2,-20)\nX5\nHOLES2(0,0,5,0,90,4)\nMCALL\nCYCLE83(10,0,2,-20,,,8,1,,,1,1)\n"
    "CYCLE84(10,0,2,-20,,,3,,1.25,90,600)\nCYCLE86(10,0,2,-20,,0,3,-.2,.1,.3,45)\nCYCLE85(9,0,1,-5,,0,9,9)\n",
    "G0 X0 Y0 Z50\nCYCLE800(0,\"T\",0,57,1,2,3,30,20,10,4,5,6,-1)\nX1 Y2\nZ3\nG1 Z2 F60\nTRANS "
    "X3\nX1\nTRANS\nCYCLE800(1,\"T\",1,64,0,0,0,"
    "3,9,0,0,0,0,1)\nG0 X1 Y2 Z3\nCYCLE800()\nG53 X1 D0\nB5 C9\nX9 Y9 Z9\nFGROUP(X,Y,Z,B)\nG1 X9 B9\n",
    "G71 G64 G90 G0 X0 Y0 Z0 B0 C0\nG1 F600\nBSPLINE SD=3\nX10 PL=0\nX20 Y10 PL=2 PW=.5\nM8 X30 Z5 PL=4\nX40 B3 "
    "PL=1\nX50 "
    "PL=0\nM9\nSD=2 G1 X60\nPOLY PO[X]=(10,1,0.5) PO[Y]=(4) Z=PO(-2,0,0,0.25) PL=2\nPO[X]=(0,-10) PO[Y]=(10) "
    "PO[]=(2,1)\nPO[B]=(10,2) X5 PL=3\nG91 BSPLINE X1\nX2 Y1\nX1\n",
    "G71 TRAORI\nG0 X0 Y0 Z0 B0 C0\nG1 F600 A3=0 B3=0 C3=1\nBSPLINE SD=2 X10\nX20 A3=1 C3=1\nORICURVE\nG1 X1 Y0 XH=1 "
    "YH=0 "
    "ZH=50\nBSPLINE SD=3\nX10 XH=10 ZH=50 PL=0\nX20 XH=30 PL=10\nX30 XH=50 YH=5 PL=0\nG1 X35\nPOLY PO[X]=(41,2) "
    "PO[XH]=(51,4,1) YH=3 ZH=50\nORIVECT G1 A3=1 X3\n",
};
constexpr std::string_view pieces[] = {"(",      ")",        ",",      "\n",           "=",           "-",
                                       "X",      "G91",      "G53 ",   "TRAORI",       "B5",          "1e9",
                                       "99",     ".",        " ",      "G2 ",          "CT ",         "G18",
                                       "SUPA ",  "AROT Y45", "D0",     "T3 M6",        "A3=1",        "G55",
                                       "AC(1)",  "IC(1)",    "MCALL ", "G70",          "TRANS ",      "SCALE X1EX99",
                                       "F1",     "\xff",     "0",      "TRAFOOF\n",    "G500",        "G95",
                                       "1EX300", "TURN=3",   "M30",    "CYCLE800()\n", "BSPLINE ",    "PL=0 ",
                                       "PW=.2 ", "SD=1 ",    "POLY ",  "PO[X]=(1,2) ", "PO[]=(2,1) ", "ORICURVE ",
                                       "XH=1 "};

TEST(SinumerikMutations, ReadOrRefusedButSound) {
    expect_read_or_refused(
        {20261122, 8000, seeds, pieces, 400, 800},
        [](std::string_view text, const ReadOptions& options, Random&) { return read_bc(text, options); },
        expect_sound_with_feeds);
}

TEST(SinumerikMutations, TheSeedsAreGood) {
    for (const std::string_view seed : seeds) {
        const auto p = read_bc(seed);
        EXPECT_TRUE(p) << said(p);
    }
}

}  // namespace
}  // namespace trunnion::nc
