#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"

#include "reading.hpp"

namespace trunnion::nc {
namespace {

using program::EventKind;
using program::FeedRule;
using program::MoveKind;
using program::Space;

TEST(Rs274, WholeProgram) {
    const auto p = read_ac(
        "%\n"
        "N10 (made by hand) G21 G90 G94 G17 G40 G49 G80 G54\n"
        "T8 M6 S3500 M3\n"
        "G0 X0 Y0 Z10 A0 C0 ; start\n"
        "g1x  1.5y- 2z.5a+30.c111511f600\n"
        "X2\n"
        "G4 P2.5\n"
        "M8\n"
        "/X99\n"
        "G1 A45\n"
        "M1\n"
        "G55 X0 Y0 Z0\n"
        "M30\n"
        "G1 X9\n"
        "%\n");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->dialect, "rs274");
    EXPECT_EQ(p->rotary_letters, (std::vector<char>{'A', 'C'}));
    ASSERT_EQ(p->moves.size(), 5u);
    EXPECT_EQ(p->moves[1].position_mm, Eigen::Vector3d(1.5, -2, .5));
    EXPECT_DOUBLE_EQ(p->moves[1].rotary_rad[0], 30 * degree);
    EXPECT_DOUBLE_EQ(p->moves[1].rotary_rad[1], 111511 * degree) << "rotary words are literal";
    EXPECT_EQ(p->moves[1].feed, (program::Feed{FeedRule::tip_speed, 10}));
    EXPECT_EQ(p->moves[1].law, program::OrientationLaw::rotary);
    EXPECT_EQ(p->moves[1].line, 5);
    EXPECT_EQ(p->moves[2].position_mm, Eigen::Vector3d(2, -2, .5)) << "modal motion";
    EXPECT_EQ(p->moves[3].feed.rule, FeedRule::rotary_rate);
    EXPECT_DOUBLE_EQ(p->moves[3].feed.value, 10 * degree);
    EXPECT_EQ(p->tools.at(p->moves[1].tool), "8");
    EXPECT_EQ(p->offsets.at(p->moves[3].offset), "G54");
    EXPECT_EQ(p->offsets.at(p->moves[4].offset), "G55");

    const std::vector<std::tuple<std::string, EventKind, bool, std::size_t>> expected = {
        {"S3500", EventKind::spindle, false, 0}, {"T8", EventKind::tool, false, 0},
        {"M6", EventKind::tool, true, 0},        {"M3", EventKind::spindle, true, 0},
        {"G4 P2.5", EventKind::dwell, true, 3},  {"M8", EventKind::coolant, false, 3},
        {"M1", EventKind::stop, true, 4},        {"M30", EventKind::stop, true, 5}};
    ASSERT_EQ(p->events.size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
        const program::Event& e = p->events[i];
        EXPECT_EQ((std::tuple{e.word, e.kind, e.stops_motion, e.before_move}), expected[i]);
    }
    EXPECT_EQ(p->events[4].dwell_s, 2.5);
    EXPECT_TRUE(told(*p, "NC0016"));
    EXPECT_TRUE(told(*p, "NC0014"));
    EXPECT_EQ(p->diagnostics.size(), 2u);
}

TEST(Rs274, BlanksMeanNothingEvenInNumbers) {
    const auto p = read_ac("G 2 1\nG0 X0 Y0 Z0\nG1 X 1 2 . 5 Y - 1 F6 0\n");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->moves.at(1).position_mm, Eigen::Vector3d(12.5, -1, 0));
    EXPECT_DOUBLE_EQ(p->moves[1].feed.value, 1);
}

