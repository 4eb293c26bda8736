#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <unistd.h>

#include "joined.hpp"
#include "sound.hpp"

namespace trunnion::nc {
namespace {

/// Parts end at a rapid behind 5 moves, where motion stands behind 9, never elsewhere.
ReadOptions small_parts(const machine::Machine& machine, std::optional<Dialect> dialect = {}) {
    ReadOptions options;
    options.machine = &machine;
    options.dialect = dialect;
    options.parts = {.to_rapid = 5, .to_stop = 9, .most = 1'000'000};
    return options;
}

const machine::Machine& ac() {
    static const machine::Machine machine = machine_with("AC");
    return machine;
}

std::string lines(int count, std::string_view pattern) {
    std::string text;
    for (int i = 1; i <= count; ++i) text += fmt::format(fmt::runtime(pattern), i, 0.5 * i, -0.25 * i) + "\n";
    return text;
}

struct Dialogue {
    std::string_view name;
    Dialect dialect;
    std::string text;
};

/// Programs of every dialect with rapids, stops, arcs, curves, events, loops, subprograms and a change of frame.
std::vector<Dialogue> programs() {
    std::string apt = "PARTNO parts\nUNITS/MM\nMULTAX/ON\nFEDRAT/500,MMPM\nSPINDL/1000,RPM\n";
    std::string rs274 = "%\nG21 G90 G64 P0.01 Q0.02\nG0 X0 Y0 Z5 A0 C0\nF300 S900 M3\n";
    std::string sinumerik = "G71 G90 G64 G54\nT1 D1\nTRAORI\nG0 X0 Y0 Z5 A0 C0\nF300 S900 M3\n";
    std::string klartext = "0 BEGIN PGM P MM\n1 TOOL CALL 3 Z S900\n2 L X+0 Y+0 Z+5 A+0 C+0 R0 FMAX M128\n3 L F300\n";
    std::string fanuc = "%\nO1234\nG21 G90 G94 G54 G17\nT3 M6\nG43.4 H3\nG0 X0. Y0. Z5. A0. C0.\nF300. S900 M3\n";
    for (int lap = 0; lap < 4; ++lap) {
        apt += lines(4, "GOTO/{0},{1},{2},0,{1},10") + "COOLNT/ON\nRAPID\nGOTO/0,0,50,0,0,1\nRAPID\nGOTO/1,0,50\n" +
               "GOTO/10,0,5\nCIRCLE/0,0,5,0,0,1,10\nGOTO/0,10,5\n" + lines(12, "GOTO/{0},{1},{2}") + "DELAY/2\n";
        rs274 += lines(4, "G1 X{0} Y{1} Z{2} A{0} C{1}") +
                 "M8\nG0 Z50\nG0 X10 Y0\nG64 P0.1\nG1 Z5\nG3 X0 Y10 I-10 J0\n" + lines(6, "G1 X{0} Y{1} A{1}") +
                 "G4 P1\n" + lines(7, "G1 X-{0} Y{1} C{0}") + "G53 G0 Z100\n" +
                 "G0 X0 Y0 Z5 A0 C0\nG5 X5 Y5 I1 J0 P-1 Q0\nG0 Z6\n";
        sinumerik += lines(4, "G1 X{0} Y{1} Z{2} A{0} C{1}") + "M8\nG0 Z50\nG0 X10 Y0\nG1 Z5\nG3 X0 Y10 I-10 J0\n" +
                     lines(6, "G1 X{0} Y{1} A{1}") + "G4 F1\n" + lines(9, "G1 X-{0} Y{1} C{0}") + "G9 X0\nG0 Y0 Z5\n" +
                     "BSPLINE SD=3\n" + lines(12, "X{0} Y{1} Z={2}") + "G0 Z60\n" +
                     lines(6, "G1 X{0} Y{1} Z{2} A3={1} B3=0 C3=5") + "G0 X0 Y0 Z5 A0 C0\n";
        klartext += lines(4, "L X{0:+} Y{1:+} Z{2:+} A{0:+} C{1:+}") + "L M8\nL Z+50 FMAX\nL X+10 Y+0 FMAX\nL Z+5\n" +
                    "CC X+0 Y+0\nC X+0 Y+10 DR+\n" + lines(6, "L X{0:+} Y{1:+} A{1:+}") +
                    "L X+20 Y+0 Z+5 A+0 C+0 FMAX\nL X+0\nCT X-20 Y+20\nSTOP\n" + lines(9, "L X{0:+} Y{1:+} Z{2:+}") +
                    lines(4, "LN X{0:+} Y{1:+} Z{2:+} TX{1:+} TY+0 TZ+5") + "L X+0 Y+0 Z+5 A+0 C+0 FMAX\n";
        fanuc += lines(4, "G1 X{0}. Y{1:.3f} Z{2:.3f} A{0}. C{1:.3f}") + "M8\nG0 Z50.\nG0 X10. Y0.\nG1 Z5.\n" +
                 "G3 X0. Y10. I-10. J0.\n" + lines(6, "G1 X{0}. Y{1:.3f} A{1:.3f}") + "G4 P1000\n" +
                 lines(7, "G1 X-{0}. Y{1:.3f} C{0}.") + "G53 G0 Z100.\nG0 X0. Y0. Z5. A0. C0.\n";
    }
    return {{"apt", Dialect::apt, apt + "FINI\n"},
            {"rs274", Dialect::rs274,
             rs274 + "o100 repeat [5]\nG91\n" + lines(3, "G1 X{0} Y{1}") + "G90\nG0 Z3\no100 endrepeat\nM2\n"},
            {"sinumerik", Dialect::sinumerik,
             sinumerik + "FOR R1=1 TO 5\n" + lines(3, "G1 X=R1+{0} Y={1}") + "G0 Z=R1\nENDFOR\nM30\n"},
            {"heidenhain", Dialect::heidenhain,
             klartext + "LBL 7\n" + lines(3, "L IX{0:+} IY{1:+}") + "L IZ+1 FMAX\nCALL LBL 7 REP 5\nEND PGM P MM\n"},
            {"fanuc", Dialect::fanuc,
             fanuc + "#1=0\nN50 #1=#1+1\n" + lines(3, "G1 X[#1+{0}] Y{1:.3f}") +
                 "G0 Z[#1]\nIF[#1 LT 5]GOTO 50\nM98 P2000 L3\nM30\nO2000\nG91\n" + lines(6, "G1 X{0}. Y1.") +
                 "G90\nG0 Z50.\nM99\n%\n"}};
}

Described whole(const program::Program& program) {
    Described out;
    add(program, out);
    return out;
}

/// Where they differ first.
std::string difference(const std::vector<std::string>& is, const std::vector<std::string>& shall) {
    for (std::size_t i = 0; i < std::max(is.size(), shall.size()); ++i)
        if (i >= is.size() || i >= shall.size() || is[i] != shall[i])
            return fmt::format("{} of {}/{}:\n  {}\n  {}", i, is.size(), shall.size(), i < is.size() ? is[i] : "-",
                               i < shall.size() ? shall[i] : "-");
    return "none";
}

void expect_same(const Described& is, const Described& shall, std::string_view about) {
    EXPECT_EQ(difference(is.moves, shall.moves), "none") << about;
    EXPECT_EQ(difference(is.events, shall.events), "none") << about;
    EXPECT_EQ(difference(is.controls, shall.controls), "none") << about;
    EXPECT_EQ(difference(is.told, shall.told), "none") << about;
}

void expect_known(const program::Program& part) {
    ASSERT_GE(part.moves.size(), 2u);
    const program::Move& start = part.moves.front();
    EXPECT_FALSE(start.position_mm.hasNaN());
    EXPECT_EQ(start.arc, program::no_arc);
    EXPECT_EQ(start.curve_part, program::no_curve_part);
    for (std::size_t i = 0; i < part.rotary_letters.size(); ++i) EXPECT_FALSE(std::isnan(start.rotary_rad[i])) << i;
}

TEST(Parts, JoinedAreTheProgramInEveryDialectAndSize) {
    for (const Dialogue& program : programs()) {
        const FileForTest file(program.name, program.text);
        const ReadOptions options = small_parts(ac(), program.dialect);
        const auto one = read_program_file(file.path(), options);
        ASSERT_TRUE(one) << program.name << ": " << said(one);
        for (const std::size_t size : {1u, 2u, 3u, 7u, 20u, 100u}) {
            ReadOptions sized = options;
            sized.parts = {.to_rapid = size, .to_stop = 2 * size, .most = 1'000'000};
            const JoinedParts read = join_parts(file.path(), sized);
            ASSERT_FALSE(read.error) << program.name << ' ' << to_string(*read.error);
            expect_same(read.joined, whole(*one), fmt::format("{} in parts of {}", program.name, size));
            EXPECT_GT(read.parts.size(), size < 20 ? 3u : 0u) << program.name << size;
            for (const program::Program& part : read.parts) {
                expect_known(part);
                expect_sound(part);
            }
        }
    }
}

TEST(Parts, EndBeforeARapidOrWhereMotionStandsElseNowhere) {
    const std::string text = "G21 G0 X0 Y0 Z0 F100\n" + lines(20, "G1 X{0}") + "G0 Z5\nG1 Z0\nG0 Z5\n" +
                             lines(12, "G1 Y{0}") + "G4 P1\n" + lines(30, "G1 X{1}");
    const FileForTest file("ends.ngc", text);
    const JoinedParts read = join_parts(file.path(), small_parts(ac(), Dialect::rs274));
    ASSERT_FALSE(read.error) << to_string(*read.error);
    ASSERT_EQ(read.parts.size(), 3u);
    EXPECT_EQ(read.parts[0].moves.size(), 21u);
    EXPECT_EQ(read.parts[1].moves[1].kind, program::MoveKind::rapid);
    EXPECT_EQ(read.parts[1].moves.size(), 1u + 3 + 12);
    EXPECT_EQ(read.parts[1].events.back().before_move, read.parts[1].moves.size());
    EXPECT_EQ(read.parts[2].moves.size(), 31u);
    EXPECT_EQ(told(read.parts[2], "NC0019"), nullptr);
}

TEST(Parts, AStandstillIsMadeAndToldWhereNoneComes) {
    const FileForTest file("stop.ngc", "G21 G0 X0 Y0 Z0 F100\n" + lines(100, "G1 X{0}"));
    ReadOptions options = small_parts(ac(), Dialect::rs274);
    options.parts.most = 30;
    const JoinedParts read = join_parts(file.path(), options);
    ASSERT_FALSE(read.error);
    ASSERT_EQ(read.parts.size(), 4u);
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(read.parts[i].moves.size(), 31u);
        EXPECT_TRUE(read.parts[i].moves.back().exact_stop);
        EXPECT_FALSE(read.parts[i].moves[29].exact_stop);
        EXPECT_TRUE(read.parts[i].diagnostics.empty());
    }
    const Diagnostic* const stop = told(read.parts[3], "NC0019");
    ASSERT_TRUE(stop);
    EXPECT_EQ(stop->count, 3);
    EXPECT_EQ(stop->place.line, 31);
    EXPECT_FALSE(told(*read_program_file(file.path(), options), "NC0019"));
}

TEST(Parts, ACurveThatIsCutGoesIntoBothParts) {
    const FileForTest file(
        "curve.mpf", "G71 G90 G64 G0 X0 Y0 Z0\nG1 F600\nBSPLINE SD=3\n" + lines(40, "X{0} Y={1}*{1}") + "G1 Z5\nM30\n");
    ReadOptions options = small_parts(ac(), Dialect::sinumerik);
    options.parts.most = 12;
    const JoinedParts read = join_parts(file.path(), options);
    ASSERT_FALSE(read.error) << to_string(*read.error);
    ASSERT_GE(read.parts.size(), 3u);
    for (const program::Program& part : read.parts) {
        ASSERT_EQ(part.curves.size(), 1u);
        expect_sound(part);
    }
    const auto one = read_program_file(file.path(), options);
    EXPECT_EQ(read.parts[1].curves[0].position_mm, one->curves[0].position_mm);
    EXPECT_EQ(read.joined.moves.size(), one->moves.size());
}

TEST(Parts, ErrorsComeBehindTheGoodPartsBeforeThem) {
    for (const Dialogue& program : programs()) {
        std::string text = program.text;
        const std::size_t late = text.find('\n', text.size() * 3 / 4);
        text.insert(late + 1, "?? what is this\n");
        const FileForTest file(program.name, text);
        const ReadOptions options = small_parts(ac(), program.dialect);
        const auto one = read_program_file(file.path(), options);
        ASSERT_FALSE(one) << program.name;
        const JoinedParts read = join_parts(file.path(), options);
        ASSERT_TRUE(read.error) << program.name;
        EXPECT_EQ(to_string(*read.error), to_string(one.error()));
        EXPECT_GT(read.parts.size(), 1u) << program.name;
        auto parts = open_program_file(file.path(), options);
        program::Program part;
        for (std::size_t i = 0; i < read.parts.size(); ++i) ASSERT_TRUE((*parts)->next(part));
        for (int again = 0; again < 2; ++again) EXPECT_EQ((*parts)->next(part).error().code, one.error().code);
    }
}

std::string_view comment_of(Dialect dialect) {
    if (dialect == Dialect::apt) return "$$ {0} a comment";
    return dialect == Dialect::fanuc ? "({0} a comment)" : "; {0} a comment";
}

TEST(Parts, ANulByteFarBehindIsAnErrorAtItsLine) {
    for (const Dialogue& program : programs()) {
        std::string text = program.text;
        const std::size_t half = text.find('\n', text.size() / 2) + 1;
        text.insert(half, lines(5000, comment_of(program.dialect)));
        const std::size_t at = text.size() * 9 / 10;
        const int line = 1 + static_cast<int>(std::ranges::count(text.substr(0, at), '\n'));
        text[at] = '\0';
        const FileForTest file(program.name, text);
        const JoinedParts read = join_parts(file.path(), small_parts(ac(), program.dialect));
        ASSERT_TRUE(read.error) << program.name;
        EXPECT_EQ(read.error->code, "NC0003") << program.name << ' ' << to_string(*read.error);
        EXPECT_EQ(read.error->place.line, line) << program.name;
        EXPECT_GT(read.parts.size(), 1u) << program.name;
    }
    const FileForTest behind("behind.ngc", "G21 G0 X0 Y0 Z0\nG1 X1 F60\nM2\n" + std::string(100'000, ' ') + '\0');
    EXPECT_EQ(read_program_file(behind.path(), {}).error().code, "NC0003");
}

TEST(Parts, MayBeDroppedAtAnyTime) {
    for (const Dialogue& program : programs()) {
        const FileForTest file(program.name, program.text);
        for (int taken = 0; taken < 3; ++taken) {
            auto parts = open_program_file(file.path(), small_parts(ac(), program.dialect));
            ASSERT_TRUE(parts);
            program::Program part;
            for (int i = 0; i < taken; ++i) ASSERT_TRUE((*parts)->next(part)) << program.name;
        }
    }
}

TEST(Parts, WaitForTheFirstWordOfAnAxis) {
    const std::string before = lines(30, "G1 X{0}") + "G0 Z5\n" + lines(30, "G1 X{0}") + "G0 Z6\n";
    const std::string late =
        "G0 X0 Y0 Z0 A0 F100\n" + before + "G1 C90\n" + lines(30, "G1 X{0} C{1}") + "G0 Z7\nG1 Z0\n";
    for (const Dialect dialect : {Dialect::rs274, Dialect::fanuc, Dialect::sinumerik}) {
        const FileForTest file("late", (dialect == Dialect::sinumerik ? "G71 " : "G21 ") + late);
        const ReadOptions options = small_parts(ac(), dialect);
        const auto one = read_program_file(file.path(), options);
        ASSERT_TRUE(one) << said(one);
        const JoinedParts read = join_parts(file.path(), options);
        ASSERT_FALSE(read.error) << to_string(*read.error);
        expect_same(read.joined, whole(*one), name_of(dialect));
        ASSERT_EQ(read.parts.front().rotary_letters, one->rotary_letters);
    }
    const FileForTest without("without", "G21 G0 X0 Y0 Z0 A0 F100 (NEAR CLAMP C 5)\n" + before + "G1 Z0\n");
    const JoinedParts read = join_parts(without.path(), small_parts(ac(), Dialect::rs274));
    EXPECT_EQ(read.parts.size(), 3u) << "C is in no block: it need not be waited for";
}

TEST(Parts, AnAxisThatAnotherFileSaysFirstIsRefused) {
    const FileForTest sub("sub.ngc", "o<s> sub\nG1 C90\no<s> endsub\n");
    const std::string name = sub.path().stem().string();
    std::ofstream(sub.path()) << fmt::format("o<{0}> sub\nG1 C90\no<{0}> endsub\n", name);
    const std::string calls = fmt::format("o<{}> call\nG1 X5\n", name);
    const std::string start = "G21 G0 X0 Y0 Z0 A0", before = " F100\n" + lines(30, "G1 X{0}") + "G0 Z5\nG1 X3\n";
    const FileForTest file("calls.ngc", start + before + calls), known("known.ngc", start + " C0" + before + calls);
    const ReadOptions options = small_parts(ac(), Dialect::rs274);
    const JoinedParts read = join_parts(file.path(), options);
    ASSERT_TRUE(read.error);
    EXPECT_EQ(read.error->code, "NC0021");
    EXPECT_EQ(read.error->value, "C");
    const JoinedParts good = join_parts(known.path(), options);
    ASSERT_FALSE(good.error) << to_string(*good.error);
    expect_same(good.joined, whole(*read_program_file(known.path(), options)), "known");
}

TEST(Parts, LinesAreCountedUpToTheLastNumber) {
    const FileForTest file("lines.ngc", "G21 G0 X0 Y0 Z0 F100\n" + lines(30, "G1 X{0}"));
    ReadOptions options = small_parts(ac(), Dialect::rs274);
    options.most_lines = 31;
    const JoinedParts read = join_parts(file.path(), options);
    ASSERT_TRUE(read.error);
    EXPECT_EQ(read.error->code, "NC0020");
    EXPECT_EQ(read.error->place.line, 31);
    options.most_lines = 32;
    EXPECT_FALSE(join_parts(file.path(), options).error);
}

TEST(Parts, WhatCannotBeOpenedIsRefusedAtOnce) {
    EXPECT_EQ(open_program_file("/no/such/file.ngc", {}).error().code, "NC0001");
    EXPECT_EQ(open_program_file(std::filesystem::temp_directory_path(), {}).error().code, "NC0001");
    const FileForTest empty("empty", ""), prose("prose", "Information listing\n"),
        nul("nul", std::string("G0 X0\n\0", 7));
    EXPECT_EQ(open_program_file(empty.path(), {}).error().code, "NC0002");
    EXPECT_EQ(open_program_file(prose.path(), {}).error().code, "NC0004");
    EXPECT_EQ(open_program_file(nul.path(), {}).error().code, "NC0003");
}

}  // namespace
}  // namespace trunnion::nc
