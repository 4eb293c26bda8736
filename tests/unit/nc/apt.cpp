#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"

#include "reading.hpp"

namespace trunnion::nc {
namespace {

using program::EventKind;
using program::FeedRule;
using program::MoveKind;

Result<program::Program> read(std::string_view text, Units units = Units::none, bool feed_elsewhere = false) {
    ReadOptions options;
    options.units = units;
    options.feed_given_elsewhere = feed_elsewhere;
    return read_program(text, "dir/part.cls", options);
}

TEST(Apt, WholeProgram) {
    const auto p = read(
        "$$ by hand\n"
        "PARTNO blade 7\n"
        "UNITS / MM\n"
        "LOADTL/8, LENGTH, 100\n"
        "SPINDL / RPM, 8000, CLW\n"
        "MULTAX / ON\n"
        "FROM / 0, 0, 100, 0, 0, 1\n"
        "RAPID\n"
        "GOTO / 0, 0, 10\n"
        "FEDRAT / 600, MMPM\n"
        "GOTO / 1.5, -2., +.5, $ the rest of this line is a comment\n"
        "   $$ so is this line\n"
        " 0.0, 0.6,   $\n"
        "0.8   $$ and this\n"
        "goto/2,0,0\n"
        "DELAY/2.5\n"
        "COOLNT/ON\n"
        "GOTO/3,0,0,1,0,0\n"
        "FINI\n"
        "the rest is not read\n");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->name, "blade 7");
    EXPECT_EQ(p->source, "dir/part.cls");
    EXPECT_EQ(p->dialect, "apt");
    EXPECT_TRUE(p->rotary_letters.empty());
    ASSERT_EQ(p->moves.size(), 5u);
    EXPECT_EQ(p->moves[1].kind, MoveKind::rapid);
    EXPECT_EQ(p->moves[1].feed.rule, FeedRule::none);
    EXPECT_EQ(p->moves[2].kind, MoveKind::feed);
    EXPECT_EQ(p->moves[2].feed, (program::Feed{FeedRule::tip_speed, 10}));
    EXPECT_EQ(p->moves[2].line, 11);
    EXPECT_TRUE(p->moves[2].position_mm.isApprox(Eigen::Vector3d(1.5, -2, .5), 1e-15));
    EXPECT_TRUE(p->moves[2].axis.isApprox(Eigen::Vector3d(0, .6, .8), 1e-15));
    EXPECT_EQ(p->moves[3].axis, p->moves[2].axis) << "three numbers keep the vector";
    EXPECT_EQ(p->moves[4].axis, Eigen::Vector3d::UnitX());
    EXPECT_EQ(p->moves[4].law, program::OrientationLaw::vector);
    EXPECT_EQ(p->tools.at(p->moves[4].tool), "8");
    ASSERT_EQ(p->events.size(), 4u);
    EXPECT_EQ(p->events[0].kind, EventKind::tool);
    EXPECT_EQ(p->events[0].before_move, 0u);
    EXPECT_EQ(p->events[1].word, "SPINDL/RPM, 8000, CLW");
    EXPECT_EQ(p->events[2].dwell_s, 2.5);
    EXPECT_EQ(p->events[2].before_move, 4u);
    EXPECT_TRUE(p->events[2].stops_motion);
    EXPECT_FALSE(p->events[3].stops_motion);
    ASSERT_TRUE(told(*p, "NC0014"));
    EXPECT_EQ(p->diagnostics.size(), 1u);
}

TEST(Apt, FeedWithEitherOrderAndItsOwnUnit) {
    const auto feed_of = [](std::string_view statements, Units units = Units::none) {
        const auto p = read(std::string("GOTO/0,0,0\n").append(statements) + "\nGOTO/1,0,0\n", units);
        return p ? p->moves.at(1).feed.value : -1.0;
    };
    EXPECT_DOUBLE_EQ(feed_of("FEDRAT/600"), 10);
    EXPECT_DOUBLE_EQ(feed_of("FEDRAT/600,MMPM"), 10);
    EXPECT_DOUBLE_EQ(feed_of("FEDRAT / MMPM , 6.E2"), 10);
    EXPECT_DOUBLE_EQ(feed_of("FEDRAT/60,IPM"), inch_mm);
    EXPECT_DOUBLE_EQ(feed_of("UNITS/INCHES\nFEDRAT/60"), inch_mm);
    EXPECT_DOUBLE_EQ(feed_of("UNITS/INCHES\nFEDRAT/60,PERMIN"), inch_mm);
    EXPECT_DOUBLE_EQ(feed_of("UNITS/INCHES\nFEDRAT/60,MMPM"), 1);
    EXPECT_DOUBLE_EQ(feed_of("UNITS/INCHES\nFEDRAT/60", Units::mm), 1);
    EXPECT_DOUBLE_EQ(feed_of("UNITS/INCHES\nFEDRAT/60,IPM", Units::mm), inch_mm)
        << "a feed keeps the unit that it names";
}

TEST(Apt, Units) {
    const auto x_of = [](std::string_view statement, Units units) {
        return read(std::string(statement) + "\nFEDRAT/1\nGOTO/0,0,0\nGOTO/2,0,0\n", units)
            ->moves.at(1)
            .position_mm.x();
    };
    for (const char* unit : {"UNITS/MM", "UNITS / MILLIMETERS", "units/mm"}) {
        EXPECT_EQ(x_of(unit, Units::none), 2);
        EXPECT_EQ(x_of(unit, Units::inch), 50.8);
    }
    for (const char* unit : {"UNITS/INCHES", "UNITS/INCH"}) {
        EXPECT_EQ(x_of(unit, Units::none), 50.8);
        EXPECT_EQ(x_of(unit, Units::mm), 2);
    }
    const auto silent = read("FEDRAT/1\nGOTO/0,0,0\nGOTO/2,0,0\n");
    EXPECT_EQ(silent->moves.at(1).position_mm.x(), 2);
    ASSERT_TRUE(told(*silent, "NC0011"));
    EXPECT_NE(told(*silent, "NC0011")->hint.find("--units"), std::string::npos);
    EXPECT_TRUE(read("FEDRAT/1\nGOTO/0,0,0\nGOTO/2,0,0\n", Units::inch)->diagnostics.empty());
    EXPECT_TRUE(told(*read("UNITS/MM\nFEDRAT/1\nGOTO/0,0,0\nGOTO/2,0,0\n", Units::inch), "NC0018"));
}

TEST(Apt, RapidIsForOneGotoOnly) {
    const auto p = read("UNITS/MM\nFEDRAT/60\nGOTO/0,0,0\nRAPID\nFEDRAT/120\nGOTO/1,0,0\nGOTO/2,0,0\n");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->moves[1].kind, MoveKind::rapid);
    EXPECT_EQ(p->moves[2].kind, MoveKind::feed);
    EXPECT_DOUBLE_EQ(p->moves[2].feed.value, 2);
}

