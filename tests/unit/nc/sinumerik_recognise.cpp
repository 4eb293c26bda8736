#include "sinumerik_reading.hpp"

namespace trunnion::nc {
namespace {

TEST(SinumerikRecognised, ByAWordThatOnlyItHas) {
    for (const std::string_view text : {"%_N_PART_MPF\nG0 X0\n",
                                        ";$PATH=/_N_MPF_DIR\nG0 X0\n",
                                        "DEF REAL A\n",
                                        "PROC MAIN\n",
                                        "N10 TRAORI\n",
                                        "N10 G0 X0 ; start\nN20 G1 X5\nN30 SUPA Z0\n",
                                        "MSG(\"a (b)\")\n",
                                        "N10 MSG (\"a\")\n",
                                        "G0 X=5\n",
                                        "x=r1+2\n",
                                        "R1=5\n",
                                        "T=\"MILL\"\n",
                                        "G2 X1 Y1 CR=5\n",
                                        "A3=1 B3=0 C3=0\n",
                                        "G0 X0\nCYCLE81(10,0,2,-5)\n",
                                        "G54\nG505\n",
                                        "G710 G90\n",
                                        "G642\n",
                                        "N1 MCALL\n",
                                        "ROT\n",
                                        "(a)\nG0 X0\n(b)\nTRAFOOF\n",
                                        "/N10 SUPA Z0\n",
                                        "GOTOF A\n",
                                        "START:\nG0 X0\n",
                                        "N5G0X1Y2TRAORI\n"}) {
        const auto dialect = recognise(text);
        ASSERT_TRUE(dialect) << text << to_string(dialect.error());
        EXPECT_EQ(*dialect, Dialect::sinumerik) << text;
    }
}

TEST(SinumerikRecognised, NotByWhatOthersHaveToo) {
    for (const std::string_view text : {"%\nG0 X0\n", "(TRAORI)\nG0 X0\n", "G0 X0 ; TRAORI\n", "#1=5\nG0 X0\n",
                                        "#<a>=5\n", "O100 SUB\nO100 CALL [1]\n", "G0 X1 (SUPA) Y2\n",
                                        "G28\nSET_GCODE_OFFSET Z=0.1\nG1 X1\n", "G17 G40 G49 G80 G90\n", "M98 P1\n"}) {
        const auto dialect = recognise(text);
        ASSERT_TRUE(dialect) << text;
        EXPECT_EQ(*dialect, Dialect::rs274) << text;
    }
    for (const std::string_view text : {"N10 G0 X0\nG43.4 H1\n", "G154 P1\nG187 P2\n", "N5 IF [#1 EQ 2] GOTO 10\n"}) {
        const auto dialect = recognise(text);
        ASSERT_TRUE(dialect) << text;
        EXPECT_EQ(*dialect, Dialect::fanuc) << text;
    }
    const std::string late = [] {
        std::string text;
        for (int i = 0; i < 6000; ++i) text += "N1 G1 X1\n";
        return text + "TRAORI\n";
    }();
    EXPECT_EQ(*recognise(late), Dialect::rs274) << "the search ends after some thousand lines";
    EXPECT_EQ(*recognise(late.substr(late.size() - std::size_t{9} * 3000 - 7)), Dialect::sinumerik);
}

TEST(SinumerikRecognised, ByName) {
    EXPECT_EQ(dialect_named("sinumerik"), Dialect::sinumerik);
    EXPECT_EQ(name_of(Dialect::sinumerik), "sinumerik");
    EXPECT_EQ(read_bc("G0 X0 Y0 Z0\nX1\n")->dialect, "sinumerik");
}

}  // namespace
}  // namespace trunnion::nc