TEST(Rs274, StartsAtTheFirstPoseThatIsKnownWhole) {
    const auto p = read_ac("G21 G0 X0 Y0\nM3\nG0 Z0\nG1 X1 F60\nM8\nG1 X2 C10\nM9\nX3\n");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->rotary_letters, std::vector<char>{'C'});
    ASSERT_EQ(p->moves.size(), 2u);
    EXPECT_EQ(p->moves[0].position_mm.x(), 2);
    EXPECT_DOUBLE_EQ(p->moves[0].rotary_rad[0], 10 * degree);
    EXPECT_EQ(p->moves[0].rotary_rad[1], 0) << "no unknown value is left in a move";
    EXPECT_EQ(told(*p, "NC0013")->count, 3);
    EXPECT_EQ(p->events[0].before_move, 0u);
    EXPECT_EQ(p->events[1].before_move, 0u);
    EXPECT_EQ(p->events[2].before_move, 1u);
}

TEST(Rs274, WithoutRotaryWordsNoMachineIsNeeded) {
    const auto p = read_program("G21 G0 X0 Y0 Z0\nG1 X1 F60\n", "a", {});
    ASSERT_TRUE(p) << said(p);
    EXPECT_TRUE(p->rotary_letters.empty());
    EXPECT_EQ(p->moves[1].law, program::OrientationLaw::rotary);
    EXPECT_TRUE(p->diagnostics.empty());
}

TEST(Rs274, InchScalesLengthsAndFeedsOnly) {
    const auto p = read_ac("G20\nG0 X0 Y0 Z0 A0\nG1 X1 A90 F60\nG1 A0\nG21\nG1 X1\n");
    ASSERT_TRUE(p) << said(p);
    EXPECT_DOUBLE_EQ(p->moves[1].position_mm.x(), 25.4);
    EXPECT_DOUBLE_EQ(p->moves[1].rotary_rad[0], 90 * degree);
    EXPECT_DOUBLE_EQ(p->moves[1].feed.value, 25.4);
    EXPECT_DOUBLE_EQ(p->moves[2].feed.value, degree) << "deg/min in either unit";
    EXPECT_DOUBLE_EQ(p->moves[3].position_mm.x(), 1);
    EXPECT_DOUBLE_EQ(p->moves[3].feed.value, 25.4) << "a change of unit leaves the feed as it is";
}

TEST(Rs274, UnitOverruled) {
    ReadOptions options;
    options.units = Units::mm;
    const auto p = read_ac("G20\nG0 X0 Y0 Z0\nG1 X1 F60\n", options);
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->moves[1].position_mm.x(), 1);
    EXPECT_DOUBLE_EQ(p->moves[1].feed.value, 1);
    EXPECT_TRUE(told(*p, "NC0018"));
    EXPECT_TRUE(told(*read_ac("G0 X0 Y0 Z0\nG1 X1 F60\n"), "NC0011"));
}

TEST(Rs274, FeedBesideAChangeOfUnitCountsInTheOldOne) {
    const auto p = read_ac("G0 X0 Y0 Z0\nG20 G1 X1 F60\n");
    ASSERT_TRUE(p) << said(p);
    EXPECT_DOUBLE_EQ(p->moves[1].feed.value, 1);
    EXPECT_TRUE(told(*p, "NC0017"));
}

TEST(Rs274, Incremental) {
    const auto p = read_ac("G21 G0 X1 Y1 Z1 A10\nG91 G1 X1 A10 F60\nX1 Y-1\nG90 X0\n");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->moves[2].position_mm, Eigen::Vector3d(3, 0, 1));
    EXPECT_DOUBLE_EQ(p->moves[2].rotary_rad[0], 20 * degree);
    EXPECT_EQ(p->moves[3].position_mm, Eigen::Vector3d(0, 0, 1));
}

TEST(Rs274, InverseTime) {
    const auto p = read_ac("G21 G93 G0 X0 Y0 Z0 A0\nG1 X1 F120\nA10 F30\nG0 X5\nG94 G1 X0 F60\n");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->moves[1].feed, (program::Feed{FeedRule::block_time, 0.5}));
    EXPECT_EQ(p->moves[2].feed, (program::Feed{FeedRule::block_time, 2}));
    EXPECT_EQ(p->moves[3].feed.rule, FeedRule::none);
    EXPECT_EQ(p->moves[4].feed, (program::Feed{FeedRule::tip_speed, 1}));
}