TEST(Apt, BarePoses) {
    for (const char* text :
         {"0,0,0,0,0,1\n1, 2, 3, 0, 1, 0\n", "0 0 0 0 0 1\r\n 1\t2 3 0  1e0 0", "0,0,0\n1,2,3,0,1,0\nFINI\n"}) {
        const auto p = read(text, Units::mm, true);
        ASSERT_TRUE(p) << said(p);
        ASSERT_EQ(p->moves.size(), 2u);
        EXPECT_EQ(p->moves[1].position_mm, Eigen::Vector3d(1, 2, 3));
        EXPECT_EQ(p->moves[1].axis, Eigen::Vector3d::UnitY());
        EXPECT_EQ(p->moves[1].feed, (program::Feed{FeedRule::tip_speed, 0}));
        EXPECT_EQ(p->name, "part");
    }
}

TEST(Apt, IgnoredWordsAreCountedOnceEach) {
    const auto p = read(
        "PPWORD/A,1\nPPWORD/B,2\nMACHIN/X,1\nINTOL/0.01\nCYCLE/OFF\nCUTCOM/OFF\nREMARK $ GODLTA/1\nPPRINT 'x'\n"
        "MSYS/0,0,0,1,0,0,0,1,0\nTOOL PATH/A,TOOL,B\nSYN/'TLAXIS','$$*TLAXIS'\nUNITS/MM\n"
        "FEDRAT/1\nGOTO/0,0,0\nGOTO/2,0,0\nEND-OF-PATH\n");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(told(*p, "NC0012", "PPWORD")->count, 2);
    EXPECT_EQ(told(*p, "NC0012", "PPWORD")->place.line, 1);
    EXPECT_EQ(p->diagnostics.size(), 6u);
}

