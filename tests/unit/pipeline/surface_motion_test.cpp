#include "trunnion/pipeline/surface_motion.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/surfacing/path_interval.hpp"
#include "trunnion/verify/check.hpp"

#include "planned.hpp"

namespace trunnion::pipeline {
namespace {

using geometry::BsplineSurface;
using surfacing::Face;

/// Bicubic, 40 × 12 mm; it falls to one side by 30° or so, so that the axis keeps away from the table's pole.
Face slope(bool knots_inside = false) {
    const geometry::SurfaceDirection one{3, {0, 0, 0, 0, 1, 1, 1, 1}}, two{3, {0, 0, 0, 0, 0.4, 0.7, 1, 1, 1, 1}};
    const geometry::SurfaceDirection& along = knots_inside ? two : one;
    const int rows = static_cast<int>(along.points());
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < rows; ++i)
        for (int j = 0; j < 4; ++j) {
            const double x = 40.0 * i / (rows - 1), y = 4.0 * j;
            points.emplace_back(x, y, 0.6 * y + 4 * std::sin(0.12 * x) - 0.01 * (y - 6) * (y - 6));
        }
    return surfacing::whole_face(BsplineSurface::make(along, one, points).value());
}

struct Work {
    machine::Machine machine = files::read_machine(test_table, "test.toml").value();
    machine::Setup setup;
    Face face;
    surfacing::SurfaceOptions surface;
    SurfaceMotionOptions options;

    explicit Work(Face on,
                  machine::Tool tool = {.kind = machine::ToolKind::ball, .diameter_mm = 8, .corner_radius_mm = 4})
        : face(std::move(on)) {
        setup.workpiece.origin_mm = {-20, -6, 30};
        setup.tool = tool;
        setup.tool.length_mm = 100;
        surface.strategy = surfacing::Strategy::along_u;
        surface.scallop_mm = 0.05;
        surface.chord_tolerance_mm = 0.001;
        surface.borders = false;
        surface.feed_mm_s = 30;
        surface.longest_step_mm = 0.5;  // turning in a plane from pose to pose is then near enough to true normals
    }

