#include "trunnion/surfacing/cutter.hpp"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "sample_surfaces.hpp"

namespace {

using namespace trunnion;
using namespace trunnion::surfacing;
using namespace trunnion::surfacing::samples;
using Eigen::Vector3d;

const CutterPose upright_pose{{0, 0, 0}, {0, 0, 1}};

std::vector<machine::Tool> tools() {
    return {flat_tool(10), ball_tool(10), torus_tool(10, 2)};
}

/// Nearest of many points on the outline in the meridian plane.
double distance_by_points(const Cutter& cutter, double out, double up) {
    double least = 1e9;
    const double flat = cutter.flat_radius_mm(), corner = cutter.corner_mm();
    constexpr int n = 20000;
    for (int k = 0; k <= n; ++k) {
        const double w = static_cast<double>(k) / n, angle = w * std::numbers::pi / 2;
        least = std::min(least, std::hypot(out - w * flat, up));
        least = std::min(least, std::hypot(out - flat - corner * std::sin(angle), up - corner * (1 - std::cos(angle))));
        if (!cutter.is_ball())
            least = std::min(least,
                             std::hypot(out - cutter.radius_mm(), up - corner - w * (cutter.reach_mm() - 2 * corner)));
    }
    return least;
}

TEST(Cutter, DistanceIsThatOfItsOutline) {
    for (const auto& tool : tools()) {
        const Cutter cutter = Cutter::make(tool).value();
        for (const double out : {0.0, 2.0, 4.0, 4.9, 6.0, 9.0})
            for (const double up : {-3.0, -0.5, 1.0, 3.0}) {
                const double d = cutter.distance_mm(upright_pose, {out * 0.6, out * 0.8, up});
                EXPECT_NEAR(std::abs(d), distance_by_points(cutter, out, up), 1e-3) << out << " " << up;
                const bool inside =
                    up > 0 && out < cutter.radius_mm() &&
                    (up > cutter.corner_mm() || out < cutter.flat_radius_mm() ||
                     std::hypot(out - cutter.flat_radius_mm(), up - cutter.corner_mm()) < cutter.corner_mm());
                EXPECT_EQ(d < 0, inside) << out << " " << up;
            }
    }
}

TEST(Cutter, HeightIsWhereALineMeetsTheBody) {
    const Cutter ball = Cutter::make(ball_tool(10)).value(), flat = Cutter::make(flat_tool(10)).value();
    EXPECT_NEAR(ball.height_mm(upright_pose, {1, 0, -0.5}, {0, 0, 1}, 10), 0.5 + 5 - std::sqrt(24.0), 1e-9);
    const Vector3d inclined = Vector3d(0.2, 0, 1).normalized();
    EXPECT_NEAR(flat.height_mm(upright_pose, {1, 0, -0.5}, inclined, 10), 0.5 / inclined.z(), 1e-8);
    EXPECT_NEAR(flat.height_mm(upright_pose, {1, 0, 0.3}, inclined, 10), -0.3 / inclined.z(), 1e-8);
    EXPECT_EQ(flat.height_mm(upright_pose, {5.1, 0, -0.5}, {0, 0, 1}, 10), 10);
}

TEST(Cutter, TouchesWhereItIsTold) {
    const Face face = facing(cylinder(20, 30, 1), {0, 0, 1});
    const auto at = shape_at(face.surface, {0.4, 0.6}, face.side).value();
    for (const auto& tool : tools())
        for (const double lean : {0.0, 0.1, 0.5}) {
            const Cutter cutter = Cutter::make(tool).value();
            const Vector3d axis = (at.normal + std::tan(lean) * at.e1 + 0.3 * std::tan(lean) * at.e2).normalized();
            const CutterPose pose = cutter.touching(at.point, at.normal, axis);
            EXPECT_NEAR(cutter.distance_mm(pose, at.point), 0, 1e-12);
            EXPECT_NEAR(cutter.distance_mm(pose, at.point - 0.01 * at.normal), 0.01, 1e-9);
            // Curvature: the gap to the tangent plane grows by ½ dᵀKd.
            if (lean == 0 && tool.kind != machine::ToolKind::ball) continue;
            if (tool.kind == machine::ToolKind::flat) continue;  // an edge
            const Eigen::Matrix2d curvature = cutter.curvature(at, axis);
            for (const Eigen::Vector2d& d :
                 {Eigen::Vector2d(0.01, 0), Eigen::Vector2d(0, 0.01), Eigen::Vector2d(0.01, 0.01)}) {
                const double gap = cutter.height_mm(pose, at.point + at.in_space(d), at.normal, 1);
                EXPECT_NEAR(gap, 0.5 * d.dot(curvature * d), 2e-7 + 0.02 * gap);
            }
        }
}

TEST(CutterRefuses, ToolsThatItHasNoBodyFor) {
    const auto code = [](const machine::Tool& tool) {
        const auto made = Cutter::make(tool);
        return made ? "" : made.error().code;
    };
    EXPECT_EQ(code(flat_tool(10)), "");
    EXPECT_EQ(code(flat_tool(0)), "SURF0201");
    EXPECT_EQ(code({.kind = machine::ToolKind::taper, .diameter_mm = 10}), "SURF0201");
    EXPECT_EQ(code(torus_tool(10, 0)), "SURF0201");
    EXPECT_EQ(code(torus_tool(10, 6)), "SURF0201");
}

}  // namespace
