#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/surfacing/leave_out.hpp"
#include "trunnion/surfacing/plan_surface.hpp"

#include "sample_surfaces.hpp"

namespace {

using namespace trunnion;
using namespace trunnion::surfacing;
using namespace trunnion::surfacing::samples;

constexpr Strategy strategies[] = {Strategy::constant_scallop, Strategy::along_u, Strategy::along_v,
                                   Strategy::parallel_planes, Strategy::lin_koren};

/// A plane that opposite borders cross on: beyond a share of its way it looks down.
Face turned_over(double size, double share) {
    const double end = size * (1 - 1 / share);
    return facing(geometry::BsplineSurface::make(
                      line(), line(), {{0, -size / 2, 0}, {0, size / 2, 0}, {size, -end / 2, 0}, {size, end / 2, 0}})
                      .value(),
                  {0, 0, 1});
}

/// A sheet of 16 mm that turns back at a share of its way along u; degree 1: at a knot.
Face folded_back(int degree, double share) {
    const geometry::SurfaceDirection once{1, {0, 0, share, 1, 1}};
    if (degree == 1)
        return whole_face(geometry::BsplineSurface::make(
                              once, line(), {{0, 0, 0}, {0, 9, 0}, {16, 0, 0}, {16, 9, 0}, {5, 0, 0}, {5, 9, 0}})
                              .value());
    // x = 16 u (2 share − u): back from u = share on.
    return whole_face(geometry::BsplineSurface::make(quadratic(), line(),
                                                     {{0, 0, 0},
                                                      {0, 9, 0},
                                                      {16 * share, 0, 0},
                                                      {16 * share, 9, 0},
                                                      {32 * share - 16, 0, 0},
                                                      {32 * share - 16, 9, 0}})
                          .value());
}

/// Round an edge of the given radius, a sheet above and one below, in one cubic each way.
Face thin_edge(double radius) {
    const geometry::SurfaceDirection cubic{3, {0, 0, 0, 0, 0.5, 0.5, 0.5, 1, 1, 1, 1}};
    std::vector<Eigen::Vector3d> points;
    const double r = radius, in = 4.0 / 3 * r;
    for (const auto& [x, z] :
         {std::pair{-3.0, 2 * r}, {-2.0, 2 * r}, {-1.0, 2 * r}, {0.0, 2 * r}, {in, 2 * r}, {in, 0.0}, {0.0, 0.0}})
        for (const double y : {0.0, 4.0}) points.emplace_back(x, y, z);
    return facing(geometry::BsplineSurface::make(cubic, line(), points).value(), {0, 0, 1});
}

Result<SurfacePlan> planned(const Face& face, double scallop_mm, Strategy strategy = Strategy::constant_scallop) {
    SurfaceOptions options;
    options.strategy = strategy;
    options.scallop_mm = scallop_mm;
    options.chord_tolerance_mm = scallop_mm / 20;
    return plan_surface(face, Cutter::make(ball_tool(6)).value(), options);
}

Result<SurfacePlan> planned_turned(const Face& face, double feed_deg) {
    SurfaceOptions options;
    options.scallop_mm = 0.05;
    options.chord_tolerance_mm = 0.0025;
    options.feed_angle_rad = feed_deg * degree;
    return plan_surface(face, Cutter::make(ball_tool(6)).value(), options);
}

/// Constant scallop and edges that are sharper than the tool: the march ends there, goes to and fro, or leaves ridges.
TEST(PlanRefuses, WhatConstantScallopDoesNotGetOver) {
    const auto stopped = planned_turned(roof(0.35, 100), 0);
    ASSERT_FALSE(stopped);
    EXPECT_EQ(stopped.error().code, "SURF0210");
    const auto to_and_fro = planned_turned(roof(0.2, 150), 90);
    ASSERT_FALSE(to_and_fro);
    EXPECT_EQ(to_and_fro.error().code, "SURF0208") << to_string(to_and_fro.error());
    const auto ridges = planned_turned(roof(0.2, 150), 46);
    ASSERT_FALSE(ridges);
    EXPECT_EQ(ridges.error().code, "SURF0209") << to_string(ridges.error());
}

/// Left out, ridges that nothing lowers are told one by one: planes along an edge that is much sharper than the tool.
TEST(PlanRefuses, NoRidgesThatAreLeftOut) {
    const Face face = thin_edge(0.1);
    const Cutter cutter = Cutter::make(ball_tool(6)).value();
    SurfaceOptions options;
    options.strategy = Strategy::parallel_planes;
    options.scallop_mm = 0.05;
    options.chord_tolerance_mm = 0.0025;
    options.feed_angle_rad = 90 * degree;
    const auto refused = plan_surface(face, cutter, options);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, "SURF0209");
    options.leave_out = true;
    const auto plan = plan_surface(face, cutter, options);
    ASSERT_TRUE(plan) << to_string(plan.error());
    EXPECT_FALSE(plan->left.empty());
    for (const LeftPlace& place : plan->left) EXPECT_GT(place.at_mm.x(), -0.5);
    const auto part = PartBody::make({&face, 1}, 0.005).value();
    const auto reached = leave_out_gouges(*plan, {&face, 1}, cutter, part, options, {.tolerance_mm = 0.01});
    ASSERT_TRUE(reached) << to_string(reached.error());
    EXPECT_EQ(reached->ridges_too_high, plan->left.size());
}

