#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "fanuc_reading.hpp"

namespace trunnion::nc {
namespace {

using Eigen::Vector3d;
using program::FeedRule;
using program::MoveKind;
using program::OrientationLaw;
using program::Space;

void expect_near(const Vector3d& found, const Vector3d& wanted) {
    EXPECT_LT((found - wanted).norm(), 1e-9) << found.transpose() << " instead of " << wanted.transpose();
}

TEST(FanucMotion, StartIsTheFirstWholePose) {
    const auto p = read_fanuc_after_start("G1 X10.");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->dialect, "fanuc");
    EXPECT_EQ(p->name, "O1");
    ASSERT_EQ(p->moves.size(), 2u);
    expect_near(p->moves[0].position_mm, {0, 0, 50});
    EXPECT_EQ(p->moves[0].space, Space::untransformed);
    EXPECT_EQ(p->tools.at(p->moves[0].tool), "8");
    EXPECT_EQ(p->offsets.at(p->moves[0].offset), "G54");
    EXPECT_EQ(p->moves[1].feed.rule, FeedRule::tip_speed);
    EXPECT_DOUBLE_EQ(p->moves[1].feed.value, 10);
    EXPECT_TRUE(told(*p, "NC0013"));
}

TEST(FanucMotion, InchesAndPoints) {
    const auto p = read_fanuc_text("G20 G0 X1. Y.5 Z-2\nG1 X2 F10.\n");
    ASSERT_TRUE(p) << said(p);
    expect_near(p->moves[0].position_mm, {25.4, 12.7, -50.8});
    EXPECT_DOUBLE_EQ(p->moves[1].feed.value, 254. / 60);
    EXPECT_EQ(told(*p, "NC0864")->count, 2);
    EXPECT_FALSE(told(*p, "NC0011"));
    EXPECT_TRUE(told(*read_fanuc_text("G0 X1. Y1. Z0\nX2.\n"), "NC0011"));
}

TEST(FanucMotion, IncrementalAndMachinePositions) {
    const auto p = read_fanuc_after_start("G91 G1 X5. Z-1.\nG90 G53 G0 Z0\nX20.");
    ASSERT_TRUE(p) << said(p);
    expect_near(p->moves[1].position_mm, {5, 0, 49});
    EXPECT_EQ(p->moves[2].space, Space::machine);
    EXPECT_TRUE(std::isnan(p->moves[2].position_mm.x()));
    EXPECT_EQ(p->moves[2].position_mm.z(), 0);
    EXPECT_EQ(p->moves[3].position_mm.x(), 20);
    EXPECT_TRUE(std::isnan(p->moves[3].position_mm.z()));
    EXPECT_EQ(read_fanuc_after_start("G1 G91 G53 Z0").error().code, "NC0834");
    EXPECT_TRUE(told(*read_fanuc_after_start("G91 G53 Z0\nG90 Z5.\nG1 Z1."), "NC0873"));
    EXPECT_EQ(read_fanuc_after_start("G91 G53 Z0\nG90 G1 X5.").error().code, "NC0837");
    EXPECT_EQ(read_fanuc_after_start("G53 G0 Z0\nG91 Z5.").error().code, "NC0830");
    EXPECT_TRUE(read_fanuc_after_start("G53\nG1 X1."));
}

TEST(FanucMotion, TipUnderG434) {
    const auto p = read_fanuc_after_start("G43.4 H8 Z50.\nG1 X10. B30. C720.\nB40.\nG49\nG0 Z100.");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->rotary_letters, (std::vector<char>{'B', 'C'}));
    const auto& cut = p->moves.at(2);
    expect_near(cut.position_mm, {10, 0, 50});  // upright, what was known stays known
    EXPECT_EQ(cut.space, Space::workpiece);
    EXPECT_EQ(cut.law, OrientationLaw::rotary);
    EXPECT_DOUBLE_EQ(cut.rotary_rad[1], 4 * std::numbers::pi);
    EXPECT_EQ(p->moves.at(3).feed.rule, FeedRule::rotary_rate);
    EXPECT_DOUBLE_EQ(p->moves.at(3).feed.value, 10 * degree);
    const auto& off = p->moves.at(4);
    EXPECT_EQ(off.space, Space::untransformed);
    EXPECT_EQ(p->tools.at(off.tool), "8 D0");
    EXPECT_TRUE(std::isnan(off.position_mm.x()));
}

