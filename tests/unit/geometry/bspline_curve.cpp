#include "trunnion/geometry/bspline_curve.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace {

using namespace trunnion;
using namespace trunnion::geometry;
using Eigen::Vector3d;

using Points = std::vector<Vector3d>;

/// Basis function from its recursive definition, half-open intervals, 0/0 := 0.
double basis(const std::vector<double>& t, std::size_t i, std::size_t p, double u) {
    if (p == 0) return t[i] <= u && u < t[i + 1] ? 1 : 0;
    const double left = t[i + p] - t[i], right = t[i + p + 1] - t[i + 1];
    return (left > 0 ? (u - t[i]) / left * basis(t, i, p - 1, u) : 0) +
           (right > 0 ? (t[i + p + 1] - u) / right * basis(t, i + 1, p - 1, u) : 0);
}

Vector3d by_definition(const BsplineCurve& curve, double u) {
    Vector3d out = Vector3d::Zero();
    for (std::size_t i = 0; i < curve.control_points_mm().size(); ++i)
        out += basis(curve.knots(), i, static_cast<std::size_t>(curve.degree()), u) * curve.control_points_mm()[i];
    return out;
}

Points wavy(std::size_t count) {
    Points out;
    for (std::size_t i = 0; i < count; ++i) {
        const double x = static_cast<double>(i);
        out.emplace_back(10 * x, 7 * std::sin(1.7 * x), 3 * std::cos(0.9 * x * x));
    }
    return out;
}

std::vector<double> uniform_knots(std::size_t count) {
    std::vector<double> out;
    for (std::size_t i = 0; i < count; ++i) out.push_back(0.5 * static_cast<double>(i) - 1);
    return out;
}

std::vector<BsplineCurve> curves() {
    std::vector<BsplineCurve> out;
    out.push_back(BsplineCurve::make(3, {0, 0, 0, 0, 0.2, 0.4, 0.6, 0.8, 1, 1, 1, 1}, wavy(8)).value());
    out.push_back(BsplineCurve::make(3, {0, 0, 0, 0, 1, 1, 2.5, 3, 3, 3, 3}, wavy(7)).value());
    for (int degree = 1; degree <= max_degree; ++degree)
        out.push_back(
            BsplineCurve::make(degree, uniform_knots(11 + static_cast<std::size_t>(degree)), wavy(10)).value());
    return out;
}

TEST(BsplineCurve, IsTheSumOfItsBasisFunctions) {
    for (const auto& curve : curves())
        for (int i = 0; i < 100; ++i) {
            const double u = curve.begin() + (curve.end() - curve.begin()) * i / 100;
            EXPECT_LT((curve.evaluate(u)[0] - by_definition(curve, u)).norm(), 1e-12) << curve.degree() << " " << u;
        }
}

TEST(BsplineCurve, ClampedRunsFromFirstToLastPoint) {
    const auto curve = curves()[0];
    EXPECT_EQ(curve.evaluate(0)[0], curve.control_points_mm().front());
    EXPECT_LT((curve.evaluate(1)[0] - curve.control_points_mm().back()).norm(), 1e-14);
    EXPECT_LT((curve.evaluate(1)[1] - 15 * (curve.control_points_mm()[7] - curve.control_points_mm()[6])).norm(),
              1e-11);
}

TEST(BsplineCurve, DerivativesMatchDifferences) {
    constexpr double h = 1e-4;
    for (const auto& curve : curves()) {
        const double u = curve.begin() + 0.37 * (curve.end() - curve.begin());
        const auto before = curve.evaluate(u - h), at = curve.evaluate(u), after = curve.evaluate(u + h);
        for (std::size_t k = 1; k < 4; ++k)
            EXPECT_LT(((after[k - 1] - before[k - 1]) / (2 * h) - at[k]).norm(), 1e-4 * (1 + at[k].norm()))
                << curve.degree();
    }
}

TEST(BsplineCurve, PiecesAreTheCurve) {
    for (const auto& curve : curves()) {
        double u = curve.begin();
        for (const auto& piece : curve.pieces()) {
            EXPECT_EQ(piece.u_begin, u);
            EXPECT_LT(piece.u_begin, piece.u_end);
            u = piece.u_end;
            for (const double v : {0.0, 0.3, 0.7, 1.0 - 1e-12}) {
                Vector3d sum = Vector3d::Zero();
                for (int k = piece.degree; k >= 0; --k)
                    sum = sum * v + piece.coefficients_mm[static_cast<std::size_t>(k)];
                EXPECT_LT((sum - curve.evaluate(piece.u_begin + v * (piece.u_end - piece.u_begin))[0]).norm(), 1e-9);
            }
        }
        EXPECT_EQ(u, curve.end());
    }
    EXPECT_EQ(curves()[1].pieces().size(), 3u);  // the double knot makes no piece of its own
}

TEST(BsplineCurve, IsRightHandedAtABreakOfADerivative) {
    const auto polyline = BsplineCurve::make(1, {0, 0, 1, 2, 2}, {{0, 0, 0}, {1, 0, 0}, {1, 5, 0}}).value();
    EXPECT_EQ(polyline.evaluate(1)[1], Vector3d(0, 5, 0));
    EXPECT_EQ(polyline.evaluate(1 - 1e-9)[1], Vector3d(1, 0, 0));
    EXPECT_EQ(polyline.evaluate(1)[2], Vector3d(0, 0, 0));
}

TEST(BsplineCurve, ContinuesItsEndPieces) {
    const auto line = BsplineCurve::make(1, {0, 0, 1, 1}, {{0, 0, 0}, {2, 0, 0}}).value();
    EXPECT_EQ(line.evaluate(-1)[0], Vector3d(-2, 0, 0));
    EXPECT_EQ(line.evaluate(3)[0], Vector3d(6, 0, 0));
}

std::string code_of(int degree, std::vector<double> knots, Points points) {
    const auto made = BsplineCurve::make(degree, std::move(knots), std::move(points));
    return made ? "" : made.error().code;
}

TEST(BsplineCurveRefuses, WhatIsNoSpline) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(code_of(0, {0, 1, 2}, wavy(2)), "GEOM0101");
    EXPECT_EQ(code_of(8, uniform_knots(20), wavy(11)), "GEOM0101");
    EXPECT_EQ(code_of(3, {0, 0, 0, 1, 1, 1}, wavy(3)), "GEOM0102");
    EXPECT_EQ(code_of(3, {0, 0, 0, 0, 1, 1, 1}, wavy(4)), "GEOM0102");
    EXPECT_EQ(code_of(3, {0, 0, 0, 0, 1, 1, 1, 0.5}, wavy(4)), "GEOM0103");
    EXPECT_EQ(code_of(3, {0, 0, 0, 0, 1, 1, 1, nan}, wavy(4)), "GEOM0103");
    EXPECT_EQ(code_of(1, {0, 1, 1, 2}, wavy(2)), "GEOM0104");
    EXPECT_EQ(code_of(2, {0, 0, 0, 1, 1, 1, 2, 2, 2}, wavy(6)), "GEOM0104");
    EXPECT_EQ(code_of(1, {0, 0, 1, 1}, {{0, 0, 0}, {nan, 0, 0}}), "GEOM0105");
    EXPECT_EQ(code_of(3, {0, 0, 0, 0, 1, 1, 1, 1}, wavy(4)), "");
}

}  // namespace
