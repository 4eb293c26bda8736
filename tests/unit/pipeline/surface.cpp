// Faces → passes → a program of straight moves or dual splines, simulated.
#include "trunnion/pipeline/surface.hpp"

#include <cmath>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "trunnion/base/quantity.hpp"
#include "trunnion/geometry/bspline_curve.hpp"
#include "trunnion/pipeline/surface_faces.hpp"
#include "trunnion/pipeline/surface_summary.hpp"

namespace trunnion::pipeline {
namespace {

using Eigen::Vector3d;
using geometry::Side;
using surfacing::Cutter;
using surfacing::Face;
using surfacing::FaceList;
using surfacing::Pass;

/// z = a (x² + y²) over a square about the origin: of radius 1/2a there, a bowl where a is above 0.
Face paraboloid(double a, double side_mm = 12) {
    const double k = a * side_mm * side_mm;
    auto surface = geometry::polynomial_surface(2, 2,
                                                {{-side_mm / 2, -side_mm / 2, k / 2},
                                                 {0, side_mm, -k},
                                                 {0, 0, k},
                                                 {side_mm, 0, -k},
                                                 {0, 0, 0},
                                                 {0, 0, 0},
                                                 {0, 0, k},
                                                 {0, 0, 0},
                                                 {0, 0, 0}});
    return surfacing::whole_face(std::move(*surface));
}

Cutter tool(machine::ToolKind kind, double diameter_mm, double corner_mm) {
    return *Cutter::make({.kind = kind, .diameter_mm = diameter_mm, .corner_radius_mm = corner_mm});
}

SurfaceProgramOptions program_options(bool splines) {
    SurfaceProgramOptions out{.splines = splines};
    out.passes.scallop_mm = 0.01;
    out.passes.chord_tolerance_mm = 0.0005;
    out.passes.lead_rad = 5 * degree;
    out.passes.feed_angle_rad = 30 * degree;
    return out;
}

std::size_t feed_moves(const program::Program& program) {
    std::size_t out = 0;
    for (const auto& move : program.moves) out += move.kind == program::MoveKind::feed;
    return out;
}

TEST(SurfaceFaces, ChosenByNumber) {
    FaceList list{.faces = {paraboloid(0.01), paraboloid(0.02), paraboloid(0.03)}};
    for (int k = 0; k < 3; ++k) list.faces[static_cast<std::size_t>(k)].number = 2 * k + 1;
    const auto chosen = choose_faces(list, std::vector{5, 1});
    ASSERT_TRUE(chosen);
    EXPECT_EQ(chosen->front().number, 5);
    EXPECT_EQ(chosen->back().number, 1);
    EXPECT_EQ(choose_faces(list, std::vector{2}).error().code, "PIPE0110");
    EXPECT_EQ(choose_faces(list, std::vector{1, 1}).error().code, "PIPE0110");
    EXPECT_EQ(choose_faces(list, {}).error().code, "PIPE0111");
    list.faces.erase(list.faces.begin() + 1, list.faces.end());
    EXPECT_EQ(choose_faces(list, {})->size(), 1u);
}

TEST(SurfaceFaces, FactsOfABowl) {
    Face bowl = paraboloid(0.025);
    const FaceFacts facts = facts_of(bowl);
    EXPECT_NEAR(facts.hollow_radius_mm, 20, 0.1);
    EXPECT_TRUE(std::isinf(facts.hump_radius_mm));
    EXPECT_TRUE(facts.whole);
    EXPECT_NEAR(facts.high_mm.x() - facts.low_mm.x(), 12, 0.4);
    EXPECT_GT(facts.along_u_mm, 12);
    EXPECT_LT(facts.along_u_mm, 12.5);
    const auto slope = [](double x, double y) { return std::sqrt(1 + 0.0025 * (x * x + y * y)); };
    double area = 0;
    for (double x = -5.95; x < 6; x += 0.1)
        for (double y = -5.95; y < 6; y += 0.1) area += 0.01 * slope(x, y);
    EXPECT_NEAR(facts.area_mm2, area, 0.1);
    bowl.side = Side::against;
    EXPECT_NEAR(facts_of(bowl).hump_radius_mm, 20, 0.1);
    bowl.loops = {{{0.2, 0.2}, {0.8, 0.2}, {0.8, 0.8}}};
    EXPECT_FALSE(facts_of(bowl).whole);
    EXPECT_LT(facts_of(bowl).area_mm2, 0.3 * area);
}

TEST(SurfaceProgram, StraightMovesKeepTheScallop) {
    const Face bowl = paraboloid(0.02);
    const auto cutter = tool(machine::ToolKind::ball, 8, 4);
    const auto options = program_options(false);
    const auto made = make_surface_program({&bowl, 1}, cutter, options);
    ASSERT_TRUE(made) << to_string(made.error());
    EXPECT_FALSE(made->splines);
    EXPECT_TRUE(made->plan.program.curves.empty());
    const auto check = *check_surface_program({&bowl, 1}, {&bowl, 1}, cutter, *made, options.passes);
    EXPECT_TRUE(check.usable());
    EXPECT_GT(check.verdict.least_ridge_mm, 0.009);
    EXPECT_GT(check.verdict.ridges, 0u);
    auto stricter = options.passes;
    stricter.scallop_mm = 0.008;
    EXPECT_FALSE(check_surface_program({&bowl, 1}, {&bowl, 1}, cutter, *made, stricter)->ridges_hold);
}

TEST(SurfaceProgram, ASinkingToolDoesNotHoldTheSurface) {
    const Face bowl = paraboloid(0.02);
    const auto cutter = tool(machine::ToolKind::ball, 8, 4);
    const auto options = program_options(false);
    auto made = *make_surface_program({&bowl, 1}, cutter, options);
    for (Pass& pass : made.plan.passes)
        for (auto& contact : pass.contacts) contact.pose.tip_mm.z() -= 0.002;
    const auto check = *check_surface_program({&bowl, 1}, {&bowl, 1}, cutter, made, options.passes);
    EXPECT_FALSE(check.surface_holds);
    EXPECT_FALSE(check.usable());
}

TEST(SurfaceProgram, SplinesKeepTheScallopWithFewerPieces) {
    for (const double a : {0.02, -0.015}) {  // hollow, humped
        const Face face = paraboloid(a, 18);
        const auto cutter = a > 0 ? tool(machine::ToolKind::ball, 10, 5) : tool(machine::ToolKind::torus, 10, 3);
        const auto options = program_options(true);
        const auto made = make_surface_program({&face, 1}, cutter, options);
        ASSERT_TRUE(made) << to_string(made.error());
        ASSERT_TRUE(made->splines);
        const SplineAccount& splines = *made->splines;
        const auto straight = *make_surface_program({&face, 1}, cutter, program_options(false));
        EXPECT_EQ(splines.curves + splines.left_straight, made->plan.passes.size());
        EXPECT_EQ(splines.curves, made->plan.program.curves.size());
        EXPECT_LT(splines.spans, feed_moves(straight.plan.program));
        EXPECT_GT(splines.tip_error_mm, 0);
        EXPECT_LE(splines.tip_error_mm, 0.25 * options.passes.chord_tolerance_mm);
        EXPECT_LE(splines.axis_error_rad, 0.012 * degree);
        EXPECT_LE(splines.touch_error_mm, options.passes.chord_tolerance_mm);
        const auto check = *check_surface_program({&face, 1}, {&face, 1}, cutter, *made, options.passes);
        EXPECT_TRUE(check.usable()) << check.verdict.highest_mm << " " << check.verdict.deepest_mm;
        EXPECT_GT(check.verdict.ridges, 0u);
        EXPECT_GT(check.verdict.least_ridge_mm, 0.009);
    }
}

TEST(SurfaceProgram, SeesTheToolInANeighbour) {
    const Face bowl = paraboloid(0.02);
    // A wall 1 mm beside the bowl's border, higher than the tool, which leans over it.
    auto wall = geometry::polynomial_surface(1, 1, {{7, -10, -5}, {0, 0, 30}, {0, 20, 0}, {0, 0, 0}});
    const Face parts[] = {bowl, surfacing::whole_face(std::move(*wall), Side::against)};
    const auto cutter = tool(machine::ToolKind::ball, 8, 4);
    const auto options = program_options(false);
    const auto made = make_surface_program({&bowl, 1}, cutter, options);
    ASSERT_TRUE(made) << to_string(made.error());
    const auto alone = check_surface_program({&bowl, 1}, {&bowl, 1}, cutter, *made, options.passes);
    EXPECT_FALSE(alone->in_part);
    const auto beside = check_surface_program({&bowl, 1}, parts, cutter, *made, options.passes);
    ASSERT_TRUE(beside->in_part);
    EXPECT_EQ(beside->in_part->face, 1);
    EXPECT_NEAR(beside->in_part->at_mm.x(), 7, 0.01);
    EXPECT_GT(beside->in_part->depth_mm, 2);
    EXPECT_FALSE(beside->usable());
}

TEST(SurfaceProgram, RidgesOfAnyHeightCanFail) {
    const Face bowl = paraboloid(0.02);
    const auto cutter = tool(machine::ToolKind::ball, 8, 4);
    auto options = program_options(false);
    options.passes.scallop_mm = 0.3;
    const auto made = make_surface_program({&bowl, 1}, cutter, options);
    ASSERT_TRUE(made) << to_string(made.error());
    EXPECT_TRUE(check_surface_program({&bowl, 1}, {&bowl, 1}, cutter, *made, options.passes)->ridges_hold);
    options.passes.scallop_mm = 0.2;
    EXPECT_FALSE(check_surface_program({&bowl, 1}, {&bowl, 1}, cutter, *made, options.passes)->ridges_hold);
}

/// The spline's knots are those moves end at: what lies on the curve and what the moves say is the same.
TEST(SurfaceProgram, MovesEndOnTheirSplines) {
    const Face face = paraboloid(0.02);
    const auto made = *make_surface_program({&face, 1}, tool(machine::ToolKind::ball, 8, 4), program_options(true));
    const auto& program = made.plan.program;
    std::size_t on_curves = 0;
    for (const auto& move : program.moves) {
        if (move.curve_part == program::no_curve_part) continue;
        const auto& part = program.curve_parts[static_cast<std::size_t>(move.curve_part)];
        const auto& curve = program.curves[static_cast<std::size_t>(part.curve)];
        const auto tip = *geometry::BsplineCurve::make(curve.degree, curve.knots, curve.position_mm);
        EXPECT_LT((Vector3d(tip.evaluate(part.to_u)[0]) - move.position_mm).norm(), 1e-9);
        ++on_curves;
    }
    EXPECT_EQ(on_curves, made.splines->spans);
}

TEST(SurfaceProgram, CallsToolAndSpindle) {
    const Face face = paraboloid(0.02);
    auto options = program_options(false);
    options.tool_name = "8";
    options.spindle_rad_s = 1200 * 360 * degree;
    const auto made = *make_surface_program({&face, 1}, tool(machine::ToolKind::ball, 8, 4), options);
    const auto& program = made.plan.program;
    std::string words;
    for (const auto& event : program.events) words += event.word + " ";
    EXPECT_EQ(words, "T8 S72000 M3 M5 M30 ");
    EXPECT_EQ(program.tools.at(program.moves.back().tool), "8");
}

TEST(SurfaceProgram, AToolThatDoesNotFitSaysWhichWould) {
    const Face bowl = paraboloid(0.05);  // radius 10
    const auto made = make_surface_program({&bowl, 1}, tool(machine::ToolKind::ball, 24, 12), program_options(true));
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().code, "SURF0203");
    EXPECT_NE(made.error().value.find("radius of the hollow"), std::string::npos) << made.error().value;
}

TEST(SurfaceSummary, JsonSaysWhatTheReportSays) {
    SurfaceSummary summary{.surface = "s.toml", .tool = "ball of 8 mm", .strategy = "along-u", .passes = 7};
    summary.faces = {facts_of(paraboloid(0.02))};
    summary.check = SurfaceCheck{.ridges_hold = true, .surface_holds = false};
    EXPECT_NE(report(summary).find("NOT USABLE"), std::string::npos);
    const auto json = nlohmann::json::parse(to_json(summary));
    EXPECT_EQ(json["passes"], 7);
    EXPECT_EQ(json["usable"], false);
    EXPECT_TRUE(json["splines"].is_null());
    EXPECT_TRUE(json["faces"][0]["hump_radius_mm"].is_null());
    EXPECT_NEAR(json["faces"][0]["hollow_radius_mm"].get<double>(), 25, 0.1);
    summary.check->surface_holds = true;
    EXPECT_EQ(report(summary).find("NOT USABLE"), std::string::npos);
}

}  // namespace
}  // namespace trunnion::pipeline