TEST(FanucMotion, VectorsUnderG435) {
    const auto p = read_fanuc_after_start("G43.5 H8 Z50.\nG1 X10. I0 J.6 K.8\nX20.\nX30. K2.");
    ASSERT_TRUE(p) << said(p);
    const auto& first = p->moves.at(2);
    EXPECT_EQ(first.law, OrientationLaw::vector);
    expect_near(first.axis, {0, .6, .8});
    expect_near(p->moves.at(3).axis, {0, .6, .8});
    expect_near(p->moves.at(4).axis, Vector3d::UnitZ());
    EXPECT_EQ(read_fanuc_after_start("G43.5 H8 Z50.\nG1 X1. I0 J0 K0").error().code, "NC0847");
    EXPECT_EQ(read_fanuc_after_start("G43.5 H8 Z50.\nG1 X1. B5.").error().code, "NC0847");
    EXPECT_EQ(read_fanuc_after_start("G1 X1. I0 J0 K1.").error().code, "NC0825");
}

TEST(FanucMotion, HaasTcpcAndDynamicOffset) {
    auto p = read_fanuc_after_start("G234 H8\nG1 X10. Y0 Z5. B30.\nG49");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->moves.back().space, Space::workpiece);
    p = read_fanuc_after_start("G0 B90. C0\nG254\nG0 X10. Y1.\nZ20.\nG1 X15.\nG255\nG53 G0 Z0");
    ASSERT_TRUE(p) << said(p);
    // B90 turns Z to X: along the machine's axes (10, 1, 20) is (20, 1, -10) in the part
    const auto& there = p->moves.at(3);
    EXPECT_EQ(there.space, Space::workpiece);
    EXPECT_EQ(there.kind, MoveKind::rapid);
    expect_near(there.position_mm, {20, 1, -10});
    expect_near(p->moves.at(4).position_mm, {20, 1, -15});
    EXPECT_EQ(p->moves.at(5).space, Space::machine);
    p = read_fanuc_after_start("G0 B30. C0\nG254\nG0 X10. Y1.\nZ20.\nG1 X15.");
    ASSERT_TRUE(p) << said(p);
    EXPECT_TRUE(told(*p, "NC0863"));  // X and Z of the part mix: one rapid when both are known
    const double c = std::cos(30 * degree), s = std::sin(30 * degree);
    expect_near(p->moves.at(2).position_mm, {10 * c + 20 * s, 1, 20 * c - 10 * s});
    EXPECT_EQ(read_fanuc_after_start("G28 B0\nG254").error().code, "NC0846");
    EXPECT_EQ(read_fanuc_after_start("G254\nG0 X1. Y1. Z1.\nG1 B5.").error().code, "NC0846");
    EXPECT_EQ(read_fanuc_after_start("G0 B30.\nG254\nG1 X1.").error().code, "NC0838");
}

TEST(FanucMotion, Circles) {
    const auto p = read_fanuc_after_start(
        "G2 X10. Y10. I10.\nG3 X20. Y0 R10.\nG2 J10.\nG18 G3 X30. Z40. K-10.\n"
        "G17 G3 X30. Y0 Z30. I-5. K5.\nG2 X30. Y0 Z20. I-5. L3");
    ASSERT_TRUE(p) << said(p);
    const auto angle = [&](std::size_t move) {
        return p->arcs.at(static_cast<std::size_t>(p->moves[move].arc)).angle_rad;
    };
    const double half = std::numbers::pi;
    EXPECT_NEAR(angle(1), -half / 2, 1e-12);
    EXPECT_NEAR(angle(2), half / 2, 1e-9);
    EXPECT_NEAR(angle(3), -2 * half, 1e-12);
    EXPECT_NEAR(angle(5), 4 * half, 1e-12);   // two turns of 5 mm
    EXPECT_NEAR(angle(6), -6 * half, 1e-12);  // three by L
    EXPECT_EQ(read_fanuc_after_start("G2 X10.").error().code, "NC0835");
    EXPECT_EQ(read_fanuc_after_start("G2 X10. I5. R5.").error().code, "NC0835");
    EXPECT_EQ(read_fanuc_after_start("G2 X0 Y0 Z10. I5. K30.").error().code, "NC0835");
    EXPECT_EQ(read_fanuc_after_start("G2 X10. I6. J5.").error().code, "NC0207");
    EXPECT_EQ(read_fanuc_after_start("G0 B10.\nG43.4 H8\nG2 X10. I5. F100.").error().code, "NC0836");
}

