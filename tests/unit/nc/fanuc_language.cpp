#include <filesystem>
#include <fstream>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "fanuc_reading.hpp"

namespace trunnion::nc {
namespace {

namespace fs = std::filesystem;

/// X of the moves behind the start: `1 2 3`.
std::string ways(const Result<program::Program>& p) {
    if (!p) return said(p);
    std::string text;
    for (std::size_t i = 1; i < p->moves.size(); ++i)
        text += fmt::format("{}{:.6g}", i > 1 ? " " : "", p->moves[i].position_mm.x());
    return text;
}

std::string run(std::string_view text) {
    return ways(read_fanuc_after_start("G1\n" + std::string(text)));
}

TEST(FanucLanguage, Lines) {
    EXPECT_EQ(run("N10 X1.\nN20X2.;X3.; N30 X4.;\n( a (b) c ) X5. (d)\n/ X6.\nX7. / X8.\n* noise\nx  8.5"),
              "1 2 3 4 5 7 8.5");
    const std::pair<const char*, const char*> refusals[] = {
        {"X1. (open", "NC0203"}, {"X", "NC0201"},         {"X1. ?", "NC0202"},      {"XX1.", "NC0204"},
        {"G12345", "NC0204"},    {"B5=3.", "NC0801"},     {"N X1.", "NC0802"},      {"X1. O5", "NC0802"},
        {"X1. X2.", "NC0824"},   {"X1. ,R2.", "NC0821"},  {"G41 D1 X5.", "NC0822"}, {"G90 G91", "NC0823"},
        {"A5.", "NC0827"},       {"X1. R5.", "NC0825"},   {"M128", "NC0851"},       {"M198 P5", "NC0821"},
        {"S-5", "NC0829"},       {"G10 L3 P1", "NC0840"}, {"G54.4 P1", "NC0821"},   {"M6.5", "NC0204"},
        {"G96 S100", "NC0821"},
    };
    for (const auto& [text, code] : refusals) {
        const auto p = read_fanuc_after_start("G1\n" + std::string(text));
        ASSERT_FALSE(p) << text;
        EXPECT_EQ(p.error().code, code) << text << "\n" << said(p);
        EXPECT_EQ(p.error().place.line, 9) << text;
    }
    EXPECT_EQ(read_fanuc_text("X1.").error().code, "NC0828");
    EXPECT_EQ(read_program("O0001\nG0 X0 Y0 Z0 B1.", "test", {}).error().code, "NC0826");
}

TEST(FanucLanguage, HeadersTitlesAndEnds) {
    auto p = read_fanuc_text("Listing made by x\n====\n\n%\nOFinal Path\nG21 G0 X0 Y0 Z0\nX1.\nM30\n%\nthe end");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->name, "OFinal Path");
    EXPECT_TRUE(told(*p, "NC0861"));
    EXPECT_TRUE(told(*p, "NC0014"));
    p = read_fanuc_text("O12 (name)\nG21 G0 X0 Y0 Z0\nX1.\nM30\n%\n");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->name, "O12");
    EXPECT_FALSE(told(*p, "NC0861"));
    EXPECT_FALSE(told(*p, "NC0014"));
    EXPECT_EQ(ways(read_fanuc_text("O1\nG0 X0 Y0 Z0\nX1.\nO2\nX2.\n")), "1");
}

TEST(FanucLanguage, Variables) {
    EXPECT_EQ(run("#1=5\nX#1\nX[#1+1]\nX-#1\n#[1+1]=#1*2\nX#[2-1+1]"), run("X5.\nX6.\nX-5.\nX10."));
    EXPECT_EQ(run("X1. Z#5\nX[2*[1+SIN[90]]]"), "1 4");
    EXPECT_EQ(run("#100=ROUND[2.5]\nX#100\nX#5001\nX[#4003]"), "3 90");
    const std::pair<const char*, const char*> refusals[] = {
        {"#0=1", "NC0811"},   {"#5221=3.", "NC0811"}, {"#3000=1", "NC0812"},  {"#1 5", "NC0803"},
        {"X[1/0]", "NC0325"}, {"X#2001", "NC0324"},   {"#1=5 X1.", "NC0803"},
    };
    for (const auto& [text, code] : refusals) EXPECT_EQ(read_fanuc_after_start(text).error().code, code) << text;
    EXPECT_TRUE(told(*read_fanuc_after_start("#3006=1 (look)\nG1 X1."), "NC0012", "#3006"));
}