    surfacing::Cutter cutter() const { return surfacing::Cutter::make(setup.tool).value(); }
    /// Rows of passes have line 1, those of links 0.
    surfacing::SurfacePlan plan() const {
        auto out = surfacing::plan_surface(face, cutter(), surface).value();
        for (program::Move& move : out.program.moves)
            move.line = std::ranges::any_of(out.passes, [&](const surfacing::Pass& pass) {
                return move.position_mm == pass.contacts.back().pose.tip_mm;
            });
        return out;
    }
    Result<SurfaceMotionSummary> move(const surfacing::SurfacePlan& plan, PlanObserver& observer) const {
        return move_surface(plan, {&face, 1}, surface, machine, setup, options, observer);
    }
};

verify::Verdict verdict_of(const Work& work, const surfacing::SurfacePlan& plan, const Recorder& recorder) {
    const auto table = verify::setpoint_table(recorder.rows).value();
    const auto poses = programmed_poses(plan, work.machine, work.setup).value();
    return verify::check(table, poses, work.machine, work.setup, {}).value();
}

/// Axis limits by differences of the setpoints alone.
double largest_ratio(const Work& work, const Recorder& recorder) {
    double largest = 0;
    const double T = work.options.plan.period_s;
    const auto& rows = recorder.rows;
    for (int i = 0; i < work.machine.axis_count; ++i) {
        const auto q = [&](std::size_t k) { return rows[std::min(k, rows.size() - 1)].position[i]; };
        const machine::AxisLimits& limits = work.machine.axes[i].feed;
        for (std::size_t k = 0; k < rows.size(); ++k) {
            largest = std::max({largest, std::abs(q(k + 1) - q(k)) / T / limits.velocity,
                                std::abs(q(k + 2) - 2 * q(k + 1) + q(k)) / (T * T) / limits.acceleration,
                                std::abs(q(k + 3) - 3 * q(k + 2) + 3 * q(k + 1) - q(k)) / (T * T * T) / limits.jerk});
        }
    }
    return largest;
}

/// How far the ball's centre is off its radius from the surface, over rows of passes.
double largest_gap(const Work& work, const Recorder& recorder) {
    const auto kinematics = machine::Kinematics::make(work.machine, work.setup.workpiece, 100).value();
    double largest = 0;
    std::size_t looked_at = 0;
    for (std::size_t i = 0; i < recorder.rows.size(); i += 5) {
        if (recorder.rows[i].line != 1) continue;
        const auto pose = kinematics.forward(recorder.rows[i].position);
        const Eigen::Vector3d centre = pose.tip_in_workpiece_mm + 4 * pose.axis_in_workpiece;
        const auto place = geometry::closest_place(work.face.surface, centre);
        largest = std::max(largest, std::abs((work.face.surface.at(place.u, place.v) - centre).norm() - 4));
        ++looked_at;
    }
    EXPECT_GT(looked_at, 500u);
    return largest;
}

TEST(SurfaceMotion, holds_limits_and_poses_over_a_whole_plan) {
    for (const bool zigzag : {true, false})
        for (const auto order : {interpolation::StepOrder::second, interpolation::StepOrder::corrected}) {
            Work work(slope());
            work.surface.zigzag = zigzag;
            work.surface.tilt_rad = 0.1;
            work.surface.lead_rad = zigzag ? 0 : 0.1;
            work.options.order = order;
            const auto plan = work.plan();
            Recorder recorder;
            const auto summary = work.move(plan, recorder);
            ASSERT_TRUE(summary) << to_string(summary.error());
            EXPECT_EQ(summary->passes, plan.passes.size());
            EXPECT_TRUE(summary->usable());
            EXPECT_EQ(summary->motion.setpoints, recorder.rows.size());
            const auto verdict = verdict_of(work, plan, recorder);
            EXPECT_TRUE(verdict.ok) << (verdict.broken.empty() ? "" : verdict.broken.front().what);
            for (const auto& axis : verdict.axes) {
                EXPECT_LT(axis.velocity_ratio, 1.001);
                EXPECT_LT(axis.acceleration_ratio, 1.001);
                EXPECT_LT(axis.jerk_ratio, 1.001);
            }
            EXPECT_GT(largest_ratio(work, recorder), 0.99);  // no slower than the limits ask for
            EXPECT_GT(summary->constant_feed_share, 0.3);
        }
}

TEST(SurfaceMotion, leads_the_tool_on_the_surface_itself) {
    Work smooth(slope());
    const auto plan = smooth.plan();
    Recorder recorder;
    ASSERT_TRUE(smooth.move(plan, recorder));
    EXPECT_LT(largest_gap(smooth, recorder), 1e-8);
    Work knotted(slope(true));
    const auto knotted_plan = knotted.plan();
    Recorder over_knots;
    const auto summary = knotted.move(knotted_plan, over_knots);
    ASSERT_TRUE(summary) << to_string(summary.error());
    EXPECT_GT(summary->bridged_mm, 0);
    EXPECT_LT(largest_gap(knotted, over_knots), summary->bridge_tip_mm + 4 * summary->bridge_axis_rad);
    EXPECT_LT(largest_ratio(knotted, over_knots), 1.001);
}

/// Against the same passes as chords, planned as a program: no slower, but for standing still at the ends of passes.
TEST(SurfaceMotion, is_as_fast_as_the_same_passes_as_a_program) {
    Work work(slope());
    const auto plan = work.plan();
    Recorder on_surface, as_program;
    const auto motion = work.move(plan, on_surface);
    const auto chords = trunnion::pipeline::plan(plan.program, work.machine, work.setup, {}, as_program);
    ASSERT_TRUE(motion && chords);
    EXPECT_LT(motion->motion.cycle_time_s, 1.1 * chords->cycle_time_s);
}

TEST(SurfaceMotion, counts_the_feed_where_it_is_asked_to) {
    Work work(slope());
    work.surface.tilt_rad = 0.3;
    work.surface.feed_mm_s = 20;
    const auto plan = work.plan();
    for (const auto point : {interpolation::FeedPoint::contact, interpolation::FeedPoint::tip}) {
        work.options.feed_point = point;
        Recorder recorder;
        const auto summary = work.move(plan, recorder);
        ASSERT_TRUE(summary);
        EXPECT_GT(summary->constant_feed_share, 0.5);
        double fastest_tip = 0;
        for (const auto& row : recorder.rows)
            if (row.line == 1) fastest_tip = std::max(fastest_tip, row.feed_mm_s);
        EXPECT_GT(fastest_tip, 20 * 0.999);
    }
}

TEST(SurfaceMotion, lays_passes_ahead_by_the_least_interval) {
    Work work(slope(), {.kind = machine::ToolKind::flat, .diameter_mm = 10});
    // A cylinder of radius 30 about x: u along it, from 20° to 70°.
    const geometry::SurfaceDirection straight{1, {0, 0, 1, 1}}, round{2, {0, 0, 0, 1, 1, 1}};
    std::vector<Eigen::Vector3d> points;
    const double from = 20 * degree, to = 70 * degree, out = 30 / std::cos((to - from) / 2);
    for (const double x : {0.0, 40.0})
        for (const auto& [radius, angle] :
             {std::pair{30.0, from}, std::pair{out, (from + to) / 2}, std::pair{30.0, to}})
            points.emplace_back(x, -radius * std::sin(angle), radius * std::cos(angle));
    const double middle = std::cos((to - from) / 2);
    work.face = surfacing::whole_face(
        BsplineSurface::make(straight, round, points, {1, middle, 1, 1, middle, 1}).value(), geometry::Side::against);
    Recorder recorder;
    const auto summary =
        move_surface_ahead(work.face, work.cutter(), work.surface, work.machine, work.setup, work.options, recorder);
    ASSERT_TRUE(summary) << to_string(summary.error());
    const double interval = surfacing::flat_interval_mm(30, 0.05);
    // Chords of that length on the arc, both borders among them.
    const double step = 2 * std::asin(interval / 2 / 30);
    EXPECT_NEAR(static_cast<double>(summary->passes), std::ceil((to - from) / step) + 1, 1.01);
    EXPECT_TRUE(summary->usable());
    EXPECT_LT(largest_ratio(work, recorder), 1.001);
    EXPECT_GT(largest_ratio(work, recorder), 0.99);
}

std::string refusal(const Work& work, const surfacing::SurfacePlan& plan) {
    Recorder recorder;
    const auto summary = work.move(plan, recorder);
    return summary ? "" : summary.error().code;
}

TEST(SurfaceMotion, refuses_what_it_cannot_move) {
    Work work(slope());
    const auto plan = work.plan();
    EXPECT_EQ(refusal(work, plan), "");
    for (const double period : {0.0, -1e-3, std::nan("")}) {
        Work bad = work;
        bad.options.plan.period_s = period;
        EXPECT_EQ(refusal(bad, plan), "PIPE0001");
    }
    for (const double feed : {0.0, -5.0}) {
        Work bad = work;
        bad.surface.feed_mm_s = feed;
        EXPECT_EQ(refusal(bad, plan), "INTP0006");
    }
    auto other = plan;
    other.passes.front().contacts[1].pose.tip_mm.x() += 1;
    EXPECT_EQ(refusal(work, other), "PIPE0130");
    Work leaning = work;
    leaning.surface.lead_rad = 0.3;
    EXPECT_EQ(refusal(leaning, plan), "PIPE0132");
    Work fixed = work;
    fixed.machine.axis_count = 3;
    fixed.machine.rotary_count = 0;
    fixed.machine.chain = {0, 1, 2};
    EXPECT_EQ(refusal(fixed, plan), "PATH0101");
    Work narrow = work;
    narrow.machine.axes[0].range_max = -5;
    EXPECT_EQ(refusal(narrow, plan), "PATH0102");
    Recorder cancelled;
    cancelled.calls_until_cancel = 0;
    EXPECT_EQ(work.move(plan, cancelled).error().code, "PIPE0002");
    Face trimmed = work.face;
    trimmed.loops.front()[0] += Eigen::Vector2d(0.1, 0.1);
    trimmed.loops.front()[1] += Eigen::Vector2d(-0.1, 0.1);
    Recorder recorder;
    EXPECT_EQ(move_surface_ahead(trimmed, work.cutter(), work.surface, work.machine, work.setup, work.options, recorder)
                  .error()
                  .code,
              "PIPE0133");
}

/// Hollow where the tool is flat, ridges of no height, passes that never end: nothing of it is begun.
TEST(SurfaceMotion, refuses_to_lay_ahead_what_has_no_passes) {
    const auto code = [](const Work& work) {
        Recorder recorder;
        const auto summary = move_surface_ahead(work.face, work.cutter(), work.surface, work.machine, work.setup,
                                                work.options, recorder);
        return summary ? "" : summary.error().code;
    };
    Work work(slope());
    EXPECT_EQ(code(work), "");
    for (const double scallop : {0.0, -0.01, 3.0, std::nan("")}) {
        Work bad = work;
        bad.surface.scallop_mm = scallop;
        EXPECT_EQ(code(bad), "SURF0202");
    }
    Work low = work;
    low.surface.retract_mm = low.surface.lift_mm;
    EXPECT_EQ(code(low), "SURF0202");
    Work still = work;
    still.surface.feed_mm_s = 0;
    EXPECT_EQ(code(still), "SURF0202");
    // z = 0.6 y + 0.02 (x − 20)²
    work.face = surfacing::whole_face(
        geometry::polynomial_surface(2, 1, {{0, 0, 8}, {0, 12, 7.2}, {40, 0, -32}, {0, 0, 0}, {0, 0, 32}, {0, 0, 0}})
            .value());
    work.setup.tool = {.kind = machine::ToolKind::flat, .diameter_mm = 10, .length_mm = 100};
    EXPECT_EQ(code(work), "SURF0203");
}

}  // namespace
}  // namespace trunnion::pipeline
