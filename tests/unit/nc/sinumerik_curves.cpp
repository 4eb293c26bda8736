#include <stdexcept>

#include "curves.hpp"
#include "sinumerik_reading.hpp"

namespace trunnion::nc {
namespace {

using Eigen::Vector3d;
using program::Curve;
using program::Program;

constexpr std::string_view start = "G71 G90 G64 G0 X0 Y0 Z0\nG1 F600\n";
constexpr std::string_view start_traori = "G71 G90 G64 TRAORI\nG0 X0 Y0 Z0 B0 C0\nG1 F600 A3=0 B3=0 C3=1\n";

Program read_curves(std::string_view head, std::string_view blocks) {
    auto p = read_bc(std::string(head).append(blocks).append("\n"));
    EXPECT_TRUE(p) << said(p);
    if (!p) throw std::runtime_error("not read");
    expect_sound_curves(*p);
    return std::move(*p);
}

std::string refusal(std::string_view head, std::string_view blocks) {
    const auto p = read_bc(std::string(head).append(blocks).append("\n"));
    return p ? "read" : p.error().code;
}

void expect_near(const Vector3d& got, const Vector3d& wanted) {
    EXPECT_LT((got - wanted).norm(), 1e-9) << got.transpose() << " for " << wanted.transpose();
}

/// Σ of Bernstein's polynomials of degree 3.
Vector3d cubic(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d, double t) {
    const double s = 1 - t;
    return s * s * s * a + 3 * s * s * t * b + 3 * s * t * t * c + t * t * t * d;
}

// ---------------------------------------------------------------------------------------------------------- BSPLINE

TEST(SinumerikBspline, OneSpanIsABezierCurve) {
    for (const char* lengths : {"0 30 0", "30 0 0", "0 0 30"}) {
        SCOPED_TRACE(lengths);
        double a = 0, b = 0, c = 0;
        ASSERT_EQ(std::sscanf(lengths, "%lf %lf %lf", &a, &b, &c), 3);
        const Program p =
            read_curves(start, fmt::format("BSPLINE SD=3\nX10 PL={}\nX20 Y10 PL={}\nX30 Z5 PL={}", a, b, c));
        ASSERT_EQ(p.moves.size(), 2u);
        const Curve& curve = curve_of(p, p.moves[1]);
        EXPECT_EQ(curve.knots, (std::vector<double>{0, 0, 0, 0, 30, 30, 30, 30}));
        EXPECT_TRUE(curve.weights.empty() && curve.axis.empty() && curve.rotary_rad.empty());
        for (const double t : {0.0, 0.3, 0.9})
            expect_near(blended(curve, curve.position_mm, 30 * t),
                        cubic({0, 0, 0}, {10, 0, 0}, {20, 10, 0}, {30, 10, 5}, t));
        EXPECT_EQ(p.moves[1].position_mm, Vector3d(30, 10, 5));
        EXPECT_EQ(p.moves[1].space, program::Space::untransformed);
    }
}

TEST(SinumerikBspline, AMoveForEachSpan) {
    const Program p = read_curves(start,
                                  "BSPLINE SD=3\nX10 PL=0\nX20 Y10 PL=2 F300\nM8 X30 Z5 PL=4\nX40 Y0 PL=1\nX50 PL=0\n"
                                  "M9\nG1 X60");
    ASSERT_EQ(p.moves.size(), 5u);
    const Curve& curve = curve_of(p, p.moves[1]);
    EXPECT_EQ(curve.knots, (std::vector<double>{0, 0, 0, 0, 2, 6, 7, 7, 7, 7}));
    // De Boor at the double-spaced knot u = 2, by hand: of P1 P2 P3 with shares 2/6, 2/7, then 2/6.
    const Vector3d a = Vector3d(10, 0, 0) + Vector3d(10, 10, 0) * (2. / 6),
                   b = Vector3d(20, 10, 0) + Vector3d(10, 0, 5) * (2. / 7);
    expect_near(p.moves[1].position_mm, a + (b - a) * (2. / 6));
    EXPECT_EQ(p.moves[3].position_mm, Vector3d(50, 0, 5));
    EXPECT_EQ(p.moves[4].curve_part, program::no_curve_part);
    EXPECT_EQ(p.moves[4].position_mm, Vector3d(60, 0, 5));
    for (std::size_t i = 1; i < 4; ++i) {
        EXPECT_EQ(p.moves[i].line, static_cast<int>(4 + i));
        EXPECT_DOUBLE_EQ(p.moves[i].feed.value, 5);
        EXPECT_EQ(p.moves[i].curve_part, static_cast<int>(i) - 1);
    }
    EXPECT_EQ(p.curve_parts[1].from_u, 2);
    EXPECT_EQ(p.curve_parts[1].to_u, 6);
    ASSERT_EQ(p.events.size(), 2u);
    EXPECT_EQ(p.events[0].before_move, 2u);
    EXPECT_EQ(p.events[1].before_move, 4u);
    EXPECT_FALSE(told(p, "NC0661"));
}

TEST(SinumerikBspline, EqualDistancesWhereNoneAreSaid) {
    const Program p = read_curves(start, "BSPLINE X10\nX20 Y10\nX30\nX40 Y0");
    const Curve& curve = curve_of(p, p.moves[1]);
    EXPECT_EQ(curve.knots, (std::vector<double>{0, 0, 0, 0, 1, 2, 2, 2, 2}));
    EXPECT_EQ(p.moves.size(), 3u);
    EXPECT_TRUE(told(p, "NC0661"));
    EXPECT_FALSE(told(read_curves(start, "BSPLINE X10\nX20 Y10\nX30"), "NC0661")) << "one span has no inner knot";
}

TEST(SinumerikBspline, DegreesAndWeights) {
    const Program p = read_curves(start, "BSPLINE SD=2\nX10 PW=0.5 PL=1\nX10 Y10 PL=0");
    const Curve& conic = curve_of(p, p.moves[1]);
    EXPECT_EQ(conic.weights, (std::vector<double>{1, 0.5, 1}));
    // (1−t)² : t(1−t) : t² with the weights, at its middle
    expect_near(blended(conic, conic.position_mm, 0.5), Vector3d(0.25 * 10 + 0.25 * 10, 0.25 * 10, 0) / 0.75);
    const Program lines = read_curves(start, "BSPLINE SD=1\nX10 PL=1\nX10 Y10 PL=3");
    EXPECT_EQ(lines.moves.size(), 3u);
    EXPECT_EQ(lines.moves[1].position_mm, Vector3d(10, 0, 0));
}

TEST(SinumerikBspline, AnotherMotionWordEndsIt) {
    const Program p = read_curves(start, "BSPLINE X10\nX20 Y9\nX30\nG1\nBSPLINE SD=2 X40\nX50");
    ASSERT_EQ(p.curves.size(), 2u);
    EXPECT_EQ(p.curves[1].degree, 2);
    EXPECT_EQ(p.curves[1].position_mm[0], Vector3d(30, 9, 0));
}

TEST(SinumerikBspline, KnotsThatRepeat) {
    const Program p = read_curves(start, "BSPLINE SD=3\nX10 PL=0\nX20 PL=1\nX30 Y5 PL=0\nX40 PL=1\nX50 PL=0");
    EXPECT_EQ(curve_of(p, p.moves[1]).knots, (std::vector<double>{0, 0, 0, 0, 1, 1, 2, 2, 2, 2}));
    EXPECT_EQ(p.moves.size(), 3u);
    // The first point said once more, as some write the polygon whole: the same curve.
    const Program whole = read_curves(start, "BSPLINE SD=3\nX0 PL=0\nX10 PL=2\nX20 Y9 PL=0\nX30 PL=0");
    EXPECT_EQ(curve_of(whole, whole.moves[1]).position_mm.size(), 4u);
    EXPECT_EQ(curve_of(whole, whole.moves[1]).knots, (std::vector<double>{0, 0, 0, 0, 2, 2, 2, 2}));
    EXPECT_EQ(whole.moves[1].line, 5);
}

TEST(SinumerikBspline, FramesMoveControlPoints) {
    const Program p = read_curves(start, "ATRANS X100\nAROT Z90\nG1 X0 Y0\nBSPLINE X10\nY10\nX0");
    const Curve& curve = curve_of(p, p.moves.back());
    expect_near(curve.position_mm[1], {100, 10, 0});
    expect_near(curve.position_mm[2], {90, 10, 0});
    expect_near(p.moves.back().position_mm, {90, 0, 0});
}

TEST(SinumerikBspline, IncrementsAndInches) {
    const Program p = read_curves(start, "G91 BSPLINE X10\nX10 Y10\nX=AC(5) Y-10\nG90 G1 X0");
    const auto& points = curve_of(p, p.moves[1]).position_mm;
    EXPECT_EQ(points[2], Vector3d(20, 10, 0));
    EXPECT_EQ(points[3], Vector3d(5, 0, 0));
    const Program inch = read_curves(start, "G70 BSPLINE X1 PL=0\nX2 PL=1\nX3 PL=0");
    EXPECT_DOUBLE_EQ(inch.moves[1].position_mm.x(), 76.2);
    EXPECT_DOUBLE_EQ(curve_of(inch, inch.moves[1]).knots.back(), 25.4);
}

TEST(SinumerikBspline, RotaryWordsAreControlValues) {
    const Program p =
        read_curves("G71 G90 G64 TRAORI\nG0 X0 Y0 Z0 B0 C0\nG1 F600\n", "BSPLINE X10 B10\nX20 B30 C90\nX30 B30");
    const Curve& curve = curve_of(p, p.moves[1]);
    ASSERT_EQ(curve.rotary_rad.size(), 4u);
    const Vector3d middle = blended(curve, curve.rotary_rad, 0.5) / degree;
    expect_near(middle, {(0 + 3 * 10 + 3 * 30 + 30) / 8., (3 * 90 + 90) / 8., 0});
    EXPECT_DOUBLE_EQ(p.moves[1].rotary_rad[0], 30 * degree);
    EXPECT_DOUBLE_EQ(p.moves[1].rotary_rad[1], 90 * degree);
    EXPECT_EQ(p.moves[1].law, program::OrientationLaw::rotary);
    // Axes that stand still, known or not.
    EXPECT_TRUE(curve_of(read_curves(start, "BSPLINE X1\nX2 Y3\nX3"), {.curve_part = 0}).rotary_rad.empty());
}

TEST(SinumerikBspline, ToolVectorsAreControlVectors) {
    const Program p = read_curves(start_traori, "BSPLINE X10\nX20 A3=1 C3=1\nX30");
    const Curve& curve = curve_of(p, p.moves.back());
    ASSERT_EQ(curve.axis.size(), 4u);
    const double root = std::sqrt(0.5);
    expect_near(blended(curve, curve.axis, 0.5), {(3 + 1) * root / 8, 0, 4. / 8 + 4 * root / 8});
    expect_near(p.moves.back().axis, {root, 0, root});
    EXPECT_TRUE(curve_of(read_curves(start_traori, "X1\nBSPLINE X10\nX20 Y9\nX30"), {.curve_part = 0}).axis.empty());
}

// --------------------------------------------------------------------------------------------------------- ORICURVE

TEST(SinumerikOricurve, TheToolPointsToTheSecondCurve) {
    const Program p = read_curves(start_traori,
                                  "ORICURVE\nG1 X1 Y0 XH=1 YH=0 ZH=50\n"
                                  "BSPLINE SD=3\nX10 XH=10 ZH=50 PL=0\nX20 XH=30 PL=10\nX30 XH=50 YH=5 PL=0");
    const Curve& curve = curve_of(p, p.moves.back());
    ASSERT_EQ(curve.axis.size(), 4u);
    EXPECT_EQ(curve.axis[0], Vector3d(0, 0, 50));
    EXPECT_EQ(curve.axis[2], Vector3d(10, 0, 50));
    for (const double t : {0.1, 0.5, 0.8}) {
        const Vector3d tip = cubic({1, 0, 0}, {10, 0, 0}, {20, 0, 0}, {30, 0, 0}, t);
        const Vector3d top = cubic({1, 0, 50}, {10, 0, 50}, {30, 0, 50}, {50, 5, 50}, t);
        expect_near(blended(curve, curve.axis, 10 * t), top - tip);
    }
    expect_near(p.moves.back().axis, Vector3d(20, 5, 50).normalized());
    EXPECT_EQ(p.moves.back().law, program::OrientationLaw::vector);
    EXPECT_FALSE(told(p, "NC0662"));
}

TEST(SinumerikOricurve, StartsAsFarAwayAsItGoesOn) {
    const Program p = read_curves(start_traori, "ORICURVE BSPLINE X10 XH=10 YH=0 ZH=80\nX20 XH=20\nX30 XH=60");
    EXPECT_EQ(curve_of(p, p.moves.back()).axis[0], Vector3d(0, 0, 80));
    EXPECT_TRUE(told(p, "NC0662"));
}

TEST(SinumerikOricurve, InFramesAndWithLines) {
    const Program p = read_curves(
        start_traori, "ORICURVE\nG1 X10 XH=40 YH=0 ZH=40\nTRANS Z5\nROT Z90\nG1 X0 Y10 Z0 XH=0 YH=20 ZH=10");
    expect_near(p.moves.at(2).axis, Vector3d(30, 0, 40) / 50);
    expect_near(p.moves.at(3).position_mm, {-10, 0, 0});
    expect_near(p.moves.at(3).axis, Vector3d(-1, 0, 1).normalized());
    EXPECT_EQ(p.moves.at(3).curve_part, program::no_curve_part);
}

TEST(SinumerikOricurve, Refusals) {
    EXPECT_EQ(refusal(start_traori, "G1 X1 XH=1 YH=1 ZH=1"), "NC0636") << "without ORICURVE";
    EXPECT_EQ(refusal(start, "ORICURVE G1 X1 XH=1 YH=1 ZH=1"), "NC0636") << "without TRAORI";
    EXPECT_EQ(refusal(start_traori, "ORICURVE\nG1 X1 XH=1 ZH=1"), "NC0636") << "YH not known";
    EXPECT_EQ(refusal(start_traori, "ORICURVE\nG2 X1 CR=9 XH=1 YH=2 ZH=1"), "NC0636");
    EXPECT_EQ(refusal(start_traori, "ORICURVE\nG91 X1 XH=1 YH=2 ZH=1"), "NC0636");
    EXPECT_EQ(refusal(start_traori, "ORICURVE\nX1 XH=1 YH=0 ZH=0"), "NC0618");
    EXPECT_EQ(refusal(start_traori, "ORICURVE\nX1 XH=1 YH=0 ZH=5 B5"), "NC0617");
    EXPECT_EQ(refusal(start_traori, "ORICURVE BSPLINE\nX1\nX2 XH=1 YH=0 ZH=5\nX3"), "NC0636") << "begins within";
    EXPECT_EQ(refusal("TRAORI G71\nG0 X0 Y0 Z0 B0 C0 F5\n", "ORICURVE BSPLINE\nX1 XH=1 YH=0 ZH=5\nX2\nX3"), "NC0629");
}

// ------------------------------------------------------------------------------------------------------------- POLY

TEST(SinumerikPoly, TheExampleOfAParabola) {
    const Program p = read_curves(start, "POLY PO[X]=(10,1,0.5) PO[Y]=(4) Z=PO(-2,0,0,0.25) PL=2\nX20 Y0\nG1 Z0");
    ASSERT_EQ(p.moves.size(), 4u);
    const Curve& curve = curve_of(p, p.moves[1]);
    EXPECT_EQ(curve.degree, 4);
    for (const double u : {0.0, 0.7, 1.9}) {
        const double ax = (10 - 1 * 4 - 0.5 * 8) / 2, az = (-2 - 0.25 * 16) / 2;
        expect_near(blended(curve, curve.position_mm, u),
                    {ax * u + u * u + 0.5 * u * u * u, 2 * u, az * u + 0.25 * u * u * u * u});
    }
    EXPECT_EQ(p.moves[1].position_mm, Vector3d(10, 4, -2));
    EXPECT_EQ(p.moves[2].curve_part, program::no_curve_part) << "ends alone: a line";
    EXPECT_EQ(p.moves[2].position_mm, Vector3d(20, 0, -2));
    EXPECT_DOUBLE_EQ(p.moves[1].feed.value, 10);
}

/// The manual's quarter of a circle.
TEST(SinumerikPoly, ADenominator) {
    const Program p = read_curves(start, "G1 X10\nPOLY PO[X]=(0,-10) PO[Y]=(10) PO[]=(2,1)");
    const Curve& curve = curve_of(p, p.moves[2]);
    ASSERT_EQ(curve.weights.size(), 3u);
    for (const double u : {0.0, 0.25, 0.5, 0.9}) {
        const Vector3d at = blended(curve, curve.position_mm, u);
        expect_near(at, Vector3d(10 * (1 - u * u), 20 * u, 0) / (1 + u * u));
        EXPECT_NEAR(at.norm(), 10, 1e-12);
    }
}

TEST(SinumerikPoly, FramesIncrementsAndRotaryAxes) {
    const Program p = read_curves("G71 G90 G64 TRAORI\nG0 X0 Y0 Z0 B0 C0\nG1 F600\n",
                                  "TRANS X100\nG1 X0\nG91 POLY PO[X]=(10,1) PO[C]=(90,30) B10\nG90 X0");
    const Curve& curve = curve_of(p, p.moves[2]);
    expect_near(curve.position_mm.back(), {110, 0, 0});
    expect_near(blended(curve, curve.position_mm, 0.5), {100 + 4.5 + 0.25, 0, 0});
    expect_near(blended(curve, curve.rotary_rad, 0.5) / degree, {5, 60 * 0.5 + 30 * 0.25, 0});
    expect_near(p.moves[3].position_mm, {100, 0, 0});
}

TEST(SinumerikPoly, SecondCurve) {
    const Program p =
        read_curves(start_traori, "ORICURVE\nG1 X1 Y0 XH=1 YH=0 ZH=50\nPOLY PO[X]=(11,2) PO[XH]=(31,4,1) YH=3");
    const Curve& curve = curve_of(p, p.moves.back());
    for (const double u : {0.2, 0.6}) {
        const double x = 1 + 8 * u + 2 * u * u, xh = 1 + 25 * u + 4 * u * u + u * u * u;
        expect_near(blended(curve, curve.axis, u), {xh - x, 3 * u, 50});
    }
    const Program turned = read_curves(start_traori, "X1\nPOLY PO[X]=(11,2) A3=1 C3=1");
    EXPECT_TRUE(curve_of(turned, turned.moves.back()).axis.empty());
    expect_near(turned.moves.back().axis, Vector3d(1, 0, 1).normalized());
    const Program assumed = read_curves(start_traori, "ORICURVE POLY PO[X]=(10,2) XH=20 YH=0 ZH=40");
    EXPECT_TRUE(told(assumed, "NC0662"));
    EXPECT_NEAR(curve_of(assumed, assumed.moves.back()).axis[0].norm(), std::hypot(10, 40), 1e-12);
}

// -------------------------------------------------------------------------------------------------- around the curve

TEST(SinumerikCurves, WordsAround) {
    const Program p =
        read_curves(start,
                    "SPLINEPATH(1,X,Y,Z,B)\nBNAT ENAT BSPLINE X10\nX20 Y5\nX30\nCT X40 Y10\nG93\nBSPLINE X50 F2\n"
                    "X60\nX70 G9\nG94 POLYPATH(\"AXES\")\nPOLY PO[X]=(80,1) F60");
    EXPECT_EQ(p.moves.size(), 5u);
    EXPECT_NE(p.moves[2].arc, program::no_arc) << "CT goes on from the curve's end";
    EXPECT_EQ(p.moves[3].feed.rule, program::FeedRule::block_time);
    EXPECT_DOUBLE_EQ(p.moves[3].feed.value, 30);
    EXPECT_TRUE(p.moves[3].exact_stop);
    EXPECT_TRUE(told(p, "NC0012", "BNAT"));
}

TEST(SinumerikCurves, Refusals) {
    const std::pair<std::string_view, std::string_view> refusals[] = {
        {"ASPLINE X1", "NC0602"},
        {"CSPLINE X1", "NC0602"},
        {"SPLINEPATH(1,X,Y)", "NC0602"},
        {"POLYPATH(\"VECT\")", "NC0602"},
        {"LEAD=5 X1", "NC0638"},
        {"X1 A5=1", "NC0638"},
        {"ORIPATH", "NC0638"},
        {"ORIRESET(0,0)", "NC0601"},
        {"BSPLINE X1\nX2", "NC0630"},
        {"BSPLINE SD=4 X1", "NC0631"},
        {"BSPLINE SD=1.5 X1", "NC0631"},
        {"BSPLINE X1\nX2 SD=2", "NC0631"},
        {"BSPLINE X1 PL=1\nX2 PL=1\nX3 PL=1", "NC0632"},
        {"BSPLINE X1 PL=0\nX2 PL=1\nX3", "NC0632"},
        {"BSPLINE X1 PL=0\nX2 PL=0\nX3 PL=0", "NC0632"},
        {"BSPLINE X1 PL=0\nX2 PL=-1\nX3 PL=0", "NC0632"},
        {"BSPLINE X1 PL=0\nX2 PL=1\nX3 PL=0\nX4 PL=0\nX5 PL=0\nX6 PL=1\nX7 PL=0", "NC0632"},
        {"BSPLINE X1\nX2 PW=0\nX3", "NC0633"},
        {"BSPLINE X1\nX2 PW=3.5\nX3", "NC0633"},
        {"X1 PL=2", "NC0613"},
        {"BSPLINE X0\nX0\nX0", "NC0637"},
        {"BSPLINE X1 B5\nX2\nX3 C5", "NC0629"},
        {"G54\nBSPLINE X1", "NC0629"},
        {"POLY PO[X]=(1,2,3,4,5,6)", "NC0634"},
        {"POLY PO[X]=()", "NC0634"},
        {"POLY PO[F]=(1,2)", "NC0634"},
        {"POLY PO[PHI]=(1,2)", "NC0634"},
        {"POLY PO[X]=(1,2) PL=0", "NC0634"},
        {"PO[X]=(1,2)", "NC0634"},
        {"POLY\nTRANS X=PO(1,2)", "NC0634"},
        {"POLY PO[X]=(1,2) X1", "NC0607"},
        {"POLY PO[X]=(1,2) PO[]=(-1)", "NC0635"},
        {"POLY PO[X]=(1,2) Y5 PO[]=(2)", "NC0635"},
        {"POLY PO[X]=(1,2) PO[B]=(2,1) PO[]=(2)", "NC0635"},
        {"POLY PO[X]=(1,2) PO[B]=(2,1)", "NC0629"},
        {"POLY PO[Y]=(0,0)", "NC0637"},
        {"MCALL CYCLE81(9,0,1,-5)\nBSPLINE X1", "NC0628"},
        {"POLY PO[X]=1", "NC0501"},
    };
    for (const auto& [blocks, code] : refusals) EXPECT_EQ(refusal(start, blocks), code) << blocks;
    EXPECT_EQ(refusal("G71 TRAORI\nG0 X0 Y0 Z0 B0 C0 F5\n", "BSPLINE X1 A3=1 C3=1\nX2\nX3"), "NC0629");
    EXPECT_EQ(refusal("G71 TRAORI\nG0 X0 Y0 Z0 B0 C0 F5\n", "BSPLINE X1\nX2 A3=1\nX3"), "NC0629");
    EXPECT_EQ(refusal(start_traori, "FGROUP(X,Y,Z,B)\nB0 C0\nBSPLINE X1\nX2\nX3"), "NC0627");
    EXPECT_EQ(refusal(start_traori, "ORICURVE\nPOLY PO[X]=(1,2) PO[]=(2,1) XH=1 YH=0 ZH=50"), "NC0635");
    EXPECT_EQ(refusal(start_traori, "BSPLINE X1 A3=1\nX2 A3=-1 C3=.01\nX3"), "NC0637");
}

}  // namespace
}  // namespace trunnion::nc