TEST(FanucLanguage, JumpsAndLoops) {
    EXPECT_EQ(run("#1=0\nN5 #1=#1+1\nX#1\nIF[#1LT3]GOTO5"), "1 2 3");
    EXPECT_EQ(run("GOTO 10\nX1.\nN10 X2."), "2");
    EXPECT_EQ(run("#1=1\nWHILE[#1 LE 3] DO1\nX#1\n#1=#1+1\nEND1\nX9."), "1 2 3 9");
    EXPECT_EQ(run("#1=1\nWHILE[#1LE2]DO1\n#2=1\nWHILE[#2LE2]DO2\nX[#1*10+#2]\n#2=#2+1\nEND2\n#1=#1+1\nEND1"),
              "11 12 21 22");
    EXPECT_EQ(run("#1=1\nDO1\nX#1\n#1=#1+1\nIF[#1 GT 2]GOTO 7\nEND1\nN7 X9."), "1 2 9");
    EXPECT_EQ(run("#1=7\nIF[#1 EQ 7] THEN #2=4\nIF[#1 EQ 8] THEN #2=5\nX#2"), "4");
    EXPECT_EQ(run("WHILE[1 EQ 2]DO1\nX1.\nEND1\nX2."), "2");
    const std::pair<const char*, const char*> refusals[] = {
        {"GOTO 99", "NC0804"},          {"GOTO [1.5]", "NC0804"},    {"END1", "NC0805"},
        {"WHILE[1 EQ 2]DO1", "NC0805"}, {"WHILE[1 EQ 1]", "NC0805"}, {"IF[1 EQ 1] X5.", "NC0803"},
        {"N1 GOTO 1", "NC0808"},        {"DO1\nEND1", "NC0808"},
    };
    for (const auto& [text, code] : refusals) {
        ReadOptions options;
        options.most_repeated_lines = 1000;
        EXPECT_EQ(read_fanuc_text("G0 X0 Y0 Z0\n" + std::string(text) + "\nX1.", options).error().code, code) << text;
    }
}

TEST(FanucLanguage, Subprograms) {
    const std::string subs = "M30\nO100\nX[#500]\n#500=#500+1\nM99\nO200\nM98 P100\nN7 X50.\nM99 P9\n";
    EXPECT_EQ(run("#500=1\nM98 P100\nM98 P100 L2\nM98 P20100\n" + subs), "1 2 3 4 5");
    EXPECT_EQ(run("#500=1\nX7. M98 P100\n" + subs), "7 1");
    EXPECT_EQ(run("#500=1\nM98 P200\nX2.\nN9 X3.\n" + subs), "1 50 3");
    EXPECT_EQ(run("M97 P40 L2\nX9.\nM30\nN40 G91 X1.\nG90\nM99"), "1 2 9");
    const auto p = read_fanuc_text("G0 X0 Y0 Z0\nX1.\nM99");
    ASSERT_TRUE(p) << said(p);
    EXPECT_TRUE(told(*p, "NC0867"));
    const std::pair<const char*, const char*> refusals[] = {
        {"M98", "NC0809"},      {"M98 P5", "NC0806"},  {"M98 P5 L0", "NC0809"},
        {"M98 P1.5", "NC0809"}, {"G65 X1.", "NC0809"}, {"M98 P300\nM30\nO300\nM98 P300\nM99", "NC0807"},
    };
    for (const auto& [text, code] : refusals) EXPECT_EQ(read_fanuc_after_start(text).error().code, code) << text;
}

TEST(FanucLanguage, Macros) {
    const std::string macro = "M30\nO9010\nX#24\nX[#7+#17]\nM99\n";
    EXPECT_EQ(run("#24=99\nG65 P9010 X1. D2. Q3.\nX#24\n" + macro), "1 5 99");  // local variables come back
    EXPECT_EQ(run("G65 P9010 L2 X1. I4. J5. K6. I7. Q3.\n" + macro), "1 10 1 10");
    EXPECT_EQ(run("G66 P9020 A3.\nX1.\nX2.\nG67\nX3.\nM30\nO9020\n#500=#500+#1\nX[#500+10]\nM99\n"), "1 13 2 16 3");
    EXPECT_EQ(read_fanuc_after_start("G65 P9010 N5").error().code, "NC0809");
}

