#include "trunnion/surfacing/leave_out.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "trunnion/surfacing/plan_region.hpp"

#include "sample_parts.hpp"
#include "sample_surfaces.hpp"

namespace {

using namespace trunnion;
using namespace trunnion::surfacing;
using namespace trunnion::surfacing::samples;
using Eigen::Vector3d;

/// 20 × 20 mm, humped at x = 0, hollow towards x = 20 mm, with a radius of 6 mm there.
Face hollow_at_its_end() {
    const auto height = [](double x, double) { return 100 * std::pow(x - 0.5, 3) - 36.1 * (x - 0.5); };
    return facing(bicubic(20, height), {0, 0, 1});
}

SurfaceOptions leaving() {
    SurfaceOptions options;
    options.strategy = Strategy::along_v;
    options.scallop_mm = 0.02;
    options.chord_tolerance_mm = 0.00025;
    options.leave_out = true;
    return options;
}

bool goes_deeper(const PartBody& part, const Cutter& cutter, const SurfacePlan& plan, double than_mm) {
    return std::ranges::any_of(plan.program.moves, [&](const program::Move& move) {
        return part.is_deeper(cutter, {move.position_mm, move.axis}, than_mm);
    });
}

TEST(LeaveOut, LeavesTheHollowThatABallIsTooLargeForAndCutsTheRest) {
    const Face face = hollow_at_its_end();
    const Cutter cutter = Cutter::make(ball_tool(16)).value();
    SurfaceOptions strict = leaving();
    strict.leave_out = false;
    const auto refused = plan_surface(face, cutter, strict);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, "SURF0203");
    const auto part = PartBody::make({&face, 1}, 0.005).value();
    const SurfacePlan planned = plan_surface(face, cutter, leaving()).value();
    const auto reached = leave_out_gouges(planned, {&face, 1}, cutter, part, leaving());
    ASSERT_TRUE(reached) << to_string(reached.error());
    EXPECT_GT(reached->left_way_mm, 20);
    double deepest_mm = 0;
    for (const Pass& pass : planned.passes)
        for (const Contact& contact : pass.contacts)
            deepest_mm = std::max(deepest_mm, part.depth_mm(cutter, contact.pose));
    EXPECT_GT(deepest_mm, 0.01);
    EXPECT_GT(reached->deepest_mm, 0.98 * deepest_mm);
    EXPECT_FALSE(goes_deeper(part, cutter, reached->plan, 0.0165));
    const auto verdict =
        check_surface(face, cutter, reached->plan.passes, {.left = reached->plan.left, .left_above_mm = 0.02});
    EXPECT_LT(verdict.highest_mm, 0.0201);
    EXPECT_LT(verdict.deepest_mm, 0.0165);
    const double share = verdict.left_mm2 / verdict.area_mm2;
    EXPECT_GT(share, 0.005);
    EXPECT_LT(share, 0.3);
}

TEST(LeaveOut, LeavesNothingOutWhereTheToolFits) {
    const Face face = hollow_at_its_end();
    const Cutter cutter = Cutter::make(ball_tool(8)).value();
    const auto part = PartBody::make({&face, 1}, 0.002).value();
    const auto reached =
        leave_out_gouges(plan_surface(face, cutter, leaving()).value(), {&face, 1}, cutter, part, leaving());
    ASSERT_TRUE(reached) << to_string(reached.error());
    EXPECT_EQ(reached->left_way_mm, 0);
    EXPECT_TRUE(reached->plan.left.empty());
}

/// A pass of one contact step with the axis up.
Pass short_pass(double x) {
    Pass out;
    for (const double y : {0.0, 1.0})
        out.contacts.push_back({.point_mm = {x, y, 0}, .normal = {0, 0, 1}, .pose = {{x, y, 0}, {0, 0, 1}}});
    return out;
}

/// Thinner than any step, between two passes that would be linked through it.
TEST(LeaveOut, LeadsNoLinkThroughASheet) {
    const Face wall = rectangle({5.3, -20, 0.5}, {0, 40, 0}, {0, 0, 30});
    const Cutter cutter = Cutter::make(ball_tool(0.4)).value();
    const auto part = PartBody::make({&wall, 1}, 0.002).value();
    SurfacePlan plan;
    plan.passes = {short_pass(0), short_pass(10)};
    plan.passes[1].index = 1;
    lead_links_clear(plan, cutter, part, leaving(), {});
    const auto highest =
        std::ranges::max(plan.program.moves, {}, [](const program::Move& move) { return move.position_mm.z(); });
    EXPECT_GT(highest.position_mm.z(), 30.5);
    lead_links_clear(plan, cutter,
                     PartBody::make(std::vector{rectangle({5.3, -20, -9}, {0, 9, 0}, {0, 0, 1})}, 0.002).value(),
                     leaving(), {});
    EXPECT_LT(plan.program.moves[2].position_mm.z(), 1.5);
}

/// The march ends at a sharp edge.
TEST(LeaveOut, LeavesWhatPassesDoNotGetTo) {
    const Face face = roof(0.35, 100);
    const Cutter cutter = Cutter::make(ball_tool(6)).value();
    SurfaceOptions options = leaving();
    options.strategy = Strategy::constant_scallop;
    options.leave_out = false;
    const auto refused = plan_surface(face, cutter, options);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, "SURF0210");
    options.leave_out = true;
    const auto part = PartBody::make({&face, 1}, 0.005).value();
    const auto plan = plan_surface(face, cutter, options);
    ASSERT_TRUE(plan) << to_string(plan.error());
    const auto reached = leave_out_gouges(*plan, {&face, 1}, cutter, part, options);
    ASSERT_TRUE(reached) << to_string(reached.error());
    const auto verdict =
        check_surface(face, cutter, reached->plan.passes, {.left = reached->plan.left, .left_above_mm = 0.02});
    EXPECT_NEAR(verdict.left_mm2 / verdict.area_mm2, 0.35, 0.03);
    EXPECT_LT(verdict.highest_mm, 0.0201);
}

TEST(LeaveOut, RefusesWhatItGetsNowhere) {
    const Face face = hollow_at_its_end();
    Face lid = facing(bicubic(20, [](double, double) { return 6.0; }), {0, 0, 1});
    lid.side = geometry::opposite(lid.side);
    const std::vector<Face> both{face, lid};
    const Cutter cutter = Cutter::make(ball_tool(8), 10).value();
    const auto part = PartBody::make(both, 0.002).value();
    auto plan = plan_surface(face, cutter, leaving());
    ASSERT_TRUE(plan) << to_string(plan.error());
    const auto nowhere = leave_out_gouges(*plan, both, cutter, part, leaving());
    ASSERT_FALSE(nowhere);
    EXPECT_EQ(nowhere.error().code, "SURF0315");
    const auto too_coarse = leave_out_gouges(*plan, both, cutter, part, leaving(), {.tolerance_mm = 0.001});
    ASSERT_FALSE(too_coarse);
    EXPECT_EQ(too_coarse.error().code, "SURF0301");
}

}  // namespace
