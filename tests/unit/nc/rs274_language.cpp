#include <filesystem>
#include <fstream>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "reading.hpp"

namespace trunnion::nc {
namespace {

/// The X of all moves behind G21 G0 X0 Y0 Z0, with blanks between; or the code.
std::string x_of(std::string_view text, const ReadOptions& options = {}) {
    const auto p = read_ac("G21 G0 X0 Y0 Z0\n" + std::string(text), options);
    if (!p) return p.error().code;
    std::string all;
    for (std::size_t i = 1; i < p->moves.size(); ++i)
        all += fmt::format("{}{:g}", i > 1 ? " " : "", p->moves[i].position_mm.x());
    return all;
}

TEST(Rs274Language, ParametersAndExpressions) {
    EXPECT_EQ(x_of("#1=5\nX#1\nX[#1+1]\nX-#1\nXABS[-2]\n"), "5 6 -5 2");
    EXPECT_EQ(x_of("#1=1\n#1=7 X#1\nX#1\n"), "1 7") << "an assignment takes effect behind its block";
    EXPECT_EQ(x_of("#1=2 #2=[#1+3]\nX[#2+1]\n"), "4") << "#1 was still 0";
    EXPECT_EQ(x_of("#<my part>=3\nX#<MyPart>\n#<_all>=4\nX#<_all>\n"), "3 4");
    EXPECT_EQ(x_of("X4\nX[#5420+1]\nX[#<_x>*2]\n"), "4 5 10");
    EXPECT_EQ(x_of("#1=1\nG#1 F100 X#1\nG[0] X2\n"), "1 2");
    EXPECT_EQ(x_of("G55 G0 X1 Y1 Z1\nX#5220\n"), "1 2");
    EXPECT_EQ(x_of("G20 X1\nG21\nX[#5420*2]\n"), "25.4 50.8") << "positions are in the unit in force";
    EXPECT_EQ(x_of("X[EXISTS[#<a>]+1]\n"), "1");
}

TEST(Rs274Language, Branches) {
    constexpr std::string_view text =
        "#1={}\no1 if [#1 EQ 1] (one)\nX1\no1 elseif [#1 EQ 2]\nX2\no1 elseif [#1 EQ 3]\nX3\no1 else\nX4\no1 "
        "endif\nX9\n";
    for (const int value : {1, 2, 3, 4})
        EXPECT_EQ(x_of(fmt::format(fmt::runtime(text), value)), fmt::format("{} 9", value));
    EXPECT_EQ(x_of("o1 if [0]\nX1\no1 endif\nX2\n"), "2");
    EXPECT_EQ(x_of("o1 if [1]\no2 if [0]\nX1\no2 else\nX2\no2 endif\no1 else\nX3\no1 endif\n"), "2");
}

TEST(Rs274Language, Loops) {
    EXPECT_EQ(x_of("o1 while [#1 LT 3]\n#1=[#1+1]\nX#1\no1 endwhile\nX9\n"), "1 2 3 9");
    EXPECT_EQ(x_of("o1 while [0]\nX1\no1 endwhile\nX9\n"), "9");
    EXPECT_EQ(x_of("o1 do\n#1=[#1+1]\nX#1\no1 while [#1 LT 3]\nX9\n"), "1 2 3 9");
    EXPECT_EQ(x_of("o1 repeat [3]\nX[#5420+1]\no1 endrepeat\n"), "1 2 3");
    EXPECT_EQ(x_of("o1 repeat [0]\nX1\no1 endrepeat\nX9\n"), "9");
    EXPECT_EQ(x_of("o1 repeat [2]\no2 repeat [2]\nX[#5420+1]\no2 endrepeat\nX[#5420+10]\no1 endrepeat\n"),
              "1 2 12 13 14 24");
    EXPECT_EQ(x_of("o<l> while [#1 LT 5]\n#1=[#1+1]\no2 if [#1 EQ 2]\no<l> continue\no2 endif\no3 if [#1 EQ 4]\no<L> "
                   "break\no3 endif\nX#1\no<l> endwhile\nX9\n"),
              "1 3 9");
    EXPECT_EQ(x_of("o1 repeat [5]\nX[#5420+1]\no1 break\no1 endrepeat\nX9\n"), "1 9");
    EXPECT_EQ(x_of("o1 do\n#1=[#1+1]\no2 if [#1 LT 3]\no1 continue\no2 endif\nX#1\no1 while [#1 LT 4]\n"), "3 4");
}

TEST(Rs274Language, Subprograms) {
    EXPECT_EQ(x_of("o100 sub\nX#1\nX#2\nX[#3+5]\no100 endsub\no100 call [3] [4]\n"), "3 4 5");
    EXPECT_EQ(x_of("#1=8\no<a-b> call [3]\nX#1\nM2\no<a-b> sub\nX#1\no<A-B> endsub\n"), "3 8")
        << "local parameters, names in either case, and a subprogram behind the end";
    EXPECT_EQ(
        x_of("o1 sub\no2 if [#1 GT 2]\no1 return [#1*2]\no2 endif\no1 endsub [1]\no1 call [5]\nX#<_value>\no1 call "
             "[2]\nX#<_value>\n"),
        "10 1");
    EXPECT_EQ(x_of("o1 sub\no1 endsub\no1 call\nX[#<_value_returned>+1]\n"), "1");
    EXPECT_EQ(x_of("o5 sub\nX5\no5 endsub\no6 sub\nX6\no6 endsub\n#1=4\no[#1+1] call\no#1 call\n"), "NC0333");
    EXPECT_EQ(x_of("o5 sub\nX5\no5 endsub\no6 sub\nX6\no6 endsub\n#1=4\no[#1+2] call\no[#1+1] call\n"), "6 5");
    EXPECT_EQ(x_of("o1 sub\no2 if [#1 GT 0]\nX#1\no1 call [#1-1]\no2 endif\no1 endsub\no1 call [5]\n"), "5 4 3 2 1");
}

TEST(Rs274Language, ProgramsByM98) {
    EXPECT_EQ(x_of("#1=5\nM98 P100\nX#1\nM2\nO0100 (a)\nX#1\n#1=9\nM99\n"), "5 9") << "its parameters are the caller's";
    EXPECT_EQ(x_of("O7\nG91\nM98 P3 L2\nM2\nO3\nX1\nM99\n"), "1 2");
    EXPECT_EQ(x_of("M98 P3 L0\nX2\nM2\nO3\nX1\nM99\n"), "2");
}

TEST(Rs274Language, StateIsKept) {
    EXPECT_EQ(x_of("M70\nG91 X1\nX1\nM72\nX1\nX5\n"), "1 2 1 5");
    EXPECT_EQ(x_of("o1 sub\nM73\nG91\nX1\no1 endsub\nX5\no1 call\nX1\n"), "5 6 1") << "M73: till it returns";
    EXPECT_EQ(x_of("M70\nM71\nM72\n"), "NC0349");
    const auto p = read_ac("G0 X0 Y0 Z0\nF600 M70\nF60\nM72\nG1 X1\n");
    ASSERT_TRUE(p) << said(p);
    EXPECT_DOUBLE_EQ(p->moves[1].feed.value, 10);
}

TEST(Rs274Language, FilesOfTheFolder) {
    const std::filesystem::path folder = std::filesystem::temp_directory_path() / "trunnion_rs274_language";
    std::filesystem::create_directories(folder);
    const auto write = [&](const char* name, std::string_view text) { std::ofstream(folder / name) << text; };
    write("main.ngc", "G21 G0 X0 Y0 Z0\no<part> call [4]\nM98 P77\nM2\n");
    write("part.ngc", "(a part)\no<part> sub\n\nX#1\no<part> endsub\nM2\n");
    write("77.ngc", "X7\nM99\n");
    write("wrong.ngc", "G21 G0 X0 Y0 Z0\no<bad> call\n");
    write("bad.ngc", "o<bad> sub\nX$\no<bad> endsub\n");
    const auto p = read_program_file(folder / "main.ngc", {});
    ASSERT_TRUE(p) << said(p);
    ASSERT_EQ(p->moves.size(), 3u);
    EXPECT_EQ(p->moves[1].position_mm.x(), 4);
    EXPECT_EQ(p->moves[1].line, 2) << "the line of the call";
    EXPECT_EQ(p->moves[2].position_mm.x(), 7);
    const auto wrong = read_program_file(folder / "wrong.ngc", {});
    ASSERT_FALSE(wrong);
    EXPECT_EQ(wrong.error().code, "NC0201");
    EXPECT_EQ(wrong.error().place.file, (folder / "bad.ngc").string());
    EXPECT_EQ(wrong.error().place.line, 2);
    write("out.ngc", "G21 G0 X0 Y0 Z0\no<../part> call\n");
    EXPECT_EQ(read_program_file(folder / "out.ngc", {}).error().code, "NC0334");
    std::filesystem::create_symlink("/etc/hostname", folder / "link.ngc");
    write("linked.ngc", "G21 G0 X0 Y0 Z0\no<link> call\n");
    EXPECT_EQ(read_program_file(folder / "linked.ngc", {}).error().code, "NC0334");
    std::filesystem::remove_all(folder);
}

TEST(Rs274Language, Refusals) {
    const std::pair<std::string_view, std::string_view> refusals[] = {
        {"#1 5\n", "NC0320"},
        {"#1=\n", "NC0320"},
        {"X[1+2\n", "NC0320"},
        {"X#<a>\n", "NC0323"},
        {"X#5221\n", "NC0324"},
        {"#5420=1\n", "NC0330"},
        {"#<_x>=1\n", "NC0330"},
        {"o1\nX1 o2 if [1]\n", "NC0331"},
        {"o if [1]\n", "NC0331"},
        {"o1 unless [1]\n", "NC0331"},
        {"o1 if [1] X1\no1 endif\n", "NC0331"},
        {"o[1] if [1]\n", "NC0331"},
        {"o1 if [1]\n", "NC0332"},
        {"o1 endif\n", "NC0332"},
        {"o1 if [1]\no2 endif\n", "NC0332"},
        {"o1 while [1]\no1 endrepeat\n", "NC0332"},
        {"o1 if [1]\no2 sub\no2 endsub\no1 endif\n", "NC0332"},
        {"o1 call\n", "NC0333"},
        {"M98 P9\n", "NC0333"},
        {"M98 P9\nO9\nX1\n", "NC0335"},
        {"o1 sub\no1 call\no1 endsub\no1 call\n", "NC0336"},
        {"M99\n", "NC0337"},
        {"o1 return\n", "NC0337"},
        {"o1 break\n", "NC0337"},
        {"o1 repeat [2]\no1 endrepeat\no1 break\n", "NC0337"},
        {"o1 repeat [1.5]\no1 endrepeat\n", "NC0339"},
        {"M98\n", "NC0339"},
        {"M98 P1.5\n", "NC0339"},
        {"M98 P1 L-1\n", "NC0339"},
        {"M72\n", "NC0349"},
    };
    for (const auto& [text, code] : refusals) EXPECT_EQ(x_of(text), code) << text;
    std::string many = "o1 sub\no1 endsub\no1 call";
    for (int i = 0; i < 31; ++i) many += " [1]";
    EXPECT_EQ(x_of(many), "NC0340");
}

TEST(Rs274Language, LoopsWithoutEndAreRefused) {
    ReadOptions options;
    options.most_repeated_lines = 1000;
    EXPECT_EQ(x_of("o1 while [1]\no1 endwhile\n", options), "NC0338");
    EXPECT_EQ(x_of("o1 repeat [1000000]\no1 endrepeat\n", options), "NC0338");
    EXPECT_EQ(x_of("M98 P1 L1000000\nM2\nO1\nM99\n", options), "NC0338");
    EXPECT_NE(x_of("o1 repeat [300]\nX[#5420+1]\no1 endrepeat\n", options), "NC0338");
    std::string long_one;
    for (int i = 1; i < 3000; ++i) long_one += fmt::format("X{}\n", i);
    EXPECT_NE(x_of(long_one, options), "NC0338") << "the text once is free";
}

TEST(Rs274Language, CommentsForTheOperatorAreCounted) {
    const auto p = read_ac("G21 G0 X0 Y0 Z0 (MSG, hello)\n(debug, #1)\n(PRINT,x)\n(a, b)\n(msg, again)\nX1\n");
    ASSERT_TRUE(p) << said(p);
    ASSERT_TRUE(told(*p, "NC0012", "(MSG,"));
    EXPECT_EQ(told(*p, "NC0012", "(MSG,")->count, 2);
    EXPECT_TRUE(told(*p, "NC0012", "(DEBUG,"));
    EXPECT_TRUE(told(*p, "NC0012", "(PRINT,"));
    EXPECT_EQ(p->diagnostics.size(), 3u);
}

}  // namespace
}  // namespace trunnion::nc