TEST(Rs274, FeedGivenElsewhere) {
    ReadOptions options;
    options.feed_given_elsewhere = true;
    const auto p = read_ac("G21 G0 X0 Y0 Z0 A0\nG1 X1\nA5\nG93 X2\n", options);
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->moves[1].feed, (program::Feed{FeedRule::tip_speed, 0}));
    EXPECT_EQ(p->moves[2].feed, (program::Feed{FeedRule::rotary_rate, 0}));
    EXPECT_EQ(p->moves[3].feed, (program::Feed{FeedRule::tip_speed, 0}));
}

TEST(Rs274, WordsOfTheControl) {
    const auto p = read_ac(
        "M428 G21 G0 X0 Y0 Z0 A0 E1\nG1 X1 E2 F60\nM64 P1\nM429\nG0 X5 Y6 Z7\nG53 G0 X0 Y0 Z0\nM428\nG0 X1 Y1 Z1\n");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->following, (std::vector<double>{1, 2, 2, 2, 2}));
    EXPECT_EQ(p->diagnostics.size(), 0u) << "M64 passes silently";
    ASSERT_EQ(p->moves.size(), 5u);
    const Space expected[] = {Space::workpiece, Space::workpiece, Space::untransformed, Space::machine,
                              Space::workpiece};
    for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(p->moves[i].space, expected[i]) << i;
    EXPECT_EQ(p->offsets.at(p->moves[2].offset), "G54");
    EXPECT_EQ(p->moves[3].offset, 0) << "G53 knows no offset";
}

TEST(Rs274, ExactStop) {
    const auto p = read_ac("G21 G0 X0 Y0 Z0\nG61 G1 X1 F60\nX2\nG64 P0.01\nX3\nG61.1 X4\n");
    ASSERT_TRUE(p) << said(p);
    const bool expected[] = {false, true, true, false, true};
    for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(p->moves[i].exact_stop, expected[i]) << i;
    EXPECT_TRUE(told(*p, "NC0012", "G64 P"));
}

TEST(Rs274, ToolsChangeWithM6Only) {
    const auto p = read_ac("G21 T1 M6\nG0 X0 Y0 Z0\nT02\nX1\nM6\nX2\n");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->tools.at(p->moves[1].tool), "1");
    EXPECT_EQ(p->tools.at(p->moves[2].tool), "2");
}

TEST(Rs274, BlocksThatChangeNothingAreLeftOut) {
    const auto p = read_ac("G21 G0 X0 Y0 Z0 C0\nX0\nG1 X1 F60\nX1 Y0\nX1 C0\nC360\n");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->moves.size(), 3u) << "a whole turn is a move";
}

TEST(Rs274, LinuxCncsOwnTcpWordsHoldWhereTheMachineFileDeclaresNone) {
    machine::Machine machine = machine_with("AC");
    machine.words = {};
    const auto program = read_with(machine, "M428 G21 G0 X0 Y0 Z0 A0 C0\nG1 X1 F60\nM429\nG1 X5 Y6 Z7\n");
    ASSERT_TRUE(program) << said(program);
    EXPECT_EQ(program->moves[1].space, program::Space::workpiece);
    EXPECT_EQ(program->moves[2].space, program::Space::untransformed);
    machine.words.tcp_on = {"M140"};
    EXPECT_EQ(read_with(machine, "M428 G21 G0 X0 Y0 Z0 A0 C0\nG1 X1 F60\n").error().code, "NC0204");
}

/// The angle of each move's arc, 0 where it is straight.
std::vector<double> angles_of(const program::Program& p) {
    std::vector<double> out;
    for (const program::Move& move : p.moves)
        out.push_back(move.arc == program::no_arc ? 0 : p.arcs.at(static_cast<std::size_t>(move.arc)).angle_rad);
    return out;
}