TEST(Apt, VectorsAreNormalisedAndToldWhenFarFromOne) {
    const auto p = read("UNITS/MM\nFEDRAT/1\nGOTO/0,0,0,0,0,2\nGOTO/1,0,0,0,3,4\nGOTO/2,0,0,0,0.60002,0.8\n");
    ASSERT_TRUE(p) << said(p);
    for (const auto& move : p->moves) EXPECT_NEAR(move.axis.norm(), 1, 1e-15);
    EXPECT_EQ(told(*p, "NC0015")->count, 2);
}

TEST(Apt, ListingInACommentGoesOn) {
    const auto p =
        read("$$-> CSYS / 1., 0., 0., $\n  0., 1., 0.,  $\n 0., 0., 1.\nUNITS/MM\nFEDRAT/1\nGOTO/0,0,0\nGOTO/2,0,0\n");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->moves.size(), 2u);
    const auto poses = read("$$ poses $\n0,0,0\n1,0,0\n", Units::mm, true);
    ASSERT_TRUE(poses) << said(poses);
    EXPECT_EQ(poses->moves.size(), 2u) << "a comment does not swallow poses";
}

TEST(Apt, PosesThatChangeNothingAreLeftOut) {
    const auto p =
        read("UNITS/MM\nFEDRAT/1\nGOTO/0,0,0\nGOTO/0,0,0\nGOTO/1,0,0\nSTOP\nGOTO/1,0,0,0,0,1\nGOTO/1,0,0,1,0,0\n");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->moves.size(), 3u);
    EXPECT_EQ(p->events.at(0).before_move, 2u);
}

TEST(Apt, TheAxisMayBeSetAlone) {
    const auto p = read("UNITS/MM\nFEDRAT/1\nTLAXIS/0,1,0\nGOTO/0,0,0\nMULTAX/OFF\nGOTO/1,0,0\nGOTO/2,0,0,0,1,0\n");
    ASSERT_TRUE(p) << said(p);
    for (const auto& move : p->moves) EXPECT_EQ(move.axis, Eigen::Vector3d::UnitY());
}

/// The angles in degrees of the arcs of a program that starts at 5, 0, 0 with the statements given; 0: a straight move.
std::vector<double> angles_of(std::string_view statements) {
    const auto p = read(std::string("UNITS/MM\nFEDRAT/60\nGOTO/5,0,0,0,0,1\n").append(statements));
    EXPECT_TRUE(p) << statements << "\n" << said(p);
    std::vector<double> out;
    if (!p) return out;
    for (std::size_t i = 1; i < p->moves.size(); ++i) {
        const std::int32_t arc = p->moves[i].arc;
        out.push_back(arc == program::no_arc
                          ? 0
                          : p->arcs.at(static_cast<std::size_t>(arc)).angle_rad *
                                (p->arcs[static_cast<std::size_t>(arc)].normal.z() > 0 ? 1 : -1) / degree);
    }
    return out;
}

void expect_angles(std::string_view statements, const std::vector<double>& expected) {
    const auto angles = angles_of(statements);
    ASSERT_EQ(angles.size(), expected.size()) << statements;
    for (std::size_t i = 0; i < angles.size(); ++i) EXPECT_NEAR(angles[i], expected[i], 1e-9) << statements << i;
}

TEST(AptArcs, OneGotoTurnsInTheRightHandSenseAboutTheNormal) {
    expect_angles("CIRCLE/0,0,0,0,0,1,5\nGOTO/0,5,0\n", {90});
    expect_angles("CIRCLE/0,0,0,0,0,-1,5\nGOTO/0,5,0\n", {-270});
    expect_angles("CIRCLE / 0, 0, 0, $\n 0, 0, 2, 5\nGOTO/0,5,0\nFEDRAT/30\nGOTO/3,4,0\n", {90, 0});
    expect_angles("CIRCLE/0,0,0,0,0,1,5,.002,.5,1,0\nGOTO/0,5,0\nGOTO/-5,0,0\n", {90, 0});
    expect_angles("CIRCLE/0,0,0,0,0,-1,5,.002,.5,1,0\nGOTO/5,0,0\n", {-360});
    expect_angles("MOVARC/0,0,0,0,0,1,5\nGOTO/0,5,-2\nGOTO/0,4,0\n", {90, 0});
    expect_angles("MOVARC/ CENTER, 0,0,0, AXIS, 0,0,1, RADIUS, 5\nGOTO/0,5,0\n", {90});
}

