#include "trunnion/surfacing/path_interval.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "sample_surfaces.hpp"

namespace {

using namespace trunnion;
using namespace trunnion::surfacing;
using namespace trunnion::surfacing::samples;

constexpr double infinite = std::numeric_limits<double>::infinity();

TEST(PathInterval, OfAFlatToolIsEquationTwo) {
    // h/R = 1/cos θ − 1 (Lin & Koren, Eq. 1), P = 2R sin θ.
    for (const double radius : {5.0, 50.0, 500.0})
        for (const double scallop : {0.001, 0.01, 0.1}) {
            const double angle = std::acos(radius / (radius + scallop));
            EXPECT_NEAR(flat_interval_mm(radius, scallop), 2 * radius * std::sin(angle), 1e-7);
        }
}

TEST(PathInterval, OfAFlatToolEndsWhereTheFlatDoes) {
    const double radius = 50, scallop = 0.01, interval = flat_interval_mm(radius, scallop);
    const double needed = interval * (radius + scallop) / radius;  // Eq. 2 holds for D ≥ P (R + h)/R
    EXPECT_NEAR(flat_reach_mm(radius, needed), interval, 1e-9);
    EXPECT_LT(flat_reach_mm(radius, 0.99 * needed), interval);
    EXPECT_EQ(flat_reach_mm(infinite, 10), 10);
}

TEST(PathInterval, OfAPlaneIsTheDiameter) {
    const auto at = shape_at(plane(40, 30), {0.3, 0.6}, geometry::Side::along).value();
    const Cutter flat = Cutter::make(flat_tool(10)).value();
    for (const double angle : {0.0, 0.4, 1.5})
        EXPECT_EQ(path_interval_mm(flat, at, at.normal, {std::cos(angle), std::sin(angle)}, 0.01), 10);
    const Cutter torus = Cutter::make(torus_tool(10, 2)).value();
    EXPECT_NEAR(path_interval_mm(torus, at, at.normal, {1, 0}, 0.01), 6 + 2 * std::sqrt(2 * 2 * 0.01 - 1e-4), 1e-9);
    const Cutter ball = Cutter::make(ball_tool(10)).value();
    EXPECT_NEAR(path_interval_mm(ball, at, at.normal, {1, 0}, 0.01), 2 * std::sqrt(2 * 5 * 0.01 - 1e-4), 1e-9);
}

TEST(PathInterval, OfABallMeetsBothCircles) {
    for (const double radius : {30.0, -30.0}) {
        const double tool = 5, scallop = 0.01, interval = round_interval_mm(radius, tool, scallop);
        const double angle = std::asin(interval / 2 / std::abs(radius));
        // From the surface's centre: ridge at R + h on the axis, tool's centre at R + r, turned by the angle.
        const double ridge = radius + scallop, centre = radius + tool;
        const double apart = std::sqrt(ridge * ridge + centre * centre - 2 * ridge * centre * std::cos(angle));
        EXPECT_NEAR(apart, tool, 1e-9) << radius;
    }
    for (const double radius : {1e6, -1e8, 1e10, -1e12})  // along lines of inflection
        EXPECT_NEAR(round_interval_mm(radius, 5, 0.01), round_interval_mm(infinite, 5, 0.01), 1e-4) << radius;
    EXPECT_GT(round_interval_mm(-30, 5, 0.01), round_interval_mm(infinite, 5, 0.01));
    EXPECT_LT(round_interval_mm(30, 5, 0.01), round_interval_mm(infinite, 5, 0.01));
}

TEST(PathInterval, TakesTheConjugateRadius) {
    // Radii 20 and 200 at 45°: with the normal radius 36.36 the scallop would be a third of what is allowed.
    const Face face = facing(torus(180, 20, -0.2, 0.4, 0.4), {1, 0, 0});
    const auto at = shape_at(face.surface, {0.5, 0.5}, face.side).value();
    const auto k = geometry::principal_curvatures(at.shape);
    ASSERT_NEAR(k.larger, 1.0 / 20, 1e-9);
    ASSERT_NEAR(k.smaller, 1.0 / 200, 1e-9);
    const Eigen::Vector2d other(-k.direction.y(), k.direction.x());
    const Eigen::Vector2d across = (k.direction + other).normalized();
    const Cutter flat = Cutter::make(flat_tool(20)).value();
    EXPECT_NEAR(path_interval_mm(flat, at, at.normal, across, 0.01), flat_interval_mm(110, 0.01), 1e-6);
    const double theirs = path_interval_mm(flat, at, at.normal, across, 0.01, true);
    EXPECT_NEAR(theirs, flat_interval_mm(400.0 / 11, 0.01), 1e-6);
    EXPECT_NEAR(theirs * theirs / (8 * 110), 0.0033, 2e-5);
}

/// Least height of a tool over points of the surface round a place, along the normal there.
double least_height_mm(const Cutter& cutter, const Face& face, const geometry::SurfaceShape& at,
                       const CutterPose& pose) {
    double least = infinite;
    const Eigen::Vector2d by_a = at.parameters_along(at.e1), by_b = at.parameters_along(at.e2);
    for (int i = -200; i <= 200; ++i)
        for (int j = -200; j <= 200; ++j) {
            const Eigen::Vector2d place = Eigen::Vector2d(0.5, 0.5) + 0.005 * (i * by_a + j * by_b);
            const Eigen::Vector3d point = face.surface.at(place.x(), place.y());
            least = std::min(least, cutter.height_mm(pose, point + 0.1 * at.normal, at.normal, 1) + 0.1);
        }
    return least;
}

TEST(GapNearby, IsThatOfTheSurfaceAllRound) {
    const Face round = facing(torus(180, 20, -0.2, 0.4, 0.4), {1, 0, 0});
    const Face hollow = facing(torus(180, 20, -0.2, 0.4, 0.4), {-1, 0, 0});
    for (const Face& face : {round, hollow})
        for (const machine::Tool& tool : {flat_tool(6), torus_tool(6, 1), ball_tool(6)}) {
            const Cutter cutter = Cutter::make(tool).value();
            const auto at = shape_at(face.surface, {0.5, 0.5}, face.side).value();
            const auto leaning = [&](double a, double b) {
                return Eigen::Vector3d(at.normal + std::tan(a) * at.e1 + std::tan(b) * at.e2).normalized();
            };
            const CutterPose touching = cutter.touching(at.point, at.normal, leaning(0.3, 0.1));
            EXPECT_NEAR(gap_nearby_mm(cutter, at, touching), 0, 1e-12);
            for (const double turn : {-0.02, 0.02}) {
                const CutterPose turned{touching.tip_mm + 0.01 * at.e1, leaning(0.3, 0.1 + turn)};
                const double gap = gap_nearby_mm(cutter, at, turned);
                EXPECT_NEAR(gap, least_height_mm(cutter, face, at, turned), 3e-4) << cutter.corner_mm() << ' ' << turn;
            }
        }
}

}  // namespace