void expect_angles(const Result<program::Program>& p, const std::vector<double>& expected) {
    ASSERT_TRUE(p) << said(p);
    const std::vector<double> angles = angles_of(*p);
    ASSERT_EQ(angles.size(), expected.size());
    for (std::size_t i = 0; i < angles.size(); ++i) EXPECT_NEAR(angles[i], expected[i], 1e-9) << i;
}

constexpr double quarter = std::numbers::pi / 2;

TEST(Rs274Arcs, EveryPlaneInBothSenses) {
    struct Case {
        std::string_view block;
        Eigen::Vector3d normal, centre;
        double angle;
    };
    const Case cases[] = {
        {"G3 X0 Y10 I-10", {0, 0, 1}, {0, 0, 10}, quarter},
        {"G17 G3 X0 Y10 I-10", {0, 0, 1}, {0, 0, 10}, quarter},
        {"G17 G2 X0 Y10 I-10 J0", {0, 0, 1}, {0, 0, 10}, -3 * quarter},
        {"G18 G3 X20 Z0 K-10", {0, 1, 0}, {10, 0, 0}, quarter},
        {"G18 G2 X20 Z0 K-10", {0, 1, 0}, {10, 0, 0}, -3 * quarter},
        {"G18 G3 X0 Z0 I-10", {0, 1, 0}, {0, 0, 10}, quarter},
        {"G19 G3 Y-10 Z0 K-10", {1, 0, 0}, {10, 0, 0}, quarter},
        {"G19 G2 Y-10 Z0 K-10", {1, 0, 0}, {10, 0, 0}, -3 * quarter},
    };
    for (const Case& c : cases) {
        const auto p = read_ac(std::string("G21 G0 X10 Y0 Z10\nF60 ").append(c.block) + "\n");
        ASSERT_TRUE(p) << c.block << said(p);
        ASSERT_EQ(p->arcs.size(), 1u);
        EXPECT_EQ(p->arcs[0].normal, c.normal) << c.block;
        EXPECT_LT((p->arcs[0].centre_mm - c.centre).norm(), 1e-12) << c.block;
        EXPECT_NEAR(p->arcs[0].angle_rad, c.angle, 1e-12) << c.block;
        EXPECT_EQ(p->moves.at(0).arc, program::no_arc);
        EXPECT_EQ(p->moves.at(1).arc, 0);
        EXPECT_EQ(p->moves[1].feed, (program::Feed{FeedRule::tip_speed, 1}));
    }
}

TEST(Rs274Arcs, WholeTurnsAndHelices) {
    expect_angles(read_ac("G21 G0 X10 Y0 Z0\nG2 I-10 F60\nG3 X10 Y0 I-10\nI-10\nG1 X11\nX12\n"),
                  {0, -4 * quarter, 4 * quarter, 4 * quarter, 0, 0});
    expect_angles(read_ac("G21 G0 X10 Y0 Z0\nG3 X0 Y10 Z-5 I-10 P3 F60\nG2 X10 Y0 Z0 R10 P2\n"),
                  {0, 9 * quarter, -5 * quarter});
    expect_angles(read_ac("G21 G0 X10 Y0 Z0\nG93 G2 I-10 Z-3 P1 F60\n"), {0, -4 * quarter});
}

TEST(Rs274Arcs, TheSignOfTheRadiusSaysWhichWayRound) {
    const auto p = read_ac("G21 G0 X10 Y0 Z0\nG3 X0 Y10 R10 F60\nX10 Y0 R-10\nG2 X0 Y10 R10\nX10 Y0 R-10\nX20 R5\n");
    expect_angles(p, {0, quarter, 3 * quarter, -quarter, -3 * quarter, -2 * quarter});
    EXPECT_LT((p->arcs[0].centre_mm).norm(), 1e-12);
    EXPECT_LT((p->arcs[1].centre_mm).norm(), 1e-12);
    EXPECT_LT((p->arcs[2].centre_mm - Eigen::Vector3d(10, 10, 0)).norm(), 1e-12);
    EXPECT_LT((p->arcs[3].centre_mm - Eigen::Vector3d(10, 10, 0)).norm(), 1e-12);
}

