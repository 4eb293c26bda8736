#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "trunnion/geometry/bspline_surface.hpp"

#include "joined.hpp"
#include "reading.hpp"

namespace trunnion::nc {
namespace {

using Eigen::Vector3d;
using program::EventKind;
using program::SurfaceStrategy;

constexpr std::string_view start = "G21 G90 T1 M6\nG0 X0 Y0 Z50 A0 C0\n";

/// A net of degrees 1 × 1 with 2 × 2 points, as surface `number`.
std::string flat(int number = 1) {
    return fmt::format("G320 P{} I1 J1 K2 L2\nX0 Y0 Z0\nX0 Y10 Z0\nX20 Y0 Z0\nX20 Y10 Z0\nG322\n", number);
}

Result<program::Program> read_surfaces(std::string_view text, const ReadOptions& options = {}) {
    return read_ac(std::string(start).append(text), options);
}

std::string code_of(const Result<program::Program>& result) {
    return result ? "read" : result.error().code;
}

TEST(SurfaceWords, ANetAndItsMachining) {
    const auto p = read_surfaces(
        "G320 P7 I2 J1 K3 L2 (degrees, control points along u and v)\n"
        "X0 Y0 Z0 ; P00\nX0 Y10 Z0\nX10 Y0 Z5\nX10 Y10 Z5\nX20 Y0 Z0\nX20 Y10 Z0\nG322\n"
        "G323 D0.0004 H30 K2 L2 Q0 R300\n"
        "G324 P7 R0.01 Q4 I30 J2 K-3 L-1 F600 S8000 M3\nM5\nM30\n");
    ASSERT_TRUE(p) << said(p);
    ASSERT_EQ(p->surfaces.size(), 1u);
    const program::Surface& surface = p->surfaces[0];
    EXPECT_EQ(surface.degree_u, 2);
    EXPECT_EQ(surface.degree_v, 1);
    EXPECT_EQ(surface.knots_u, (std::vector<double>{0, 0, 0, 1, 1, 1}));
    EXPECT_EQ(surface.knots_v, (std::vector<double>{0, 0, 1, 1}));
    ASSERT_EQ(surface.position_mm.size(), 6u);
    EXPECT_EQ(surface.position_mm[3], Vector3d(10, 10, 5));
    EXPECT_TRUE(surface.weights.empty());
    ASSERT_EQ(p->surface_jobs.size(), 1u);
    const program::SurfaceJob& job = p->surface_jobs[0];
    EXPECT_EQ(job.surface, 0);
    EXPECT_TRUE(job.normal_against);
    EXPECT_EQ(job.strategy, SurfaceStrategy::parallel_planes);
    EXPECT_DOUBLE_EQ(job.scallop_mm, 0.01);
    EXPECT_DOUBLE_EQ(job.chord_tolerance_mm, 0.0004);
    EXPECT_DOUBLE_EQ(job.feed_angle_rad, std::numbers::pi / 6);
    EXPECT_DOUBLE_EQ(job.lead_rad, std::numbers::pi / 90);
    EXPECT_DOUBLE_EQ(job.tilt_rad, -std::numbers::pi / 60);
    EXPECT_FALSE(job.zigzag);
    EXPECT_FALSE(job.borders);
    EXPECT_DOUBLE_EQ(job.lift_mm, 2);
    EXPECT_DOUBLE_EQ(job.retract_mm, 30);
    EXPECT_DOUBLE_EQ(job.feed_mm_s, 10);
    EXPECT_DOUBLE_EQ(job.approach_mm_s, 5);
    EXPECT_EQ(p->tools[job.tool], "1");
    EXPECT_EQ(p->offsets[job.offset], "G54");
    EXPECT_EQ(job.before_move, 1u);
    EXPECT_EQ(job.line, 12);
    ASSERT_EQ(p->moves.size(), 1u) << "defining and machining are no moves yet";
    std::string order;
    for (const program::Event& event : p->events) order += event.word + ",";
    EXPECT_EQ(order, "T1,M6,S8000,M3,G324 P7,M5,M30,") << "the job stands between M3 and M5";
}

TEST(SurfaceWords, KnotsAndWeights) {
    const auto p = read_surfaces(
        "G320 P1 I2 J1 K4 L2\nI0 J0\nI0 J0\nI0 J2\nI.25 J2\nI1\nI1\nI1\n"
        "X0 Y0 Z0 R2\nX0 Y9 Z0\nX1 Y0 Z0\nX1 Y9 Z0\nX2 Y0 Z0\nX2 Y9 Z0\nX3 Y0 Z0\nX3 Y9 Z0 R.5\n"
        "G322\nG324 P1 R0.01 F100\n");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->surfaces[0].knots_u, (std::vector<double>{0, 0, 0, 0.25, 1, 1, 1}));
    EXPECT_EQ(p->surfaces[0].knots_v, (std::vector<double>{0, 0, 2, 2}));
    EXPECT_EQ(p->surfaces[0].weights, (std::vector<double>{2, 1, 1, 1, 1, 1, 1, 0.5}));
}

TEST(SurfaceWords, APolynomialIsWhatItsCoefficientsSay) {
    const auto p = read_surfaces(
        "G321 P1 I2 J3\n"
        "X0 Y0 Z1\nX0 Y40 Z2\nX0 Y0 Z-3\nX0 Y0 Z4\n"
        "X60 Y0 Z5\nX0 Y0 Z-6\nX1 Y0 Z7\nX0 Y2 Z8\n"
        "X0 Y0 Z9\nX0 Y0 Z1\nX0 Y3 Z-2\nX4 Y0 Z3\nG322\nG324 P1 R0.01 F100\n");
    ASSERT_TRUE(p) << said(p);
    const program::Surface& s = p->surfaces[0];
    const auto surface =
        geometry::BsplineSurface::make({s.degree_u, s.knots_u}, {s.degree_v, s.knots_v}, s.position_mm, s.weights);
    ASSERT_TRUE(surface);
    for (const double u : {0.0, 0.3, 1.0})
        for (const double v : {0.0, 0.6, 1.0}) {
            const Vector3d expected(
                60 * u + u * v * v + 4 * u * u * v * v * v, 40 * v + 2 * u * v * v * v + 3 * u * u * v * v,
                1 + 2 * v - 3 * v * v + 4 * v * v * v + u * (5 - 6 * v + 7 * v * v + 8 * v * v * v) +
                    u * u * (9 + v - 2 * v * v + 3 * v * v * v));
            EXPECT_LT((surface->at(u, v) - expected).norm(), 1e-12) << u << " " << v;
        }
}

TEST(SurfaceWords, ExpressionsParametersLoopsAndComments) {
    const auto p = read_surfaces(
        "#<number> = 3 (a comment)\n#1 = 0\n"
        "G320 P[#<number>] I1 J1 K3 L[1+1]\n"
        "o1 while [#1 LT 3]\n(row) X[10*#1] Y0 Z[#1**2]\nN10 X[10*#1] Y[SQRT[16]] Z[#1**2]\n"
        "#1 = [#1 + 1]\no1 endwhile\n/ X1 Y1 Z1\nG322\n#<ridge> = 0.02\n"
        "G324 P#<number> R#<ridge> F[100*3]\n");
    ASSERT_TRUE(p) << said(p);
    ASSERT_EQ(p->surfaces[0].position_mm.size(), 6u);
    EXPECT_EQ(p->surfaces[0].position_mm[4], Vector3d(20, 0, 4));
    EXPECT_EQ(p->surfaces[0].position_mm[5], Vector3d(20, 4, 4));
    EXPECT_DOUBLE_EQ(p->surface_jobs[0].scallop_mm, 0.02);
    EXPECT_DOUBLE_EQ(p->surface_jobs[0].feed_mm_s, 5);
}

TEST(SurfaceWords, InchesScaleAllLengthsButNoAngleKnotOrWeight) {
    const auto p = read_surfaces(
        "G20\nG320 P1 I1 J1 K2 L2\nJ0\nJ0\nJ3\nJ3\nX0 Y0 Z0\nX0 Y1 Z0 R2\nX2 Y0 Z0\nX2 Y1 Z.5\n"
        "G322\nG323 D.0001 H2 K.1 R10\nG324 P1 R.001 I10 F60\n");
    ASSERT_TRUE(p) << said(p);
    EXPECT_TRUE(p->surfaces[0].position_mm[3].isApprox(Vector3d(50.8, 25.4, 12.7)));
    EXPECT_EQ(p->surfaces[0].weights[1], 2);
    EXPECT_EQ(p->surfaces[0].knots_v.back(), 3);
    const program::SurfaceJob& job = p->surface_jobs[0];
    EXPECT_DOUBLE_EQ(job.scallop_mm, 0.0254);
    EXPECT_DOUBLE_EQ(job.chord_tolerance_mm, 0.00254);
    EXPECT_DOUBLE_EQ(job.retract_mm, 50.8);
    EXPECT_DOUBLE_EQ(job.lift_mm, 2.54);
    EXPECT_DOUBLE_EQ(job.feed_mm_s, 25.4);
    EXPECT_DOUBLE_EQ(job.approach_mm_s, 254.0 / 60);
    EXPECT_DOUBLE_EQ(job.feed_angle_rad, std::numbers::pi / 18);
}

TEST(SurfaceWords, SeveralSurfacesToolsOffsetsAndShifts) {
    const auto p = read_surfaces(flat(1) + flat(2) +
                                 "F500\nG324 P2 R.01\nG324 P1 R.02\nT2 M6 G55\nG324 P2 R.03\nG52 X5\nG324 P2 R.01\n" +
                                 flat(2) + "G324 P2 R.04\n");
    ASSERT_TRUE(p) << said(p);
    ASSERT_EQ(p->surface_jobs.size(), 5u);
    const auto& jobs = p->surface_jobs;
    EXPECT_EQ(p->tools[jobs[0].tool] + p->offsets[jobs[0].offset], "1G54");
    EXPECT_EQ(p->tools[jobs[2].tool] + p->offsets[jobs[2].offset], "2G55");
    EXPECT_EQ(jobs[0].surface, jobs[2].surface) << "the same surface machined twice is there once";
    EXPECT_NE(jobs[0].surface, jobs[1].surface);
    const auto corner = [&](std::size_t job) {
        return p->surfaces[static_cast<std::size_t>(jobs[job].surface)].position_mm[0];
    };
    EXPECT_EQ(corner(2), Vector3d(0, 0, 0));
    EXPECT_EQ(corner(3), Vector3d(5, 0, 0)) << "G52 shifts a surface as it does positions";
    EXPECT_EQ(corner(4), Vector3d(5, 0, 0));
    EXPECT_DOUBLE_EQ(jobs[4].scallop_mm, 0.04);
}

TEST(SurfaceWords, LengthOfAnotherToolBringsItsShape) {
    const auto p = read_surfaces(flat() + "G43 H5\nG324 P1 R.01 F100\n");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->tools[p->surface_jobs[0].tool], "5");
}

