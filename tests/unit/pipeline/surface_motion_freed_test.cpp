#include <algorithm>
#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/geometry/great_circle.hpp"
#include "trunnion/pipeline/surface_motion_check.hpp"
#include "trunnion/surfacing/orientation_surface.hpp"

#include "surface_motion_samples.hpp"

namespace trunnion::pipeline {
namespace {

using namespace surface_motion_samples;
using Eigen::Vector3d;

constexpr double allowed_mm = 0.02;

Face rectangle(const Vector3d& corner, const Vector3d& u, const Vector3d& v) {
    return surfacing::whole_face(geometry::polynomial_surface(1, 1, {corner, v, u, Vector3d(0, 0, 0)}).value());
}

/// A floor that begins 6 mm from a wall of 40 mm; the tool leans 15° towards its feed, in passes to and from the wall.
struct AtTheWall {
    SurfaceCase work;
    Face wall = rectangle({0, -20, 0}, {0, 60, 0}, {0, 0, 40});
    surfacing::Cutter cutter;
    machine::Kinematics kinematics = machine::Kinematics::make(work.machine, work.setup.workpiece, 100).value();

    explicit AtTheWall(const machine::Tool& tool)
        : work(rectangle({6, 0, 0}, {30, 0, 0}, {0, 8, 0}), tool),
          cutter(surfacing::Cutter::make(work.setup.tool, 40).value()) {
        work.surface.lead_rad = 15 * degree;
        work.surface.scallop_mm = 0.2;
        work.surface.chord_tolerance_mm = 0.005;
        work.surface.gouge_tolerance_mm = allowed_mm;
        work.surface.longest_step_mm = 0.2;  // where the lean is small, the flat end whirls as the lean turns
    }

    SurfaceResult freed() const {
        SurfaceProgramOptions options{
            .passes = work.surface, .others = {wall}, .freeing = lean_limits(cutter, work.surface.lead_rad)};
        if (!cutter.is_ball()) options.freeing->least_lead_rad = 5 * degree;
        auto out = make_surface_program({&work.face, 1}, cutter, options).value();
        for (program::Move& move : out.plan.program.moves)
            move.line = std::ranges::any_of(out.plan.passes, [&](const surfacing::Pass& pass) {
                return move.position_mm == pass.contacts.back().pose.tip_mm;
            });
        return out;
    }
    std::optional<surfacing::Penetration> in_part(MotionInPart& motion) const {
        return motion.check(std::vector{work.face, wall}, allowed_mm).value().in_part;
    }
};

constexpr machine::Tool ball{.kind = machine::ToolKind::ball, .diameter_mm = 10, .corner_radius_mm = 5};
constexpr machine::Tool torus{.kind = machine::ToolKind::torus, .diameter_mm = 10, .corner_radius_mm = 2};

/// Passes to and fro stand on an orientation surface for each sense; the motion has its axes, within all limits.
TEST(FreedSurfaceMotion, FollowsTheOrientationSurfaceThroughoutAPlanToAndFro) {
    for (const machine::Tool& tool : {ball, torus}) {
        const AtTheWall at(tool);
        Recorder unfreed;
        MotionInPart gouging(at.kinematics, at.cutter, {}, unfreed);
        ASSERT_TRUE(at.work.move(surfacing::plan_surface(at.work.face, at.cutter, at.work.surface).value(), gouging));
        ASSERT_TRUE(at.in_part(gouging));

        const SurfaceResult made = at.freed();
        std::set<const surfacing::OrientationSurface*> orientations;
        for (const auto& pass : made.plan.passes) orientations.insert(pass.orientation.get());
        ASSERT_TRUE(made.freed->worst);
        EXPECT_GE(made.plan.passes.size(), 2u);
        EXPECT_TRUE(std::ranges::any_of(orientations, [](const auto* one) { return one != nullptr; }));
        Recorder recorder;
        MotionInPart motion(at.kinematics, at.cutter, {}, recorder);
        const auto summary = at.work.move(made.plan, motion);
        ASSERT_TRUE(summary) << to_string(summary.error());
        EXPECT_FALSE(at.in_part(motion));
        const auto verdict = verdict_of(at.work, made.plan, recorder);
        EXPECT_TRUE(verdict.ok) << (verdict.broken.empty() ? "" : verdict.broken.front().what);
        EXPECT_LT(largest_ratio(at.work, recorder), 1.001);
        EXPECT_GT(largest_ratio(at.work, recorder), 0.99);
        EXPECT_LE(summary->bridge_axis_rad, 2e-5);
    }
}

/// The floor is at z = 0: where the tool touches it is known from its pose alone.
TEST(FreedSurfaceMotion, StandsOnTheFloorWithTheAxisOfTheSurface) {
    const AtTheWall at(torus);
    const SurfaceResult made = at.freed();
    Recorder recorder;
    const auto summary = at.work.move(made.plan, recorder);
    ASSERT_TRUE(summary) << to_string(summary.error());
    const double corner = 2, flat = 3;
    double deepest = 0, least_lean = 1, most_lean = 0;
    for (const auto& row : recorder.rows) {
        if (row.line != 1) continue;
        const auto pose = at.kinematics.forward(row.position);
        const Vector3d& axis = pose.axis_in_workpiece;
        const double lean = std::acos(axis.z());
        const double lowest = pose.tip_in_workpiece_mm.z() + corner * axis.z() - flat * std::sin(lean) - corner;
        deepest = std::max(deepest, std::abs(lowest));
        least_lean = std::min(least_lean, lean);
        most_lean = std::max(most_lean, lean);
    }
    EXPECT_LT(deepest, 3e-4);  // of bridges 0.2 µm
    EXPECT_LT(least_lean, 12 * degree);
    EXPECT_GT(most_lean, 14.9 * degree);
}

TEST(FreedSurfaceMotion, RefusesPosesThatAreNotThoseOfTheSurface) {
    const AtTheWall at(ball);
    const SurfaceResult made = at.freed();
    const auto code = [&](const surfacing::SurfacePlan& plan) {
        Recorder recorder;
        const auto summary = at.work.move(plan, recorder);
        return summary ? "" : summary.error().code;
    };
    EXPECT_EQ(code(made.plan), "");
    auto without = made.plan;
    for (auto& pass : without.passes) pass.orientation = nullptr;
    EXPECT_EQ(code(without), "PIPE0132");
    auto swapped = made.plan;
    const auto other = std::ranges::find_if(swapped.passes, [&](const auto& pass) {
        return pass.orientation && pass.orientation != swapped.passes.front().orientation;
    });
    ASSERT_NE(other, swapped.passes.end());  // one surface for each sense
    std::swap(other->orientation, swapped.passes.front().orientation);
    EXPECT_EQ(code(swapped), "PIPE0132");
}

}  // namespace
}  // namespace trunnion::pipeline