TEST(Rs274Arcs, CentresFromTheStartOrFromZero) {
    const auto p = read_ac(
        "G21 G0 X10 Y5 Z0\nG91 G2 X10 Y-10 J-10 F60\nX-10 Y-10 I-10\nG90 G90.1 G3 X20 Y-5 I10 J-5\nG91.1 X10 Y5 "
        "I-10\n");
    expect_angles(p, {0, -quarter, -quarter, quarter, quarter});
    for (const program::Arc& arc : p->arcs) EXPECT_LT((arc.centre_mm - Eigen::Vector3d(10, -5, 0)).norm(), 1e-12);
    EXPECT_LT((p->moves[2].position_mm - Eigen::Vector3d(10, -15, 0)).norm(), 1e-12);
}

TEST(Rs274Arcs, InchesScaleCentreAndTolerance) {
    const auto p = read_ac("G20 G0 X1 Y0 Z0\nG3 X0 Y1.0004 I-1 F60\n");
    expect_angles(p, {0, quarter});
    EXPECT_LT(p->arcs[0].centre_mm.norm(), 1e-12);
    EXPECT_EQ(read_ac("G21 G0 X1 Y0 Z0\nG3 X0 Y1.01 I-1 F60\n").error().code, "NC0207");
    EXPECT_TRUE(read_ac("G20 G0 X1 Y0 Z0\nG3 X0 Y1.0009 I-1 F60\n"));
}

TEST(Rs274Arcs, RotaryWordsTurnAlong) {
    const auto p = read_ac("G21 G0 X10 Y0 Z0 A0 C0\nG3 X0 Y10 I-10 A20 C90 F60\nG3 X10 Y0 I0 J-10 C0\n");
    expect_angles(p, {0, quarter, 3 * quarter});
    EXPECT_DOUBLE_EQ(p->moves[1].rotary_rad[1], 90 * degree);
    EXPECT_DOUBLE_EQ(p->moves[2].rotary_rad[0], 20 * degree);
    EXPECT_EQ(p->moves[1].law, program::OrientationLaw::rotary);
}

TEST(Rs274Arcs, InEverySpace) {
    const auto p = read_ac(
        "G21 G0 X10 Y0 Z0 A0 C0\nM429\nG0 X10 Y0\nG3 X0 Y10 I-10 F60\nG53 G0 X1 Y2\nG53 G2 X3 Y2 I1\nM428\nG0 Y5 "
        "X10\nG2 I-5\n");
    expect_angles(p, {0, 0, quarter, 0, -2 * quarter, 0, -4 * quarter});
    EXPECT_EQ(p->moves[2].space, Space::untransformed);
    EXPECT_EQ(p->moves[4].space, Space::machine);
    EXPECT_EQ(p->arcs[1].centre_mm.head<2>(), Eigen::Vector2d(2, 2));
    EXPECT_TRUE(std::isnan(p->moves[4].position_mm.z())) << "Z stays where it stands, the circle is the same";
    EXPECT_EQ(p->moves[6].space, Space::workpiece);
    for (const program::Arc& arc : p->arcs) EXPECT_TRUE(arc.centre_mm.allFinite());
}

TEST(Rs274Arcs, TheFirstPoseIsNoMotion) {
    const auto p = read_ac("G21 G0 X10 Y0 Z0\nG3 X0 Y10 I-10 A0 C0 F60\nG3 X-10 Y0 J-10\n");
    ASSERT_TRUE(p) << said(p);
    ASSERT_EQ(p->moves.size(), 2u);
    EXPECT_EQ(p->moves[0].arc, program::no_arc);
    EXPECT_NEAR(p->arcs.at(static_cast<std::size_t>(p->moves[1].arc)).angle_rad, quarter, 1e-12);
}