TEST(SurfaceWords, BehindASurfaceThePositionIsNotKnown) {
    const std::string job = flat() + "G2 X5 Y5 I5 F100\nG324 P1 R.01\n";
    const auto p = read_surfaces(job + "G0 Z80\nG0 X1 Y2 A10\n");
    ASSERT_TRUE(p) << said(p);
    ASSERT_EQ(p->moves.size(), 4u);
    const program::Move& up = p->moves[2];
    EXPECT_TRUE(std::isnan(up.position_mm[0]) && up.position_mm[2] == 80);
    EXPECT_TRUE(std::isnan(up.rotary_rad[0]) && std::isnan(up.rotary_rad[1]));
    EXPECT_EQ(p->rotary_letters, (std::vector<char>{'A', 'C'}));
    EXPECT_EQ(p->surface_jobs[0].before_move, 2u);
    EXPECT_EQ(code_of(read_surfaces(job + "X5 Y5\n")), "NC0308") << "the motion in force before it is over";
    EXPECT_EQ(code_of(read_surfaces(job + "G91 G1 X5\n")), "NC0309");
    EXPECT_EQ(code_of(read_surfaces(job + "G2 X5 Y5 I5\n")), "NC0317");
    EXPECT_EQ(code_of(read_surfaces(job + "G92 X0\n")), "NC0342");
}