std::string code_of(const Face& face, Strategy strategy) {
    const auto plan = planned(face, 0.05, strategy);
    return plan ? "" : plan.error().code;
}

TEST(PlanRefuses, FacesThatTurnOver) {
    for (const Strategy strategy : strategies) {
        EXPECT_EQ(code_of(turned_over(16, 0.8), strategy), "SURF0211");
        EXPECT_EQ(code_of(turned_over(16, 0.5), strategy), "SURF0211");
        EXPECT_EQ(code_of(folded_back(2, 0.7), strategy), "SURF0211");
        EXPECT_EQ(code_of(folded_back(1, 0.7), strategy), "SURF0211");
        EXPECT_EQ(code_of(turned_over(16, 2), strategy), "");  // borders that do not cross on the face
    }
    const auto refused = planned(turned_over(16, 0.8), 0.05);
    EXPECT_NE(refused.error().text.find("(12.8"), std::string::npos) << refused.error().text;
}

/// Only what lies within its borders counts; an edge however thin is none that turns over.
TEST(PlanRefuses, NoFaceThatTurnsOverBeyondItsBordersOrRoundAnEdge) {
    Face part = turned_over(16, 0.8);
    part.loops = {{{0, 0}, {0.7, 0}, {0.7, 1}, {0, 1}}};
    EXPECT_EQ(code_of(part, Strategy::along_u), "");
    for (const double radius : {0.5, 0.01}) {
        const auto plan = planned(thin_edge(radius), 0.05, Strategy::along_u);
        EXPECT_TRUE(plan || plan.error().code != "SURF0211") << to_string(plan.error());
    }
}

/// A sliver across a large box: nearly all of the places that count are beside the face, and cost little.
TEST(PlanRefuses, FinerScallopsThanTheWorkAllows) {
    Face sliver = facing(plane(200, 200), {0, 0, 1});
    sliver.loops = {{{0, 0}, {0.01, 0}, {1, 1}, {0.99, 1}}};
    const auto refused = planned(sliver, 2e-7, Strategy::along_u);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, "SURF0206");
    EXPECT_NE(refused.error().limit.find("600000"), std::string::npos) << to_string(refused.error());
    EXPECT_NE(refused.error().value.find("% of the face"), std::string::npos) << to_string(refused.error());
    EXPECT_TRUE(planned(sliver, 0.1, Strategy::along_u));
}

/// Where the work is far too much that is said long before it is done.
TEST(PlanRefuses, HopelessPlansEarly) {
    const Face face = facing(torus(60, 20, -0.5, 1, 0.4), {1, 0, 0});
    for (const Strategy strategy : {Strategy::constant_scallop, Strategy::parallel_planes}) {
        const auto refused = planned(face, 1e-9, strategy);
        ASSERT_FALSE(refused);
        EXPECT_EQ(refused.error().code, "SURF0206");
        const std::string& value = refused.error().value;
        const std::size_t at = value.find("at ");
        ASSERT_NE(at, std::string::npos) << value;
        EXPECT_LT(std::stoi(value.substr(at + 3)), 60'000) << value;
    }
}

}  // namespace
