#include "heidenhain_reading.hpp"
#include "mutation.hpp"

namespace trunnion::nc {
namespace {

constexpr std::string_view seeds[] = {
    "0 BEGIN PGM A MM\n1 TOOL CALL \"A\" Z S100 F60\n2 L X+0 Y+0 Z+9 B+0 C+0 R0 FMAX M3\n3 L M128\n4 L X+1 B+30 F60\n"
    "5 LN X+2 Y+1 Z+1 TX+0 TY+0.6 TZ+0.8\n6 L X+3 M126\n7 CC X+5 Y+1\n8 C X+7 Y+1 DR+\n9 CR X+9 Y+3 R+2 DR-\n"
    "10 L M140 MB5\n11 L M129\n12 L X+1 C+350 FMAX\n13 L Z+5 M91 FMAX\n14 END PGM A MM\n",
    "BEGIN PGM A INCH\nL X+0 Y+0 Z+9 FMAX\nQ1=3\nLBL 1\nL IX+1 Y+Q1 F60\nCALL LBL 1 REP 2\nFN 0: Q2 = +5\n"
    "Q3 = SQRT (Q1^2 + Q2 * SIN 30)\nL X+Q3\nFN 9: IF +Q1 EQU +3 GOTO LBL \"B\"\nL X+9\nLBL \"B\"\nCALL LBL 5\nM30\n"
    "LBL 5\nCC X+1 Y+1\nLP PR+4 PA+30\nLBL 0\nEND PGM A INCH\n",
    "BEGIN PGM A MM\nL X+0 Y+0 Z+50 FMAX\nL X+9 F99\nRND R0.5\nL Y+5\nCYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+5\nCYCL "
    "DEF 8.1 Y\nCYCL DEF 10.1 "
    "ROT+30\n"
    "CYCL DEF 11.1 SCL 0.5\nL X+9 Y+1 F99\nCT X+3 Y+9\nCYCL DEF 9.1 DWELL 1\nCC X+1 Y+1\nCP IPA+400 "
    "IZ-1 DR+\n",
    "BEGIN PGM A MM\nL X+0 Y+0 Z+50 FMAX\nPLANE SPATIAL SPA+10 SPB+20 SPC+30 TURN FMAX SEQ+\nL X+1 Y+2 Z+20 FMAX\n"
    "CYCL DEF 200 DRILLING ~\n Q200=2 ;A ~\n Q201=-9 ~\n Q206=99 ~\n Q202=4 ~\n Q203=0 ~\n Q204=9\nL X+2 FMAX M99\n"
    "PLANE RESET STAY\nL B+5 C+9 FMAX\nPLANE VECTOR BX+1 BY+0 BZ+0 NX+0 NY-1 NZ+1 STAY\nL X+1 Y+1 Z+1 FMAX\n"
    "FUNCTION TCPM F TCP AXIS SPAT PATHCTRL VECTOR\nL A+5 X+2 F9\nFUNCTION RESET TCPM\nPLANE RESET TURN FMAX\n"
    "CYCL DEF 19.1 A+5 F99\nL X+1 Y+1 Z+9 FMAX\n",
};
constexpr std::string_view pieces[] = {"(",
                                       ")",
                                       ",",
                                       "\n",
                                       "~\n",
                                       "-",
                                       "X+",
                                       "IX+1 ",
                                       "M91 ",
                                       "M128\n",
                                       "B+5",
                                       "1e9",
                                       "99",
                                       ".",
                                       " ",
                                       "C DR+ ",
                                       "CT ",
                                       "CC\n",
                                       "M99 ",
                                       "Q1",
                                       "+Q120",
                                       "PLANE RESET TURN\n",
                                       "F1",
                                       "\xff",
                                       "0",
                                       "M129 ",
                                       "FMAX ",
                                       "M94\n",
                                       "M116 ",
                                       "RND R1\n",
                                       "LBL 0\n",
                                       "M30\n",
                                       "TOOL CALL 3 Z\n",
                                       "CALL LBL 1\n",
                                       "99999999",
                                       "\"",
                                       ";",
                                       "CYCL CALL\n",
                                       "LN ",
                                       "NZ+1 ",
                                       "F CONT",
                                       "M140 MB MAX "};

TEST(HeidenhainMutations, ReadOrRefusedButSound) {
    expect_read_or_refused(
        {20261123, 8000, seeds, pieces, 400, 800},
        [](std::string_view text, const ReadOptions& options, Random&) { return read_klartext(text, options); },
        expect_sound_with_feeds);
}

TEST(HeidenhainMutations, TheSeedsAreGood) {
    for (const std::string_view seed : seeds) {
        const auto p = read_klartext(seed);
        EXPECT_TRUE(p) << said(p);
    }
}

}  // namespace
}  // namespace trunnion::nc
