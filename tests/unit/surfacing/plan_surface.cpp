#include "trunnion/surfacing/plan_surface.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/surfacing/chord_steps.hpp"
#include "trunnion/surfacing/machined_surface.hpp"

#include "sample_surfaces.hpp"

namespace {

using namespace trunnion;
using namespace trunnion::surfacing;
using namespace trunnion::surfacing::samples;
using Eigen::Vector3d;

SurfaceOptions fine() {
    SurfaceOptions options;
    options.chord_tolerance_mm = 0.00025;
    return options;
}

Face free_form(double size) {
    return facing(
        bicubic(size, [size](double x,
                             double y) { return size * (0.2 * std::sin(3 * x) * std::cos(2.5 * y) + 0.075 * x * y); }),
        {0, 0, 1});
}

struct Case {
    const char* name;
    Face face;
    machine::Tool tool;
    double lead_deg = 0;
};

std::vector<Case> cases() {
    const Vector3d up(0, 0, 1), out(1, 0, 0);
    return {{"cylinder, flat", facing(cylinder(20, 30, 1.4), up), flat_tool(4)},
            {"sphere, ball", facing(torus(0, 25, -0.4, 0.8, 0.8), out), ball_tool(10)},
            {"torus, torus with lead", facing(torus(60, 20, -0.5, 1, 0.4), out), torus_tool(10, 2), 10},
            {"free form, ball", free_form(40), ball_tool(16)}};
}

SurfaceVerdict machined(const Case& one, const SurfaceOptions& options, SurfacePlan& plan) {
    const Cutter cutter = Cutter::make(one.tool).value();
    SurfaceOptions all = options;
    all.lead_rad = one.lead_deg * degree;
    auto planned = plan_surface(one.face, cutter, all);
    EXPECT_TRUE(planned) << one.name << " " << to_string(planned.error());
    if (!planned) return {};
    plan = std::move(*planned);
    return check_surface(one.face, cutter, plan.passes, {.grid_mm = 2, .ridge_spacing_mm = 6});
}

class ConstantScallop : public testing::TestWithParam<double> {};

/// Ridges are as high as allowed, all of them; nothing is cut into, nothing is left beside borders.
TEST_P(ConstantScallop, IsConstant) {
    for (const Case& one : cases()) {
        SurfaceOptions options = fine();
        options.feed_angle_rad = GetParam() * degree;
        SurfacePlan plan;
        const auto verdict = machined(one, options, plan);
        EXPECT_GT(verdict.ridges, 10u) << one.name;
        EXPECT_GT(verdict.least_ridge_mm, 0.009) << one.name;
        EXPECT_LT(verdict.largest_ridge_mm, 0.01005) << one.name;
        EXPECT_LT(verdict.highest_mm, 0.01005) << one.name;
        EXPECT_LT(verdict.deepest_mm, 0.001) << one.name;
    }
}

INSTANTIATE_TEST_SUITE_P(Feeds, ConstantScallop, testing::Values(0, 30));

/// Every surface with every tool that fits.
std::vector<Case> all_cases() {
    const Vector3d up(0, 0, 1), out(1, 0, 0);
    const std::pair<const char*, Face> surfaces[] = {
        {"cylinder of 20 mm", facing(cylinder(20, 60, 2.2), up)},
        {"sphere of 25 mm", facing(torus(0, 25, -0.7, 1.4, 1.4), out)},
        {"torus, 60 and 20 mm", facing(torus(60, 20, -0.9, 1.8, 0.6), out)},
        {"that torus from within", facing(torus(60, 20, -0.9, 1.8, 0.6), -out)},
        {"its inner half, a saddle", facing(torus(60, 20, std::numbers::pi - 0.8, 1.6, 1), -out)},
        {"free form, convex, 60 mm", facing(bicubic(60,
                                                    [](double x, double y) {
                                                        return -21 * (x - 0.45) * (x - 0.45) -
                                                               15 * (y - 0.5) * (y - 0.5) - 7 * (x - 0.5) * (y - 0.5) -
                                                               5 * x * x * x;
                                                    }),
                                            up)},
        {"free form with hollows, 40 mm", free_form(40)}};
    std::vector<Case> out_cases;
    for (const auto& [name, face] : surfaces) {
        out_cases.push_back({name, face, flat_tool(8)});
        out_cases.push_back({name, face, ball_tool(10)});
        out_cases.push_back({name, face, torus_tool(10, 2)});
        out_cases.push_back({name, face, torus_tool(10, 2), 10});
    }
    return out_cases;
}

std::string tool_text(const Case& one) {
    const char* kind = one.tool.kind == machine::ToolKind::flat   ? "flat"
                       : one.tool.kind == machine::ToolKind::ball ? "ball"
                                                                  : "torus";
    return fmt::format("{} {} mm{}", kind, one.tool.diameter_mm, one.lead_deg > 0 ? ", lead 10°" : "");
}

TEST(StraightMoves, OfALeaningFlatToolDoNotCutIntoATwistedSurface) {
    const Face face = facing(bicubic(10, [](double x, double y) { return 6 * x * x * (y - 0.5); }), {0, 0, 1});
    SurfaceOptions options;
    options.tilt_rad = 10 * degree;
    options.feed_angle_rad = 20 * degree;
    options.scallop_mm = 0.1;
    options.strategy = Strategy::parallel_planes;
    SurfacePlan plan;
    const auto verdict = machined({"twisted", face, flat_tool(3), 10}, options, plan);
    EXPECT_LT(verdict.deepest_mm, options.chord_tolerance_mm);
    EXPECT_GT(verdict.deepest_mm, 0.5 * options.chord_tolerance_mm);
}

class NightlyFigures : public testing::TestWithParam<Strategy> {};

/// Ridges of all surfaces with all tools, as a table; those of constant scallop as constant as promised.
TEST_P(NightlyFigures, OfAllSurfacesAndTools) {
    const Strategy strategy = GetParam();
    const bool turns = strategy == Strategy::constant_scallop || strategy == Strategy::parallel_planes;
    const std::vector<double> feeds = turns ? std::vector{0.0, 30.0, 45.0, 60.0, 90.0} : std::vector{0.0};
    for (const Case& one : all_cases())
        for (const double feed : feeds) {
            SurfaceOptions options = fine();
            options.strategy = strategy;
            options.feed_angle_rad = feed * degree;
            options.lead_rad = one.lead_deg * degree;
            const Cutter cutter = Cutter::make(one.tool).value();
            const auto plan = plan_surface(one.face, cutter, options);
            if (!plan) {
                fmt::print("| {} | {} | {} | {} | | | |\n", one.name, tool_text(one), feed, plan.error().code);
                EXPECT_TRUE(plan.error().code == "SURF0203" || plan.error().code == "SURF0209") << plan.error().text;
                continue;
            }
            const auto verdict = check_surface(one.face, cutter, plan->passes, {.ridge_spacing_mm = 4});
            fmt::print("| {} | {} | {} | {} + {} | {:.2f}-{:.2f} | {:.2f} | {:.2f} |\n", one.name, tool_text(one), feed,
                       verdict.ridges, verdict.at_reach, 1e3 * verdict.least_ridge_mm, 1e3 * verdict.largest_ridge_mm,
                       1e3 * verdict.highest_mm, 1e3 * verdict.deepest_mm);
            EXPECT_LT(verdict.deepest_mm, 0.001) << one.name << feed;
            EXPECT_LT(verdict.highest_mm, 0.01005) << one.name << feed;
            if (strategy == Strategy::constant_scallop && verdict.ridges > 0) {
                EXPECT_GT(verdict.least_ridge_mm, 0.009) << one.name << feed;
            }
        }
}

INSTANTIATE_TEST_SUITE_P(Nightly, NightlyFigures,
                         testing::Values(Strategy::constant_scallop, Strategy::along_u, Strategy::along_v,
                                         Strategy::parallel_planes, Strategy::lin_koren));

class SafeStrategies : public testing::TestWithParam<Strategy> {};

TEST_P(SafeStrategies, NeverLeaveMore) {
    for (const Case& one : cases()) {
        SurfaceOptions options = fine();
        options.strategy = GetParam();
        options.feed_angle_rad = 0.3;
        SurfacePlan plan;
        const auto verdict = machined(one, options, plan);
        EXPECT_LT(verdict.highest_mm, 0.01005) << one.name;
        // Somewhere it is used, unless the tool's reach is.
        EXPECT_TRUE(plan.highest_ridge_mm > 0.0085 || plan.largest_interval_mm > 1.99 * one.tool.diameter_mm / 2)
            << one.name;
        EXPECT_LT(verdict.deepest_mm, 0.001) << one.name;
    }
}

INSTANTIATE_TEST_SUITE_P(All, SafeStrategies,
                         testing::Values(Strategy::along_u, Strategy::along_v, Strategy::parallel_planes));

TEST(LinKoren, LeavesLessThanItMayAwayFromPrincipalDirections) {
    // A torus fed along its parameters is fed along principal directions; sheared parameters are not.
    const Face face = facing(torus(60, 20, -0.6, 1.2, 0.5), {1, 0, 0});
    const Cutter flat = Cutter::make(flat_tool(8)).value();
    SurfaceOptions theirs = fine(), ours = fine();
    theirs.strategy = Strategy::lin_koren;
    const auto a = plan_surface(face, flat, theirs).value(), b = plan_surface(face, flat, ours).value();
    const auto verdict = check_surface(face, flat, a.passes, {.ridge_spacing_mm = 4});
    EXPECT_LT(verdict.largest_ridge_mm, 0.01005);
    EXPECT_GE(a.cut_length_mm, 0.99 * b.cut_length_mm);
}

/// A sharp edge that leans to both sides has no radius in the normal section; what it sweeps has one.
TEST(LinKoren, LaysPassesOfToolsThatLeanToBothSides) {
    const Face face = facing(torus(60, 20, -0.4, 0.8, 0.3), {1, 0, 0});
    for (const machine::Tool& tool : {flat_tool(10), torus_tool(10, 2)}) {
        SurfaceOptions theirs = fine();
        theirs.strategy = Strategy::lin_koren;
        theirs.lead_rad = 10 * degree;
        theirs.tilt_rad = 5 * degree;
        const Cutter cutter = Cutter::make(tool).value();
        const auto plan = plan_surface(face, cutter, theirs);
        ASSERT_TRUE(plan) << to_string(plan.error());
        EXPECT_GT(plan->least_interval_mm, 0.3);
        const auto verdict = check_surface(face, cutter, plan->passes, {.ridge_spacing_mm = 4});
        EXPECT_LT(verdict.highest_mm, 0.01005);
        EXPECT_GT(verdict.largest_ridge_mm, 0.004);
    }
}

TEST(PlanSurface, LaysPassesOnAPlaneATheToolsDiameterApart) {
    const Face face = facing(plane(60, 44), {0, 0, 1});  // no place of the grid under a rim
    const Cutter flat = Cutter::make(flat_tool(10)).value();
    for (const Strategy strategy :
         {Strategy::constant_scallop, Strategy::along_u, Strategy::parallel_planes, Strategy::lin_koren}) {
        SurfaceOptions options;
        options.strategy = strategy;
        const auto plan = plan_surface(face, flat, options).value();
        EXPECT_DOUBLE_EQ(plan.least_interval_mm, 10);
        EXPECT_DOUBLE_EQ(plan.largest_interval_mm, 10);
        const auto verdict = check_surface(face, flat, plan.passes);
        EXPECT_LT(verdict.highest_mm, 1e-9);
        EXPECT_LT(verdict.deepest_mm, 1e-9);
    }
}

TEST(PlanSurface, MachinesABicubicOf100MillimetresInSeconds) {
    const Face face = free_form(100);
    const Cutter ball = Cutter::make(ball_tool(20)).value();
    const auto plan = plan_surface(face, ball, fine()).value();
    const auto verdict = check_surface(face, ball, plan.passes, {.grid_mm = 4, .ridge_spacing_mm = 25});
    EXPECT_LT(verdict.highest_mm, 0.01005);
    EXPECT_GT(verdict.least_ridge_mm, 0.009);
    EXPECT_LT(verdict.deepest_mm, 0.001);
}

/// A square plate with a square hole.
Face holed_plate() {
    Face face = facing(plane(30, 30), {0, 0, 1});
    face.loops.push_back({{0.3, 0.3}, {0.6, 0.3}, {0.6, 0.6}, {0.3, 0.6}});
    return face;
}

TEST(PlanSurface, KeepsToTheFace) {
    const Face face = holed_plate();
    const Cutter ball = Cutter::make(ball_tool(6)).value();
    for (const double angle : {0.0, 0.5}) {
        SurfaceOptions options = fine();
        options.feed_angle_rad = angle;
        const auto plan = plan_surface(face, ball, options).value();
        for (const Pass& pass : plan.passes)
            for (const Contact& contact : pass.contacts) {
                EXPECT_GT(contact.place.u, -1e-6);
                EXPECT_LT(contact.place.v, 1 + 1e-6);
                const bool in_hole =
                    std::abs(contact.place.u - 0.45) < 0.15 - 1e-6 && std::abs(contact.place.v - 0.45) < 0.15 - 1e-6;
                EXPECT_FALSE(in_hole) << contact.place.u << " " << contact.place.v;
            }
        EXPECT_LT(check_surface(face, ball, plan.passes, {.ridge_spacing_mm = 5}).highest_mm,
                  0.01005);  // borders are covered as well
    }
}

TEST(PlanSurface, KeepsLeadAndTilt) {
    const Face face = facing(cylinder(40, 30, 0.8), {0, 0, 1});
    const Cutter torus = Cutter::make(torus_tool(10, 3)).value();
    SurfaceOptions options;
    options.lead_rad = 8 * degree;
    options.tilt_rad = 3 * degree;
    options.borders = false;
    const auto plan = plan_surface(face, torus, options).value();
    for (const Pass& pass : plan.passes)
        for (std::size_t i = 0; i + 1 < pass.contacts.size(); ++i) {
            const Contact& at = pass.contacts[i];
            const Vector3d feed = (pass.contacts[i + 1].point_mm - at.point_mm).normalized();
            EXPECT_NEAR(at.pose.axis.dot(feed) / at.pose.axis.dot(at.normal), std::tan(8 * degree), 0.02);
            EXPECT_NEAR(torus.distance_mm(at.pose, at.point_mm), 0, 1e-9);
        }
}

TEST(PlanSurface, WritesAProgramOfItsPasses) {
    const Face face = facing(cylinder(30, 20, 0.8), {0, 0, 1});
    const Cutter ball = Cutter::make(ball_tool(8)).value();
    for (const bool zigzag : {true, false}) {
        SurfaceOptions options;
        options.zigzag = zigzag;
        const auto plan = plan_surface(face, ball, options).value();
        std::size_t cutting = 0, rapids = 0, contacts = 0;
        for (const auto& move : plan.program.moves) {
            EXPECT_NEAR(move.axis.norm(), 1, 1e-12);
            rapids += move.kind == program::MoveKind::rapid;
            cutting += move.feed.value == options.feed_mm_s;
        }
        for (const Pass& pass : plan.passes) contacts += pass.contacts.size();
        EXPECT_GE(cutting, contacts - plan.passes.size());
        EXPECT_EQ(rapids >= 3 * plan.passes.size() - 1, !zigzag);
        // One way: the same direction in all passes; to and fro: the other one in each.
        const auto direction = [&](std::size_t k) -> Vector3d {
            return (plan.passes[k].contacts.back().point_mm - plan.passes[k].contacts.front().point_mm).normalized();
        };
        EXPECT_NEAR(direction(3).dot(direction(4)), zigzag ? -1 : 1, 0.05);
    }
}

TEST(PlanSurface, IsTheSameOnceMore) {
    const auto face = free_form(30);
    const Cutter ball = Cutter::make(ball_tool(16)).value();
    const auto a = plan_surface(face, ball, fine()).value(), b = plan_surface(face, ball, fine()).value();
    ASSERT_EQ(a.program.moves.size(), b.program.moves.size());
    for (std::size_t i = 0; i < a.program.moves.size(); ++i)
        EXPECT_EQ(a.program.moves[i].position_mm, b.program.moves[i].position_mm);
}

/// A flat tool fed obliquely to rulings cuts along them as far as its rim: passes are that far apart, not closer.
TEST(PlanSurface, UsesTheRimOfAFlatToolObliqueToRulings) {
    const Face face = facing(cylinder(20, 30, 1.4), {0, 0, 1});
    SurfaceOptions options = fine();
    options.feed_angle_rad = 30 * degree;
    const auto plan = plan_surface(face, Cutter::make(flat_tool(8)).value(), options).value();
    // The corner of the end's disc and the strip that lies within the scallop of the tangent plane.
    const double strip = std::sqrt(2 * 20 * 0.00975), along = std::sqrt(16 - strip * strip);
    const double interval = 2 * (0.5 * along + std::sqrt(0.75) * strip);
    EXPECT_NEAR(plan.least_interval_mm, interval, 0.01 * interval);
    EXPECT_NEAR(plan.largest_interval_mm, interval, 0.01 * interval);
}

/// A torus seen from within, and its saddle.
TEST(PlanSurface, MachinesHollowsAndSaddles) {
    const Vector3d out(1, 0, 0);
    const Case hollows[] = {{"hollow", facing(torus(30, 12, -0.6, 1.2, 0.6), -out), ball_tool(10)},
                            {"saddle", facing(torus(30, 12, std::numbers::pi - 0.5, 1, 0.8), -out), ball_tool(10)}};
    for (const Case& one : hollows) {
        SurfacePlan plan;
        const auto verdict = machined(one, fine(), plan);
        EXPECT_GT(verdict.ridges, 3u) << one.name;
        EXPECT_GT(verdict.least_ridge_mm, 0.009) << one.name;
        EXPECT_LT(verdict.highest_mm, 0.01005) << one.name;
        EXPECT_LT(verdict.deepest_mm, 0.001) << one.name;
    }
}

std::string code_of(const Face& face, const machine::Tool& tool, const SurfaceOptions& options) {
    const auto plan = plan_surface(face, Cutter::make(tool).value(), options);
    return plan ? "" : plan.error().code;
}

TEST(PlanSurfaceRefuses, HollowsThatTheToolDoesNotFit) {
    const Face hollow = facing(cylinder(8, 12, 1), {0, 0, -1});
    EXPECT_EQ(code_of(hollow, ball_tool(15), {}), "");
    EXPECT_EQ(code_of(hollow, ball_tool(17), {}), "SURF0203");
    EXPECT_EQ(code_of(hollow, flat_tool(4), {}), "SURF0203");
    const auto refused = plan_surface(hollow, Cutter::make(ball_tool(17)).value(), {});
    EXPECT_NE(refused.error().value.find("8 mm"), std::string::npos) << refused.error().value;
}

TEST(PlanSurfaceRefuses, BodiesThatCutBesideTheirContact) {
    // A torus tool whose lead is too small for the hollow: its back would dig in.
    const Face hollow = facing(cylinder(40, 30, 0.7), {0, 0, -1});
    SurfaceOptions options;
    options.feed_angle_rad = 90 * degree;
    options.lead_rad = 2 * degree;
    const std::string code = code_of(hollow, torus_tool(16, 2), options);
    EXPECT_TRUE(code == "SURF0204" || code == "SURF0203") << code;
    options.lead_rad = 20 * degree;
    EXPECT_EQ(code_of(hollow, torus_tool(10, 2), options), "");
}

/// Inside a torus the sharp hollow is round the tube; the offset of a larger tool would intersect itself there.
TEST(PlanSurfaceRefuses, OffsetsThatIntersectThemselves) {
    const Face hollow = facing(torus(30, 4, -0.5, 1, 0.5), {-1, 0, 0});
    EXPECT_EQ(code_of(hollow, ball_tool(7), {}), "");
    const auto refused = plan_surface(hollow, Cutter::make(ball_tool(9)).value(), {});
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, "SURF0203");
    EXPECT_NE(refused.error().value.find("4 mm"), std::string::npos) << refused.error().value;
    EXPECT_NE(refused.error().text.find(" at ("), std::string::npos) << refused.error().text;
}