TEST(AptArcs, AnAngleSaysTheSenseAndTheTurns) {
    expect_angles("MOVARC/0,0,0,0,0,1,5,ANGLE,90\nGOTO/0,5,0\n", {90});
    expect_angles("MOVARC/0,0,0,0,0,1,5,ANGLE,270\nGOTO/0,5,0\n", {-270});
    expect_angles("MOVARC/0,0,0,0,0,1,5,ANGLE,-270\nGOTO/0,5,0\n", {-270});
    expect_angles("MOVARC/0,0,0,0,0,-1,5,ANGLE,270\nGOTO/0,5,0\n", {-270});
    expect_angles("MOVARC/0,0,0,0,0,1,5,ANGLE,810\nGOTO/0,5,-3\n", {810});
    expect_angles("MOVARC/0,0,0,0,0,1,5,ANGLE,360\nGOTO/5,0,0\n", {360});
    expect_angles("MOVARC/0,0,0,0,0,1,5,ANGLE,-720\nGOTO/5,0,-1\n", {-720});
    expect_angles("MOVARC/0,0,0,0,0,1,5,ANGLE,180\nGOTO/-5,0,0\n", {180});
}

TEST(AptArcs, SeveralPointsGoTheShorterWay) {
    expect_angles("CIRCLE/0,0,0,0,0,1,5\nGOTO/3,-4,0\nGOTO/0,-5,0\nGOTO/-5,0,0\nFEDRAT/9\nGOTO/0,0,0\n",
                  {-53.13010235415598, -36.86989764584402, -90, 0});
    expect_angles("CIRCLE/0,0,0,0,0,-1,5\nGOTO/0,5,0\nGOTO/-5,0,0\nGOTO/-6,0,0\nGOTO/-5,0,0\n", {90, 90, 0, 0});
    expect_angles("CIRCLE/0,0,0,0,0,1,5\nGOTO/0,5,0\nGOTO/-5,0,0\nGOTO/0,-5,0\nGOTO/5,0,0\n", {90, 90, 90, 90});
    expect_angles("CIRCLE/0,0,0,0,0,1,5\nGOTO/0,5,0\nGOTO/-5,0,-3\n", {90, 0});
    expect_angles("CIRCLE/0,0,0,0,0,1,5\nGOTO/-5,0,0\nGOTO/5,0,0\n", {180, 180});
}

TEST(AptArcs, DrivenAlongACircleToALine) {
    expect_angles("AUTOPS\nINDIRV/0,1,0\nTLON,GOFWD/ (CIRCLE/ 0,0,0,$\n 5),ON,(LINE/ 0,0,0,$\n 0,5,0)\nGOTO/0,6,0\n",
                  {90, 0});
    expect_angles("INDIRV/0,-1,0\nTLON,GOFWD/(CIRCLE/0,0,0,5),ON,2,INTOF,(LINE/0,0,0,0,5,0)\n", {-270});
    expect_angles("INDIRV/.5,-.1,0\nTLON,GOFWD/CIRCLE/0,0,0,5,ON,2,INTOF,LINE/0,0,0,5,0,0\n", {-360});
    expect_angles("INDIRV/0,2,0\nTLON,GOFWD/(CIRCLE/CANON,0,0,9,0,0,-1,5),ON,(LINE/0,0,0,-5,0,0)\n", {180});
}

TEST(AptArcs, LengthsInInchesAndTheToolTurnsAlong) {
    const auto p = read(
        "UNITS/INCHES\nFEDRAT/60\nGOTO/1,0,2,0,0,1\nCIRCLE/0,0,2,0,0,1,1\nGOTO/0,1.0003,2,0,1,0\n"
        "CIRCLE/0,0,0,0,1,0,1\n");
    ASSERT_FALSE(p) << "the last circle has no end";
    const auto whole = read("UNITS/INCHES\nFEDRAT/60\nGOTO/1,0,2,0,0,1\nCIRCLE/0,0,2,0,0,1,1\nGOTO/0,1.0003,2,0,1,0\n");
    ASSERT_TRUE(whole) << said(whole);
    EXPECT_LT((whole->arcs.at(0).centre_mm - Eigen::Vector3d(0, 0, 50.8)).norm(), 1e-12);
    EXPECT_NEAR(whole->arcs[0].angle_rad, 90 * degree, 1e-12);
    EXPECT_EQ(whole->moves[1].axis, Eigen::Vector3d::UnitY());
    EXPECT_EQ(whole->moves[1].law, program::OrientationLaw::vector);
    EXPECT_DOUBLE_EQ(whole->moves[1].feed.value, inch_mm);
}

}  // namespace
}  // namespace trunnion::nc
