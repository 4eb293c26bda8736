#include "mutation.hpp"

#include <cmath>
#include <cstdint>
#include <string>

#include <gtest/gtest.h>

#include "reading.hpp"

namespace trunnion::nc {
namespace {

constexpr std::string_view seeds[] = {
    "%\nN1 (a) G21 G90 G94 G54\nT8 M6 S3500 M3\nG0 X0 Y0 Z10 A0 C0 ; b\ng1x  1.5y- 2z.5a+30.c11f600\nG91 X2\nG4 P2.5\n"
    "G93 G1 A45 F3\nM429\nG90 G0 X1 Y1 Z1\nM428 G53 X0 Y0\nG0 X0 Y5\nG3 X5 Y0 Z-2 J-5\nG18 G2 X0 R9 P2\nG43 H2\nG20 "
    "G61 G0 X1 Y1 Z1 E4\n/X4\nM30\n%\n",
    "G21 G0 X0 Y0 Z9 F9\n#1=2 #<a>=[#1+SIN[30]]\no1 sub\no2 if [#1 GT 1]\nX[#1]\no2 else\nY1\no2 endif\no1 endsub "
    "[3]\no1 call "
    "[4]\no3 while [#1 LT 5]\n#1=[#1+1]\no3 endwhile\no4 repeat [2]\nG91X1\no4 endrepeat\nM98 P7 L2\nM2\nO7\nG0 "
    "Z[#5422+1]\nM99\n",
    "G21 G0 X0 Y0 Z9 A0 F9 S9 M3\nG98 G83 X1 Z1 R5 Q2\nG84 Z1 R5\nG80 G92 X0 A0\nG92.1 G5 X5 Y5 I1 J1 P1 Q1\nG5.1 X6 "
    "Y6 "
    "I1 J0\nG5.2 X7 Y7 P2 L3\nX8 Y9\nG5.3\nM70 G95 G1 X1 F1\nM72 G10 L20 X0\n",
    "PARTNO a\nUNITS/MM\nPPWORD/A,1\nLOADTL/8\nMULTAX/ON\nFROM/0,0,9,0,0,1\nRAPID\nGOTO/0,0,1\nFEDRAT/6,MMPM\n"
    "GOTO / 1.5, -2.,.5, $ c\n 0.0, 0.6, $\n0.8 $$ "
    "d\nDELAY/2\nMSYS/0,0,0,1,0,0,0,1,0\nTLAXIS/0,0,1\ngoto/5,0,0\n"
    "CIRCLE/0,0,0,0,0,1,5\nGOTO/0,5,0\nGOTO/-5,0,0\nMOVARC/0,0,0,0,0,-1,5,ANGLE,90\nGOTO/0,5,0\nINDIRV/1,0,0\n"
    "TLON,GOFWD/(CIRCLE/0,0,0,5),ON,(LINE/0,0,0,5,0,0)\nFINI\n",
    "UNITS/MM\nFEDRAT/9\nSPINDL/600,RPM\nMSYS/0,0,1,1,0,0,0,1,0\nFROM/0,0,0\nNURBS/\nKNOT/.25,.5\nKNOT/.5, "
    "1.\nCNTRL/1,0,0\nCNTRL/2,1,0\nCNTRL/3,1,5\nCNTRL/4,1,6\nCNTRL/5,0,6\nCNTRL/6,0,6\nMSYS/1,0,0,0,1,0,-1,0,0\nGODLTA/"
    "1,2,3\nFEDRAT/.1,MMPR\nGOTO/5,0,0\nCIRCLE/0,0,0,0,0,1,5,1,1,1,1,TIMES,2\nGOTO/5,0,3\nROTABL/0,CLW\nGODLTA/5\n",
    "0 0 0 0 0 1\n1 2 3 0 0.6 0.8\n1,2,4,0.6,0,0.8\n-1e-5 2 .5 0 0 1\n",
};
constexpr std::string_view pieces[] = {"$",
                                       "$$",
                                       "/",
                                       "(",
                                       ")",
                                       "%",
                                       ";",
                                       "\n",
                                       "\r\n",
                                       ",",
                                       "-",
                                       "E",
                                       "G",
                                       "X",
                                       "1e999",
                                       "#",
                                       "[",
                                       "nan",
                                       "99",
                                       ".",
                                       " ",
                                       "F0",
                                       "G2",
                                       "M2",
                                       "\xff",
                                       "GOTO/",
                                       "=",
                                       "\t",
                                       "0",
                                       "UNITS/IN",
                                       "G91",
                                       "G54.1",
                                       "M6",
                                       "T99999999999999999999",
                                       std::string_view("\0", 1)};

/// Their rotary words are all known.
void expect_sound_and_whole(const program::Program& p) {
    expect_sound(p);
    for (const program::Move& move : p.moves)
        for (const double word : move.rotary_rad) ASSERT_TRUE(std::isfinite(word));
}

TEST(Mutations, ReadOrRefusedButSound) {
    const auto read = [](std::string_view text, ReadOptions options, Random& random) {
        if (random.below(4) == 0) options.dialect = random.below(2) == 0 ? Dialect::apt : Dialect::rs274;
        return read_ac(text, options);
    };
    expect_read_or_refused({20250714, 12000, seeds, pieces}, read, expect_sound_and_whole);
}

}  // namespace
}  // namespace trunnion::nc