/// A torus tool leaning so that it hardly fits into a hollow: passes run into each other.
TEST(PlanSurfaceRefuses, PassesThatRunIntoEachOther) {
    SurfaceOptions options = fine();
    options.lead_rad = 10 * degree;
    options.feed_angle_rad = 30 * degree;
    const std::string code = code_of(facing(torus(60, 20, -0.9, 1.8, 0.6), {-1, 0, 0}), torus_tool(10, 2), options);
    EXPECT_TRUE(code == "SURF0209" || code == "SURF0208" || code == "SURF0203") << code;
}

TEST(PlanSurfaceRefuses, OptionsOutOfRange) {
    const Face face = facing(plane(20, 20), {0, 0, 1});
    const auto with = [&](auto change) {
        SurfaceOptions options;
        change(options);
        return code_of(face, ball_tool(6), options);
    };
    EXPECT_EQ(with([](SurfaceOptions&) {}), "");
    EXPECT_EQ(with([](SurfaceOptions& o) { o.scallop_mm = 0; }), "SURF0202");
    EXPECT_EQ(with([](SurfaceOptions& o) { o.chord_tolerance_mm = 0.006; }), "SURF0202");
    EXPECT_EQ(with([](SurfaceOptions& o) { o.lead_rad = 2; }), "SURF0202");
    EXPECT_EQ(with([](SurfaceOptions& o) { o.retract_mm = 0.5; }), "SURF0202");
    EXPECT_EQ(with([](SurfaceOptions& o) { o.feed_mm_s = std::nan(""); }), "SURF0202");
}

TEST(PlanSurfaceRefuses, FacesWithoutNormals) {
    const auto point = geometry::BsplineSurface::make(line(), line(), std::vector(4, Vector3d(1, 2, 3))).value();
    EXPECT_EQ(code_of(whole_face(point), ball_tool(6), {}), "SURF0205");
}

}  // namespace