TEST(SurfaceWords, DefiningLeavesTheMotionInForce) {
    const auto p = read_surfaces("G1 X1 F100\n" + flat() + "X2\nG324 P1 R.01\n");
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->moves.back().position_mm.x(), 2);
}

TEST(SurfaceWords, SuperfluousMovesBeforeTheStartAreLeftOut) {
    const auto p = read_ac("G21 G90 F100\nG0 X1 Y1 Z1\nG0 A0 C0\n" + flat() + "G324 P1 R.01\nG0 Z80 A5\n");
    ASSERT_TRUE(p) << said(p);
    EXPECT_TRUE(told(*p, "NC0013"));
    EXPECT_EQ(p->moves.size(), 2u);
    EXPECT_EQ(p->surface_jobs[0].before_move, 1u);
}

TEST(SurfaceWords, ProgramsWithThemAreRecognised) {
    const auto dialect = recognise("%\nN5 G21 G90\nN10 G320P1I1J1K2L2\nIF [#1 EQ 2] GOTO 5\n");
    ASSERT_TRUE(dialect);
    EXPECT_EQ(*dialect, Dialect::rs274);
    const auto other = recognise("G21\nG3201\n(G320)\nO1234\n");
    ASSERT_TRUE(other);
    EXPECT_EQ(*other, Dialect::fanuc);
}

