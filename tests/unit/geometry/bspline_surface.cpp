#include "trunnion/geometry/bspline_surface.hpp"

#include <cmath>
#include <limits>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "trunnion/geometry/bspline_curve.hpp"

namespace {

using namespace trunnion;
using namespace trunnion::geometry;
using Eigen::Vector3d;

std::vector<double> clamped(int degree, int intervals) {
    std::vector<double> out(static_cast<std::size_t>(degree), 0.0);
    for (int i = 0; i <= intervals; ++i) out.push_back(i + 0.1 * (i % 2));
    out.insert(out.end(), static_cast<std::size_t>(degree), out.back());
    return out;
}

BsplineSurface wavy(int degree_u, int degree_v, bool rational) {
    const SurfaceDirection u{degree_u, clamped(degree_u, 4)}, v{degree_v, clamped(degree_v, 3)};
    std::vector<Vector3d> points;
    std::vector<double> weights;
    for (std::size_t i = 0; i < u.points(); ++i)
        for (std::size_t j = 0; j < v.points(); ++j) {
            const double x = static_cast<double>(i), y = static_cast<double>(j);
            points.emplace_back(10 * x, 8 * y + std::sin(x), 3 * std::sin(x + 0.5 * y));
            weights.push_back(1 + 0.4 * std::sin(2 * x + 3 * y));
        }
    if (!rational) weights.clear();
    return BsplineSurface::make(u, v, points, weights).value();
}

std::vector<BsplineSurface> surfaces() {
    std::vector<BsplineSurface> out;
    for (const bool rational : {false, true}) {
        for (int degree = 1; degree <= max_degree; ++degree)
            out.push_back(wavy(degree, max_degree + 1 - degree, rational));
        out.push_back(wavy(3, 3, rational));
    }
    return out;
}

/// By rows: the curve whose control points are those of the curves along v.
Vector3d by_curves(const BsplineSurface& s, double u, double v) {
    std::vector<Vector3d> column;
    std::vector<double> weights;
    for (std::size_t i = 0; i < s.u().points(); ++i) {
        const std::size_t first = i * s.v().points();
        std::vector<Vector3d> homogeneous;
        std::vector<Vector3d> weight;
        for (std::size_t k = first; k < first + s.v().points(); ++k) {
            const double w = s.weights().empty() ? 1 : s.weights()[k];
            homogeneous.push_back(w * s.control_points_mm()[k]);
            weight.emplace_back(w, 0, 0);
        }
        const double w = BsplineCurve::make(s.v().degree, s.v().knots, weight).value().evaluate(v)[0].x();
        column.push_back(BsplineCurve::make(s.v().degree, s.v().knots, homogeneous).value().evaluate(v)[0] / w);
        weights.push_back(w);
    }
    return BsplineCurve::make(s.u().degree, s.u().knots, column, weights).value().evaluate(u)[0];
}

TEST(BsplineSurface, IsACurveOfCurves) {
    for (const auto& s : surfaces())
        for (int i = 0; i <= 10; ++i)
            for (int j = 0; j <= 10; ++j) {
                const double u = s.u().end() * i / 10, v = s.v().end() * j / 10;
                EXPECT_LT((s.at(u, v) - by_curves(s, u, v)).norm(), 1e-11) << s.u().degree << " " << u << " " << v;
            }
}

TEST(BsplineSurface, DerivativesMatchDifferences) {
    constexpr double h = 1e-4;
    for (const auto& s : surfaces()) {
        const double u = 0.37 * s.u().end(), v = 0.61 * s.v().end();
        const auto at = s.evaluate(u, v);
        const auto u_before = s.evaluate(u - h, v), u_after = s.evaluate(u + h, v);
        const auto v_before = s.evaluate(u, v - h), v_after = s.evaluate(u, v + h);
        const auto near = [&](const Vector3d& after, const Vector3d& before, const Vector3d& derivative) {
            EXPECT_LT(((after - before) / (2 * h) - derivative).norm(), 1e-5 * (1 + derivative.norm())) << s.u().degree;
        };
        near(u_after.at, u_before.at, at.by_u);
        near(v_after.at, v_before.at, at.by_v);
        near(u_after.by_u, u_before.by_u, at.by_uu);
        near(u_after.by_v, u_before.by_v, at.by_uv);
        near(v_after.by_u, v_before.by_u, at.by_uv);
        near(v_after.by_v, v_before.by_v, at.by_vv);
    }
}

TEST(BsplineSurface, ContinuesItsEndPieces) {
    const auto plane =
        BsplineSurface::make({1, {0, 0, 1, 1}}, {1, {0, 0, 1, 1}}, {{0, 0, 0}, {0, 2, 0}, {3, 0, 0}, {3, 2, 0}})
            .value();
    EXPECT_EQ(plane.at(-1, 2), Vector3d(-3, 4, 0));
}

TEST(PolynomialSurface, IsItsCoefficients) {
    std::vector<Vector3d> a;
    for (int k = 0; k < 12; ++k) a.emplace_back(std::sin(k + 1.0), std::cos(2.0 * k), 0.1 * k);
    const auto s = polynomial_surface(3, 2, a).value();  // Lin & Koren, Eq. 3
    for (const double u : {0.0, 0.3, 1.0})
        for (const double v : {0.0, 0.7, 1.0}) {
            Vector3d sum = Vector3d::Zero();
            for (int i = 0; i <= 3; ++i)
                for (int j = 0; j <= 2; ++j)
                    sum += std::pow(u, i) * std::pow(v, j) * a[static_cast<std::size_t>(3 * i + j)];
            EXPECT_LT((s.at(u, v) - sum).norm(), 1e-14);
        }
}

TEST(ClosestPlace, IsWhereTheNormalMeetsThePoint) {
    for (const auto& s : surfaces()) {
        if (s.u().degree == 1 || s.v().degree == 1) continue;  // has edges inside
        for (int i = 1; i < 8; ++i) {
            const double u = s.u().end() * i / 8, v = s.v().end() * (9 - i) / 9;
            const auto at = s.evaluate(u, v);
            const Vector3d point = at.at + 0.3 * at.by_u.cross(at.by_v).normalized();
            const auto global = closest_place(s, point);
            EXPECT_LT((s.at(global.u, global.v) - at.at).norm(), 1e-7) << s.u().degree << " " << i;
            const auto local = closest_place(s, point, {u + 0.05, v - 0.05});
            EXPECT_LT((s.at(local.u, local.v) - at.at).norm(), 1e-7) << s.u().degree << " " << i;
        }
    }
}

TEST(ClosestPlace, StaysWithinTheDomainUnlessAMarginIsGiven) {
    const auto plane =
        BsplineSurface::make({1, {0, 0, 1, 1}}, {1, {0, 0, 1, 1}}, {{0, 0, 0}, {0, 20, 0}, {30, 0, 0}, {30, 20, 0}})
            .value();
    const auto inside = closest_place(plane, {33, 7, 5}, {0.5, 0.5});
    EXPECT_EQ(inside.u, 1);
    EXPECT_NEAR(inside.v, 0.35, 1e-12);
    EXPECT_NEAR(closest_place(plane, {33, 7, 5}, {0.5, 0.5}, 0.2).u, 1.1, 1e-12);
    const auto corner = closest_place(plane, {40, 50, 0});
    EXPECT_EQ(corner.u, 1);
    EXPECT_EQ(corner.v, 1);
}

std::string code_of(SurfaceDirection u, SurfaceDirection v, std::vector<Vector3d> points, std::vector<double> w = {}) {
    const auto made = BsplineSurface::make(std::move(u), std::move(v), std::move(points), std::move(w));
    return made ? "" : made.error().code;
}

TEST(BsplineSurfaceRefuses, WhatIsNoSurface) {
    const SurfaceDirection line{1, {0, 0, 1, 1}};
    const std::vector<Vector3d> net{{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}};
    EXPECT_EQ(code_of(line, line, net), "");
    EXPECT_EQ(code_of({0, {0, 1, 2}}, line, net), "GEOM0101");
    EXPECT_EQ(code_of(line, {8, std::vector(18, 0.0)}, net), "GEOM0101");
    EXPECT_EQ(code_of({1, {0, 0, 1}}, line, net), "GEOM0102");
    EXPECT_EQ(code_of(line, line, {net.begin(), net.end() - 1}), "GEOM0102");
    EXPECT_EQ(code_of(line, {1, {0, 1, 0, 1}}, net), "GEOM0103");
    EXPECT_EQ(code_of(line, {1, {0, 1, 1, 2}}, net), "GEOM0104");
    auto broken = net;
    broken[3].z() = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(code_of(line, line, broken), "GEOM0105");
    EXPECT_EQ(code_of(line, line, net, {1, 1, 1}), "GEOM0107");
    EXPECT_EQ(code_of(line, line, net, {1, 1, 1, 0}), "GEOM0107");
    EXPECT_EQ(polynomial_surface(8, 1, std::vector(18, Vector3d(0, 0, 0))).error().code, "GEOM0101");
    EXPECT_EQ(polynomial_surface(3, 1, net).error().code, "GEOM0102");
}

}  // namespace
