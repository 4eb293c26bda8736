#include "trunnion/surfacing/surface_tool_path.hpp"

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "trunnion/geometry/great_circle.hpp"
#include "trunnion/surfacing/machined_surface.hpp"

#include "sample_parts.hpp"

namespace {

using namespace trunnion;
using namespace trunnion::surfacing;
using namespace trunnion::surfacing::samples;
using Eigen::Vector3d;
using geometry::SurfacePlace;

constexpr double degree = std::numbers::pi / 180;

OrientationLimits wide_limits() {
    return {.least_lead_rad = -80 * degree, .most_lead_rad = 89.9 * degree, .most_tilt_rad = 80 * degree};
}
/// In place: the orientation surface points to the face.
struct GuidedForm {
    Face face = free_form_face();
    Cutter cutter;
    OrientationSurface orientation;
    GuidedForm(const machine::Tool& tool, const Lean& lean)
        : cutter(Cutter::make(tool, 40).value()),
          orientation(
              OrientationSurface::make(face, GuidingSurface::make(face, cutter).value(), lean, wide_limits()).value()) {
    }
    GuidedTool tool() const { return {face, cutter, orientation}; }
};

TEST(SurfaceToolPath, ContactsTouchWhateverTheOrientation) {
    for (const auto& tool : {flat_tool(10), ball_tool(10), torus_tool(12, 3)})
        for (const Lean& lean : {Lean{0, 0}, {12 * degree, 0}, {-8 * degree, 20 * degree}, {70 * degree, 0}}) {
            const GuidedForm guided(tool, lean);
            for (const double u : {0.1, 0.5, 0.9})
                for (const double v : {0.2, 0.8}) {
                    const auto at = contact_at(guided.tool(), {u, v}, {1, 0.2, 0});
                    ASSERT_TRUE(at) << to_string(at.error());
                    const Vector3d truth = guided.face.surface.at(u, v);
                    const double bound = guided.orientation.guiding().error_bound_mm();
                    EXPECT_NEAR(guided.cutter.distance_mm(at->pose, truth), 0, bound + 1e-9) << lean.lead_rad;
                    // Its normal at the contact is the surface's: a little off the surface it is as far from the tool.
                    EXPECT_NEAR(guided.cutter.distance_mm(at->pose, truth - 0.01 * at->normal), 0.01, bound + 1e-4);
                }
        }
}

TEST(SurfaceToolPath, AnUprightToolIsTheLimitOfOneThatLeansTowardsTheFeed) {
    const Face face = facing(plane(60, 40), {0, 0, 1});
    const Cutter torus_cutter = Cutter::make(torus_tool(12, 3)).value();
    const auto guiding = GuidingSurface::make(face, torus_cutter).value();
    const auto tip = [&](double lead) -> Vector3d {
        const auto orientation = OrientationSurface::make(face, guiding, Lean{lead, 0}, wide_limits()).value();
        return contact_at({face, torus_cutter, orientation}, {0.5, 0.5}, {1, 0, 0}).value().pose.tip_mm;
    };
    EXPECT_LT((tip(0) - tip(0.001)).norm(), 0.01);
    EXPECT_NEAR(tip(0).x(), 30 - 3, 1e-9);
    EXPECT_GT((tip(0) - tip(-0.001)).norm(), 5.9);  // on the other side it is the other edge
}

TEST(SurfaceToolPath, StraightMovesKeepTheChordTolerance) {
    const GuidedForm guided(torus_tool(12, 3), {10 * degree, 5 * degree});
    const std::vector<SurfacePlace> line{{0.05, 0.1}, {0.5, 0.6}, {0.95, 0.7}};
    for (const double tolerance : {0.01, 0.0005}) {
        const auto pass =
            pass_on(guided.tool(), line, 3, {.chord_tolerance_mm = tolerance, .longest_step_mm = 50}).value();
        EXPECT_EQ(pass.index, 3);
        double largest = 0;
        for (std::size_t k = 0; k + 1 < pass.contacts.size(); ++k) {
            const Contact &a = pass.contacts[k], &b = pass.contacts[k + 1];
            for (double w = 0.02; w < 1; w += 0.02) {
                const CutterPose pose{(1 - w) * a.pose.tip_mm + w * b.pose.tip_mm,
                                      geometry::slerp(a.pose.axis, b.pose.axis, w)};
                const Vector3d at =
                    guided.face.surface.at((1 - w) * a.place.u + w * b.place.u, (1 - w) * a.place.v + w * b.place.v);
                largest = std::max(largest, std::abs(guided.cutter.distance_mm(pose, at)));
            }
        }
        EXPECT_LT(largest, 1.1 * tolerance + guided.orientation.guiding().error_bound_mm());
        EXPECT_GT(largest, 0.1 * tolerance);
    }
}

/// What a plan leaves does not change for a ball whatever the orientations: the simulation says so.
TEST(SurfaceToolPath, ReorientsAPlan) {
    const GuidedForm guided(ball_tool(16), {15 * degree, 10 * degree});
    SurfaceOptions options{.scallop_mm = 0.05, .chord_tolerance_mm = 0.001};
    const auto planned = plan_surface(guided.face, guided.cutter, options);
    ASSERT_TRUE(planned) << to_string(planned.error());
    const auto& plan = *planned;
    const auto made = reoriented(guided.tool(), plan.passes, {.chord_tolerance_mm = options.chord_tolerance_mm});
    ASSERT_TRUE(made) << to_string(made.error());
    const auto& turned = *made;
    ASSERT_EQ(turned.size(), plan.passes.size());
    const SurfaceCheckOptions check{.grid_mm = 2, .ridge_spacing_mm = 15};
    const auto before = check_surface(guided.face, guided.cutter, plan.passes, check);
    const auto after = check_surface(guided.face, guided.cutter, turned, check);
    EXPECT_LT(after.deepest_mm, 0.002);
    EXPECT_NEAR(after.largest_ridge_mm, before.largest_ridge_mm, 0.002);
    EXPECT_NEAR(after.highest_mm, before.highest_mm, 0.003);
    for (std::size_t k = 0; k < turned.size(); k += 5) {
        const Contact& at = turned[k].contacts.front();
        const auto shape = shape_at(guided.face.surface, at.place, guided.face.side).value();
        const auto lean = lean_of(at.pose.axis, shape, shape.by_u.normalized()).value();
        EXPECT_NEAR(lean.lead_rad, 15 * degree, 0.001);
        EXPECT_NEAR(lean.tilt_rad, 10 * degree, 0.001);
    }
}

TEST(SurfaceToolPath, SplinesOfAPassTouchWithinTheirTolerance) {
    const GuidedForm guided(ball_tool(10), {10 * degree, 5 * degree});
    const std::vector<SurfacePlace> places{{0.05, 0.1}, {0.3, 0.3}, {0.5, 0.6}, {0.8, 0.65}, {0.95, 0.7}};
    for (const double tolerance : {0.01, 0.0005}) {
        const auto made = dual_spline_on(guided.tool(), places, {.tip_tolerance_mm = tolerance}).value();
        EXPECT_LE(made.tip_error_mm, tolerance);
        double largest = 0;
        SurfacePlace near = places.front();
        for (double s = 0; s <= made.spline.end(); s += 0.05) {
            const Vector3d tip = made.spline.bottom().evaluate(s)[0], top = made.spline.top().evaluate(s)[0];
            const Vector3d centre = tip + 5 * (top - tip).normalized();
            near = geometry::closest_place(guided.face.surface, centre, near);
            largest = std::max(largest, std::abs((guided.face.surface.at(near.u, near.v) - centre).norm() - 5));
        }
        EXPECT_LT(largest, 1.5 * tolerance + 0.0006);
    }
}

/// 40° there and back: what the distance of interpolating splines is off before it is normalised.
TEST(SurfaceToolPath, TheDistanceOfSplinesIsApproximate) {
    const Face face = facing(plane(60, 20), {0, 0, 1});
    const Cutter ball = Cutter::make(ball_tool(6)).value();
    const auto guiding = GuidingSurface::make(face, ball).value();
    const auto swing = [](const geometry::SurfaceShape& shape) -> std::optional<Vector3d> {
        const double turn = 40 * degree * std::sin(std::numbers::pi * shape.point.x() / 60);
        return Vector3d(std::sin(turn), 0, std::cos(turn));
    };
    const auto orientation =
        OrientationSurface::make(face, guiding, swing, wide_limits(), {.height_mm = 50, .tolerance_mm = 1e-5}).value();
    const PassSplineOptions any{.tip_tolerance_mm = 10, .axis_tolerance_rad = 1, .height_mm = 50};
    for (const auto& [count, least_mm, most_mm] : {std::tuple{8, 0.065, 0.068}, {30, 0.00040, 0.00042}}) {
        std::vector<SurfacePlace> places;
        for (int k = 0; k < count; ++k) places.push_back({static_cast<double>(k) / (count - 1), 0.5});
        const auto made = dual_spline_on({face, ball, orientation}, places, any).value();
        ASSERT_EQ(made.poses, static_cast<std::size_t>(count));
        double off = 0;
        for (double s = 0; s <= 60; s += 0.01)
            off = std::max(
                off, std::abs((made.spline.top().evaluate(s)[0] - made.spline.bottom().evaluate(s)[0]).norm() - 50));
        EXPECT_GT(off, least_mm);
        EXPECT_LT(off, most_mm);
    }
}

/// Lead that goes through 0 along a pass: a torus would have to jump across its end, a ball has no end to jump across.
TEST(SurfaceToolPathRefuses, ToolsThatLeanThroughTheNormal) {
    const Face face = facing(plane(60, 20), {0, 0, 1});
    const std::vector<SurfacePlace> line{{0.1, 0.5}, {0.9, 0.5}};
    const auto code = [&](const machine::Tool& tool) {
        const Cutter cutter = Cutter::make(tool).value();
        const auto swing = [](const geometry::SurfaceShape& shape) -> std::optional<Vector3d> {
            const double lead = 10 * degree * (shape.point.x() / 30 - 1);
            return Vector3d(std::sin(lead), 0, std::cos(lead));
        };
        const auto guiding = GuidingSurface::make(face, cutter).value();
        const auto orientation = OrientationSurface::make(face, guiding, swing, wide_limits()).value();
        const auto pass = pass_on({face, cutter, orientation}, line, 0);
        return pass ? std::string() : pass.error().code;
    };
    EXPECT_EQ(code(ball_tool(10)), "");
    EXPECT_EQ(code(torus_tool(10, 2)), "SURF0312");
    EXPECT_EQ(code(flat_tool(10)), "SURF0312");
}

TEST(SurfaceToolPathRefuses, BadPlacesAndOptions) {
    const GuidedForm guided(torus_tool(12, 3), {10 * degree, 0});
    const std::vector<SurfacePlace> one{{0.5, 0.5}}, outside{{0.5, 0.5}, {1.5, 0.5}}, two{{0.2, 0.5}, {0.8, 0.5}};
    EXPECT_EQ(contact_at(guided.tool(), {-0.1, 0.5}, {1, 0, 0}).error().code, "SURF0309");
    EXPECT_EQ(pass_on(guided.tool(), one, 0).error().code, "SURF0309");
    EXPECT_EQ(pass_on(guided.tool(), outside, 0).error().code, "SURF0309");
    EXPECT_EQ(pass_on(guided.tool(), two, 0, {.chord_tolerance_mm = 0}).error().code, "SURF0301");
    EXPECT_EQ(dual_spline_on(guided.tool(), one).error().code, "SURF0309");
    EXPECT_EQ(dual_spline_on(guided.tool(), two, {.tip_tolerance_mm = 0}).error().code, "SURF0301");
    EXPECT_EQ(dual_spline_on(guided.tool(), two, {.tip_tolerance_mm = 1e-9, .most_poses = 50}).error().code,
              "SURF0305");
}

}  // namespace