TEST(SurfaceWords, PartsHaveTheirSurfaces) {
    std::string text = std::string(start) + flat(1) + flat(2) + "F100\n";
    for (int i = 0; i < 6; ++i) {
        for (int k = 1; k <= 7; ++k) text += fmt::format("G1 X{} Y{} Z50 A0 C0\n", k, i);
        text += fmt::format("M3\nG324 P{} R0.01\nM5\nG0 Z60\nG0 X0 Y0 A0 C0\nG0 X1\n", 1 + i % 2);
    }
    const FileForTest file("surfaces.ngc", text);
    static const machine::Machine machine = machine_with("AC");
    ReadOptions options;
    options.machine = &machine;
    options.parts = {.to_rapid = 5, .to_stop = 9, .most = 1'000'000};
    const auto parts = join_parts(file.path(), options);
    ASSERT_FALSE(parts.error) << to_string(*parts.error);
    ASSERT_GT(parts.parts.size(), 3u);
    std::size_t jobs = 0;
    for (const program::Program& part : parts.parts) {
        for (const program::SurfaceJob& job : part.surface_jobs) {
            EXPECT_EQ(job.surface, static_cast<std::int32_t>(jobs % 2));
            ASSERT_LT(static_cast<std::size_t>(job.surface), part.surfaces.size());
            ASSERT_GT(job.before_move, 0u);
            ASSERT_LT(job.before_move, part.moves.size()) << "the moves behind it are in its part";
            EXPECT_EQ(part.moves[job.before_move - 1].position_mm, Vector3d(7, double(jobs), 50));
            EXPECT_TRUE(std::isnan(part.moves[job.before_move].position_mm.x()));
            ++jobs;
        }
        EXPECT_TRUE(part.moves.front().position_mm.allFinite());
    }
    EXPECT_EQ(jobs, 6u);
    Described whole;
    const auto read = read_program_file(file.path(), options);
    ASSERT_TRUE(read) << said(read);
    add(*read, whole);
    EXPECT_EQ(whole, parts.joined) << "moves and events are those of the whole program";
}

TEST(SurfaceWords, FreedOfGougesAgainstAllSurfacesDefinedBefore) {
    const auto p = read_surfaces(flat(1) + flat(2) + "F500\nG324 P1 R.01\nG323 P1 J40\nG324 P1 R.01\n" + flat(3) +
                                 "G324 P2 R.01\nG52 X5\nG324 P1 R.01\nG323 P0\nG324 P1 R.01\nG323 P1\nG324 P1 R.01\n");
    ASSERT_TRUE(p) << said(p);
    const auto& jobs = p->surface_jobs;
    ASSERT_EQ(jobs.size(), 6u);
    EXPECT_FALSE(jobs[0].free_of_gouges);
    EXPECT_TRUE(jobs[0].others.empty());
    EXPECT_TRUE(jobs[1].free_of_gouges);
    EXPECT_DOUBLE_EQ(jobs[1].reach_mm, 40);
    EXPECT_EQ(jobs[1].others.size(), 1u) << "the third one is not defined yet";
    EXPECT_EQ(jobs[2].others.size(), 2u);
    EXPECT_EQ(jobs[2].others[0], jobs[1].surface) << "those in the program are there once";
    EXPECT_EQ(jobs[2].surface, jobs[1].others[0]);
    const auto corner = [&](std::int32_t surface) {
        return p->surfaces[static_cast<std::size_t>(surface)].position_mm[0];
    };
    for (const std::int32_t other : jobs[3].others) EXPECT_EQ(corner(other), Vector3d(5, 0, 0)) << "G52 shifts all";
    EXPECT_FALSE(jobs[4].free_of_gouges);
    EXPECT_TRUE(jobs[4].others.empty());
    EXPECT_TRUE(jobs[5].free_of_gouges);
    EXPECT_DOUBLE_EQ(jobs[5].reach_mm, 40) << "conditions stay in force";
}

