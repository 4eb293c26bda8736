#include <stdexcept>

#include "trunnion/base/quantity.hpp"

#include "curves.hpp"
#include "reading.hpp"

namespace trunnion::nc {
namespace {

using Eigen::Vector3d;

program::Program read_apt_text(std::string_view text) {
    auto p = read_program(std::string("UNITS/MM\nFEDRAT/600,MMPM\n").append(text), "part.cls", {});
    EXPECT_TRUE(p) << said(p);
    if (!p) throw std::runtime_error("not read");
    expect_sound_curves(*p);
    return std::move(*p);
}

void expect_near(const Vector3d& got, const Vector3d& wanted) {
    EXPECT_LT((got - wanted).norm(), 1e-9) << got.transpose() << " for " << wanted.transpose();
}

TEST(AptNurbs, OneSpanIsABezierCurve) {
    const auto p = read_apt_text(
        "GOTO/0,0,0,0,.6,.8\nNURBS/\nKNOT/1.\nCNTRL/10,0,0\nCNTRL/20,10,0\nCNTRL/30,10,5\nGOTO/40,10,5\n");
    ASSERT_EQ(p.moves.size(), 3u);
    const program::Curve& curve = curve_of(p, p.moves[1]);
    EXPECT_EQ(curve.knots, (std::vector<double>{0, 0, 0, 0, 1, 1, 1, 1}));
    const double t = 0.3, s = 0.7;
    expect_near(blended(curve, curve.position_mm, t), Vector3d(3 * s * s * t * 10 + 3 * s * t * t * 20 + t * t * t * 30,
                                                               3 * s * t * t * 10 + t * t * t * 10, t * t * t * 5));
    EXPECT_EQ(p.moves[1].position_mm, Vector3d(30, 10, 5));
    EXPECT_EQ(p.moves[1].axis, p.moves[0].axis);
    EXPECT_DOUBLE_EQ(p.moves[1].feed.value, 10);
    EXPECT_EQ(p.moves[1].line, 8);
    EXPECT_EQ(p.moves[2].curve_part, program::no_curve_part);
}

TEST(AptNurbs, KnotsOverSeveralRecordsAndSpans) {
    const auto p = read_apt_text(
        "GOTO/0,0,0\nNURBS/\nKNOT/.25,.5\nKNOT/.5, "
        "1.\nCNTRL/1,0,0\nCNTRL/2,1,0\nCNTRL/3,1,5\nCNTRL/4,1,6\nCNTRL/5,0,6\n"
        "CNTRL/6,0,6\nPAINT/COLOR,5\nNURBS/\nKNOT/1\nCNTRL/7,0,6\nCNTRL/8,0,6\nCNTRL/9,0,5\n");
    ASSERT_EQ(p.curves.size(), 2u);
    EXPECT_EQ(p.curves[0].knots, (std::vector<double>{0, 0, 0, 0, .25, .5, .5, 1, 1, 1, 1}));
    ASSERT_EQ(p.moves.size(), 5u);
    EXPECT_EQ(p.curve_parts[1].from_u, .25);
    EXPECT_EQ(p.curve_parts[1].to_u, .5);
    EXPECT_EQ(p.moves[3].position_mm, Vector3d(6, 0, 6));
    EXPECT_EQ(p.curves[1].position_mm[0], Vector3d(6, 0, 6));
}

/// The two examples of CATIA's help, as far as their forms go.
TEST(AptNurbs, OfCatia) {
    const auto p = read_apt_text(
        "GOTO/0,0,0\nBEGIN NURBS_SIEMENS(D=3,F=4000,AXIS=0.00,0.60,0.80);\nN0,XT= 0.000,YT=0.000,ZT=0.000,DK= "
        "0.00,W=1.0;\n"
        "N1,XT=10.000,YT=0.000,ZT=0.000,DK= 0.00,W=1.0;\nN2,XT=20.000,YT=5,ZT=0.000,DK=30.00,W=2.0;\n"
        "N3,XT=30.000,YT=0.000,ZT=0.000,DK= 0.00,W=1.0;\nEND NURBS;\nGOTO/31,0,0\n");
    ASSERT_EQ(p.moves.size(), 4u) << "the tool is turned first";
    const program::Curve& curve = curve_of(p, p.moves[2]);
    EXPECT_EQ(curve.knots, (std::vector<double>{0, 0, 0, 0, 30, 30, 30, 30}));
    EXPECT_EQ(curve.weights, (std::vector<double>{1, 1, 2, 1}));
    const double t = 0.4, s = 0.6, w = s * s * s + 3 * s * s * t + 6 * s * t * t + t * t * t;
    expect_near(blended(curve, curve.position_mm, 30 * t),
                Vector3d(3 * s * s * t * 10 + 6 * s * t * t * 20 + t * t * t * 30, 6 * s * t * t * 5, 0) / w);
    expect_near(p.moves[2].axis, {0, .6, .8});
    EXPECT_DOUBLE_EQ(p.moves[2].feed.value, 4000. / 60);
    EXPECT_EQ(p.moves[2].line, 7);
}

TEST(AptNurbs, OfCatiaWithAToolThatTurns) {
    const auto p = read_apt_text(
        "BEGIN NURBS_SIEMENS(D=3,F=4000,AXIS=VAR,LENGTH=100.00);\nN0,XT= 0.000,YT=0.000,ZT=0.000,XH= 0.000, $\n"
        "YH=0.000,ZH=100.00,DK= 0.00,W=1.0;\nN1,XT=10,YT=0,ZT=0,XH=10,YH=0,ZH=100.00,DK= 0.00,W=1.0;\n"
        "N2,XT=20,YT=0,ZT=0,XH=20,YH=30,ZH=100.00,DK=30.00,W=1.0;\nN3,XT=30,YT=0,ZT=0,XH=60,YH=0,ZH=100,DK=0,W=1;\n"
        "END NURBS;\n");
    ASSERT_EQ(p.moves.size(), 2u);
    const program::Curve& curve = curve_of(p, p.moves[1]);
    expect_near(blended(curve, curve.axis, 15), {30. / 8, 3 * 30. / 8, 100});
    expect_near(p.moves[1].axis, Vector3d(30, 0, 100).normalized());
}

TEST(AptSpellings, Steps) {
    const auto p = read_apt_text("FROM/1,2,3,0,.6,.8\nGODLTA/1,0,-3\nGODLTA/-5\nRAPID\nGODLTA/0,0,9\nGODLTA/1,1,1\n");
    ASSERT_EQ(p.moves.size(), 5u);
    expect_near(p.moves[1].position_mm, {2, 2, 0});
    expect_near(p.moves[2].position_mm, {2, 2 - 3, -4});
    EXPECT_EQ(p.moves[3].kind, program::MoveKind::rapid);
    EXPECT_EQ(p.moves[4].kind, program::MoveKind::feed);
}

TEST(AptSpellings, FromSaysAgainWhereTheToolIs) {
    const auto p = read_apt_text("GOTO/1,2,3\nGOTO/2,2,3\nFROM/2,2,3\nGOTO/3,2,3\n");
    EXPECT_EQ(p.moves.size(), 3u);
    EXPECT_EQ(p.moves[2].kind, program::MoveKind::feed);
}

TEST(AptSpellings, SystemsLieInTheFirstOne) {
    const auto same = read_apt_text("MSYS/5,6,7,0,1,0,-1,0,0\nGOTO/1,2,3\nGOTO/2,2,3\n");
    EXPECT_EQ(same.moves[0].position_mm, Vector3d(1, 2, 3));
    EXPECT_FALSE(told(same, "NC0424"));
    // The second one is turned about Z by 90 deg against the first, which is itself turned: their Z agree.
    const auto p = read_apt_text(
        "MSYS/10,0,0,0,1,0,-1,0,0,0,0,1\nGOTO/1,0,0,.6,0,.8\nMSYS/10,5,0,-1,0,0,0,-1,0\nGOTO/1,0,2,.6,0,.8\n"
        "CIRCLE/3,0,2,0,0,1,2\nGOTO/3,-2,2\nGODLTA/1,0,0\nMSYS/10,0,0,0,1,0,-1,0,0\nGOTO/1,0,0\n");
    ASSERT_EQ(p.moves.size(), 5u);
    // (1,0,2) there is (10-1, 5, 2) in the parent, and (5, 1, 2) in the first one.
    expect_near(p.moves[1].position_mm, {5, 1, 2});
    expect_near(p.moves[1].axis, {0, .6, .8});
    expect_near(p.moves[2].position_mm, {5 + 2, 3, 2});
    expect_near(p.arcs.at(0).centre_mm, {5, 3, 2});
    expect_near(p.moves[3].position_mm, {7, 4, 2});
    EXPECT_EQ(p.moves[4].position_mm, Vector3d(1, 0, 0));
    EXPECT_EQ(told(p, "NC0424")->count, 1);
}

TEST(AptSpellings, FeedPerTurn) {
    const auto p = read_apt_text(
        "GOTO/0,0,0\nFEDRAT/0.2,MMPR\nSPINDL/600,RPM,CLW\nGOTO/1,0,0\nSPINDL/RPM,300\nGOTO/2,0,0\nFEDRAT/.01,IPR\n"
        "GOTO/3,0,0\nFEDRAT/60\nGOTO/4,0,0\n");
    ASSERT_EQ(p.moves.size(), 5u);
    EXPECT_DOUBLE_EQ(p.moves[1].feed.value, 2);
    EXPECT_DOUBLE_EQ(p.moves[2].feed.value, 1);
    EXPECT_DOUBLE_EQ(p.moves[3].feed.value, 1.27);
    EXPECT_DOUBLE_EQ(p.moves[4].feed.value, 1);
}

TEST(AptSpellings, TablesThatStandAndTurnsOfAHelix) {
    const auto p = read_apt_text(
        "ROTABL/    "
        "0.000000,,TABLE,CLW\nROTABL/ATANGL,0,INCR\nGOTO/5,0,0\nCIRCLE/0,0,0,0,0,1,5,.1,.5,1,0,TIMES,3\nGOTO/5,0,9\n"
        "MOVARC/0,0,0,0,0,1,5,TIMES,.25\nGOTO/0,5,9\n");
    EXPECT_EQ(told(p, "NC0012", "ROTABL")->count, 2);
    EXPECT_NEAR(p.arcs.at(0).angle_rad / degree, 3 * 360, 1e-9);
    EXPECT_NEAR(p.arcs.at(1).angle_rad / degree, 90, 1e-9);
}

}  // namespace
}  // namespace trunnion::nc
