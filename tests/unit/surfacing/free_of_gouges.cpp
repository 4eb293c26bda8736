#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/geometry/great_circle.hpp"
#include "trunnion/surfacing/freed_plan.hpp"
#include "trunnion/surfacing/plan_region.hpp"

#include "sample_parts.hpp"

namespace {

using namespace trunnion;
using namespace trunnion::surfacing;
using namespace trunnion::surfacing::samples;
using Eigen::Vector3d;

constexpr double allowed_mm = 0.01;

/// The bottom beside a wall of 40 mm, 1 mm farther from it than the ball's radius, and that wall.
std::vector<Face> bottom_and_wall() {
    return {rectangle({6, 0, 0}, {30, 0, 0}, {0, 12, 0}), rectangle({0, -20, 0}, {0, 60, 0}, {0, 0, 40})};
}

Cutter long_ball() {
    return Cutter::make(ball_tool(10), 40).value();
}

SurfaceOptions leading(double lead_deg) {
    SurfaceOptions options;
    options.strategy = Strategy::along_u;
    options.scallop_mm = 0.1;
    options.chord_tolerance_mm = 0.005;
    options.lead_rad = lead_deg * degree;
    options.borders = false;
    return options;
}

OrientationLimits limits(double least_lead_deg, double most_lead_deg, double most_tilt_deg) {
    return {.least_lead_rad = least_lead_deg * degree,
            .most_lead_rad = most_lead_deg * degree,
            .most_tilt_rad = most_tilt_deg * degree};
}

Result<FreedPlan> freed(const std::vector<Face>& faces, const SurfaceOptions& options,
                        const OrientationLimits& within) {
    const Cutter cutter = long_ball();
    const auto plan = plan_surface(faces.front(), cutter, options).value();
    const auto part = PartBody::make(faces, 0.002).value();
    return free_of_gouges(plan, {faces.data(), 1}, cutter, part, options,
                          {.tolerance_mm = allowed_mm, .limits = within});
}

/// Deepest of dense samples of the faces on all moves of a program, links too.
double deepest_on_the_way(const std::vector<Face>& faces, const program::Program& program) {
    const SampledPart samples(faces, 0.5);
    const Cutter cutter = long_ball();
    double deepest = 0;
    for (std::size_t k = 1; k < program.moves.size(); ++k) {
        const program::Move &from = program.moves[k - 1], &to = program.moves[k];
        const int parts = 1 + static_cast<int>((to.position_mm - from.position_mm).norm());
        for (int i = 0; i <= parts; ++i) {
            const double w = static_cast<double>(i) / parts;
            deepest = std::max(deepest, samples.depth_mm(cutter, {(1 - w) * from.position_mm + w * to.position_mm,
                                                                  geometry::slerp(from.axis, to.axis, w)}));
        }
    }
    return deepest;
}

TEST(FreeOfGouges, TurnsAToolOutOfAWallAndNoFartherThanNeeded) {
    const auto faces = bottom_and_wall();
    const SurfaceOptions options = leading(15);
    const auto plan = plan_surface(faces.front(), long_ball(), options).value();
    ASSERT_GT(deepest_on_the_way(faces, plan.program), 1);

    const auto out = freed(faces, options, limits(-60, 60, 60));
    ASSERT_TRUE(out) << to_string(out.error());
    EXPECT_LT(deepest_on_the_way(faces, out->plan.program), allowed_mm + 0.002);
    ASSERT_TRUE(out->worst);
    EXPECT_EQ(out->worst->kind, GougeKind::global);
    EXPECT_GT(out->gouges[static_cast<std::size_t>(GougeKind::global)], 0u);
    EXPECT_GT(out->passes_turned, 0u);
    // Upright it has 1 mm over the 35 mm of its shank beside the wall: 15° less that, and what clearance is added.
    EXPECT_GT(out->largest_turn_rad, 10 * degree);
    EXPECT_LT(out->largest_turn_rad, 20 * degree);
}

TEST(FreeOfGouges, KeepsToTheLimitsOfLeadAndTilt) {
    const auto within = limits(-2, 18, 12);
    const auto out = freed(bottom_and_wall(), leading(15), within);
    ASSERT_TRUE(out) << to_string(out.error());
    double least_lead = 1, most_tilt = 0;
    for (const Pass& pass : out->plan.passes) {
        const Vector3d feed = (pass.contacts.back().point_mm - pass.contacts.front().point_mm).normalized();
        for (const Contact& at : pass.contacts) {
            const double up = at.pose.axis.dot(at.normal), lead = std::atan2(at.pose.axis.dot(feed), up);
            const double tilt = std::atan2(at.pose.axis.dot(at.normal.cross(feed)), up);
            EXPECT_GT(lead, within.least_lead_rad - 1e-3);
            EXPECT_LT(lead, within.most_lead_rad + 1e-3);
            EXPECT_LT(std::abs(tilt), within.most_tilt_rad + 1e-3);
            least_lead = std::min(least_lead, lead);
            most_tilt = std::max(most_tilt, std::abs(tilt));
        }
    }
    EXPECT_LT(least_lead, 10 * degree);  // turned indeed
}

TEST(FreeOfGouges, LeavesAPlanThatIsFreeAsItIs) {
    const auto faces = bottom_and_wall();
    const SurfaceOptions options = leading(0);
    const auto plan = plan_surface(faces.front(), long_ball(), options).value();
    const auto out = freed(faces, options, limits(-60, 60, 60));
    ASSERT_TRUE(out) << to_string(out.error());
    EXPECT_FALSE(out->worst);
    EXPECT_EQ(out->passes_turned, 0u);
    ASSERT_EQ(out->plan.program.moves.size(), plan.program.moves.size());
    for (std::size_t k = 0; k < plan.program.moves.size(); ++k)
        EXPECT_EQ(out->plan.program.moves[k].position_mm, plan.program.moves[k].position_mm);
}

/// Bottom, rounding of 8 mm and wall of a pocket. The pass along the border beside the rounding has two ways out:
/// towards the wall, or, at one end of it, over the wall's end. Its orientations must take the same one.
TEST(FreeOfGouges, TakesOneWayOutAlongABorderBesideARounding) {
    const double y = 30, half = std::sqrt(0.5);
    const geometry::BsplineSurface rounding =
        geometry::BsplineSurface::make(quadratic(), line(),
                                       {{0, 0, 8}, {0, y, 8}, {0, 0, 0}, {0, y, 0}, {8, 0, 0}, {8, y, 0}},
                                       {1, 1, half, half, 1, 1})
            .value();
    const std::vector<Face> faces{rectangle({8, 0, 0}, {10, 0, 0}, {0, y, 0}), facing(rounding, {1, 0, 1}),
                                  rectangle({0, 0, 8}, {0, y, 0}, {0, 0, 32})};
    SurfaceOptions options = leading(15);
    options.scallop_mm = 0.2;
    options.chord_tolerance_mm = 0.0025;
    options.gouge_tolerance_mm = 1e6;
    options.borders = true;
    const Cutter cutter = Cutter::make(torus_tool(10, 2), 40).value();
    const auto plan = plan_surface(faces.front(), cutter, options).value();
    const auto part = PartBody::make(faces, 0.0025).value();
    const auto out = free_of_gouges(plan, {faces.data(), 1}, cutter, part, options,
                                    {.tolerance_mm = allowed_mm, .limits = limits(1, 60, 60)});
    ASSERT_TRUE(out) << to_string(out.error());
    EXPECT_LT(out->largest_turn_rad, 20 * degree);
    const SampledPart samples(faces, 0.25);
    double deepest = 0;
    for (const Pass& pass : out->plan.passes)
        for (const Contact& at : pass.contacts) deepest = std::max(deepest, samples.depth_mm(cutter, at.pose));
    EXPECT_LT(deepest, allowed_mm + 0.002);
}

TEST(FreeOfGougesRefuses, LimitsThatLeaveNoWayOut) {
    const auto out = freed(bottom_and_wall(), leading(15), limits(14, 60, 0.5));
    ASSERT_FALSE(out);
    EXPECT_EQ(out.error().code, "SURF0310");
    EXPECT_NE(out.error().value.find("depth"), std::string::npos) << out.error().value;
}

TEST(FreeOfGougesRefuses, PassesThatGougeOverSeveralFaces) {
    const auto alone = bottom_and_wall();
    Face onward = rectangle({36, 0, 0}, {10, 0, 0}, {0, 12, 0});
    onward.number = 2;
    const std::vector<Face> faces{alone.front(), onward, alone.back()};
    SurfaceOptions options = leading(15);
    options.strategy = Strategy::parallel_planes;
    const Cutter cutter = long_ball();
    const std::span<const Face> machined(faces.data(), 2);
    const auto plan = plan_region(machined, cutter, options);
    ASSERT_TRUE(plan) << to_string(plan.error());
    const auto part = PartBody::make(faces, 0.002).value();
    const auto out = free_of_gouges(*plan, machined, cutter, part, options,
                                    {.tolerance_mm = allowed_mm, .limits = limits(-60, 60, 60)});
    ASSERT_FALSE(out);
    EXPECT_EQ(out.error().code, "SURF0313");
    // One face alone can be freed.
    EXPECT_TRUE(freed(alone, leading(15), limits(-60, 60, 60)));
}

/// Two floors on both sides of a fence: links go over it, unless it is too high for them.
Result<FreedPlan> over_fence(double height) {
    std::vector<Face> faces{rectangle({-25, 50, 0}, {16, 0, 0}, {0, 12, 0}),
                            rectangle({11, 50, 0}, {16, 0, 0}, {0, 12, 0})};
    for (const Face& face : block(2, 120, height)) faces.push_back(face);
    SurfaceOptions options = leading(0);
    options.retract_mm = 2;
    const Cutter cutter = Cutter::make(ball_tool(10)).value();
    const std::span<const Face> machined(faces.data(), 2);
    const auto part = PartBody::make(faces, 0.002).value();
    return free_of_gouges(plan_region(machined, cutter, options).value(), machined, cutter, part, options,
                          {.tolerance_mm = allowed_mm});
}

TEST(FreeOfGouges, RaisesLinksOverWhatStandsBetween) {
    const auto low = over_fence(20);
    ASSERT_TRUE(low) << to_string(low.error());
    EXPECT_EQ(low->links_raised, 1u);
    EXPECT_EQ(low->highest_link_mm, 32);  // 2 mm, doubled until it is over 20
}

TEST(FreeOfGougesRefuses, LinksThatNothingFrees) {
    const auto high = over_fence(200);
    ASSERT_FALSE(high);
    EXPECT_EQ(high.error().code, "SURF0314");
}

}  // namespace