TEST(SurfaceWords, TheReachIsALength) {
    const auto p = read_surfaces(flat() + "G20 G323 D.0001 H1 K.1\nG323 P1 J2\nG324 P1 R.001 F10\n");
    EXPECT_EQ(code_of(p), "NC0050") << "G20 needs a block of its own";
    const auto inch = read_surfaces(flat() + "G20\nG323 P1 J2\nG324 P1 R.001 F10\n");
    ASSERT_TRUE(inch) << said(inch);
    EXPECT_DOUBLE_EQ(inch->surface_jobs[0].reach_mm, 50.8);
}

struct Refusal {
    std::string name, code, text;
};

class RefusedSurface : public testing::TestWithParam<Refusal> {};

TEST_P(RefusedSurface, HasItsCodeAndPlace) {
    const auto p = read_surfaces(GetParam().text);
    EXPECT_EQ(code_of(p), GetParam().code) << said(p);
    if (p) return;
    EXPECT_GT(p.error().place.line, 2) << said(p);
}

std::vector<Refusal> refusals() {
    const std::string net = "G320 P1 I1 J1 K2 L2\n", points = "X0 Y0 Z0\nX0 Y1 Z0\nX1 Y0 Z0\nX1 Y1 Z0\n";
    const std::string job = flat() + "F100\nG324 P1 R.01 ";
    return {
        {"NoNumber", "NC0051", "G320 I1 J1 K2 L2\n"},
        {"NumberNotWhole", "NC0051", "G320 P1.5 I1 J1 K2 L2\n"},
        {"NumberZero", "NC0051", "G320 P0 I1 J1 K2 L2\n"},
        {"NumberTooLarge", "NC0051", "G320 P10000 I1 J1 K2 L2\n"},
        {"DegreeZero", "NC0052", "G320 P1 I0 J1 K2 L2\n"},
        {"DegreeNine", "NC0052", "G320 P1 I1 J9 K2 L10\n"},
        {"DegreeMissing", "NC0052", "G321 P1 I1\n"},
        {"DegreeOfPolynomial", "NC0052", "G321 P1 I8 J1\n"},
        {"CountMissing", "NC0053", "G320 P1 I1 J1 K2\n"},
        {"FewerPointsThanDegree", "NC0053", "G320 P1 I3 J1 K3 L2\n"},
        {"CountNotWhole", "NC0053", "G320 P1 I3 J1 K4.5 L2\n"},
        {"CountInfinite", "NC0053", "G320 P1 I3 J1 K[10**300] L2\n"},
        {"MillionPoints", "NC0054", "G320 P1 I3 J3 K1000 L1000\n"},
        {"TooManyPointsTogether", "NC0054", net + points + "G322\nG320 P2 I3 J3 K500 L500\n"},
        {"OnePointTooMany", "NC0053", net + points + "X0 Y0 Z0\n"},
        {"MissingRow", "NC0058", net + "X0 Y0 Z0\nX0 Y1 Z0\nG322\n"},
        {"MissingCoefficient", "NC0058", "G321 P1 I1 J1\nX0 Y0 Z0\nG322\n"},
        {"PointWithoutZ", "NC0055", net + "X0 Y0\n"},
        {"PointTooFar", "NC0055", net + "X0 Y0 Z[10**300]\n"},
        {"PointOfInfiniteExpression", "NC0327", net + "X0 Y0 Z[10**200*10**200]\n"},
        {"PointOfNoNumber", "NC0326", net + "X0 Y0 Z[SQRT[-1]]\n"},
        {"PointNan", "NC0201", net + "X0 Y0 Znan\n"},
        {"WeightZero", "NC0056", net + "X0 Y0 Z0 R0\n"},
        {"WeightNegative", "NC0056", net + "X0 Y0 Z0 R-1\n"},
        {"WeightHuge", "NC0056", net + "X0 Y0 Z0 R10000000\n"},
        {"WeightInPolynomial", "NC0050", "G321 P1 I1 J1\nX0 Y0 Z0 R1\n"},
        {"KnotsFall", "NC0057", net + "I0\nI1\nI.5\n"},
        {"KnotsMissing", "NC0057", net + "I0\nI0\nI1\n" + points + "G322\n"},
        {"KnotTooMany", "NC0057", net + "J0\nJ0\nJ1\nJ1\nJ1\n"},
        {"KnotsAllAlike", "NC0057", net + "J0\nJ0\nJ0\nJ0\n" + points + "G322\n"},
        {"KnotTooLarge", "NC0057", net + "J10000000000\n"},
        {"KnotsInPolynomial", "NC0057", "G321 P1 I1 J1\nI0\n"},
        {"PointAndKnot", "NC0050", net + "X0 Y0 Z0 I0\n"},
        {"FeedInSurface", "NC0050", net + "F100\n"},
        {"MotionInSurface", "NC0050", net + "G1 X0 Y0 Z0\n"},
        {"SurfaceInSurface", "NC0050", net + "G320 P2 I1 J1 K2 L2\n"},
        {"NotAlone", "NC0050", "G1 G320 P1 I1 J1 K2 L2\n"},
        {"LetterWithoutUse", "NC0050", "G320 P1 I1 J1 K2 L2 D3\n"},
        {"InsideNurbs", "NC0050", "G5.2 P1 X1 Y1 F100\nG320 P1 I1 J1 K2 L2\n"},
        {"TwoSurfaceWords", "NC0304", "G320 G321 P1 I1 J1 K2 L2\n"},
        {"EndWithoutBeginning", "NC0059", "G322\n"},
        {"NoEnd", "NC0059", net + points},
        {"Incremental", "NC0066", "G91\n" + net},
        {"NotDefined", "NC0060", flat() + "F100\nG324 P2 R.01\n"},
        {"NotDefinedYet", "NC0060", "F100\nG324 P1 R.01\n" + flat()},
        {"MachiningWithoutNumber", "NC0051", flat() + "G324 R.01 F100\n"},
        {"NoScallop", "NC0061", flat() + "G324 P1 F100\n"},
        {"ScallopZero", "NC0061", flat() + "G324 P1 R0 F100\n"},
        {"ScallopNegative", "NC0061", flat() + "G324 P1 R-.01 F100\n"},
        {"UnknownStrategy", "NC0062", job + "Q6\n"},
        {"StrategyNotWhole", "NC0062", job + "Q1.5\n"},
        {"AngleWithoutUse", "NC0062", job + "Q2 I10\n"},
        {"LeadLying", "NC0062", job + "J90\n"},
        {"TiltLying", "NC0062", job + "K-95\n"},
        {"SideUnknown", "NC0063", job + "L0\n"},
        {"LiftAboveRetract", "NC0063", "G323 K20 H10\n"},
        {"ChordZero", "NC0063", "G323 D0\n"},
        {"ApproachNegative", "NC0063", "G323 R-1\n"},
        {"PassesOfNoKind", "NC0063", "G323 L3\n"},
        {"FreedInPart", "NC0063", "G323 P2\n"},
        {"ReachNotAsked", "NC0063", "G323 J40\n"},
        {"ReachNoLongerAsked", "NC0063", "G323 P1 J40\nG323 P0 J30\n"},
        {"ReachZero", "NC0063", "G323 P1 J0\n"},
        {"ReachNegative", "NC0063", "G323 P1 J-5\n"},
        {"NoFeed", "NC0205", flat() + "G324 P1 R.01\n"},
        {"InverseTime", "NC0065", flat() + "G93 G324 P1 R.01 F1\n"},
        {"TcpOff", "NC0065", "M429\n" + job + "\n"},
        {"MachinePositions", "NC0065", flat() + "F100\nG53 G324 P1 R.01\n"},
        {"ExactStop", "NC0065", "G61\n" + job + "\n"},
        {"AxisWord", "NC0050", job + "X1\n"},
        {"RotaryWord", "NC0050", job + "A1\n"},
        {"WithG2", "NC0304", "G2 X5 Y5 I5 F100\n" + flat() + "G2 G324 P1 R.01\n"},
        {"WithDwell", "NC0313", flat() + "F100\nG4 G324 P1 R.01\n"},
        {"WithPathControl", "NC0313", flat() + "F100\nG64 G324 P1 R.01\n"},
        {"WithToolInSpindle", "NC0313", flat() + "F100\nM61 G324 P1 R.01 Q2\n"},
        {"WithOutput", "NC0313", flat() + "F100\nM62 G324 P1 R.01\n"},
        {"WithCall", "NC0313", flat() + "F100\nM98 G324 P1 R.01\n"},
        {"WithUsersWord", "NC0313", flat() + "F100\nM110 G324 P1 R.01\n"},
        {"WithHome", "NC0343", flat() + "F100\nG28 G324 P1 R.01\n"},
        {"WithFollowing", "NC0313", job + "E1\n"},
        {"ForeignLetter", "NC0313", job + "D1\n"},
    };
}

