#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "detail/sinumerik_interpreter.hpp"
#include "random.hpp"

namespace trunnion::nc::sinumerik {
namespace {

bool is_word(std::string_view name) {
    constexpr std::string_view words[] = {"SUPA",  "TRAORI", "TRAFOOF", "HOLES2", "MSG",   "STOPRE",
                                          "FNORM", "COMPOF", "CR",      "TURN",   "TRANS", "AROT",
                                          "ROT",   "FGREF",  "FGROUP",  "POS",    "SPOS"};
    return name.starts_with("CYCLE") || std::ranges::find(words, name) != std::end(words);
}

std::string transcript(const Argument& argument) {
    switch (argument.kind) {
        case Argument::Kind::empty:
            return "";
        case Argument::Kind::number:
            return fmt::format("{:.12g}", argument.number);
        case Argument::Kind::text:
            return fmt::format("\"{}\"", argument.text);
        case Argument::Kind::name:
            return argument.text;
    }
    return "?";
}

/// As a person would write the word with its value worked out.
std::string transcript(const Word& word) {
    constexpr std::string_view countings[] = {"", "AC", "IC", "DC", "ACP", "ACN"};
    std::string line(word.name);
    if (word.extension != 0) line += fmt::format("{}", word.extension);
    if (!word.index.empty()) line += fmt::format("[{}]", word.index);
    if (word.name.size() > 1 && (word.has_value || word.has_text)) line += '=';
    if (word.has_value)
        line += fmt::format("{}{:.12g}", countings[static_cast<std::size_t>(word.counting)], word.value);
    if (word.has_text) line += fmt::format("\"{}\"", word.text);
    if (!word.is_call) return line;
    line += '(';
    for (const Argument& argument : word.arguments)
        line.append(&argument == word.arguments.data() ? "" : ",").append(transcript(argument));
    return line + ')';
}

struct Carried {
    std::string blocks;  ///< words apart by a blank, blocks by ` | `
    std::string lines;   ///< of the blocks, apart by a blank
    std::string places;  ///< the lines in their own files
    Diagnostic error;
    std::vector<Diagnostic> notices;
};

Carried carry_out(std::string_view text, const std::string& file = "test", const Limits& limits = {}) {
    Findings findings(file);
    Interpreter interpreter(text, file, findings, is_word, limits);
    Carried carried;
    Block block;
    for (;;) {
        const auto step = interpreter.next(block);
        if (step == Interpreter::Step::end) break;
        if (step == Interpreter::Step::refused) {
            carried.error = findings.take_error();
            EXPECT_FALSE(carried.error.code.empty());
            break;
        }
        EXPECT_FALSE(block.words.empty());
        carried.blocks += carried.blocks.empty() ? "" : " | ";
        for (const Word& word : block.words)
            carried.blocks.append(&word == block.words.data() ? "" : " ").append(transcript(word));
        carried.lines += fmt::format("{}{}", carried.lines.empty() ? "" : " ", block.line);
        carried.places += fmt::format("{}{}", carried.places.empty() ? "" : " ", block.place.line);
    }
    carried.notices = findings.take_notices();
    return carried;
}

void expect_blocks(std::string_view text, std::string_view blocks) {
    const Carried carried = carry_out(text);
    EXPECT_EQ(carried.blocks, blocks) << text;
    EXPECT_EQ(carried.error.code, "") << text << "\n" << to_string(carried.error);
}

void expect_refused(std::string_view text, std::string_view code, int line, int column, const Limits& limits = {}) {
    const Carried carried = carry_out(text, "test", limits);
    EXPECT_EQ(carried.error.code, code) << text << "\n" << to_string(carried.error) << "\n" << carried.blocks;
    EXPECT_EQ(carried.error.place.line, line) << text << "\n" << to_string(carried.error);
    EXPECT_EQ(carried.error.place.column, column) << text << "\n" << to_string(carried.error);
    EXPECT_EQ(carried.error.place.file, "test");
    EXPECT_FALSE(carried.error.text.empty());
}

/// What the expression is worth, to twelve digits.
std::string worth(std::string_view expression) {
    return carry_out("DEF INT II=7\nDEF STRING[20] SS=\"ab\"\nR1=2 R2=-3\nX=" + std::string(expression)).blocks;
}

TEST(SinumerikText, Words) {
    expect_blocks("N10 G0X53.839Y129.142", "G0 X53.839 Y129.142");
    expect_blocks("g1 x.5 y1. z-.5 a+3", "G1 X0.5 Y1 Z-0.5 A3");
    expect_blocks("X=10 Y = 20 Z= 30 B 5", "X10 Y20 Z30 B5");
    expect_blocks("X1.5EX-3 Y=2EX2 Z1EX+1", "X0.0015 Y200 Z10");
    expect_blocks("T08 D1 T=\"Mill d8\" T1=\"x\"", "T8 D1 T\"Mill d8\" T1\"x\"");
    expect_blocks("M2=3 S1=1000 M3 H5=1", "M23 S11000 M3 H51");
    expect_blocks("A3=1 B3 = 0 C3=-1 I1=2 A3", "A3=1 B3=0 C3=-1 I1=2 A3");
    expect_blocks("CR=12.5 TURN=2 SUPA TRAORI", "CR=12.5 TURN=2 SUPA TRAORI");
    expect_blocks("X=AC(10) Y=IC(-5) C=DC(45) A=ACP(1+1) B=ACN( 3 ) I=AC(0.)", "XAC10 YIC-5 CDC45 AACP2 BACN3 IAC0");
    expect_blocks("TRAORI(1) CYCLE800() CYCLE90 (1,,\"R d\",-2,)", "TRAORI(1) CYCLE800() CYCLE90(1,,\"R d\",-2,)");
    expect_blocks("FGROUP(X,y) FGREF[c]=57.3 POS[1+1]=4", "FGROUP(X,Y) FGREF[C]=57.3 POS[2]=4");
    expect_blocks("MCALL CYCLE81(1,2)\nX5\nMCALL", "MCALL CYCLE81(1,2) | X5 | MCALL");
    expect_blocks("MSG(\"a;b\") ; a comment \xc3\xa4\nX1;X2", "MSG(\"a;b\") | X1");
    expect_blocks("\xef\xbb\xbfN1 X1\r\n\r\n  \r\nN2 X2\r\n", "X1 | X2");
    expect_blocks("R1=2R2=3\nX=R1Y=R2Z=-R1", "X2 Y3 Z-2");
    expect_blocks("N10 LABEL: X1\n:20 X2\nN30\n%\nX3", "X1 | X2 | X3");
    expect_blocks("", "");
}

TEST(SinumerikText, PlacesOfWords) {
    Findings findings("test");
    Interpreter interpreter("\nN10 AGAIN: X1 Y=2 TRAORI(1)\n", "test", findings, is_word);
    Block block;
    ASSERT_EQ(interpreter.next(block), Interpreter::Step::block);
    ASSERT_EQ(block.words.size(), 3u);
    EXPECT_EQ(block.line, 2);
    EXPECT_EQ(block.label, "AGAIN");
    EXPECT_EQ(block.spot(block.words[1]).line, 2);
    EXPECT_EQ(block.spot(block.words[0]).column, 12);
    EXPECT_EQ(block.spot(block.words[1]).column, 15);
    EXPECT_EQ(block.spot(block.words[2]).column, 19);
    EXPECT_TRUE(block.spot(block.words[2]).file.empty());
    EXPECT_EQ(interpreter.next(block), Interpreter::Step::end);
}

TEST(SinumerikText, BlockDelete) {
    const Carried carried = carry_out("X1\n/X2\n/3 N10 X3\n  /IF\nX4");
    EXPECT_EQ(carried.blocks, "X1 | X4");
    ASSERT_EQ(carried.notices.size(), 1u);
    EXPECT_EQ(carried.notices[0].code, "NC0016");
    EXPECT_EQ(carried.notices[0].count, 3);
    EXPECT_EQ(carried.notices[0].place.line, 2);
}

TEST(SinumerikText, TellsOfTextBehindTheEnd) {
    const Carried carried = carry_out("X1\nM30\n; a comment\n%\nX2\n%_N_SUB_SPF\nX3\n");
    EXPECT_EQ(carried.blocks, "X1 | M30");
    ASSERT_EQ(carried.notices.size(), 1u);
    EXPECT_EQ(carried.notices[0].code, "NC0014");
    EXPECT_EQ(carried.notices[0].place.line, 5);
    EXPECT_TRUE(carry_out("GOTOF AA\nX1\nBB: M30\nAA: X2\nGOTOB BB\n; end\n").notices.empty());
    EXPECT_TRUE(carry_out("X1\nM30\n%\n").notices.empty());
}

TEST(SinumerikText, RefusesWhatIsNoWord) {
    expect_refused("X1 )", "NC0202", 1, 4);
    expect_refused("X1 \xc3\xa4", "NC0202", 1, 4);
    expect_refused("X1.2.3", "NC0202", 1, 5);
    expect_refused("X1.5=3", "NC0202", 1, 5);
    expect_refused("(X1)", "NC0202", 1, 1);
    expect_refused("X5\nY", "NC0201", 2, 1);
    expect_refused("X-", "NC0201", 1, 1);
    expect_refused("X--1", "NC0201", 1, 1);
    expect_refused("X1EX999", "NC0201", 1, 1);
    expect_refused("X" + std::string(400, '9'), "NC0201", 1, 1);
    expect_refused("M99999999999=1", "NC0201", 1, 1);
    expect_refused("X=", "NC0501", 1, 3);
    expect_refused("X=AC 5", "NC0501", 1, 6);
    expect_refused("T=\"MILL", "NC0515", 1, 3);
    expect_refused("X='H7F'", "NC0516", 1, 3);
    expect_refused("FGREF[1=1", "NC0501", 1, 8);
    expect_refused("TRAORI(1", "NC0501", 1, 9);
}

TEST(SinumerikExpressions, Arithmetic) {
    EXPECT_EQ(worth("1+2*3-4/8"), "X6.5");
    EXPECT_EQ(worth("(1+2)*3"), "X9");
    EXPECT_EQ(worth("-(R1)"), "X-2");
    EXPECT_EQ(worth("-R1*-R2"), "X-6");
    EXPECT_EQ(worth("10-3-2"), "X5");
    EXPECT_EQ(worth("7 DIV 2"), "X3");
    EXPECT_EQ(worth("-7 DIV 2"), "X-3");
    EXPECT_EQ(worth("7 MOD 4 + 1"), "X4");
    EXPECT_EQ(worth("R1+R[1]+R[R1]+R500"), "X1");
    EXPECT_EQ(worth("II+1"), "X8");
    EXPECT_EQ(worth("$PI"), "X3.14159265359");
    EXPECT_EQ(worth("12 B_AND 10"), "X8");
    EXPECT_EQ(worth("12 B_OR 10"), "X14");
    EXPECT_EQ(worth("12 B_XOR 10"), "X6");
    EXPECT_EQ(worth("B_NOT 5"), "X-6");
}

TEST(SinumerikExpressions, Functions) {
    EXPECT_EQ(worth("SIN(30)"), "X0.5");
    EXPECT_EQ(worth("COS(60)"), "X0.5");
    EXPECT_EQ(worth("TAN(45)"), "X1");
    EXPECT_EQ(worth("ASIN(1)"), "X90");
    EXPECT_EQ(worth("ACOS(-1)"), "X180");
    EXPECT_EQ(worth("ATAN2(30.5,80.1)"), "X20.8455339268");
    EXPECT_EQ(worth("ATAN2(-1,-1)"), "X-135");
    EXPECT_EQ(worth("SQRT(2)"), "X1.41421356237");
    EXPECT_EQ(worth("ABS(R2)"), "X3");
    EXPECT_EQ(worth("POT(R2)"), "X9");
    EXPECT_EQ(worth("TRUNC(-2.7)"), "X-2");
    EXPECT_EQ(worth("TRUNC(61.01*1000)"), "X61010");
    EXPECT_EQ(worth("ROUND(2.5)"), "X3");
    EXPECT_EQ(worth("ROUNDUP(3.1)"), "X4");
    EXPECT_EQ(worth("ROUNDUP(-3.6)"), "X-3");
    EXPECT_EQ(worth("ROUNDUP(3)"), "X3");
    EXPECT_EQ(worth("LN(1)"), "X0");
    EXPECT_EQ(worth("EXP(1)"), "X2.71828182846");
    EXPECT_EQ(worth("MINVAL(R1,R2)"), "X-3");
    EXPECT_EQ(worth("MAXVAL(R1,R2)"), "X2");
    EXPECT_EQ(worth("BOUND(1,5,9)"), "X5");
    EXPECT_EQ(worth("BOUND(1,5,3)"), "X3");
}

TEST(SinumerikExpressions, ComparisonsAndLogic) {
    EXPECT_EQ(worth("R1==2"), "X1");
    EXPECT_EQ(worth("0.1+0.2==0.3"), "X1");
    EXPECT_EQ(worth("0.1+0.2>0.3"), "X0");
    EXPECT_EQ(worth("0.1+0.2>=0.3"), "X1");
    EXPECT_EQ(worth("0.3<>0.30001"), "X1");
    EXPECT_EQ(worth("2<=1"), "X0");
    EXPECT_EQ(worth("2<2"), "X0");
    EXPECT_EQ(worth("(R1==2) AND (R2==-3)"), "X1");
    EXPECT_EQ(worth("(R1==2) AND (R2==3)"), "X0");
    EXPECT_EQ(worth("TRUE XOR TRUE OR FALSE"), "X0");
    EXPECT_EQ(worth("TRUE OR TRUE AND FALSE"), "X1");
    EXPECT_EQ(worth("NOT FALSE"), "X1");
    EXPECT_EQ(worth("NOT (R1==2)"), "X0");
    EXPECT_EQ(worth("1+1==2*1"), "X1");
    EXPECT_EQ(worth("SS==\"ab\""), "X1");
    EXPECT_EQ(worth("SS<<1==\"ab1\""), "X1");
    EXPECT_EQ(worth("\"a\"<>\"A\""), "X1");
    expect_blocks("T=\"D\"<<8<<\"_\"<<0.5", "T\"D8_0.5\"");
}

TEST(SinumerikExpressions, Refusals) {
    expect_refused("X=1+", "NC0501", 1, 5);
    expect_refused("X=(1+2", "NC0501", 1, 7);
    expect_refused("X=1+*2", "NC0501", 1, 5);
    expect_refused("IF R1>5 AND R2<3 GOTOF A", "NC0501", 1, 15);
    expect_refused("X=FOO+1", "NC0502", 1, 3);
    expect_refused("X=$AA_IM[X]", "NC0503", 1, 3);
    expect_refused("$P_UIFR[1]=CTRANS(X,10)", "NC0504", 1, 1);
    expect_refused("$TC_DP1[1,1]=120", "NC0504", 1, 1);
    expect_refused("$AA_IM", "NC0503", 1, 1);
    expect_refused("X=FOO(1)", "NC0505", 1, 3);
    expect_refused("X=\"a\"+1", "NC0506", 1, 6);
    expect_refused("X=-\"a\"", "NC0506", 1, 3);
    expect_refused("R1=\"a\"", "NC0506", 1, 4);
    expect_refused("X=1==\"a\"", "NC0506", 1, 4);
    expect_refused("X=\"a\"<\"b\"", "NC0506", 1, 6);
    expect_refused("X=1.5 MOD 2", "NC0506", 1, 7);
    expect_refused("X=1.5 B_AND 2", "NC0506", 1, 7);
    expect_refused("X=1/0", "NC0507", 1, 4);
    expect_refused("X=1 DIV R0", "NC0507", 1, 5);
    expect_refused("X=1 MOD 0", "NC0507", 1, 5);
    expect_refused("X=SQRT(-1)", "NC0508", 1, 3);
    expect_refused("X=ASIN(2)", "NC0508", 1, 3);
    expect_refused("X=ACOS(-1.1)", "NC0508", 1, 3);
    expect_refused("X=TAN(90)", "NC0508", 1, 3);
    expect_refused("X=LN(0)", "NC0508", 1, 3);
    expect_refused("X=ATAN2(0,0)", "NC0508", 1, 3);
    expect_refused("X=BOUND(5,1,3)", "NC0508", 1, 3);
    expect_refused("X=EXP(1000)", "NC0509", 1, 3);
    expect_refused("R1=1EX300\nX=R1*R1", "NC0509", 2, 5);
    expect_refused("X=R1000", "NC0510", 1, 3);
    expect_refused("X=R[-1]", "NC0510", 1, 5);
    expect_refused("R[0.5]=1", "NC0510", 1, 3);
    expect_refused("X=ATAN2(1)", "NC0514", 1, 3);
    expect_refused("X=SIN(1,2)", "NC0514", 1, 3);
    expect_refused("X=" + std::string(1000, '(') + "1", "NC0543", 1, 68);
    expect_refused("X=" + std::string(1000, '-') + "1", "NC0543", 1, 68);
    expect_refused("R1", "NC0501", 1, 3);
}

TEST(SinumerikVariables, KindsAndConversions) {
    expect_blocks("DEF REAL AA, BB=1.5\nDEF INT CC=2.5, DD=-1.4\nX=AA Y=BB Z=CC A=DD", "X0 Y1.5 Z3 A-1");
    expect_blocks("DEF BOOL BO=5\nDEF CHAR CH=\"A\"\nX=BO Y=CH\nBO=\"\"\nX=BO", "X1 Y65 | X0");
    expect_blocks("DEF STRING[8] NAME=\"Mill\"\nT=NAME\nNAME=NAME<<1\nT=NAME", "T\"Mill\" | T\"Mill1\"");
    expect_blocks("DEF AXIS AX=X, AY\nAY=y\nFGROUP(AX,AY) FGREF[AX]=2", "FGROUP(X,Y) FGREF[X]=2");
    expect_blocks("def real _camtol\n_camtol=.02\nCYCLE832(_camtol,1)", "CYCLE832(0.02,1)");
}

TEST(SinumerikVariables, Arrays) {
    expect_blocks("DEF REAL AA[4]=SET(1,2,,4)\nX=AA[0] Y=AA[1] Z=AA[2] A=AA[3]", "X1 Y2 Z0 A4");
    expect_blocks("DEF INT AA[2,3]=(1,2,3,4,5,6)\nX=AA[1,0] Y=AA[0,2]", "X4 Y3");
    expect_blocks("DEF REAL AA[4]=REP(7)\nAA[1]=SET(1,2)\nX=AA[0] Y=AA[1] Z=AA[2] A=AA[3]", "X7 Y1 Z2 A7");
    expect_blocks("DEF REAL AA[4]\nAA[1]=REP(5,2)\nR1=3\nAA[R1]=AA[1]*2\nX=AA[0] Y=AA[2] Z=AA[3]", "X0 Y5 Z10");
}

TEST(SinumerikVariables, Refusals) {
    expect_refused("DEF FRAME FF", "NC0511", 1, 5);
    expect_refused("DEF NCK REAL FF", "NC0511", 1, 5);
    expect_refused("DEF REAL X", "NC0511", 1, 10);
    expect_refused("DEF REAL R1", "NC0511", 1, 10);
    expect_refused("DEF REAL 5", "NC0511", 1, 10);
    expect_refused("DEF REAL AA[2,2,2,2]", "NC0511", 1, 19);
    expect_refused("DEF REAL AA, AA", "NC0512", 1, 14);
    expect_refused("DEF REAL AA\nDEF INT AA", "NC0512", 2, 9);
    expect_refused("DEF REAL TRAORI", "NC0512", 1, 10);
    expect_refused("DEF REAL AC", "NC0512", 1, 10);
    expect_refused("DEF REAL SET", "NC0512", 1, 10);
    expect_refused("DEF REAL SIN", "NC0512", 1, 10);
    expect_refused("DEF REAL LOOP", "NC0512", 1, 10);
    expect_refused("DEF REAL AA BB", "NC0524", 1, 13);
    expect_refused("X1 DEF REAL AA", "NC0524", 1, 4);
    expect_refused("DEF STRING SS", "NC0501", 1, 12);
    expect_refused("DEF STRING[300] SS", "NC0510", 1, 12);
    expect_refused("DEF REAL AA[0]", "NC0510", 1, 13);
    expect_refused("DEF REAL AA[2]\nX=AA[2]", "NC0510", 2, 6);
    expect_refused("DEF REAL AA[2]\nX=AA", "NC0514", 2, 3);
    expect_refused("DEF REAL AA\nX=AA[0]", "NC0514", 2, 3);
    expect_refused("DEF REAL AA[2]=SET(1,2,3)", "NC0514", 1, 24);
    expect_refused("DEF REAL AA[2]=5", "NC0501", 1, 16);
    expect_refused("DEF REAL AA=\"t\"", "NC0506", 1, 13);
    expect_refused("DEF AXIS AX=5", "NC0506", 1, 13);
    expect_refused("DEF INT II=3000000000", "NC0513", 1, 12);
    expect_refused("DEF CHAR CC=256", "NC0513", 1, 13);
    expect_refused("DEF STRING[2] SS=\"abc\"", "NC0513", 1, 18);
    expect_refused("DEF REAL AA[1000000]\nDEF REAL BB[1]", "NC0544", 2, 10);
    expect_refused("AA=1", "NC0502", 1, 1);
    expect_refused("AA[1]=1", "NC0502", 1, 1);
}

TEST(SinumerikFlow, Jumps) {
    expect_blocks("X1\nGOTOF ENDE\nX2\nENDE: X3", "X1 | X3");
    expect_blocks("R1=0\nAGAIN:\nR1=R1+1\nX=R1\nIF R1<3 GOTOB AGAIN\nX9", "X1 | X2 | X3 | X9");
    expect_blocks("GOTOF N30\nN20 X2\nN30 X3", "X3");
    expect_blocks("GOTOF N30\nN20 X2\nN30X3", "X3");
    expect_blocks("GOTO AA\nX1\nAA: X2\nGOTO BB\nX3\nBB: X4", "X2 | X4");
    expect_blocks("R1=R1+1\nAA: X=R1\nR1=R1+1\nIF R1<4 GOTO AA\nX9", "X1 | X2 | X3 | X9");
    expect_blocks("GOTOC NOWHERE\nX1", "X1");
    expect_blocks("R1=R1+1\nX=R1\nIF R1<3 GOTOS\nX9", "X1 | X2 | X3 | X9");
    expect_blocks("R1=2\nGOTOF \"L_\"<<R1\nL_1: X1\nL_2: X2", "X2");
    expect_blocks("DEF STRING[9] TO_=\"l_2\"\nGOTOF TO_\nL_1: X1\nL_2: X2", "X2");
    expect_blocks("X1 R1=1 GOTOF AA\nX2\nAA: X=R1+2", "X1 | X3");
    expect_blocks("R1=2\nIF R1==1 GOTOF AA IF R1==2 GOTOF BB\nX0\nAA: X1\nBB: X2", "X2");
    expect_blocks("AA: X1\nX2\nGOTOF AA\nAA: X3", "X1 | X2 | X3");
    expect_blocks("R1=2\nCASE R1 OF 1 GOTOF AA 2 GOTOF BB DEFAULT GOTOF CC\nAA: X1\nBB: X2\nCC: X3", "X2 | X3");
    expect_blocks("R1=7\nCASE(R1) OF 1 GOTOF AA DEFAULT GOTOF CC\nAA: X1\nCC: X3", "X3");
    expect_blocks("R1=7\nCASE R1 OF 1 GOTOF AA\nX0\nAA: X1", "X0 | X1");
}

TEST(SinumerikFlow, Structures) {
    constexpr std::string_view choice = "IF R1==1\nX1\nIF R2\nX2\nENDIF\nELSE\nX3\nENDIF\nX4\n";
    expect_blocks("R1=1 R2=1\n" + std::string(choice), "X1 | X2 | X4");
    expect_blocks("R1=1\n" + std::string(choice), "X1 | X4");
    expect_blocks("R2=1\n" + std::string(choice), "X3 | X4");
    expect_blocks("DEF INT II\nFOR II=1 TO 3\nX=II\nENDFOR\nX=II", "X1 | X2 | X3 | X4");
    expect_blocks("FOR R1=3 TO 1\nX=R1\nENDFOR\nX9", "X9");
    expect_blocks("DEF INT II,JJ\nFOR II=0 TO 1\nFOR JJ=II TO 1\nX=II Y=JJ\nENDFOR\nENDFOR", "X0 Y0 | X0 Y1 | X1 Y1");
    expect_blocks("WHILE R1<2\nR1=R1+1\nX=R1\nENDWHILE\nX9", "X1 | X2 | X9");
    expect_blocks("WHILE FALSE\nX1\nENDWHILE\nX9", "X9");
    expect_blocks("REPEAT\nR1=R1+1\nX=R1\nUNTIL R1>=2\nX9", "X1 | X2 | X9");
    expect_blocks("LOOP\nR1=R1+1\nX=R1\nIF R1==2 GOTOF OUT\nENDLOOP\nOUT: X9", "X1 | X2 | X9");
    expect_blocks("R1=0.1\nWHILE R1<1\nX=R1\nR1=R1+0.3\nENDWHILE", "X0.1 | X0.4 | X0.7");
    expect_blocks("N10 START: IF R1 == 0\nX1\nN30 ENDIF", "X1");
}

TEST(SinumerikFlow, RepeatedParts) {
    expect_blocks("AA: X1\nX2\nREPEAT AA\nX3", "X1 | X2 | X1 | X2 | X3");
    expect_blocks("AA: X1\nREPEAT AA P=2\nX3", "X1 | X1 | X1 | X3");
    expect_blocks("AA: X1\nBB: X2\nX3\nREPEAT AA BB P2\nX9", "X1 | X2 | X3 | X1 | X2 | X1 | X2 | X9");
    expect_blocks("AA: X1\nENDLABEL: X2\nX3\nREPEAT AA\nX9", "X1 | X2 | X3 | X1 | X2 | X9");
    expect_blocks("AA: X1\nX2\nREPEATB AA P=2\nX9", "X1 | X2 | X1 | X1 | X9");
    expect_blocks("REPEATB AA\nX5\nAA: X1", "X1 | X5 | X1");
    expect_blocks("R1=2\nAA: X1\nREPEAT AA P=R1\nREPEAT AA P=0", "X1 | X1 | X1");
    // one within the other, and a part that is left by a jump
    expect_blocks("AA: X1\nREPEATB AA\nREPEAT AA\nX9", "X1 | X1 | X1 | X1 | X9");
    expect_blocks("AA: X1\nR1=R1+1\nIF R1==2 GOTOF BB\nREPEAT AA P=5\nBB: X9", "X1 | X1 | X9");
}

TEST(SinumerikFlow, Refusals) {
    expect_refused("GOTOF AA\nX1", "NC0521", 1, 1);
    expect_refused("AA: X1\nGOTOF AA", "NC0521", 2, 1);
    expect_refused("GOTOB AA\nAA: X1", "NC0521", 1, 1);
    expect_refused("GOTOF N99", "NC0521", 1, 1);
    expect_refused("REPEAT AA", "NC0521", 1, 1);
    expect_refused("AA: X1\nX2\nREPEAT AA BB", "NC0521", 3, 1);
    expect_refused("REPEATB AA", "NC0521", 1, 1);
    expect_refused("IF R1\nX1", "NC0522", 1, 1);
    expect_refused("X1\nENDIF", "NC0522", 2, 1);
    expect_refused("ELSE", "NC0522", 1, 1);
    expect_refused("N10 ENDLOOP", "NC0522", 1, 5);
    expect_refused("IF R1\nELSE\nELSE\nENDIF", "NC0522", 3, 1);
    expect_refused("WHILE R1\nENDFOR", "NC0522", 2, 1);
    expect_refused("LOOP\nIF 1\nENDLOOP", "NC0522", 3, 1);
    expect_refused("REPEAT\nX1", "NC0522", 1, 1);
    expect_refused("UNTIL R1", "NC0522", 1, 1);
    expect_refused("GOTOF AA\nIF R1\nAA: X1\nENDIF", "NC0523", 1, 1);
    expect_refused("IF R1 X1 GOTOF AA\nAA:", "NC0524", 1, 1);
    expect_refused("X1 LOOP\nENDLOOP", "NC0522", 2, 1);
    expect_refused("LOOP X1\nENDLOOP", "NC0524", 1, 6);
    expect_refused("GOTOF", "NC0524", 1, 6);
    expect_refused("FOR R1=1 5\nENDFOR", "NC0524", 1, 10);
    expect_refused("FOR AA=1 TO 5\nENDFOR", "NC0502", 1, 5);
    expect_refused("CASE R1 IN 1 GOTOF AA", "NC0524", 1, 9);
    expect_refused("CASE R1 OF 0 AA", "NC0524", 1, 14);
    expect_refused("R5=3\nFOR R1=1 TO R5\nR5=R5+1\nENDFOR", "NC0525", 2, 5);
    expect_refused("REPEAT AA\nAA: X1", "NC0526", 1, 1);
    expect_refused("AA: X1 REPEAT AA", "NC0524", 1, 8);
    expect_refused("AA: REPEATB AA", "NC0526", 1, 5);
    expect_refused("AA: X1\nREPEAT AA P=-1", "NC0510", 2, 13);
}

TEST(SinumerikFlow, EndlessProgramsEnd) {
    const Limits few{.lines = 1000};
    expect_refused("LOOP\nENDLOOP", "NC0542", 1, 1, few);
    expect_refused("AA: GOTOB AA", "NC0542", 1, 1, few);
    expect_refused("AA: X1\nREPEATB AA P=100000", "NC0542", 1, 1, few);
    expect_refused("SUB P=100000\n%_N_SUB_SPF\n", "NC0542", 1, 1, few);
    // Lines read once do not count.
    std::string many;
    for (int i = 0; i < 5000; ++i) many += "X1\n";
    EXPECT_EQ(carry_out(many, "test", few).error.code, "");
}

TEST(SinumerikSubprograms, InTheSameFile) {
    const Carried carried = carry_out(
        "%_N_MAIN_MPF\n;$PATH=/_N_WKS_DIR\nX1\nSUB\nL100 P2\nM30\n%_N_SUB_SPF\nY1\nM17\n%_N_L100_SPF\nY2 M17\nY3\n");
    EXPECT_EQ(carried.error.code, "") << to_string(carried.error);
    EXPECT_EQ(carried.blocks, "X1 | Y1 | Y2 | Y2 | M30");
    EXPECT_EQ(carried.lines, "3 8 11 11 6");
    expect_blocks("%_N_SUB_SPF\nY1\nRET\n%_N_MAIN_MPF\nX1\nSUB P=2\nP2 SUB\nM2\nX9", "X1 | Y1 | Y1 | Y1 | Y1 | M2");
    expect_blocks("CALL \"sub\"\nCALL \"_N_SUB_SPF\"\nM17\n%_N_SUB_SPF\nR1=R1+1\nX=R1 M30", "X1 | X2 | M17");
    expect_blocks("SUB\nX2\n%_N_SUB_SPF\nPROC SUB\nX1\nENDPROC\nX3", "X1 | X2");
    expect_blocks("; a comment\n%\n%_N_SUB_SPF\nX1\n", "X1");
    expect_blocks("SUB\n%SUB_SPF\nX1\n", "X1");
    expect_blocks("EXTERN SUB(REAL)\nSUB(3)\n%_N_SUB_SPF\nPROC SUB(REAL AA) SBLOF DISPLOF\nX=AA\nRET", "X3");
}

TEST(SinumerikSubprograms, Parameters) {
    const auto with = [](std::string_view call, std::string_view proc, std::string_view body) {
        return fmt::format("DEF REAL VV=1\nDEF STRING[5] SS=\"t\"\n{}\nA=VV\n%_N_SUB_SPF\n{}\n{}\nRET\n", call, proc,
                           body);
    };
    expect_blocks(with("SUB(1,2.6,\"ab\")", "PROC SUB(REAL AA, INT BB, STRING[3] CC)", "X=AA Y=BB T=CC"),
                  "X1 Y3 T\"ab\" | A1");
    expect_blocks(with("SUB(,5)", "PROC SUB(REAL AA, REAL BB=2, REAL CC=3)", "X=AA Y=BB Z=CC"), "X0 Y5 Z3 | A1");
    expect_blocks(with("SUB(VV)", "PROC SUB(VAR REAL AA)", "AA=AA+4"), "A5");
    expect_blocks(with("SUB(VV) P2", "PROC SUB(VAR REAL AA)", "AA=AA+4"), "A5");
    expect_blocks(with("SUB(VV)", "PROC SUB(REAL AA)", "AA=AA+4"), "A1");
    expect_blocks(with("SUB(X)", "PROC SUB(AXIS AA)", "FGROUP(AA)"), "FGROUP(X) | A1");
    // Variables are those of one program, R parameters those of all.
    expect_blocks("R1=5\nSUB\nX=R1\n%_N_SUB_SPF\nDEF REAL VV=2\nR1=R1+VV", "X7");
    expect_refused(with("SUB", "", "X=VV"), "NC0502", 7, 3);
    expect_refused(with("SUB(1)", "", "X1"), "NC0534", 7, 1);
    expect_refused(with("SUB(1,2)", "PROC SUB(REAL AA)", ""), "NC0534", 6, 1);
    expect_refused(with("SUB(1)", "PROC SUB(VAR REAL AA)", ""), "NC0534", 6, 14);
    expect_refused(with("SUB()", "PROC SUB(AXIS AA)", ""), "NC0534", 6, 10);
    expect_refused(with("SUB(SS)", "PROC SUB(REAL AA)", ""), "NC0506", 6, 10);
    expect_refused(with("SUB(1)", "PROC SUB(REAL AA[3])", ""), "NC0535", 6, 10);
    expect_refused(with("SUB", "PROC SUB SAVE", ""), "NC0535", 6, 10);
    expect_refused(with("SUB", "PROC SUB WHATEVER", ""), "NC0535", 6, 10);
    expect_refused(with("SUB", "X1\nPROC SUB", ""), "NC0535", 7, 1);
}

TEST(SinumerikSubprograms, Refusals) {
    expect_refused("X1\nL54", "NC0531", 2, 1);
    expect_refused("FAZOWANIE(1,2,,3)", "NC0531", 1, 1);
    expect_refused("G1 X10 FOOBAR", "NC0531", 1, 8);
    expect_refused("FOOBAR X10", "NC0531", 1, 1);
    expect_refused("PROC MAIN(REAL AA)\nX=AA", "NC0534", 1, 1);
    expect_refused("MCALL FAZOWANIE(1,2,,3)", "NC0531", 1, 7);
    expect_refused("MCALL 5", "NC0531", 1, 7);
    expect_refused("CALL \"../x\"", "NC0532", 1, 6);
    expect_refused("CALL \"/tmp/x.SPF\"", "NC0532", 1, 6);
    expect_refused("CALL \"a\\x\"", "NC0532", 1, 6);
    expect_refused("CALL 5", "NC0506", 1, 6);
    expect_refused("X1 SUB\n%_N_SUB_SPF\n", "NC0536", 1, 4);
    expect_refused("SUB X1\n%_N_SUB_SPF\n", "NC0536", 1, 5);
    expect_refused("P2.5 SUB\n%_N_SUB_SPF\n", "NC0510", 1, 1);
    expect_refused("PCALL \"x\"", "NC0537", 1, 1);
    expect_refused("CALL BLOCK AA TO BB", "NC0537", 1, 1);
    expect_refused("RET(\"x\")", "NC0537", 1, 1);
    expect_refused("SUB\n%_N_SUB_SPF\nSUB\n", "NC0541", 3, 1);
}

TEST(SinumerikSubprograms, SixteenWithinEachOther) {
    const auto nested = [](int depth) {
        std::string text = "SUB_1\n";
        for (int i = 1; i <= depth; ++i)
            text += fmt::format("%_N_SUB_{}_SPF\n{}\n", i, i < depth ? fmt::format("SUB_{}", i + 1) : "X1");
        return text;
    };
    expect_blocks(nested(16), "X1");
    EXPECT_EQ(carry_out(nested(17)).error.code, "NC0541");
}

TEST(SinumerikText, SizesAreBounded) {
    std::string words, arguments = "CYCLE81(0";
    for (int i = 0; i < 1000; ++i) words += "X1", arguments += ",0";
    EXPECT_EQ(carry_out(words).error.code, "");
    EXPECT_EQ(carry_out(words + "X1").error.code, "NC0545");
    EXPECT_EQ(carry_out(arguments + ")").error.code, "NC0545");
    std::string text = "T=\"a\"";
    for (int i = 0; i < 10000; ++i) text += "<<1";
    EXPECT_EQ(carry_out(text).error.code, "NC0545");
}

/// A folder with a main program that is removed again.
class SinumerikFolder : public testing::Test {
  protected:
    void SetUp() override {
        const auto* const test = testing::UnitTest::GetInstance()->current_test_info();
        root_ = std::filesystem::temp_directory_path() /
                fmt::format("trunnion_{}_{}", test->name(), std::random_device{}());
        std::filesystem::create_directories(root_ / "programs");
    }
    void TearDown() override {
        std::error_code ignored;
        std::filesystem::remove_all(root_, ignored);
    }
    void write(const std::string& name, std::string_view text) const {
        std::ofstream(root_ / name, std::ios::binary) << text;
    }
    Carried run(std::string_view text) const {
        write("programs/main.mpf", text);
        return carry_out(text, (root_ / "programs/main.mpf").string());
    }
    std::filesystem::path root_;
};

TEST_F(SinumerikFolder, SubprogramsBesideTheMainProgram) {
    write("programs/sub.spf", "PROC SUB(REAL AA)\r\nX=AA\r\nDEEPER\r\nM17\r\n");
    write("programs/Deeper.Mpf", "\xef\xbb\xbf%_N_DEEPER_MPF\nX7\nINNER\n%_N_INNER_SPF\nX8\n");
    write("programs/L54.SPF", "Y54\n");
    const Carried carried = run("X0\nSUB(5)\nL54\nCALL \"sub.SPF\"\n");
    EXPECT_EQ(carried.error.code, "") << to_string(carried.error);
    EXPECT_EQ(carried.blocks, "X0 | X5 | X7 | X8 | Y54 | X0 | X7 | X8");
    EXPECT_EQ(carried.lines, "1 2 2 2 3 4 4 4");
    EXPECT_EQ(carried.places, "1 2 2 5 1 2 2 5");
}

TEST_F(SinumerikFolder, ErrorsSayTheirFile) {
    write("programs/SUB.SPF", "X1\nX=1/0\n");
    const Carried carried = run("X0\nSUB\n");
    EXPECT_EQ(carried.error.code, "NC0507");
    EXPECT_EQ(carried.error.place.file, (root_ / "programs/SUB.SPF").string());
    EXPECT_EQ(carried.error.place.line, 2);
}

TEST_F(SinumerikFolder, Refusals) {
    write("outside.spf", "X1\n");
    write("programs/binary.spf", std::string_view("X1\0", 3));
    std::error_code error;
    std::filesystem::create_symlink(root_ / "outside.spf", root_ / "programs/leak.spf", error);
    ASSERT_FALSE(error);
    std::filesystem::create_directory(root_ / "programs/folder.spf");
    EXPECT_EQ(run("OUTSIDE").error.code, "NC0531");
    EXPECT_EQ(run("LEAK").error.code, "NC0532");
    EXPECT_EQ(run("CALL \"../OUTSIDE\"").error.code, "NC0532");
    EXPECT_EQ(run("BINARY").error.code, "NC0533");
    EXPECT_EQ(run("FOLDER").error.code, "NC0533");
    EXPECT_EQ(run("MAIN").error.code, "NC0541");
    write("programs/TWICE.SPF", "");
    write("programs/twice.spf", "");
    if (!std::filesystem::equivalent(root_ / "programs/TWICE.SPF", root_ / "programs/twice.spf")) {
        EXPECT_EQ(run("TWICE").error.code, "NC0533");
    }
    // Without a file there is no folder either, whatever lies in the one that is current.
    EXPECT_EQ(carry_out("L54", (root_ / "programs/none.mpf").string()).error.code, "NC0531");
}

TEST(SinumerikRealFiles, AreCarriedOut) {
    const std::filesystem::path folder = std::filesystem::path(TRUNNION_SHARED_DIR) / "data/nc/siemens";
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no shared data";
    const auto carried_out = [&](const char* name) {
        std::ifstream stream(folder / name, std::ios::binary);
        const std::string text{std::istreambuf_iterator<char>(stream), {}};
        return carry_out(text, (folder / name).string());
    };
    for (const char* const name : {"achskreuz_spinner_u5620.mpf", "dmu70evo_840d_in.mpf", "huron_kx20_training.mpf",
                                   "schluesselanhaenger_spinner_u5620.mpf"})
        EXPECT_EQ(carried_out(name).error.code, "") << name;
    // It calls subprograms that are not with it.
    EXPECT_EQ(carried_out("edytornc_sinumerik840d.nc").error.code, "NC0531");
}

TEST(SinumerikMutation, AnyTextEnds) {
    constexpr std::string_view seed =
        "%_N_MAIN_MPF\nN10 DEF REAL AA=1.5, BB[3]=SET(1,2,3)\nDEF STRING[9] SS=\"t\"\nN20 G0X1Y=R1+2*SIN(AA) T=SS<<1\n"
        "FOR R1=1 TO 3\nIF (R1==2) AND NOT FALSE\nBB[1]=REP(2,2)\nELSE\nX=AC(-BB[R1-1])\nENDIF\nENDFOR\n"
        "AG: R2=R2+1\nIF R2<3 GOTOB AG\nREPEAT\nR3=R3+1\nUNTIL R3>2\nWHILE R4<2\nR4=R4+1\nENDWHILE\nREPEAT AG P=2\n"
        "CASE R2 OF 1 GOTOF AG 3 GOTOF ZZ DEFAULT GOTOF ZZ\nZZ: SUB(AA,2) P2\nMCALL CYCLE81(1,,\"a\")\n/X1\nM30\n"
        "%_N_SUB_SPF\nPROC SUB(VAR REAL AA, INT BB=1) SBLOF\nAA=AA+BB\nFGREF[C]=1 M2=3\nRET\n";
    constexpr std::string_view pieces[] = {
        "(",  ")",        "[",    "]",           "=",      "\n",  "\"", ",",        "R",    "1",   "-",
        "<<", "GOTOB AG", "P=9",  "ENDIF",       "LOOP\n", "$A",  ":",  "SUB",      "\xff", "EX9", "/",
        "%",  "'",        "NOT ", "99999999999", "N20",    "IF ", ";",  "DEF INT ", "M17",  " "};
    ASSERT_EQ(carry_out(seed).error.code, "") << to_string(carry_out(seed).error);
    Random random{0x5DEECE66D1234567u};
    int carried_through = 0;
    for (int round = 0; round < 4000; ++round) {
        std::string text(seed);
        const std::size_t edits = 1 + random.below(3);
        for (std::size_t i = 0; i < edits; ++i) {
            const std::size_t at = random.below(text.size());
            const std::size_t cut = random.below(4);
            const std::size_t piece = random.below(std::size(pieces));
            text.replace(at, cut, pieces[piece]);
        }
        carried_through += carry_out(text, "test", {.lines = 2000}).error.code.empty();
    }
    EXPECT_GT(carried_through, 100);
    EXPECT_LT(carried_through, 3000);
}

}  // namespace
}  // namespace trunnion::nc::sinumerik
