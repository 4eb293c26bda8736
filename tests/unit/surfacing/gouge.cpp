#include "trunnion/surfacing/gouge.hpp"

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "trunnion/geometry/great_circle.hpp"

#include "sample_parts.hpp"

namespace {

using namespace trunnion;
using namespace trunnion::surfacing;
using namespace trunnion::surfacing::samples;
using Eigen::Vector3d;
using geometry::SurfacePlace;

constexpr double degree = std::numbers::pi / 180;

/// A part of which the first face is machined along u, with one orientation everywhere.
struct Work {
    std::vector<Face> faces;
    Cutter cutter;
    OrientationSurface orientation;
    PartBody part;
    std::vector<Pass> passes;

    Work(std::vector<Face> of, const machine::Tool& tool, double reach_mm, const Lean& lean,
         const OrientationLimits& limits, const std::vector<double>& rows, double spacing_mm = 5)
        : faces(std::move(of)),
          cutter(Cutter::make(tool, reach_mm).value()),
          orientation(OrientationSurface::make(faces.front(), GuidingSurface::make(faces.front(), cutter).value(), lean,
                                               limits, {.spacing_mm = spacing_mm})
                          .value()),
          part(PartBody::make(faces, 0.002).value()) {
        for (std::size_t k = 0; k < rows.size(); ++k) {
            const std::vector<SurfacePlace> row{{0.02, rows[k]}, {0.98, rows[k]}};
            passes.push_back(pass_on(this->tool(), row, static_cast<int>(k)).value());
        }
    }
    GuidedTool tool() const { return {faces.front(), cutter, orientation}; }
    Result<GougeReport> check(const GougeOptions& options = {}) const {
        return find_gouges(faces.front(), 0, cutter, part, passes, options);
    }
};

OrientationLimits limits(double least_lead, double most_lead, double most_tilt) {
    return {.least_lead_rad = least_lead * degree,
            .most_lead_rad = most_lead * degree,
            .most_tilt_rad = most_tilt * degree};
}

/// Deepest of the dense samples at all contacts and halfway between them.
double sampled(const Work& work, const std::vector<Pass>& passes) {
    const SampledPart samples(work.faces, 0.4);
    double deepest = 0;
    for (const Pass& pass : passes)
        for (std::size_t k = 0; k < pass.contacts.size(); ++k) {
            const CutterPose& at = pass.contacts[k].pose;
            deepest = std::max(deepest, samples.depth_mm(work.cutter, at));
            if (k + 1 == pass.contacts.size()) continue;
            const CutterPose& next = pass.contacts[k + 1].pose;
            deepest = std::max(deepest, samples.depth_mm(work.cutter, {0.5 * (at.tip_mm + next.tip_mm),
                                                                       geometry::slerp(at.axis, next.axis, 0.5)}));
        }
    return deepest;
}

void expect_removed(const Work& work, GougeKind kind, const std::string& name) {
    const auto before = work.check().value();
    ASSERT_FALSE(before.gouges.empty()) << name;
    EXPECT_EQ(before.worst()->kind, kind) << name;
    EXPECT_NEAR(before.deepest_mm, sampled(work, work.passes), 0.1 + 0.05 * before.deepest_mm) << name;

    const auto removed = remove_gouges(work.tool(), 0, work.part, work.passes);
    ASSERT_TRUE(removed) << name << ": " << to_string(removed.error());
    EXPECT_EQ(removed->before.deepest_mm, before.deepest_mm);
    EXPECT_TRUE(removed->after.gouges.empty());
    EXPECT_LE(sampled(work, removed->passes), 0.01 + work.orientation.guiding().error_bound_mm()) << name;
    EXPECT_TRUE(removed->orientation.beyond_limits().empty());
    EXPECT_LT(removed->largest_step_rad, 4 * degree) << name;
    // The contacts stay, and the tool still touches there.
    for (std::size_t k = 0; k < work.passes.size(); ++k) {
        EXPECT_LT((removed->passes[k].contacts.front().point_mm - work.passes[k].contacts.front().point_mm).norm(),
                  1e-9);
        for (const Contact& at : removed->passes[k].contacts)
            EXPECT_NEAR(work.cutter.distance_mm(at.pose, at.point_mm), 0, 0.001);
    }
    ::testing::Test::RecordProperty(name, std::to_string(before.deepest_mm) + " mm before, turn " +
                                              std::to_string(removed->largest_turn_rad / degree) + " deg, step " +
                                              std::to_string(removed->largest_step_rad / degree) + " deg, rounds " +
                                              std::to_string(removed->rounds) + ", targets " +
                                              std::to_string(removed->targets) + ", poses " +
                                              std::to_string(removed->after.poses));
}

/// Bottom of a pocket, the tool tilted towards the wall beside it.
Work pocket(double tilt_deg, const OrientationLimits& allowed) {
    // u runs along the wall: corner at the wall's far end.
    const Face bottom = rectangle({0, 60, 0}, {0, -60, 0}, {60, 0, 0});
    return {{facing(bottom.surface, {0, 0, 1}), pocket_with_wall()[1]},
            torus_tool(10, 2),
            40,
            {5 * degree, tilt_deg * degree},
            allowed,
            {0.16, 0.19, 0.23, 0.3, 0.4, 0.7}};
}

TEST(Gouge, OfAPocketsWallIsFoundAndRemoved) {
    const auto plus = pocket(12, limits(1, 40, 40));
    const auto minus = pocket(-12, limits(1, 40, 40));
    const bool plus_gouges = !plus.check().value().gouges.empty();
    EXPECT_NE(plus_gouges, !minus.check().value().gouges.empty());  // tilted away from the wall it is free
    expect_removed(plus_gouges ? plus : minus, GougeKind::global, "pocket");
}

/// A saddle, hollow along the feed: the rear of a large flat end cuts.
Work saddle(double lead_deg, const OrientationLimits& allowed) {
    const Face face = facing(
        bicubic(60, [](double x, double y) { return 12 * (2 * x - 1) * (2 * x - 1) - 8 * (2 * y - 1) * (2 * y - 1); }),
        {0, 0, 1});
    return {{face}, torus_tool(20, 3), 40, {lead_deg * degree, 0}, allowed, {0.3, 0.4, 0.5, 0.6, 0.7}};
}

TEST(Gouge, OfTheToolsRearIsFoundAndRemoved) {
    EXPECT_TRUE(saddle(25, limits(1, 40, 40)).check().value().gouges.empty());
    expect_removed(saddle(4, limits(1, 40, 40)), GougeKind::rear, "saddle");
}

/// Two blades 30 mm apart, faces towards each other; the tool leans over the edge of the one that it machines.
Work blades(double lead_deg, const OrientationLimits& allowed) {
    const Face machined = rectangle({0, 0, 40}, {0, 60, 0}, {0, 0, -40}),
               other = rectangle({30, 0, 40}, {0, 60, 0}, {0, 0, -40});
    OrientationLimits upwards = allowed;
    upwards.feed = {.along = FeedReference::Along::direction, .direction = {0, 0, 1}};
    return {{facing(machined.surface, {1, 0, 0}), facing(other.surface, {-1, 0, 0})},
            ball_tool(8),
            80,
            {lead_deg * degree, 0},
            upwards,
            {0.2, 0.35, 0.5, 0.65}};
}

TEST(Gouge, OfABladeBesideIsFoundAndRemoved) {
    EXPECT_TRUE(blades(75, limits(-85, 85, 60)).check().value().gouges.empty());
    expect_removed(blades(50, limits(-85, 85, 60)), GougeKind::global, "blades");
}

/// A long straight move through a wall of 15 mm across a floor: its two contacts are free.
GougeReport through_a_wall(bool solid) {
    Face wall = rectangle({30, 20, 0}, {0, 20, 0}, {0, 0, 15});
    wall.solid = solid;
    Work work({rectangle({0, 0, 0}, {60, 0, 0}, {0, 60, 0}), wall}, ball_tool(6), 30, {0, 0}, limits(-10, 10, 10),
              {0.5});
    work.passes = {
        pass_on(work.tool(), std::vector<SurfacePlace>{{0.1, 0.5}, {0.9, 0.5}}, 0, {.longest_step_mm = 100}).value()};
    EXPECT_EQ(work.passes[0].contacts.size(), 2u);
    return work.check().value();
}

TEST(Gouge, BetweenContactsIsSeen) {
    const auto report = through_a_wall(false);
    ASSERT_EQ(report.gouges.size(), 1u);
    EXPECT_NEAR(report.gouges[0].share, 0.5, 0.08);
    EXPECT_EQ(report.gouges[0].face, 1);
    EXPECT_GT(report.deepest_mm, 2.7);  // the radius, to half a step: a sheet is not deeper
    EXPECT_LT(report.deepest_mm, 3.001);
    EXPECT_GT(report.poses, 90u);  // steps of 0.5 mm over 48
}

TEST(Gouge, BetweenContactsBehindTheSkinOfASolidIsSeen) {
    const auto report = through_a_wall(true);
    ASSERT_EQ(report.gouges.size(), 1u);
    EXPECT_EQ(report.gouges[0].face, 1);
    EXPECT_GT(report.deepest_mm, 2.9);  // the radius, and what the axis is behind the wall
    EXPECT_LT(report.deepest_mm, 30);
    EXPECT_GT(report.poses, 90u);
}

TEST(Gouge, OfTheHolderIsToldAsSuch) {
    const auto work = pocket(0, limits(1, 40, 40));
    EXPECT_TRUE(work.check().value().gouges.empty());
    const auto report = work.check({.holder = {.radius_mm = 25, .from_mm = 20, .to_mm = 60}}).value();
    ASSERT_FALSE(report.gouges.empty());
    EXPECT_EQ(report.worst()->kind, GougeKind::holder);
}

TEST(Gouge, OfAHollowThatIsTooTightIsLocal) {
    const Face trough = facing(cylinder(8, 60, 2), {0, 0, -1});
    const Work work({trough}, torus_tool(20, 6), 40, {5 * degree, 0}, limits(0, 40, 40), {0.5});
    const auto report = work.check().value();
    ASSERT_FALSE(report.gouges.empty());
    bool local = false;
    for (const Gouge& gouge : report.gouges) local = local || gouge.kind == GougeKind::local;
    EXPECT_TRUE(local);
}

TEST(GougeRefuses, WhatItCannotFreeAndBadOptions) {
    const auto code = [](const Work& work, const GougeRemovalOptions& options = {}) {
        const auto removed = remove_gouges(work.tool(), 0, work.part, work.passes, options);
        return removed ? Diagnostic{} : removed.error();
    };
    const auto narrow = code(saddle(4, limits(1, 6, 2)));
    EXPECT_EQ(narrow.code, "SURF0310");
    EXPECT_NE(narrow.value.find("depth 0."), std::string::npos) << narrow.value;
    const auto work = saddle(4, limits(1, 40, 40));
    EXPECT_EQ(code(work, {.most_rounds = 0}).code, "SURF0311");
    EXPECT_EQ(work.check({.tolerance_mm = 0.003}).error().code, "SURF0301");  // the part knows no better than 2 µm
    EXPECT_EQ(work.check({.step_mm = 0}).error().code, "SURF0301");
}

}  // namespace