INSTANTIATE_TEST_SUITE_P(SurfaceWords, RefusedSurface, testing::ValuesIn(refusals()),
                         [](const auto& each) { return each.param.name; });

TEST(SurfaceWords, WhereTheToolStandsMustBeKnown) {
    EXPECT_EQ(code_of(read_ac("G21 F100\n" + flat() + "G324 P1 R.01\nG0 X0 Y0 Z5\n")), "NC0067");
    EXPECT_EQ(code_of(read_ac("G21 F100\nG0 X0 Y0 Z50\nG55 G0 A0\n" + flat() + "G324 P1 R.01\n")), "NC0067");
    EXPECT_EQ(code_of(read_ac("G21 F100\nG0 X0 Y0 Z50\n" + flat() + "G324 P1 R.01\nG0 A0 Z60\n")), "NC0067");
    EXPECT_EQ(code_of(read_ac("G21 F100\nG0 X0 Y0 Z50\n" + flat() + "G324 P1 R.01\nG0 Z60\n")), "read");
}

TEST(SurfaceWords, AFeedFromElsewhereMayCome) {
    ReadOptions options;
    options.feed_given_elsewhere = true;
    const auto p = read_surfaces(flat() + "G324 P1 R.01\n", options);
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->surface_jobs[0].feed_mm_s, 0);
}