TEST(FanucLanguage, FilesOfTheFolder) {
    const fs::path folder = fs::temp_directory_path() / "trunnion_fanuc_files";
    fs::remove_all(folder);
    fs::create_directories(folder / "inner");
    const auto write = [&](const fs::path& name, std::string_view text) { std::ofstream(folder / name) << text; };
    write("main.nc", "%\nO0001\nG21 G0 X0 Y0 Z0\nM98 P12\nM30\n%\n");
    write("O0012.nc", "%\nO12\nX5.\nM99\n%\n");
    write("../trunnion_fanuc_outside", "X7.\n");
    ReadOptions options;
    EXPECT_EQ(ways(read_program_file(folder / "main.nc", options)), "5");
    write("12.txt", "X6.\n");
    EXPECT_EQ(read_program_file(folder / "main.nc", options).error().code, "NC0810");
    fs::remove(folder / "12.txt");
    fs::remove(folder / "O0012.nc");
    EXPECT_EQ(read_program_file(folder / "main.nc", options).error().code, "NC0806");
    fs::create_symlink(folder / "../trunnion_fanuc_outside", folder / "O0012");
    EXPECT_EQ(read_program_file(folder / "main.nc", options).error().code, "NC0810");
    fs::remove_all(folder);
    fs::remove(folder / "../trunnion_fanuc_outside");
}

TEST(FanucLanguage, SettingsThatMoveNothing) {
    const auto p = read_fanuc_after_start(
        "G5.1 Q1\nG5 P10000\nG8 P1\nG187 P2 E.01\nG103 P1\nG10 L50\nN1320 P1 R5.\nG11\n"
        "G10 L10 P1 R5.\nM29 S500\nM19 P90\nG61.1\nDPRNT[X#1]\nG1 X1.");
    ASSERT_TRUE(p) << said(p);
    for (const char* word : {"G5.1", "G5", "G8", "G187", "G103", "G10 L50", "G61.1", "DPRNT"})
        EXPECT_TRUE(told(*p, "NC0012", word)) << word;
    EXPECT_TRUE(told(*p, "NC0866"));
}

TEST(FanucRecognise, ByContent) {
    for (const char* text :
         {"%\nO0001\nG0 X1.\n", "O0012(part)\n", "%\nOFinal\n", "G21\nG0 X1.\nG43.4 H1 Z5.\n", "N5 G65 P9010 A1.\n",
          "(a)\nG0 X1\nIF[#1 EQ 1] GOTO 5\n", "G0 X1\nN7 G54.1 P2\n", "G0G68.2X1\n", "WHILE [#1 LT 5] DO1\n",
          "Listing\n\n%\nG0 X1.\n", "%PM9001\nN1 G93 B5=3\n", "G234 H2\n", "G1 X1\nG6.2 P4 K0 X1\n"}) {
        const auto dialect = recognise(text);
        ASSERT_TRUE(dialect) << text;
        EXPECT_EQ(*dialect, Dialect::fanuc) << text;
    }
    for (const char* text : {"%\nG0 X1\nG43 H1\nG54\n%\n", "O7\nM98 P3\nM2\nO3 (a)\nM99\n",
                             "o100 sub\no100 endsub\nG0 X1\n", "G5.1 X1 Y1 I1 J1\n", "(G43.4)\nG0 X1 ; G65 P1\n",
                             "#1=4\nG0 X#1\n", "O1 if [#1 EQ 2]\n", "G28 Z0\nG81 R1 Z1\n"})
        EXPECT_EQ(*recognise(text), Dialect::rs274) << text;
    EXPECT_EQ(*recognise("G0 X=R1\nG43.4 H1\n"), Dialect::sinumerik);
    EXPECT_EQ(recognise("Listing\nmore\n").error().code, "NC0004");
    EXPECT_EQ(*recognise("; by hand\n;\n0 BEGIN PGM A MM\n"), Dialect::heidenhain) << "comments tell nothing";
    EXPECT_EQ(*recognise("; by hand\nG0 X1\n"), Dialect::rs274);
    EXPECT_EQ(*recognise("; nothing but this\n"), Dialect::rs274);
    EXPECT_EQ(read_program("%PM9001\nN1 G93 B5=3\n", "test", {}).error().code, "NC0801");
}

}  // namespace
}  // namespace trunnion::nc
