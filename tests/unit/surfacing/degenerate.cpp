#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/surfacing/machined_surface.hpp"
#include "trunnion/surfacing/part_body.hpp"

#include "sample_surfaces.hpp"

namespace {

using namespace trunnion;
using namespace trunnion::surfacing;
using namespace trunnion::surfacing::samples;
using Eigen::Vector3d;

constexpr double pi = std::numbers::pi;

/// A sector of a cone about the z axis, its tip up at the origin; u from the tip down.
geometry::BsplineSurface cone(double radius, double height, double turn) {
    std::vector<Vector3d> points;
    std::vector<double> weights;
    for (const double share : {0.0, 1.0})
        for (const ArcPoint& p : arc(radius, -turn / 2, turn)) {
            points.emplace_back(share * p.x, share * p.y, -share * height);
            weights.push_back(p.weight);
        }
    return geometry::BsplineSurface::make(line(), quadratic(), points, weights).value();
}

/// A triangle as a patch of four corners, of which two are one.
geometry::BsplineSurface triangle(double size) {
    return geometry::BsplineSurface::make(line(), line(),
                                          {{0, 0, 0}, {0, 0, 0}, {size, -size / 2, 0}, {size, size / 2, 0}})
        .value();
}

/// A plane whose parameter stands still at a share of its way: x goes as (u − share)³.
geometry::BsplineSurface stalling(double size, double share) {
    const geometry::SurfaceDirection cubic{3, {0, 0, 0, 0, 1, 1, 1, 1}};
    const double a = share, b = 1 - share;
    std::vector<Vector3d> points;
    for (const double x : {-a * a * a, a * a * b, -a * b * b, b * b * b})
        for (const double y : {0.0, 1.0}) points.emplace_back(4 * size * x, size * y, 0);
    return geometry::BsplineSurface::make(cubic, line(), points).value();
}

/// A face with an edge that is one point, and its normal, which the surface does not know there.
struct Degenerate {
    const char* name;
    Face face;
    std::function<Vector3d(const Vector3d& point)> normal;
};

constexpr double cone_radius = 10, cone_height = 8, sphere_radius = 14;

Vector3d out_of_cone(const Vector3d& at) {
    const Vector3d out = Vector3d(at.x(), at.y(), 0).normalized();
    return (cone_height * out + cone_radius * Vector3d::UnitZ()).normalized();
}

Degenerate tip_of_cone() {
    return {"cone", facing(cone(cone_radius, cone_height, 1.4), {1, 0, 0}), out_of_cone};
}

geometry::BsplineSurface cap() {
    return torus(0, sphere_radius, pi / 2 - 0.7, 0.7, 1.2);
}

std::vector<Degenerate> faces() {
    return {tip_of_cone(),
            {"pole", facing(cap(), {0, 0, 1}), [](const Vector3d& at) -> Vector3d { return at.normalized(); }},
            {"pole from within", facing(cap(), {0, 0, -1}),
             [](const Vector3d& at) -> Vector3d { return -at.normalized(); }},
            {"triangle", facing(triangle(11), {0, 0, 1}), [](const Vector3d&) { return Vector3d(0, 0, 1); }}};
}

constexpr Strategy strategies[] = {Strategy::constant_scallop, Strategy::along_u, Strategy::along_v,
                                   Strategy::parallel_planes, Strategy::lin_koren};

SurfaceOptions options_of(Strategy strategy, const Cutter& cutter) {
    SurfaceOptions options;
    options.strategy = strategy;
    options.scallop_mm = 0.05;
    options.chord_tolerance_mm = 0.001;
    if (!cutter.is_ball()) options.lead_rad = 10 * degree;
    return options;
}

std::string code_of(const Face& face, const machine::Tool& tool, Strategy strategy) {
    const Cutter cutter = Cutter::make(tool).value();
    const auto plan = plan_surface(face, cutter, options_of(strategy, cutter));
    return plan ? "" : plan.error().code;
}

struct Heights {
    double lowest = 0, highest = 0;
};

/// Heights left over the face's own points, nearer and nearer to all its borders, along normals that are known.
Heights heights_left(const Degenerate& one, const Cutter& cutter, const std::vector<Pass>& passes) {
    const MachinedSurface machined(cutter, passes);
    constexpr double near[] = {1e-5, 1e-3, 0.01, 0.03};
    std::vector<double> shares;
    for (const double share : near) shares.insert(shares.end(), {share, 1 - share});
    for (int k = 1; k < 24; ++k) shares.push_back(k / 24.0);
    const ParameterBox box = parameter_box(one.face);
    Heights out;
    for (const double a : shares)
        for (const double b : shares) {
            const Eigen::Vector2d at = box.low + Eigen::Vector2d(a, b).cwiseProduct(box.high - box.low);
            const Vector3d point = one.face.surface.at(at.x(), at.y());
            const double height = machined.height_mm(point, one.normal(point), 1);
            out.lowest = std::min(out.lowest, height);
            out.highest = std::max(out.highest, height);
        }
    return out;
}

double deepest_in(const PartBody& part, const Cutter& cutter, const program::Program& program) {
    double deepest = 0;
    for (const program::Move& move : program.moves)
        deepest = std::max(deepest, part.depth_mm(cutter, {move.position_mm, move.axis}));
    return deepest;
}

class EdgesThatAreOnePoint : public testing::TestWithParam<Strategy> {};

/// The tool stays on the face's side at tips and poles, and cuts right up to them.
TEST_P(EdgesThatAreOnePoint, AreMachinedWithoutGouges) {
    for (const Degenerate& one : faces()) {
        const auto part = PartBody::make({&one.face, 1}, 0.002).value();
        for (const machine::Tool& tool : {ball_tool(5), torus_tool(5, 1)}) {
            const Cutter cutter = Cutter::make(tool).value();
            const SurfaceOptions options = options_of(GetParam(), cutter);
            const std::string name = std::string(one.name) + (cutter.is_ball() ? ", ball" : ", torus");
            const auto plan = plan_surface(one.face, cutter, options);
            // Leaning tools turn at a tip: from there on no distance of passes may keep the ridges.
            if (!plan && !cutter.is_ball() && plan.error().code == "SURF0209") continue;
            ASSERT_TRUE(plan) << name << ": " << to_string(plan.error());
            EXPECT_LT(deepest_in(part, cutter, plan->program), 0.002) << name;
            const Heights left = heights_left(one, cutter, plan->passes);
            EXPECT_GT(left.lowest, -0.0011) << name;
            if (GetParam() == Strategy::lin_koren) continue;  // whose ridges nothing bounds
            EXPECT_LT(left.highest, 1.2 * options.scallop_mm) << name;
            EXPECT_GT(left.highest, 0.5 * options.scallop_mm) << name;
        }
    }
}

INSTANTIATE_TEST_SUITE_P(All, EdgesThatAreOnePoint, testing::ValuesIn(strategies));

TEST(Degenerate, TipsOfHollowConesAreRefused) {
    const Face hollow = facing(cone(cone_radius, cone_height, 1.4), {-1, 0, 0});
    for (const Strategy strategy : strategies)
        for (const machine::Tool& tool : {ball_tool(6), torus_tool(6, 1)})
            EXPECT_EQ(code_of(hollow, tool, strategy), "SURF0203");
}

/// Lin and Koren's rule looks at curvatures, not at ridges: what it would leave above the scallop is told, with its
/// place, and is not left.
TEST(Degenerate, RidgesOfLinAndKorensRuleAreToldAndNotLeft) {
    const Degenerate one = tip_of_cone();
    const auto told = [&](const machine::Tool& tool, double scallop_mm) {
        const Cutter cutter = Cutter::make(tool).value();
        SurfaceOptions options = options_of(Strategy::lin_koren, cutter);
        options.scallop_mm = scallop_mm;
        const auto plan = plan_surface(one.face, cutter, options).value();
        EXPECT_LT(plan.highest_ridge_mm, scallop_mm);
        return plan.program.diagnostics;
    };
    EXPECT_TRUE(told(ball_tool(5), 0.05).empty());
    const auto leaning = told(torus_tool(5, 1), 0.05);
    ASSERT_EQ(leaning.size(), 1u);
    EXPECT_EQ(leaning[0].code, "SURF0212");
    EXPECT_EQ(leaning[0].severity, Severity::warning);
    EXPECT_EQ(leaning[0].limit, "0.05 mm");
    double x = 0, y = 0, z = 0;
    ASSERT_EQ(std::sscanf(leaning[0].text.c_str(), "%*[^(](%lf %lf %lf)", &x, &y, &z), 3) << leaning[0].text;
    EXPECT_NEAR(std::hypot(x, y), -z * cone_radius / cone_height, 0.002) << "on the cone";
}

TEST(Degenerate, LinesWhereParametersStandStillAreCrossed) {
    const Degenerate one{"stalling", facing(stalling(12, 0.3), {0, 0, 1}),
                         [](const Vector3d&) -> Vector3d { return {0, 0, 1}; }};
    const Cutter ball = Cutter::make(ball_tool(6)).value();
    const auto part = PartBody::make({&one.face, 1}, 0.002).value();
    for (const Strategy strategy : strategies) {
        const auto plan = plan_surface(one.face, ball, options_of(strategy, ball));
        ASSERT_TRUE(plan) << to_string(plan.error());
        EXPECT_LT(deepest_in(part, ball, plan->program), 1e-6);
        const Heights left = heights_left(one, ball, plan->passes);
        EXPECT_GT(left.lowest, -1e-6);
        EXPECT_LT(left.highest, 1.005 * 0.05);
        EXPECT_GT(left.highest, 0.7 * 0.05);
    }
}

TEST(Degenerate, FacesWithoutNormalsWhereTheyBeginAreRefused) {
    for (const Strategy strategy : strategies)
        EXPECT_EQ(code_of(facing(stalling(16, 0.5), {0, 0, 1}), ball_tool(6), strategy), "SURF0205");
}

/// An edge far thinner than ridges are high has next to no interval. A flank is no steeper than 45° all the same, so
/// that steps along it are as long as what a move is off sideways asks for.
TEST(Sharp, StepsAlongAnEdgeAreNotShortenedByItsIntervals) {
    constexpr double ring = 30, edge = 0.002, turn = 0.5, chord_mm = 0.01, ball_mm = 5;
    const Face face = facing(torus(ring, edge, 0.2, 1.0, turn), {1, 0, 0});
    const Cutter ball = Cutter::make(ball_tool(2 * ball_mm)).value();
    const SurfaceOptions options{.strategy = Strategy::along_v,
                                 .scallop_mm = 0.2,
                                 .chord_tolerance_mm = chord_mm,
                                 .borders = false,
                                 .longest_step_mm = 50};
    const auto plan = plan_surface(face, ball, options);
    ASSERT_TRUE(plan) << to_string(plan.error());
    ASSERT_EQ(plan->passes.size(), 1u);
    // Chords of the ring that the ball's middle goes round; what they are off counts up to 1.5 times.
    const double longest_mm = std::sqrt(8 * chord_mm * (ring + ball_mm) / 1.5), way_mm = turn * (ring + ball_mm);
    EXPECT_LT(static_cast<double>(plan->passes[0].contacts.size()), 1.3 * way_mm / longest_mm + 2);
}

}  // namespace