TEST(SurfaceWords, MachiningBlocksAreLimited) {
    const auto loop = [](int times) {
        return flat() + fmt::format("F100\n#1 = {}\no1 repeat [#1]\nG324 P1 R.01\no1 endrepeat\n", times);
    };
    const auto most = read_surfaces(loop(10'000));
    ASSERT_TRUE(most) << said(most);
    EXPECT_EQ(most->surfaces.size(), 1u);
    EXPECT_EQ(code_of(read_surfaces(loop(10'001))), "NC0054");
}

TEST(SurfaceWords, SurfacesToKeepOutOfAreLimited) {
    const auto loop = [](int others, int times) {
        return fmt::format(
            "#1 = 0\no1 repeat [{}]\n#1 = [#1+1]\nG320 P#1 I1 J1 K2 L2\nX0 Y0 Z0\nX0 Y1 Z0\nX1 Y0 Z0\n"
            "X1 Y1 Z0\nG322\no1 endrepeat\nF100\nG323 P1\no2 repeat [{}]\nG324 P1 R.01\no2 endrepeat\n",
            others + 1, times);
    };
    const auto most = read_surfaces(loop(200, 5000));
    ASSERT_TRUE(most) << said(most);
    EXPECT_EQ(most->surfaces.size(), 201u);
    EXPECT_EQ(code_of(read_surfaces(loop(200, 5001))), "NC0054");
}

}  // namespace
}  // namespace trunnion::nc
