#include <filesystem>
#include <fstream>

#include "heidenhain_reading.hpp"

namespace trunnion::nc {
namespace {

/// The X to which `L X+Q1` goes behind some blocks.
std::string value(std::string_view blocks) {
    const auto p = after_start(std::string(blocks) + "\nL X+Q1 Y+1\n");
    return p ? number(p->moves.back().position_mm.x()) : p.error().code;
}

TEST(HeidenhainLanguage, Formulas) {
    EXPECT_EQ(value("Q1 = 5 * 3 + 2 * 10"), "35");
    EXPECT_EQ(value("Q2 = 30\nQ1 = 10 * SIN Q2"), "5");
    EXPECT_EQ(value("Q1 = SQ 10 - 3^3"), "73");
    EXPECT_EQ(value("Q1 = 400 % 360"), "40");
    EXPECT_EQ(value("Q1 = - ( 1 + 2 ) * -4"), "12");
    EXPECT_EQ(value("Q1=SQRT(16)+ABS -3+INT 2,7+FRAC 1.5+SGN -9+NEG 1"), "7.5");
    EXPECT_EQ(value("Q1 = ATAN 1 + ASIN 1 + ACOS 1 + COS 0 + TAN 45 + LN EXP 1 + LOG 100"), "140");
    EXPECT_EQ(value("Q1 = PI"), "3.14159");
    EXPECT_EQ(value("QL3 = 2\nQR4 = 3\nQ1 = QL3 * QR4"), "6");
}

TEST(HeidenhainLanguage, Functions) {
    EXPECT_EQ(value("FN 0: Q1 = +60"), "60");
    EXPECT_EQ(value("FN 0: Q2 = 7\nFN 1: Q1 = -Q2 + -5"), "-12");
    EXPECT_EQ(value("FN 2: Q1 = +10 - +5"), "5");
    EXPECT_EQ(value("FN 3: Q1 = +3 * +3"), "9");
    EXPECT_EQ(value("FN 4: Q1 = +4 DIV +2"), "2");
    EXPECT_EQ(value("FN 5: Q1 = SQRT 4"), "2");
    EXPECT_EQ(value("FN 6: Q1 = SIN +30"), "0.5");
    EXPECT_EQ(value("FN 7: Q1 = COS +60"), "0.5");
    EXPECT_EQ(value("FN 8: Q1 = +3 LEN +4"), "5");
    EXPECT_EQ(value("FN 13: Q1 = +0 ANG -1"), "270");
    EXPECT_EQ(value("Q1 = 3\nFN 16: F-PRINT A.A/B.TXT"), "3");
}

TEST(HeidenhainLanguage, RefusedFormulas) {
    EXPECT_EQ(value("Q1 = 5 /"), "NC0731");
    EXPECT_EQ(value("Q1 5"), "NC0731");
    EXPECT_EQ(value("Q1 = (5"), "NC0731");
    EXPECT_EQ(value("Q1 = FOO 5"), "NC0731");
    EXPECT_EQ(value("Q1 = Q2"), "NC0732");
    EXPECT_EQ(value("Q1 = Q108"), "NC0732");
    EXPECT_EQ(value("Q2000 = 1"), "NC0733");
    EXPECT_EQ(value("QL500 = 1"), "NC0733");
    EXPECT_EQ(value("Q1 = 1 / 0"), "NC0734");
    EXPECT_EQ(value("Q1 = SQRT -1"), "NC0734");
    EXPECT_EQ(value("QS1 = \"A\""), "NC0735");
    EXPECT_EQ(value("Q1 = " + std::string(65, '(') + "1"), "NC0736");
    EXPECT_EQ(value("Q1 = 1" + std::string(64, ' ') + "X"), "NC0737");
    EXPECT_EQ(value("FN 18: SYSREAD Q1 = ID20"), "NC0738");
    EXPECT_EQ(value("FN 14: ERROR = 1000"), "NC0739");
    std::string deep = "Q1 = ";
    for (int i = 0; i < 64; ++i) deep += "NEG ";
    EXPECT_EQ(value(deep + "1"), "NC0736");
}

TEST(HeidenhainLanguage, ParametersAsValues) {
    EXPECT_EQ(klartext("Q1=5\nQ2=300\nL X+Q1 Y-Q1 FQ2\nL IX+Q1 F Q2"), "F u 5 -5 0\nF u 10 -5 0\n");
    EXPECT_EQ(code_of(after_start("L X+Q99")), "NC0732");
    EXPECT_EQ(code_of(after_start("L X+")), "NC0731");
}

TEST(HeidenhainLanguage, Subprograms) {
    EXPECT_EQ(
        klartext(
            "CALL LBL 1\nCALL LBL \"UP\"\nL X+9 M30\nLBL 1\nL IX+1\nLBL 0\nLBL \"UP\"\nL IZ+1\nCALL LBL 01\nLBL 0"),
        "F u 1 0 0\nF u 1 0 1\nF u 2 0 1\nF u 9 0 1\n");
    EXPECT_EQ(klartext("LBL 500\nL IX+1\nLBL 0\nCALL LBL 500"), "F u 1 0 0\nF u 2 0 0\n")
        << "what is met without a call is carried out too";
}

TEST(HeidenhainLanguage, Repeats) {
    EXPECT_EQ(klartext("LBL 1\nL IX+1\nCALL LBL 1 REP 2\nL Y+1"), "F u 1 0 0\nF u 2 0 0\nF u 3 0 0\nF u 3 1 0\n");
    EXPECT_EQ(klartext("LBL 1\nL IX+1\nLBL 2\nL IY+1\nCALL LBL 2 REP 1/1\nCALL LBL 1 REP 1"),
              "F u 1 0 0\nF u 1 1 0\nF u 1 2 0\nF u 2 2 0\nF u 2 3 0\nF u 2 4 0\n")
        << "the inner repeat begins anew";
    EXPECT_EQ(klartext("Q1=3\nLBL 1\nL IX+1\nCALL LBL 1 REP Q1"), "F u 1 0 0\nF u 2 0 0\nF u 3 0 0\nF u 4 0 0\n");
}

TEST(HeidenhainLanguage, Jumps) {
    EXPECT_EQ(klartext("Q1=0\nLBL 1\nL IX+1\nQ1=Q1+1\nFN 12: IF +Q1 LT +3 GOTO LBL 1"),
              "F u 1 0 0\nF u 2 0 0\nF u 3 0 0\n");
    EXPECT_EQ(klartext("FN 9: IF +1 EQU +1 GOTO LBL \"A B\"\nL X+1\nLBL \"A B\"\nL Y+1"), "F u 0 1 0\n");
    EXPECT_EQ(klartext("FN 10: IF 1 NE 1 GOTO LBL 2\nL X+1\nLBL 2\nFN 11: IF 2 GT 1 GOTO LBL 3\nL X+2\nLBL 3\nL Y+1"),
              "F u 1 0 0\nF u 1 1 0\n");
}

TEST(HeidenhainLanguage, RefusedFlow) {
    EXPECT_EQ(code_of(after_start("CALL LBL 7")), "NC0741");
    EXPECT_EQ(code_of(after_start("LBL 7\nLBL 7\nCALL LBL 7")), "NC0741");
    EXPECT_EQ(code_of(after_start("CALL LBL 0")), "NC0741");
    EXPECT_EQ(code_of(after_start("LBL 1\nCALL LBL 1")), "NC0742");
    EXPECT_EQ(code_of(after_start("CALL LBL 1\nM30\nLBL 1\nL X+1")), "NC0744");
    EXPECT_EQ(code_of(after_start("LBL 1\nL IX+1\nCALL LBL 1 REP 70000")), "NC0745");
    EXPECT_EQ(code_of(after_start("CALL LBL 1 MORE\nLBL 1")), "NC0737");
    EXPECT_EQ(code_of(after_start("FN 9: IF 1 LIKE 2 GOTO LBL 1\nLBL 1")), "NC0738");
    EXPECT_EQ(code_of(after_start("CALL SELECTED PGM")), "NC0701");
    ReadOptions options;
    options.most_repeated_lines = 1000;
    EXPECT_EQ(code_of(read_klartext("BEGIN PGM A MM\nLBL 1\nFN 9: IF 0 EQU 0 GOTO LBL 1\n", options)), "NC0743");
    EXPECT_EQ(code_of(read_klartext("BEGIN PGM A MM\nLBL 1\nCALL LBL 1 REP 60000\n", options)), "NC0743");
}

TEST(HeidenhainLanguage, BlocksOfSeveralLines) {
    const auto p = after_start("PLANE SPATIAL SPA+0 ~\n SPB+0 ; text ~\n SPC+0 STAY ~\n\nL X+1 ~\n Y+Q9");
    ASSERT_FALSE(p);
    EXPECT_EQ(p.error().code, "NC0732");
    EXPECT_EQ(p.error().place.line, 9);
    EXPECT_EQ(p.error().place.column, 4);
    EXPECT_EQ(code_of(after_start("L X+1 ~\n" + std::string(30'000, ' ') + "Y+1 ~\n" + std::string(30'000, 'Y'))),
              "NC0748");
}

TEST(HeidenhainLanguage, TextBehindTheEnd) {
    const auto p = read_klartext("BEGIN PGM A MM\nL X+0 Y+0 Z+0 FMAX\nL X+1 FMAX\nEND PGM A MM\nL X+2\n");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->moves.size(), 2u);
    EXPECT_TRUE(told(*p, "NC0014"));
}

class HeidenhainFolder : public testing::Test {
  protected:
    void SetUp() override {
        const auto* const test = testing::UnitTest::GetInstance()->current_test_info();
        folder_ = std::filesystem::temp_directory_path() / (std::string("klartext_") + test->name());
        std::filesystem::create_directories(folder_ / "inner");
        write("SUB.H",
              "\xEF\xBB\xBF"
              "0 BEGIN PGM SUB INCH\n1 QL1=1\n2 L X+QL1 FMAX\n3 END PGM SUB INCH\n");
        write("ends.h", "BEGIN PGM E MM\nM30\nEND PGM E MM\n");
        write("own.h", "BEGIN PGM E MM\nCALL PGM OWN\nEND PGM E MM\n");
        write("inner/deep.h", "BEGIN PGM E MM\nEND PGM E MM\n");
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }
    void write(const char* name, std::string_view text) const { std::ofstream(folder_ / name) << text; }
    Result<program::Program> run(std::string_view blocks) const {
        static const machine::Machine machine = machine_with("BC");
        write("MAIN.H", std::string("BEGIN PGM MAIN MM\nL X+0 Y+0 Z+0 FMAX\n").append(blocks));
        ReadOptions options;
        options.machine = &machine;
        return read_program_file(folder_ / "MAIN.H", options);
    }
    std::filesystem::path folder_;
};

TEST_F(HeidenhainFolder, OtherPrograms) {
    const auto p = run("CALL PGM sub\nL Y+2 FMAX\nCALL PGM \"SUB.H\"\nL Y+3 FMAX\n");
    EXPECT_EQ(moves_of(p), "R u 25.4 0 0\nR u 25.4 2 0\nR u 25.4 3 0\n") << "each in its own unit";
    ASSERT_TRUE(p);
    EXPECT_EQ(p->moves[1].line, 3) << "the line of the call";
}

TEST_F(HeidenhainFolder, Refused) {
    EXPECT_EQ(code_of(run("QL1=1\nCALL PGM sub\nL X+QL1 FMAX\n")), "read");
    EXPECT_EQ(code_of(run("CALL PGM TNC:\\SUB.H\n")), "NC0746");
    EXPECT_EQ(code_of(run("CALL PGM inner/deep.h\n")), "NC0746");
    EXPECT_EQ(code_of(run("CALL PGM ..\\SUB.H\n")), "NC0746");
    EXPECT_EQ(code_of(run("CALL PGM OTHER\n")), "NC0747");
    EXPECT_EQ(code_of(run("CALL PGM ENDS\n")), "NC0745");
    EXPECT_EQ(code_of(run("CALL PGM OWN\n")), "NC0742");
    EXPECT_EQ(code_of(run("CALL PGM SUB MORE\n")), "NC0737");
}

}  // namespace
}  // namespace trunnion::nc