TEST(FanucMotion, Feeds) {
    auto p = read_fanuc_after_start("G93 G1 X1. F30.\nX2. F15.\nG94 X3. F60.\nG95 S600 X4. F.2");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->moves[1].feed.rule, FeedRule::block_time);
    EXPECT_DOUBLE_EQ(p->moves[1].feed.value, 2);
    EXPECT_DOUBLE_EQ(p->moves[2].feed.value, 4);
    EXPECT_DOUBLE_EQ(p->moves[3].feed.value, 1);
    EXPECT_DOUBLE_EQ(p->moves[4].feed.value, 2);
    EXPECT_EQ(read_fanuc_after_start("G93 G1 X1. F30.\nX2.").error().code, "NC0832");
    EXPECT_EQ(read_fanuc_after_start("G95 G1 X4. F.2").error().code, "NC0833");
    EXPECT_EQ(read_fanuc_after_start("G1 X4. F0").error().code, "NC0206");
    EXPECT_EQ(read_fanuc_text("G0 X0 Y0 Z0\nG1 X1.").error().code, "NC0205");
}

TEST(FanucMotion, ReferencePoint) {
    auto p = read_fanuc_after_start("G1 X5.\nG91 G28 Z0\nG90 G0 X20. Y1.\nZ30.\nG1 Z20.");
    ASSERT_TRUE(p) << said(p);
    EXPECT_TRUE(told(*p, "NC0862"));
    ASSERT_EQ(p->moves.size(), 5u);
    EXPECT_TRUE(std::isnan(p->moves[2].position_mm.z()));  // Z is where it was left
    EXPECT_EQ(p->moves[3].position_mm.z(), 30);
    EXPECT_EQ(read_fanuc_after_start("G91 G28 Z0\nG90 G1 X20.").error().code, "NC0837");
    EXPECT_EQ(read_fanuc_after_start("G91 G28 B0\nG90 G1 X20. Z1.").error().code, "NC0837");
    p = read_fanuc_after_start("G90 G28 X7. Z60.\nG0 X1. Z1.\nG1 X2.");  // by way of the point that is said
    ASSERT_TRUE(p) << said(p);
    expect_near(p->moves[1].position_mm, {7, 0, 60});
}

TEST(FanucMotion, StopsAndDwells) {
    const auto p = read_fanuc_after_start("G4 P500\nG4 X1.5\nG4 P2.\nG9 G1 X1.\nX2.\nG61 X3.\nG64 X4.\nM0\nM7");
    ASSERT_TRUE(p) << said(p);
    std::vector<double> dwells;
    for (const auto& event : p->events)
        if (event.kind == program::EventKind::dwell) dwells.push_back(event.dwell_s);
    EXPECT_EQ(dwells, (std::vector<double>{.5, 1.5, 2}));
    EXPECT_TRUE(p->moves[1].exact_stop);
    EXPECT_FALSE(p->moves[2].exact_stop);
    EXPECT_TRUE(p->moves[3].exact_stop);
    EXPECT_FALSE(p->moves[4].exact_stop);
    EXPECT_EQ(read_fanuc_after_start("G4").error().code, "NC0831");
}

TEST(FanucMotion, OffsetsAndTools) {
    const auto p =
        read_fanuc_after_start("G54.1 P3 G0 X1. Y2. Z3.\nG55 X1. Y2. Z3.\nT9\nM6\nG43 H9 Z5.\nH0 Z6.\nG154 P2 X0");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->offsets.at(p->moves[1].offset), "G54.1 P3");
    EXPECT_EQ(p->offsets.at(p->moves[2].offset), "G55");
    EXPECT_EQ(p->tools.at(p->moves[3].tool), "9");
    EXPECT_EQ(p->tools.at(p->moves[4].tool), "9 D0");
    EXPECT_EQ(p->offsets.at(p->moves[5].offset), "G154 P2");
    EXPECT_EQ(read_fanuc_text("G0 X0 Y0 Z0\nG43 Z1.").error().code, "NC0839");
    EXPECT_EQ(read_fanuc_after_start("G54.1 X0").error().code, "NC0829");
    EXPECT_TRUE(told(*read_fanuc_after_start("G49\nG1 X1."), "NC0869"));
}

// ---------------------------------------------------------------------------------------------------------------
// frames

