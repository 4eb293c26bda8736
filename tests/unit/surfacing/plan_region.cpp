#include "trunnion/surfacing/plan_region.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"

#include "sample_surfaces.hpp"

namespace {

using namespace trunnion;
using namespace trunnion::surfacing;
using namespace trunnion::surfacing::samples;
using Eigen::Vector3d;

constexpr double pi = std::numbers::pi;

/// A patch of a cylinder round the y axis from one angle on, u along y.
geometry::BsplineSurface cylinder_part(double radius, double length, double from, double turn) {
    std::vector<Vector3d> points;
    std::vector<double> weights;
    for (const double y : {0.0, length})
        for (const ArcPoint& p : arc(radius, from, turn)) {
            points.emplace_back(p.x, y, p.y);
            weights.push_back(p.weight);
        }
    return geometry::BsplineSurface::make(line(), quadratic(), points, weights).value();
}

/// Two halves of a vault that meet at its top.
std::vector<Face> vault() {
    std::vector<Face> faces{facing(cylinder_part(20, 14, pi / 2, 0.4), {0, 0, 1}),
                            facing(cylinder_part(20, 14, pi / 2 - 0.4, 0.4), {0, 0, 1})};
    faces[1].number = 2;
    return faces;
}

SurfaceOptions planes(double angle_deg) {
    SurfaceOptions options;
    options.strategy = Strategy::parallel_planes;
    options.chord_tolerance_mm = 0.00025;
    options.feed_angle_rad = angle_deg * degree;
    return options;
}

Cutter ball(double diameter) {
    return Cutter::make(ball_tool(diameter)).value();
}

TEST(PlanRegion, LeadsPassesOnAcrossTheBordersOfFaces) {
    const auto faces = vault();
    const auto plan = plan_region(faces, ball(16), planes(90));
    ASSERT_TRUE(plan) << to_string(plan.error());
    std::size_t crossing = 0, cutting = 0;
    for (const Pass& pass : plan->passes) {
        if (pass.index < 0) continue;
        ++cutting;
        std::set<int> on;
        for (const Contact& contact : pass.contacts) on.insert(contact.face);
        crossing += on.size() == 2;
        for (std::size_t i = 1; i < pass.contacts.size(); ++i)
            EXPECT_GT((pass.contacts[i].point_mm - pass.contacts[i - 1].point_mm).norm(), 1e-5);
    }
    EXPECT_EQ(crossing, cutting);
    // The border that both share has no pass of its own: six of eight are left.
    EXPECT_EQ(std::ranges::count(plan->passes, -1, &Pass::index), 6);
    const auto verdict = check_region(faces, ball(16), plan->passes);
    EXPECT_LT(verdict.highest_mm, 0.01005);
    EXPECT_LT(verdict.deepest_mm, 0.001);
    EXPECT_GT(plan->highest_ridge_mm, 0.009);  // of a cylinder cut by planes across it
}

TEST(PlanRegion, FaceByFaceCoversTheSharedBorderOnce) {
    const auto faces = vault();
    SurfaceOptions options = planes(30);
    options.strategy = Strategy::constant_scallop;
    options.across_joints = false;
    const auto plan = plan_region(faces, ball(16), options).value();
    EXPECT_EQ(std::ranges::count(plan.passes, -1, &Pass::index), 7);
    const auto verdict = check_region(faces, ball(16), plan.passes);
    EXPECT_LT(verdict.highest_mm, 0.01005);
    EXPECT_LT(verdict.deepest_mm, 0.001);
    EXPECT_GT(plan.highest_ridge_mm, 0.009);
}

TEST(PlanRegion, OfOneFaceIsThatOfTheFace) {
    const Face face = facing(cylinder(20, 24, 0.8), {0, 0, 1});
    const auto alone = plan_surface(face, ball(8), planes(20)).value();
    const auto region = plan_region({&face, 1}, ball(8), planes(20)).value();
    ASSERT_EQ(alone.program.moves.size(), region.program.moves.size());
    for (std::size_t i = 0; i < alone.program.moves.size(); ++i)
        EXPECT_EQ(alone.program.moves[i].position_mm, region.program.moves[i].position_mm);
}

/// All parts of a section are machined: legs of a U that no way joins.
TEST(PlanRegion, FindsEveryPartOfASection) {
    Face face = facing(plane(24, 24), {0, 0, 1});
    face.loops = {{{0, 0}, {1, 0}, {1, 1}, {0.7, 1}, {0.7, 0.3}, {0.3, 0.3}, {0.3, 1}, {0, 1}}};
    for (const Strategy strategy : {Strategy::parallel_planes, Strategy::constant_scallop, Strategy::along_u}) {
        SurfaceOptions options = planes(0);
        options.strategy = strategy;
        const auto plan = plan_surface(face, ball(12), options);
        ASSERT_TRUE(plan) << to_string(plan.error());
        EXPECT_LT(check_surface(face, ball(12), plan->passes).highest_mm, 0.01005);
    }
}

TEST(PlanRegionRefuses, ToolsThatCutANeighbouringFace) {
    // A floor and a wall on it, which a ball on the floor meets.
    std::vector<Face> faces{facing(plane(20, 8), {0, 0, 1}), facing(plane(20, 8), {0, 0, 1})};
    faces[1].surface =
        geometry::BsplineSurface::make(line(), line(), {{20, 0, 0}, {20, 8, 0}, {20, 0, 8}, {20, 8, 8}}).value();
    faces[1].side = geometry::shape_at(faces[1].surface, {0.5, 0.5}, geometry::Side::along)->normal.x() < 0
                        ? geometry::Side::along
                        : geometry::Side::against;
    faces[1].number = 2;
    const auto plan = plan_region(faces, ball(6), planes(0));
    ASSERT_FALSE(plan);
    EXPECT_EQ(plan.error().code, "SURF0204");
    EXPECT_NE(plan.error().text.find("face 2"), std::string::npos) << plan.error().text;
    EXPECT_TRUE(plan_region({faces.data(), 1}, ball(6), planes(0)));
}

TEST(PlanRegionRefuses, NoFaces) {
    EXPECT_EQ(plan_region({}, ball(6), {}).error().code, "SURF0207");
}

}  // namespace