/// Coordinates as text, `-` where the axis stays where it stands.
std::string coordinates_of(const program::Move& move) {
    std::string out;
    for (const double coordinate : move.position_mm)
        out += std::isnan(coordinate) ? "- " : fmt::format("{:g} ", coordinate);
    return out;
}

TEST(Rs274Frames, WhatIsNotSaidInAnotherFrameStaysWhereItStands) {
    const auto p = read_ac(
        "G21 G0 X1 Y2 Z3 A0 C0\nG53 G0 Z0\nG53 G0 X5\nG1 Y4 F60\nX7\nM429\nG1 A10\nZ9\nG55\nX8\nM428 G54\nX1 Y1 Z1\n");
    ASSERT_TRUE(p) << said(p);
    const char* const expected[] = {"1 2 3 ", "- - 0 ", "5 - 0 ", "- 4 - ", "7 4 - ",
                                    "- - - ", "- - 9 ", "8 - - ", "1 1 1 "};
    ASSERT_EQ(p->moves.size(), std::size(expected));
    for (std::size_t i = 0; i < std::size(expected); ++i) EXPECT_EQ(coordinates_of(p->moves[i]), expected[i]) << i;
    EXPECT_EQ(p->moves[1].space, Space::machine);
    EXPECT_EQ(p->moves[3].space, Space::workpiece);
    EXPECT_EQ(p->moves[5].space, Space::untransformed);
    EXPECT_EQ(p->moves[5].feed.rule, FeedRule::rotary_rate) << "no linear axis is asked to move";
    EXPECT_EQ(p->moves[6].feed.rule, FeedRule::tip_speed);
    EXPECT_EQ(p->offsets.at(p->moves[7].offset), "G55");
}

TEST(Rs274Frames, TheFirstPoseIsWhole) {
    const auto p = read_ac("G21 G53 G0 Z0\nG0 X1 Y1\nZ5\nG53 G0 Z0 A0\nX2\nX3 Y3 Z3\nC0 X5\nG1 X6 F60\n");
    ASSERT_TRUE(p) << said(p);
    ASSERT_EQ(p->moves.size(), 2u);
    EXPECT_EQ(coordinates_of(p->moves[0]), "5 3 3 ");
    const auto late = read_ac("G21 G0 X1 Y1 Z5 A0\nG53 G0 Z0 C0\nX2\nX3 Y3 Z3\nG1 X6 F60\n");
    ASSERT_TRUE(late) << said(late);
    EXPECT_EQ(coordinates_of(late->moves[0]), "3 3 3 ") << "known whole, not only in its rotary words";
}

TEST(Rs274Tools, LengthByG43) {
    const auto p = read_ac(
        "G21 T8 M6\nG0 X0 Y0 Z0\nG43 H3\nX1 Y1 Z1\nG43\nX2 Y2 Z2\nG43 H3\nT9 M6\nX3 Y3 Z3\nG49\nX4 Y4 Z4\nG43 "
        "H0\nX5\n");
    ASSERT_TRUE(p) << said(p);
    const char* const expected[] = {"8", "3", "8", "3", "9", "9 D0"};
    ASSERT_EQ(p->moves.size(), std::size(expected));
    for (std::size_t i = 0; i < std::size(expected); ++i) EXPECT_EQ(p->tools.at(p->moves[i].tool), expected[i]) << i;
    EXPECT_EQ(coordinates_of(p->moves[5]), "5 - - ") << "with another length the axes stay, not the tip";
}

TEST(Rs274Tools, TheSameCoordinatesWithAnotherToolAreAMove) {
    const auto p = read_ac("G21 T1 M6\nG0 X0 Y0 Z0\nT2 M6\nX0 Y0 Z0\nX0\nG53 X1 Y1 Z1\nT1 M6\nG53 X1 Y1 Z1\n");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->moves.size(), 3u);
}

}  // namespace
}  // namespace trunnion::nc
