#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "trunnion/geometry/bspline_curve.hpp"
#include "trunnion/path/curve_way.hpp"
#include "trunnion/path/path_builder.hpp"
#include "trunnion/path/rotary_stands.hpp"

#include "trunnion_table.hpp"

/// Curves of a program on their way into runs.
namespace trunnion::path {
namespace {

using Eigen::Vector3d;
using program::Curve;
using program::Move;
using program::Program;

/// A cubic of two spans, with a tool axis or words that turn along it.
Program two_spans(OrientationLaw law) {
    Program out;
    Curve curve;
    curve.degree = 3;
    curve.knots = {0, 0, 0, 0, 2, 3, 3, 3, 3};
    curve.position_mm = {{0, 0, 0}, {4, 1, 0}, {8, 6, 1}, {12, 4, 2}, {16, -3, 0}};
    for (int i = 0; i < 5; ++i) {
        if (law == OrientationLaw::vector)
            curve.axis.emplace_back(6 + i, 2.0 * i, 20);
        else
            curve.rotary_rad.push_back({(20 + 7.0 * i) * degree, 10.0 * i * i * degree, 0});
    }
    if (law == OrientationLaw::rotary) out.rotary_letters = {'A', 'C'};
    const auto position = geometry::BsplineCurve::make(3, curve.knots, curve.position_mm).value();
    const auto point = [&](const std::vector<Vector3d>& points, double u) {
        return geometry::BsplineCurve::make(3, curve.knots, points).value().evaluate(u)[0];
    };
    std::vector<Vector3d> words;
    for (const auto& at : curve.rotary_rad) words.emplace_back(at[0], at[1], at[2]);
    Move move;
    move.law = law;
    move.feed = {FeedRule::tip_speed, 10};
    const double ends[] = {0, 2, 3};
    for (int k = 0; k < 3; ++k) {
        move.position_mm = position.evaluate(ends[k])[0];
        if (law == OrientationLaw::vector)
            move.axis = point(curve.axis, ends[k]).normalized();
        else
            Eigen::Map<Vector3d>(move.rotary_rad.data()) = point(words, ends[k]);
        move.line = k + 1;
        if (k > 0) {
            move.curve_part = k - 1;
            out.curve_parts.push_back({0, ends[k - 1], ends[k]});
        }
        out.moves.push_back(move);
    }
    out.curves.push_back(curve);
    return out;
}

Result<Run> built(const Program& program, const machine::Setup& setup = {},
                  const machine::Machine& machine = trunnion_table()) {
    const auto stands = choose_rotary_stands(program, machine, setup);
    if (!stands) return fail(stands.error());
    static std::vector<PathBuilder> kept;  // the runs' kinematics
    auto builder = PathBuilder::make(program, machine, setup, *stands);
    if (!builder) return fail(builder.error());
    kept.push_back(std::move(*builder));
    Run run;
    if (auto more = kept.back().next(run); !more) return fail(more.error());
    return run;
}

Vector3d position(const PathCoordinates& at) {
    return Vector3d(at.position_mm.data());
}

TEST(Curves, ComeIntoTheRunPartByPart) {
    const Program program = two_spans(OrientationLaw::vector);
    const auto run = built(program);
    ASSERT_TRUE(run) << to_string(run.error());
    ASSERT_EQ(run->blocks.size(), 2u);
    const Curve& curve = program.curves[0];
    const auto tip = geometry::BsplineCurve::make(3, curve.knots, curve.position_mm).value();
    const auto axis = geometry::BsplineCurve::make(3, curve.knots, curve.axis).value();
    for (std::size_t block = 0; block < 2; ++block) {
        const CurveWay way(*run, block);
        const auto& part = program.curve_parts[block];
        for (const double v : {0.0, 0.3, 0.8, 1.0}) {
            const double u = part.from_u + v * (part.to_u - part.from_u);
            EXPECT_LT((position(way.at(v)) - tip.evaluate(u)[0]).norm(), 1e-12);
            EXPECT_LT((Vector3d(way.at(v).orientation.data()) - axis.evaluate(u)[0].normalized()).norm(), 1e-12);
        }
        EXPECT_NEAR(run->blocks[block].length_mm, way.length_mm(0, 1), 1e-9);
    }
}

TEST(Curves, AreMovedWithTheWorkOffset) {
    Program program = two_spans(OrientationLaw::vector);
    program.offsets.push_back("G55");
    machine::Setup setup;
    setup.offsets["G55"] = {Vector3d(10, 20, 30), Eigen::AngleAxisd(0.3, Vector3d::UnitZ()).toRotationMatrix()};
    for (Move& move : program.moves) move.offset = 1;
    const auto run = built(program, setup);
    ASSERT_TRUE(run) << to_string(run.error());
    const CurveWay way(*run, 0);
    const Vector3d in_offset =
        geometry::BsplineCurve::make(3, program.curves[0].knots, program.curves[0].position_mm).value().evaluate(1)[0];
    const auto& frame = setup.offsets["G55"];
    EXPECT_LT((position(way.at(0.5)) - frame.rotation * in_offset - frame.origin_mm).norm(), 1e-12);
}

TEST(Curves, WithoutTcpAreThoseOfTheLinearAxes) {
    for (const Space space : {Space::machine, Space::untransformed}) {
        Program program = two_spans(OrientationLaw::rotary);
        for (Move& move : program.moves) move.space = space;
        machine::Setup setup;
        setup.tool.length_mm = 40;
        setup.workpiece.origin_mm = {1, 2, 3};
        const auto run = built(program, setup);
        ASSERT_TRUE(run) << to_string(run.error());
        EXPECT_EQ(run->space, Space::machine);
        const CurveWay way(*run, 1);
        const Vector3d shift = space == Space::machine ? Vector3d::Zero() : Vector3d(1, 2, 43);
        const Curve& curve = program.curves[0];
        const auto tip = geometry::BsplineCurve::make(3, curve.knots, curve.position_mm).value();
        EXPECT_LT((position(way.at(0.5)) - tip.evaluate(2.5)[0] - shift).norm(), 1e-12);
    }
}

TEST(Curves, TurnByTheirWords) {
    const Program program = two_spans(OrientationLaw::rotary);
    const auto run = built(program);
    ASSERT_TRUE(run) << to_string(run.error());
    std::vector<Vector3d> words;
    for (const auto& at : program.curves[0].rotary_rad) words.emplace_back(at[0], at[1], 0);
    const auto spline = geometry::BsplineCurve::make(3, program.curves[0].knots, words).value();
    const CurveWay way(*run, 0);
    const auto there = way.at(0.25).orientation;
    EXPECT_NEAR(there[0], spline.evaluate(0.5)[0].x(), 1e-12);
    EXPECT_NEAR(there[1], spline.evaluate(0.5)[0].y(), 1e-12);
}

TEST(Curves, WithoutOrientationTurnInProportionToTheParameter) {
    Program program = two_spans(OrientationLaw::vector);
    program.curves[0].axis.clear();
    const auto run = built(program);
    ASSERT_TRUE(run) << to_string(run.error());
    const CurveWay way(*run, 0);
    const Vector3d expected = geometry::slerp(program.moves[0].axis, program.moves[1].axis, 0.3);
    EXPECT_LT((Vector3d(way.at(0.3).orientation.data()) - expected).norm(), 1e-12);
}

TEST(Curves, OneSplineForEachBlockIsAsGood) {
    Program program = two_spans(OrientationLaw::vector);
    program.curves.push_back(program.curves[0]);
    program.curve_parts[1].curve = 1;
    ASSERT_TRUE(built(program));
}

/// A quarter circle of 10 mm as a rational quadratic.
path::Run quarter() {
    const double w = std::numbers::sqrt2 / 2;
    geometry::BezierPiece piece;
    piece.degree = 2;
    piece.control[0] = {10, 0, 0, 1};
    piece.control[1] = {10 * w, 10 * w, 0, w};
    piece.control[2] = {0, 10, 0, 1};
    Run run;
    run.vertices = {{{10, 0, 0}, {0, 0, 1}}, {{0, 10, 0}, {0, 0, 1}}};
    run.curves = {{piece, {}}};
    run.blocks.push_back({.curve = 0});
    return run;
}

TEST(CurveWay, GoesAnEvenPaceByLength) {
    const path::Run run = quarter();
    const CurveWay way(run, 0);
    EXPECT_NEAR(way.length_mm(0, 1), 5 * std::numbers::pi, 1e-9);
    const double v = way.at_length(0.3), angle = 0.15 * std::numbers::pi;
    EXPECT_NEAR(way.at(v).position_mm[0], 10 * std::cos(angle), 1e-7);
    const auto series = way.by_length(v);
    EXPECT_NEAR(series[0].d1(), -std::sin(angle), 1e-7);
    EXPECT_NEAR(series[0].d2(), -std::cos(angle) / 10, 1e-8);
    EXPECT_NEAR(series[1].d3(), -std::cos(angle) / 100, 1e-8);
}

TEST(CurveWay, CountsTurningAsTheMetricOfThePathDoes) {
    const Program program = two_spans(OrientationLaw::vector);
    const auto run = built(program);
    ASSERT_TRUE(run);
    const CurveWay way(*run, 0);
    double sum = 0;
    constexpr int parts = 4000;
    for (int k = 0; k < parts; ++k)
        sum += block_length_mm(*run, way.at(k / double(parts)), way.at((k + 1) / double(parts)));
    EXPECT_NEAR(way.length_mm(0, 1), sum, 1e-5 * sum);
}

// Refusals

template <class Spoil>
void expect_refused(const char* code, const Spoil& spoil, OrientationLaw law = OrientationLaw::vector) {
    Program program = two_spans(law);
    spoil(program);
    const auto run = built(program);
    ASSERT_FALSE(run) << code;
    EXPECT_EQ(run.error().code, code) << run.error().text;
}

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

TEST(CurveRefusals, PartsThatDoNotExist) {
    expect_refused("PATH0121", [](Program& p) { p.moves[1].curve_part = 2; });
    expect_refused("PATH0121", [](Program& p) { p.moves[1].curve_part = -2; });
    expect_refused("PATH0121", [](Program& p) { p.curve_parts[0].curve = 1; });
    expect_refused("PATH0121", [](Program& p) { p.moves[0].curve_part = 0; });
    expect_refused("PATH0121", [](Program& p) {
        p.arcs.push_back({});
        p.moves[1].arc = 0;
    });
}

TEST(CurveRefusals, CurvesThatAreNone) {
    expect_refused("PATH0122", [](Program& p) { p.curves[0].degree = 0; });
    expect_refused("PATH0122", [](Program& p) { p.curves[0].degree = 8; });
    expect_refused("PATH0122", [](Program& p) { p.curves[0].knots.pop_back(); });
    expect_refused("PATH0122", [](Program& p) { p.curves[0].knots[4] = 4; });
    expect_refused("PATH0122", [](Program& p) { p.curves[0].knots[4] = nan; });
    expect_refused("PATH0122", [](Program& p) { p.curves[0].axis.pop_back(); });
    expect_refused("PATH0122", [](Program& p) { p.curves[0].position_mm[2].y() = nan; });
    expect_refused("PATH0122", [](Program& p) { p.curves[0].axis[2].y() = nan; });
    expect_refused("PATH0122", [](Program& p) { p.curves[0].weights = {1, 1, 1, 1}; });
    expect_refused("PATH0122", [](Program& p) { p.curves[0].weights = {1, 1, 0, 1, 1}; });
    expect_refused("PATH0122", [](Program& p) { p.curves[0].weights = {1, 1, -1, 1, 1}; });
    expect_refused("PATH0122", [](Program& p) { p.curves[0].rotary_rad.pop_back(); }, OrientationLaw::rotary);
    expect_refused("PATH0122", [](Program& p) { p.curves[0].rotary_rad[1][0] = nan; }, OrientationLaw::rotary);
}

TEST(CurveRefusals, PartsThatAreEmptyOutsideOrOverAKnot) {
    expect_refused("PATH0123", [](Program& p) { p.curve_parts[0].from_u = 2; });
    expect_refused("PATH0123", [](Program& p) { p.curve_parts[0].from_u = 2.5; });
    expect_refused("PATH0123", [](Program& p) { p.curve_parts[0].from_u = -0.1; });
    expect_refused("PATH0123", [](Program& p) { p.curve_parts[1].to_u = 3.1; });
    expect_refused("PATH0123", [](Program& p) { p.curve_parts[1].to_u = nan; });
    expect_refused("PATH0123", [](Program& p) { p.curve_parts[0].to_u = 2.1; });
}

TEST(CurveRefusals, EndsThatAreElsewhere) {
    expect_refused("PATH0124", [](Program& p) { p.moves[0].position_mm.x() += 2e-3; });
    expect_refused("PATH0124", [](Program& p) { p.moves[2].position_mm.x() += 2e-3; });
    expect_refused("PATH0124", [](Program& p) {
        p.moves[0].axis = {0.1, 0, 1};
        p.moves[0].axis.normalize();
    });
    expect_refused("PATH0124", [](Program& p) { p.moves[2].rotary_rad[1] += 1e-4; }, OrientationLaw::rotary);
    Program near = two_spans(OrientationLaw::vector);
    near.moves[0].position_mm.x() += 0.9e-3;
    const auto run = built(near);
    ASSERT_TRUE(run) << "within 1 µm it is the curve";
    EXPECT_EQ(CurveWay(*run, 0).at(0).position_mm[0], near.moves[0].position_mm.x());
}

TEST(CurveRefusals, AxesThatVanishOrHaveNoTcp) {
    expect_refused("PATH0125", [](Program& p) {
        for (std::size_t i = 0; i < 5; ++i) p.curves[0].axis[i] = (2.0 - static_cast<double>(i)) * Vector3d(1, 0, 1);
    });
    expect_refused("PATH0125", [](Program& p) {
        for (Move& move : p.moves) move.space = Space::machine;
    });
}

}  // namespace
}  // namespace trunnion::path
