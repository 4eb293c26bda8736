#include "trunnion/geometry/surface_shape.hpp"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace {

using namespace trunnion;
using namespace trunnion::geometry;
using Eigen::Vector2d;
using Eigen::Vector3d;

/// A quarter of a torus' outside, exactly: circle of the tube over u, the way round over v.
BsplineSurface quarter_torus(double ring_mm, double tube_mm) {
    const double w = std::numbers::sqrt2 / 2;
    const std::vector<Vector3d> tube{{ring_mm, 0, tube_mm}, {ring_mm + tube_mm, 0, tube_mm}, {ring_mm + tube_mm, 0, 0}};
    const std::vector<double> arc{1, w, 1};
    std::vector<Vector3d> points;
    std::vector<double> weights;
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) {
            const double r = tube[i].x();
            points.emplace_back(j == 2 ? 0 : r, j == 0 ? 0 : r, tube[i].z());
            weights.push_back(arc[i] * arc[j]);
        }
    const SurfaceDirection quarter{2, {0, 0, 0, 1, 1, 1}};
    return BsplineSurface::make(quarter, quarter, points, weights).value();
}

/// z = ½ (a x² + 2 b x y + c y²) over 20 × 20 mm about the origin.
BsplineSurface quadric(double a, double b, double c) {
    std::vector<Vector3d> k(9, Vector3d::Zero());  // x = 20u − 10, y = 20v − 10
    const auto z = [&](std::size_t i, std::size_t j) -> double& { return k[3 * i + j].z(); };
    k[0] = {-10, -10, 50 * a + 100 * b + 50 * c};
    k[3].x() = 20;
    k[1].y() = 20;
    z(1, 0) = -200 * a - 200 * b;
    z(0, 1) = -200 * c - 200 * b;
    z(2, 0) = 200 * a;
    z(0, 2) = 200 * c;
    z(1, 1) = 400 * b;
    return polynomial_surface(2, 2, k).value();
}

TEST(SurfaceShape, OfATorusIsKnown) {
    const auto torus = quarter_torus(30, 8);
    for (const double u : {0.1, 0.5, 0.8})
        for (const double v : {0.2, 0.6}) {
            const auto shape = shape_at(torus, {u, v}, Side::along).value();
            const Vector3d ring = 30 * Vector3d(shape.point.x(), shape.point.y(), 0).normalized();
            const Vector3d out = (shape.point - ring).normalized();
            const double sign = shape.normal.dot(out);
            EXPECT_NEAR(std::abs(sign), 1, 1e-12);
            const auto outside = shape_at(torus, {u, v}, sign > 0 ? Side::along : Side::against).value();
            const auto k = principal_curvatures(outside.shape);
            const double around = std::hypot(out.x(), out.y()) / std::hypot(shape.point.x(), shape.point.y());
            EXPECT_NEAR(k.larger, 1.0 / 8, 1e-10);
            EXPECT_NEAR(k.smaller, around, 1e-10);
            const auto inside = shape_at(torus, {u, v}, sign > 0 ? Side::against : Side::along).value();
            EXPECT_NEAR(principal_curvatures(inside.shape).smaller, -1.0 / 8, 1e-10);
            EXPECT_NEAR(outside.normal_curvature(k.direction), k.larger, 1e-12);
            EXPECT_NEAR(outside.in_space(k.direction).dot(outside.normal), 0, 1e-12);
        }
}

TEST(SurfaceShape, NormalTurnsByTheShapeOperator) {
    const auto s = quadric(0.02, 0.01, -0.03);
    const SurfacePlace at{0.37, 0.62};
    const auto here = shape_at(s, at, Side::along).value();
    for (const Vector2d& way : {Vector2d(1, 0), Vector2d(0.3, -0.8)}) {
        constexpr double h = 1e-5;
        const auto before = shape_at(s, {at.u - h * way[0], at.v - h * way[1]}, Side::along).value();
        const auto after = shape_at(s, {at.u + h * way[0], at.v + h * way[1]}, Side::along).value();
        const Vector3d moved = (after.point - before.point) / (2 * h),
                       turned = (after.normal - before.normal) / (2 * h);
        EXPECT_LT((here.shape * here.components(moved) - here.components(turned)).norm(), 1e-6);
        EXPECT_LT((here.parameters_along(moved) - way).norm(), 1e-6);
        // κ = II/I in parameters as well
        const double by_forms = way.dot(here.second * way) / way.dot(here.first * way);
        EXPECT_NEAR(by_forms, here.normal_curvature(here.components(moved).normalized()), 1e-7);
    }
}

TEST(ConjugateRadius, IsTheNormalRadiusInPrincipalDirectionsOnly) {
    const Eigen::Matrix2d shape = Vector2d(1.0 / 20, 1.0 / 200).asDiagonal();
    EXPECT_NEAR(conjugate_radius(shape, {1, 0}), 20, 1e-12);
    EXPECT_NEAR(conjugate_radius(shape, {0, 1}), 200, 1e-12);
    // At 45° the outline of the surface seen along the feed, not the normal section of radius 36.4 mm.
    const Vector2d across = Vector2d(1, 1).normalized();
    EXPECT_NEAR(conjugate_radius(shape, across), across.dot(shape.inverse() * across), 1e-10);
    EXPECT_NEAR(conjugate_radius(shape, across), 110, 1e-10);
    EXPECT_NEAR(1 / across.dot(shape * across), 36.3636, 1e-3);
}

TEST(ConjugateRadius, OfFlatSurfacesIsInfiniteOrThatAcross) {
    EXPECT_EQ(conjugate_radius(Eigen::Matrix2d::Zero(), {1, 0}), std::numeric_limits<double>::infinity());
    const Eigen::Matrix2d cylinder = Vector2d(0.05, 0).asDiagonal();
    EXPECT_NEAR(conjugate_radius(cylinder, {1, 0}), 20, 1e-12);
    EXPECT_EQ(conjugate_radius(cylinder, {0, 1}), std::numeric_limits<double>::infinity());
}

TEST(SurfaceShape, IsMissingWhereThereIsNoNormal) {
    // A triangle whose edge u = 0 is one point.
    const auto fan =
        BsplineSurface::make({1, {0, 0, 1, 1}}, {1, {0, 0, 1, 1}}, {{0, 0, 0}, {0, 0, 0}, {1, 0, 0}, {1, 1, 0}})
            .value();
    EXPECT_FALSE(shape_at(fan, {0, 0.5}, Side::along));
    ASSERT_TRUE(shape_at(fan, {0.001, 0.5}, Side::along));
    EXPECT_NEAR(shape_at(fan, {0.001, 0.5}, Side::along)->normal.z(), 1, 1e-12);
    EXPECT_NEAR(shape_at(fan, {0.001, 0.5}, Side::against)->normal.z(), -1, 1e-12);
}

}  // namespace
