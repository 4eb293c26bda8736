#include <filesystem>

#include "heidenhain_reading.hpp"

namespace trunnion::nc {
namespace {

TEST(HeidenhainRefused, WithCodeAndPlace) {
    struct Case {
        const char *block, *code;
        int column;
    };
    for (const auto& [block, code, column] :
         std::initializer_list<Case>{{"L X+1 RL", "NC0702", 7},
                                     {"CR X+1 R+ F100", "NC0702", 8},
                                     {"L X+1 Q", "NC0204", 7},
                                     {"L X+1 X+2", "NC0706", 7},
                                     {"L X+1 A+2", "NC0708", 7},
                                     {"L X+1 U+2", "NC0708", 7},
                                     {"L X+1 K+2", "NC0204", 7},
                                     {"L X+1 !", "NC0202", 7},
                                     {"L X+1 FOO", "NC0204", 7},
                                     {"L X+1 F1 F2", "NC0706", 10},
                                     {"L X+1 M1.5", "NC0711", 7},
                                     {"L X+1 M-3", "NC0711", 7},
                                     {"L X+1 M92", "NC0701", 7},
                                     {"L X+1 M103 F50", "NC0701", 7},
                                     {"L X+1 PA+3", "NC0711", 7},
                                     {"APPR LT X+1 LEN5", "NC0703", 1},
                                     {"DEP LCT X+1 R5", "NC0703", 1},
                                     {"FL X+1", "NC0703", 1},
                                     {"SPL X+1", "NC0703", 1},
                                     {"PATTERN DEF POS1", "NC0701", 1},
                                     {"TCH PROBE 0.0", "NC0701", 1},
                                     {"FUNCTION TURNDATA", "NC0701", 10},
                                     {"G1 X5", "NC0204", 1},
                                     {"WHATEVER", "NC0204", 1},
                                     {"+5", "NC0204", 1},
                                     {"TOOL CHANGE", "NC0204", 1},
                                     {"CYCL", "NC0204", 5},
                                     {"L X+1 DR", "NC0717", 7},
                                     {"L X+99999999999999999999 IX+1", "NC0706", 26}}) {
        const auto p = after_start(block);
        EXPECT_EQ(code_of(p), code) << block;
        if (p || column == 0) continue;
        EXPECT_EQ(p.error().place.line, 4) << block;
        EXPECT_EQ(p.error().place.column, column) << block;
    }
}

TEST(HeidenhainRefused, WithoutAMachineOrAMove) {
    EXPECT_EQ(code_of(read_program("BEGIN PGM A MM\nL X+0 B+1\n", "test", {})), "NC0707");
    EXPECT_EQ(code_of(read_klartext("BEGIN PGM A MM\nM3\nEND PGM A MM\n")), "NC0005");
    EXPECT_EQ(code_of(read_klartext("BEGIN PGM A MM\nL X+1 FMAX\nL Y+1 FMAX\nEND PGM A MM\n")), "NC0006");
    EXPECT_TRUE(told(*read_klartext("L X+1 Y+1 Z+1 FMAX\nL X+2 FMAX\n"), "NC0011")) << "no BEGIN PGM: no unit";
}

TEST(HeidenhainRecognised, ByItsBlocks) {
    for (const char* text : {"0 BEGIN PGM A MM\n",
                             "\xEF\xBB\xBF"
                             "BEGIN PGM A INCH\n",
                             "\r\n\r\n  begin pgm a mm\r\n", "12 BLK FORM 0.1 Z X+0\n", "TOOL CALL 5 Z S1000\n",
                             "5 CYCL DEF 7.0 DATUM SHIFT\n", "L X+1 Y+2 FMAX\n", "10 LN X+1 Y+2 Z+3 NX+0 NY+0 NZ+1\n",
                             "CALL LBL 5\n", "FUNCTION TCPM F TCP\n", "L IX-1\n"}) {
        const auto dialect = recognise(std::string_view(text).starts_with("\xEF") ? text + 3 : text);
        ASSERT_TRUE(dialect) << text;
        EXPECT_EQ(*dialect, Dialect::heidenhain) << text;
    }
    EXPECT_EQ(read_program("\xEF\xBB\xBF"
                           "0 BEGIN PGM A MM\nL X+0 Y+0 Z+0 FMAX\nL X+1 FMAX",
                           "test", {})
                  ->dialect,
              "heidenhain");
    for (const char* text : {"L10\n", "N10 G0 X0\n", "G1 X1\n", "LIMS=3000\n", "%\nG0 X1\n"}) {
        const auto dialect = recognise(text);
        EXPECT_TRUE(!dialect || *dialect != Dialect::heidenhain) << text;
    }
}

TEST(HeidenhainRealFile, IsReadWhole) {
    const std::filesystem::path file =
        std::filesystem::path(TRUNNION_SHARED_DIR) / "data/nc/heidenhain/dmc100_tnc_in.h";
    if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is absent";
    static const machine::Machine machine = machine_with("BC");
    ReadOptions options;
    options.machine = &machine;
    const auto p = read_program_file(file, options);
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->dialect, "heidenhain");
    EXPECT_GT(p->moves.size(), 3800u);
    EXPECT_EQ(p->arcs.size(), 144u);
    int vector = 0, tip = 0;
    for (const program::Move& move : p->moves) {
        vector += move.law == program::OrientationLaw::vector ? 1 : 0;
        tip += move.space == program::Space::workpiece && move.law == program::OrientationLaw::rotary ? 1 : 0;
    }
    EXPECT_GT(vector, 150) << "in tilted planes";
    EXPECT_GT(tip, 1500) << "under M128";
}

}  // namespace
}  // namespace trunnion::nc