TEST(FanucFrames, Shifts) {
    auto p = read_fanuc_after_start("G52 X10. Z1.\nG1 X0\nG52 X0 Z0\nX1.\nG92 X100.\nX101.\nG92.1\nX5.");
    ASSERT_TRUE(p) << said(p);
    expect_near(p->moves[1].position_mm, {10, 0, 50});
    expect_near(p->moves[2].position_mm, {1, 0, 50});
    expect_near(p->moves[3].position_mm, {2, 0, 50});
    expect_near(p->moves[4].position_mm, {5, 0, 50});
    p = read_fanuc_after_start(
        "G55\nG90 G10 L2 P1 X100. Y0 Z0\nG54 G0 X0 Y0 Z50.\nG10 L2 P1 X103.\nG1 X1.\nG91 G10 L2 P1 Y2.\nG90 Y0");
    ASSERT_FALSE(p);  // the start has moved in G54 already
    EXPECT_EQ(p.error().code, "NC0840");
    p = read_fanuc_text(
        "G21 G90 G10 L2 P2 X100. Y0 Z0\nG55 G0 X0 Y0 Z5.\nG10 L2 P2 X103.\nG1 X1. F60\nG91 G10 L2 P2 Y2.\nG90 Y0");
    ASSERT_TRUE(p) << said(p);
    EXPECT_TRUE(told(*p, "NC0865"));
    expect_near(p->moves[1].position_mm, {4, 0, 5});
    expect_near(p->moves[2].position_mm, {4, 2, 5});
    EXPECT_EQ(read_fanuc_after_start("G92 X0\nG53 G0 X0\nG92 X0").error().code, "NC0841");
    EXPECT_EQ(read_fanuc_after_start("G52 B5.").error().code, "NC0841");
    EXPECT_TRUE(read_fanuc_after_start("G92 S3000\nG1 X1."));
}

TEST(FanucFrames, RotationAndMirror) {
    auto p = read_fanuc_after_start(
        "G68 X10. Y0 R90.\nG1 X20. Y0\nG69\nX20.\nG51.1 X0\nX5. Y1.\nG2 X10. Y6. I5.\nG50.1 X0\nG1 X0");
    ASSERT_TRUE(p) << said(p);
    expect_near(p->moves[1].position_mm, {10, 10, 50});
    expect_near(p->moves[2].position_mm, {20, 10, 50});
    expect_near(p->moves[3].position_mm, {-5, 1, 50});
    const auto& arc = p->arcs.at(0);
    expect_near(arc.centre_mm - Vector3d(0, 0, arc.centre_mm.z()), {-10, 1, 0});
    EXPECT_GT(arc.angle_rad * arc.normal.z(), 0) << "a mirrored circle goes the other way round";
    EXPECT_EQ(read_fanuc_after_start("G68 X0 Y0").error().code, "NC0842");
    EXPECT_EQ(read_fanuc_after_start("G68 X0 Y0 Z0 I1 J0 K0 R5.").error().code, "NC0842");
    EXPECT_EQ(read_fanuc_after_start("G68 X0 Y0 R5.\nG51.1 X0").error().code, "NC0845");
    EXPECT_EQ(read_fanuc_after_start("G43.4 H8\nG51.1 X0\nG1 X1. B5.").error().code, "NC0845");
    EXPECT_EQ(read_fanuc_after_start("G51 P2.").error().code, "NC0821");
}

TEST(FanucFrames, TiltedPlane) {
    const auto p = read_fanuc_after_start(
        "G49\nG68.2 X10. Y0 Z0 I90. J90. K0\nG53.1\nG0 X1. Y2.\nG43 H8 Z3.\nG1 Z0\nG69\nG53 G0 Z0");
    ASSERT_TRUE(p) << said(p);
    // about Z by 90°, then about the new X by 90°: the plane's Z is the offset's X
    const auto& there = p->moves.at(1);
    EXPECT_EQ(there.law, OrientationLaw::vector);
    EXPECT_EQ(there.kind, MoveKind::rapid);
    expect_near(there.axis, Vector3d::UnitX());
    expect_near(there.position_mm, {10 + 3, 1, 2});
    expect_near(p->moves.at(2).position_mm, {10, 1, 2});
    EXPECT_EQ(p->moves.at(3).law, OrientationLaw::rotary);
    const auto rpy = read_fanuc_after_start("G68.2 P1 Q123 X0 Y0 Z0 I90. J0 K90.\nG53.1 P1\nG0 X0 Y0 Z1.\nG1 Z0");
    ASSERT_TRUE(rpy) << said(rpy);
    expect_near(rpy->moves.at(1).axis, Vector3d::UnitX());  // Z to −Y, then about Z to X
    EXPECT_TRUE(told(*rpy, "NC0871"));
}

