#include "trunnion/geometry/bezier_piece.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "trunnion/geometry/bspline_curve.hpp"
#include "trunnion/geometry/great_circle.hpp"

namespace {

using namespace trunnion;
using namespace trunnion::geometry;
using Eigen::Vector3d;

BsplineCurve made(int degree, bool weighted) {
    std::vector<double> knots, weights;
    std::vector<Vector3d> points;
    const int count = degree + 4;
    for (int i = 0; i < count + degree + 1; ++i) knots.push_back(i + 0.3 * std::sin(i));
    for (int i = 0; i < count; ++i) {
        points.emplace_back(5 * i, 4 * std::sin(1.3 * i), 2 * std::cos(2.1 * i) + 6);
        weights.push_back(weighted ? 1 + 0.6 * std::sin(2.7 * i) : 1);
    }
    return BsplineCurve::make(degree, knots, points, weighted ? weights : std::vector<double>{}).value();
}

/// A quarter of the unit circle, exactly.
BezierPiece quarter() {
    const double w = std::numbers::sqrt2 / 2;
    BezierPiece out;
    out.degree = 2;
    out.control[0] = {1, 0, 0, 1};
    out.control[1] = {w, w, 0, w};
    out.control[2] = {0, 1, 0, 1};
    return out;
}

TEST(BsplineCurve, WithWeightsIsTheQuotientOfSums) {
    const auto curve = made(3, true);
    std::vector<Vector3d> weighted;
    std::vector<Vector3d> weight;
    for (std::size_t i = 0; i < curve.weights().size(); ++i) {
        weighted.push_back(curve.weights()[i] * curve.control_points_mm()[i]);
        weight.push_back(Vector3d::Constant(curve.weights()[i]));
    }
    const auto above = BsplineCurve::make(3, curve.knots(), weighted).value();
    const auto below = BsplineCurve::make(3, curve.knots(), weight).value();
    for (double u = curve.begin(); u < curve.end(); u += 0.07)
        EXPECT_LT((curve.evaluate(u)[0] - above.evaluate(u)[0] / below.evaluate(u)[0].x()).norm(), 1e-12);
}

TEST(BsplineCurve, RefusesWeightsThatDoNotFit) {
    const std::vector<double> knots{0, 0, 1, 1};
    const std::vector<Vector3d> points{{0, 0, 0}, {1, 0, 0}};
    EXPECT_TRUE(BsplineCurve::make(1, knots, points, {1, 2}));
    for (const std::vector<double>& weights :
         {std::vector<double>{1}, {1, 0}, {1, -1}, {1, INFINITY}, {NAN, 1}, {1, 1, 1}}) {
        const auto refused = BsplineCurve::make(1, knots, points, weights);
        ASSERT_FALSE(refused);
        EXPECT_EQ(refused.error().code, "GEOM0107");
    }
}

TEST(BezierPiece, IsItsPartOfTheSpline) {
    for (int degree = 1; degree <= max_degree; ++degree)
        for (const bool weighted : {false, true}) {
            const auto curve = made(degree, weighted);
            for (double at = curve.begin() + 0.01; at < curve.end(); at += 0.9) {
                const auto [begin, end] = curve.interval_at(at);
                const double from = begin + 0.2 * (end - begin), to = end, step = to - from;
                const BezierPiece piece = curve.piece(from, to);
                for (const double v : {0.0, 0.3, 0.99}) {
                    const auto here = piece.evaluate(v), there = curve.evaluate(from + v * step);
                    double scale = 1;
                    for (int k = 0; k < 4; ++k, scale *= step)
                        EXPECT_LT((here[k] - scale * there[k]).norm(), 1e-9 * (1 + scale * there[k].norm()))
                            << "degree " << degree << " derivative " << k;
                    EXPECT_LT((piece.at(v) - here[0]).norm(), 1e-12);
                }
            }
        }
}

TEST(BezierPiece, PartsAndMapsAreThoseOfTheCurve) {
    const BezierPiece piece = quarter(), part = piece.part(0.25, 0.75);
    Eigen::Matrix3d turn;
    turn << 0, -1, 0, 1, 0, 0, 0, 0, 2;
    const BezierPiece mapped = piece.mapped(turn, {1, 2, 3});
    for (const double v : {0.0, 0.4, 1.0}) {
        EXPECT_LT((part.at(v) - piece.at(0.25 + 0.5 * v)).norm(), 1e-15);
        EXPECT_LT((mapped.at(v) - (turn * piece.at(v) + Vector3d(1, 2, 3))).norm(), 1e-15);
        EXPECT_NEAR(piece.at(v).norm(), 1, 1e-15);
    }
    BezierPiece fitted = piece;
    fitted.fit_ends({1.001, 0, 0}, {0, 1, 0.002});
    EXPECT_LT((fitted.at(0) - Vector3d(1.001, 0, 0)).norm(), 1e-15);
    EXPECT_LT((fitted.at(1) - Vector3d(0, 1, 0.002)).norm(), 1e-15);
    EXPECT_LT((fitted.at(0.5) - piece.at(0.5)).norm(), 0.002);
    EXPECT_GT((fitted.at(0.5) - piece.at(0.5)).norm(), 0.0005);
}

TEST(BezierPiece, BoundsOfChordAndTurnHoldAndAreTight) {
    for (int degree = 2; degree <= max_degree; ++degree)
        for (const bool weighted : {false, true}) {
            const auto curve = made(degree, weighted);
            const auto [begin, end] = curve.interval_at(0.5 * (curve.begin() + curve.end()));
            const BezierPiece piece = curve.piece(begin, end).part(0.4, 0.5);
            const Vector3d start = piece.at(0), last = piece.at(1);
            double off = 0, turn = 0, length = 0, angle = 0;
            Vector3d before = start;
            for (double v = 0; v <= 1; v += 1.0 / 64) {
                const Vector3d at = piece.at(v);
                off = std::max(off, (at - ((1 - v) * start + v * last)).norm());
                turn = std::max(turn, angle_between(at, (1 - v) * start.normalized() + v * last.normalized()));
                length += (at - before).norm();
                angle += angle_between(before, at);
                before = at;
            }
            EXPECT_GE(piece.chord_error(), off);
            EXPECT_LE(piece.chord_error(), 1.6 * off) << degree;
            EXPECT_GE(piece.chord_turn(), turn);
            EXPECT_LE(piece.chord_turn(), 1.6 * turn + 1e-12) << degree;
            EXPECT_GE(piece.polygon_length(), length);
            EXPECT_GE(piece.polygon_turn(), angle - 1e-12);
        }
}

TEST(BezierPiece, ADirectionThatMayVanishHasNoBound) {
    BezierPiece piece;
    piece.degree = 1;
    piece.control[0] = {1, 0, 0, 1};
    piece.control[1] = {-1, 0, 0, 1};
    EXPECT_EQ(piece.chord_turn(), std::numbers::pi);
    piece.control[1] = {0, 0, 0, 1};
    EXPECT_GE(piece.polygon_turn(), std::numbers::pi);
}

}  // namespace
