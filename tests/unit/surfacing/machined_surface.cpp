#include "trunnion/surfacing/machined_surface.hpp"

#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "trunnion/geometry/great_circle.hpp"

#include "sample_surfaces.hpp"

namespace {

using namespace trunnion;
using namespace trunnion::surfacing;
using namespace trunnion::surfacing::samples;
using Eigen::Vector3d;

/// Two straight rows of a tool along x, `apart` in y, on the plane z = 0.
std::vector<std::vector<CutterPose>> two_rows(double apart) {
    const Vector3d up(0, 0, 1);
    return {{{{0, 0, 0}, up}, {{30, 0, 0}, up}}, {{{0, apart, 0}, up}, {{30, apart, 0}, up}}};
}

TEST(MachinedSurface, OfTwoRowsOfABallHasTheKnownRidge) {
    const MachinedSurface cut(Cutter::make(ball_tool(10)).value(), two_rows(2));
    const Vector3d up(0, 0, 1);
    for (const double x : {1.0, 15.0, 29.3}) {
        EXPECT_NEAR(cut.height_mm({x, 0, 0}, up, 1), 0, 1e-9);
        EXPECT_NEAR(cut.height_mm({x, 1, 0}, up, 1), 5 - std::sqrt(24.0), 1e-8);
        EXPECT_NEAR(cut.height_mm({x, 2.5, 0}, up, 1), 5 - std::sqrt(25 - 0.25), 1e-8);
    }
    EXPECT_EQ(cut.height_mm({15, 9, 0}, up, 1), 1);                            // uncut
    EXPECT_NEAR(cut.height_mm({15, 0, 0.2}, up, 1), -0.2, 1e-9);               // gouged
    EXPECT_NEAR(cut.height_mm({33, 0, 0}, up, 2), 5 - std::sqrt(16.0), 1e-8);  // beyond the row's end
}

TEST(MachinedSurface, BesideAKnifeEdgeIsAsDeepAsTheToolIsInIt) {
    // A plate of 1 um, cut from above and from below by 2 um: along its normal nothing is left.
    const Vector3d up(0, 0, 1), down(0, 0, -1);
    const MachinedSurface cut(Cutter::make(ball_tool(10)).value(), {{{{0, 0, -0.002}, up}, {{30, 0, -0.002}, up}},
                                                                    {{{0, 0, 0.001}, down}, {{30, 0, 0.001}, down}}});
    EXPECT_NEAR(cut.height_mm({15, 0, 0}, up, 1), -1, 1e-8);
    EXPECT_NEAR(cut.depth_mm({15, 0, 0}), 0.002, 1e-9);
    EXPECT_EQ(cut.depth_mm({15, 9, 0}), 0);
}

TEST(MachinedSurface, OfTiltingMovesIsThatOfManyPoses) {
    // A torus tool that leans more and more, against its poses taken one by one.
    const Cutter torus = Cutter::make(torus_tool(10, 2)).value();
    const Vector3d from = Vector3d(0.1, 0.05, 1).normalized(), to = Vector3d(0.35, -0.1, 1).normalized();
    const MachinedSurface cut(torus, {{{{0, 0, 0}, from}, {{12, 1, 0.5}, to}}});
    const geometry::GreatCircle turn(from, to);
    for (const double x : {2.0, 5.5, 9.0})
        for (const double y : {-2.0, 0.3, 2.5}) {
            const Vector3d point(x, y, -1), up(0, 0, 1);
            double least = 5;
            constexpr int poses = 20000;
            for (int k = 0; k <= poses; ++k) {
                const double w = static_cast<double>(k) / poses;
                least = std::min(least, torus.height_mm({w * Vector3d(12, 1, 0.5), turn.at(w)}, point, up, 5));
            }
            EXPECT_NEAR(cut.height_mm(point, up, 5), least, 2e-5) << x << " " << y;
        }
}

TEST(MachinedSurface, OfNothingIsUncut) {
    EXPECT_EQ(
        MachinedSurface(Cutter::make(ball_tool(10)).value(), std::vector<Pass>{}).height_mm({0, 0, 0}, {0, 0, 1}, 3),
        3);
}

TEST(CheckSurface, SeesWhatIsWrongWithAPlan) {
    const Face face = facing(plane(30, 20), {0, 0, 1});
    const Cutter ball = Cutter::make(ball_tool(10)).value();
    SurfaceOptions options;
    options.chord_tolerance_mm = 0.00025;
    auto plan = plan_surface(face, ball, options).value();
    const auto sound = check_surface(face, ball, plan.passes);
    EXPECT_LT(sound.highest_mm, 0.01);
    EXPECT_LT(sound.deepest_mm, 1e-6);
    ASSERT_GT(sound.ridges, 30u);

    auto deep = plan.passes;  // one pose too low
    auto& low = deep[deep.size() / 3].contacts;
    low[low.size() / 2].pose.tip_mm.z() -= 0.003;
    EXPECT_NEAR(check_surface(face, ball, deep, {.grid_mm = 0.25}).deepest_mm, 0.003, 0.0005);

    auto missing = plan.passes;  // one pass left out: ridges four times as high
    missing.erase(missing.begin() + static_cast<std::ptrdiff_t>(missing.size() / 3));
    EXPECT_NEAR(check_surface(face, ball, missing).largest_ridge_mm, 4 * sound.median_ridge_mm,
                0.1 * sound.median_ridge_mm);
}

}  // namespace