TEST(FanucFrames, TiltedPlaneRefusals) {
    const std::string plane = "G68.2 X0 Y0 Z0 I0 J45. K0\n";
    EXPECT_EQ(read_fanuc_after_start(plane + "G0 X1. Y1. Z1.").error().code, "NC0844");
    EXPECT_EQ(read_fanuc_after_start("G53.1").error().code, "NC0844");
    EXPECT_EQ(read_fanuc_after_start(plane + "G53.1\nG1 X1.").error().code, "NC0838");
    EXPECT_EQ(read_fanuc_after_start(plane + "G53.1\nG0 X1. Y1. Z1. C5.").error().code, "NC0844");
    EXPECT_EQ(read_fanuc_after_start("G68.2 P2 X0 Y0 Z0").error().code, "NC0843");
    EXPECT_EQ(read_fanuc_after_start("G68.2 P1 X0 Y0 Z0 I5. J5.").error().code, "NC0843");
    EXPECT_TRUE(read_fanuc_after_start(plane + "G43.4 H8\nG0 X1. Y1. Z1. B5.\nG1 X2."));  // by the tip anyway
}

// ---------------------------------------------------------------------------------------------------------------
// curves

TEST(FanucNurbs, OneMoveForEverySpan) {
    const auto p =
        read_fanuc_after_start("G6.2 P3 K0 X0 Y0 Z50. R1.\nK0 X10.\nK0 Y10. R2.\nK.5 X20.\nK1.\nK1.\nK1.\nG1 X30.");
    ASSERT_TRUE(p) << said(p);
    ASSERT_EQ(p->curves.size(), 1u);
    const auto& curve = p->curves[0];
    EXPECT_EQ(curve.degree, 2);
    EXPECT_EQ(curve.knots, (std::vector<double>{0, 0, 0, .5, 1, 1, 1}));
    EXPECT_EQ(curve.weights, (std::vector<double>{1, 1, 2, 1}));
    ASSERT_EQ(p->moves.size(), 4u);
    ASSERT_EQ(p->curve_parts.size(), 2u);
    EXPECT_EQ(p->curve_parts[0].to_u, .5);
    EXPECT_EQ(p->curve_parts[1].from_u, .5);
    // halfway the mean of the two middle points, by weight: (1 · (10, 0) + 2 · (10, 10)) / 3
    expect_near(p->moves[1].position_mm, {10, 20. / 3, 50});
    expect_near(p->moves[2].position_mm, {20, 10, 50});
    EXPECT_EQ(p->moves[2].feed.rule, FeedRule::tip_speed);
    EXPECT_EQ(p->moves[3].curve_part, program::no_curve_part);
}

TEST(FanucNurbs, TurnsWithRotaryWords) {
    const auto p = read_fanuc_after_start("G43.4 H8 Z50.\nG6.2 P2 K0 X0 Y0 Z50. B0 C0\nK0 X10. B20.\nK1.\nK1.");
    ASSERT_TRUE(p) << said(p);
    ASSERT_EQ(p->curves.at(0).rotary_rad.size(), 2u);
    EXPECT_DOUBLE_EQ(p->curves[0].rotary_rad[1][0], 20 * degree);
    EXPECT_DOUBLE_EQ(p->moves.back().rotary_rad[0], 20 * degree);
}

TEST(FanucNurbs, Refusals) {
    for (const char* text :
         {"G6.2 P5 K0 X0", "G6.2 X0 Y0", "G6.2 P2 K0 X1. Y0 Z50.\nK0 X2.\nK1.\nK1.",
          "G6.2 P2 K0 X0\nK0 X2.\nK1.\nG1 X3.", "G6.2 P2 K0 X0\nK1. X2.\nK.5", "G6.2 P2 K0 X0\nK0 X1. R0",
          "G6.2 P2 K0 X0\nK.1 X1.\nK1.\nK1.", "G6.2 P2 K0 X0\nK0 X1.\nK.5 X2.\nK.5 X3.\nK1.\nK1.",
          "G6.2 P2 K0 X0\nK1. X1.\nK1.\nK1. X2.", "G53 G0 Z0\nG6.2 P2 K0 X0",
          "G6.2 P3 K0 X0\nK1. X1.\nK1.\nK1.\nK1."}) {
        const auto p = read_fanuc_after_start(text);
        ASSERT_FALSE(p) << text;
        EXPECT_EQ(p.error().code, "NC0850") << text << said(p);
    }
}

}  // namespace
}  // namespace trunnion::nc
