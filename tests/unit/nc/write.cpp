// What is written, word by word, and what is refused.
#include "trunnion/nc/write.hpp"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"

#include "reading.hpp"

namespace trunnion::nc {
namespace {

using program::FeedRule;
using program::Move;
using program::MoveKind;
using program::OrientationLaw;
using program::Program;
using program::Space;

/// The lines behind the head, which ends with the line of modal words.
std::string body(const Program& program, WriteOptions options, const machine::Machine* machine = nullptr) {
    const auto text = write_text(program, machine, options);
    if (!text) return to_string(text.error());
    std::size_t begin = 0;
    for (const char* last : {"G17 G40 G54\n", "G90 G94 G64\n", "MULTAX/ON\n", "G80 G49\n", " MM\n"})
        if (const auto at = text->find(last); at != text->npos) {
            begin = at + std::string_view(last).size();
            break;
        }
    return text->substr(begin);
}

WriteOptions to(Dialect dialect) {
    WriteOptions out;
    out.dialect = dialect;
    return out;
}

std::string rs274_of(std::string_view text, WriteOptions options = to(Dialect::rs274)) {
    static const machine::Machine machine = machine_with("AC");
    const auto program = read_ac(text);
    return program ? body(*program, options, &machine) : said(program);
}

std::string sinumerik_of(std::string_view text) {
    static const machine::Machine machine = machine_with("AC");
    const auto program = read_ac(text);
    return program ? body(*program, to(Dialect::sinumerik), &machine) : said(program);
}

Program vectors() {
    const auto program =
        read_program("UNITS/MM\nFEDRAT/600,MMPM\nGOTO/1,2,3,0,0,1\nGOTO/4,2,3,0.6,0,0.8\n", "v.cls", {});
    return *program;
}

TEST(Write, says_what_changes) {
    EXPECT_EQ(rs274_of("G21 G0 X1 Y2 Z3 A0 C0\nG1 X1.5 Y2 F600\nX2 C90.25\nG0 Z10\n"),
              "M428\nG0 X1 Y2 Z3 A0 C0\nG1 X1.5 F600\nX2 C90.25\nG0 Z10\nM2\n");
}

TEST(Write, keeps_the_precision_with_the_fewest_digits) {
    WriteOptions coarse = to(Dialect::rs274);
    coarse.precision_mm = 0.0005;
    coarse.precision_deg = 0.05;
    EXPECT_EQ(rs274_of("G21 G0 X1.23449 Y-0.0004 Z1000000 A0.449 C0\nG1 X2 F123.456\n", coarse),
              "M428\nG0 X1.234 Y0 Z1000000 A0.4 C0\nG1 X2 F123.456\nM2\n");
}

TEST(Write, leaves_out_what_moves_less_than_can_be_said) {
    WriteOptions coarse = to(Dialect::rs274);
    coarse.precision_mm = 0.005;
    EXPECT_EQ(rs274_of("G21 G0 X0 Y0 Z0\nG1 X0.001 F600\nX1\n", coarse), "M428\nG0 X0 Y0 Z0\nG1 X1 F600\nM2\n");
}

TEST(Write, numbers_blocks) {
    WriteOptions options = to(Dialect::rs274);
    options.block_numbers = true;
    EXPECT_NE(rs274_of("G21 G0 X0 Y0 Z0\nG1 X1 F600\n", options).find("N30 G0 X0 Y0 Z0\nN40 G1 X1 F600\nN50 M2\n"),
              std::string::npos);
}

TEST(Write, writes_inches) {
    WriteOptions options = to(Dialect::rs274);
    options.units = Units::inch;
    EXPECT_EQ(rs274_of("G21 G0 X0 Y0 Z0 A0\nG1 X25.4 F254\nA10 F100\n", options),
              "M428\nG0 X0 Y0 Z0 A0\nG1 X1 F10\nA10 F100\nM2\n")
        << "deg/min have no inch";
}

TEST(Write, writes_feeds_by_their_rule) {
    EXPECT_EQ(rs274_of("G21 G0 X0 Y0 Z0 A0\nG93 G1 X1 F120\nX2 A5 F60\nG94 X3 F600\n"),
              "M428\nG0 X0 Y0 Z0 A0\nG1 X1 G93 F120\nX2 A5 F60\nX3 G94 F600\nM2\n");
    WriteOptions inverse = to(Dialect::rs274);
    inverse.inverse_time = true;
    EXPECT_EQ(rs274_of("G21 G0 X0 Y0 Z0\nG1 X10 F600\n", inverse), "M428\nG0 X0 Y0 Z0\nG1 X10 G93 F60\nM2\n");
}

TEST(Write, writes_arcs_in_their_planes) {
    EXPECT_EQ(rs274_of("G21 G0 X0 Y0 Z0\nG2 X10 Y0 I5 J0 F600\nG18 G3 X20 Z0 I5 K0\nG17 G3 X20 Y0 I-5 J0 P2\n"),
              "M428\nG0 X0 Y0 Z0\nG2 X10 I5 J0 F600\nG18 G3 X20 I5 K0\nG17 I-5 J0 P2\nM2\n");
    EXPECT_EQ(sinumerik_of("G21 G0 X0 Y0 Z0\nG2 X10 Y0 Z-3 I5 J0 P2 F600\n"),
              "G54\nTRAORI\nORIAXES\nG0 X0 Y0 Z0\nG2 X10 Z-3 I5 J0 TURN=1 F600\nM30\n");
}

TEST(Write, writes_positions_of_the_machine_and_tcp) {
    const std::string_view text = "G21 M428 G0 X0 Y0 Z0 A0 C0\nG53 G0 Z5\nM429\nG0 X1 Y1 Z9\nG1 X2 F60\n";
    EXPECT_EQ(rs274_of(text), "M428\nG0 X0 Y0 Z0 A0 C0\nG53 Z5\nM429\nX1 Y1 Z9\nG1 X2 F60\nM2\n");
    EXPECT_EQ(sinumerik_of(text),
              "G54\nTRAORI\nORIAXES\nG0 X0 Y0 Z0 A0 C0\nD0\nTRAFOOF\nSUPA Z5\nD1\nX1 Y1 Z9\nG1 X2 F60\nM30\n");
}

TEST(Write, writes_tools_offsets_events_and_stops) {
    EXPECT_EQ(rs274_of("G21 T3 M6\nS500 M3\nG55 G61\nG0 X0 Y0 Z0\nM8\nG1 X1 F60\nG4 P0.5\nG64 P0.01\nX2\nM30\n"),
              "T3\nM6\nS500\nM3\nG61\nM428\nG55\nG0 X0 Y0 Z0\nM8\nG1 X1 F60\nG4 P0.5\nG64 P0.01\nX2\nM30\n");
    EXPECT_EQ(sinumerik_of("G21 T3 M6\nG55 G61\nG0 X0 Y0 Z0\nG1 X1 F60\nG4 P0.5\nM30\n"),
              "T3\nM6\nG55\nTRAORI\nORIAXES\nG9 G0 X0 Y0 Z0\nG9 G1 X1 F60\nG4 F0.5\nM30\n");
}

TEST(Write, writes_vectors) {
    EXPECT_EQ(body(vectors(), to(Dialect::apt)),
              "RAPID\nGOTO/1,2,3,0,0,1\nFEDRAT/600,MMPM\nGOTO/4,2,3,0.6,0,0.8\nFINI\n");
    EXPECT_EQ(body(vectors(), to(Dialect::sinumerik)),
              "TRAORI\nORIWKS ORIVECT\nG0 X1 Y2 Z3 C3=1\nG1 X4 A3=0.6 C3=0.8 F600\nM30\n");
    EXPECT_EQ(body(vectors(), to(Dialect::heidenhain)),
              "1 M128\n2 LN X+1 Y+2 Z+3 TX+0 TY+0 TZ+1 R0 FMAX\n3 LN X+4 Y+2 Z+3 TX+0.6 TY+0 TZ+0.8 R0 F600\n"
              "4 M30\n5 END PGM V MM\n");
    EXPECT_EQ(body(vectors(), to(Dialect::fanuc)),
              "G54\nG43.5 H1\nG0 X1. Y2. Z3. I0. J0. K1.\nG1 X4. I0.6 J0. K0.8 F600.\nM30\n%\n");
}

TEST(Write, writes_the_circles_of_cl_data) {
    const auto program = read_ac("G21 G0 X0 Y0 Z0\nG3 X10 Y0 I5 J0 F600\n");
    EXPECT_EQ(body(*program, to(Dialect::apt)),
              "RAPID\nGOTO/0,0,0\nFEDRAT/600,MMPM\nMOVARC/5,0,0,0,0,1,5,ANGLE,180\nGOTO/10,0,0\nFINI\n");
}

/// A quarter circle about X + Z: only sinumerik and apt have it, the others get chords within the precision.
TEST(Write, divides_what_the_dialect_has_not) {
    Program program = *read_ac("G21 G0 X0 Y0 Z0\nG1 X1 F600\n");
    const Eigen::Vector3d normal = Eigen::Vector3d(1, 0, 1).normalized(), arm(0, 10, 0);
    program.moves[1].arc = 0;
    program.arcs.push_back({-arm, normal, std::numbers::pi / 2});
    program.moves[1].position_mm = -arm + Eigen::AngleAxisd(std::numbers::pi / 2, normal) * arm;
    const machine::Machine machine = machine_with("AC");
    WriteOptions options = to(Dialect::rs274);
    options.precision_mm = 0.01;
    std::string text;
    const auto written = write_program(program, &machine, options, [&](std::string_view piece) { text += piece; });
    ASSERT_TRUE(written);
    ASSERT_EQ(written->diagnostics.size(), 1u);
    EXPECT_EQ(written->diagnostics[0].code, "NC0910");
    const auto read = read_ac(text);
    ASSERT_TRUE(read) << said(read);
    EXPECT_NEAR(static_cast<double>(read->moves.size()), 1 + std::numbers::pi / 2 / (2 * std::acos(1 - 0.001)), 6);
    for (std::size_t k = 1; k < read->moves.size(); ++k) {
        const Eigen::Vector3d middle = 0.5 * (read->moves[k].position_mm + read->moves[k - 1].position_mm) + arm;
        EXPECT_NEAR(middle.norm(), 10, 0.02);
    }
    EXPECT_NE(body(program, to(Dialect::sinumerik), &machine).find("CIP"), std::string::npos);
}

/// Control points from the second on; PL=0 beside both ends.
TEST(Write, writes_curves_as_splines) {
    Program program = vectors();
    program::Curve curve;
    curve.knots = {0, 0, 0, 0, 2, 5, 5, 5, 5};
    for (int i = 0; i < 5; ++i) {
        curve.position_mm.emplace_back(1 + i, 2, 3);
        curve.axis.emplace_back(0.1 * i, 0, 1);
    }
    program.curves = {curve};
    program.curve_parts = {{0, 0, 2}, {0, 2, 5}};
    Move& first = program.moves[1];
    first.curve_part = 0;
    Move second = first;
    second.curve_part = 1;
    second.position_mm = {5, 2, 3};
    second.axis = Eigen::Vector3d(0.4, 0, 1).normalized();
    program.moves.push_back(second);
    EXPECT_EQ(body(program, to(Dialect::sinumerik)),
              "TRAORI\nORIWKS ORICURVE\nG0 X1 Y2 Z3 XH=1 YH=2 ZH=103\n"
              "BSPLINE SD=3 X2 Y2 Z3 XH=12 YH=2 ZH=103 PL=0 F600\nX3 Y2 Z3 XH=23 YH=2 ZH=103 PL=2\n"
              "X4 Y2 Z3 XH=34 YH=2 ZH=103 PL=3\nX5 Y2 Z3 XH=45 YH=2 ZH=103 PL=0\nM30\n");
    EXPECT_NE(body(program, to(Dialect::apt)).find("GOTO/5,2,3"), std::string::npos) << "divided";
}

TEST(Write, tells_what_has_no_word) {
    const machine::Machine machine = machine_with("AC");
    Program program = *read_ac("G21 G61.1 G0 X0 Y0 Z0\nG93 G1 X1 F60\n");
    program.events.push_back({program::EventKind::other, true, 0, "H7", 1, 2});
    std::string text;
    const auto written =
        write_program(program, &machine, to(Dialect::apt), [&](std::string_view piece) { text += piece; });
    ASSERT_TRUE(written) << to_string(written.error());
    std::string codes;
    for (const Diagnostic& diagnostic : written->diagnostics) codes += diagnostic.code + " ";
    EXPECT_EQ(codes, "NC0914 NC0911 NC0913 ");
    EXPECT_NE(text.find("PPRINT/H7\n"), std::string::npos);
    EXPECT_NE(text.find("FEDRAT/60,MMPM\n"), std::string::npos);
}

TEST(Write, makes_comments_harmless) {
    WriteOptions options = to(Dialect::rs274);
    options.head = {"a (b)\nG0 X99"};
    const auto text = write_text(*read_ac("G21 G0 X0 Y0 Z0\nG1 X1 F600\n"), nullptr, options);
    ASSERT_TRUE(text);
    EXPECT_TRUE(text->starts_with("( a [b]?G0 X99)\nG21 "));
}

void expect_refused(const Program& program, WriteOptions options, std::string_view code) {
    const auto text = write_text(program, nullptr, options);
    ASSERT_FALSE(text) << *text;
    EXPECT_EQ(text.error().code, code);
}

TEST(Write, refuses_what_cannot_be_said) {
    const Program words = *read_ac("G21 G0 X0 Y0 Z0 A0 C0\nG1 X1 A5 F600\n");
    WriteOptions none = to(Dialect::rs274);
    none.precision_mm = 0;
    expect_refused(words, none, "NC0901");
    expect_refused(vectors(), to(Dialect::rs274), "NC0902");
    expect_refused(words, to(Dialect::apt), "NC0902");
    Program machine_space = vectors();
    machine_space.moves[1].space = Space::machine;
    expect_refused(machine_space, to(Dialect::apt), "NC0903");
    Program far = vectors();
    far.moves[1].position_mm.x() = 1e300;
    expect_refused(far, to(Dialect::apt), "NC0904");
    Program offset = words;
    offset.offsets[offset.moves[0].offset] = "G599";
    expect_refused(offset, to(Dialect::rs274), "NC0905");
    Program tool = words;
    tool.tools = {"MILL (long)"};
    expect_refused(tool, to(Dialect::rs274), "NC0906");
    Program nowhere = words;
    nowhere.moves[1].arc = 0;
    nowhere.arcs.push_back({{0, 5, 0}, Eigen::Vector3d(1, 1, 1).normalized(), 1});
    nowhere.moves[1].position_mm.x() = std::nan("");
    expect_refused(nowhere, to(Dialect::sinumerik), "NC0907");
}

}  // namespace
}  // namespace trunnion::nc
