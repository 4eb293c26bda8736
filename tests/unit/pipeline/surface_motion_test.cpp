#include "trunnion/pipeline/surface_motion.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "surface_motion_samples.hpp"

namespace trunnion::pipeline {
namespace {

using namespace surface_motion_samples;

/// How far the ball's centre is off its radius from the surface, over rows of passes.
double largest_gap(const SurfaceCase& work, const Recorder& recorder) {
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
            SurfaceCase work(slope());
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
    SurfaceCase smooth(slope());
    const auto plan = smooth.plan();
    Recorder recorder;
    ASSERT_TRUE(smooth.move(plan, recorder));
    EXPECT_LT(largest_gap(smooth, recorder), 1e-8);
    SurfaceCase knotted(slope(true));
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
    SurfaceCase work(slope());
    const auto plan = work.plan();
    Recorder on_surface, as_program;
    const auto motion = work.move(plan, on_surface);
    const auto chords = trunnion::pipeline::plan(plan.program, work.machine, work.setup, {}, as_program);
    ASSERT_TRUE(motion && chords);
    EXPECT_LT(motion->motion.cycle_time_s, 1.1 * chords->cycle_time_s);
}

TEST(SurfaceMotion, counts_the_feed_where_it_is_asked_to) {
    SurfaceCase work(slope());
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

std::string refusal(const SurfaceCase& work, const surfacing::SurfacePlan& plan) {
    Recorder recorder;
    const auto summary = work.move(plan, recorder);
    return summary ? "" : summary.error().code;
}

TEST(SurfaceMotion, refuses_what_it_cannot_move) {
    SurfaceCase work(slope());
    const auto plan = work.plan();
    EXPECT_EQ(refusal(work, plan), "");
    for (const double period : {0.0, -1e-3, std::nan("")}) {
        SurfaceCase bad = work;
        bad.options.plan.period_s = period;
        EXPECT_EQ(refusal(bad, plan), "PIPE0001");
    }
    for (const double feed : {0.0, -5.0}) {
        SurfaceCase bad = work;
        bad.surface.feed_mm_s = feed;
        EXPECT_EQ(refusal(bad, plan), "INTP0006");
    }
    auto other = plan;
    other.passes.front().contacts[1].pose.tip_mm.x() += 1;
    EXPECT_EQ(refusal(work, other), "PIPE0130");
    SurfaceCase leaning = work;
    leaning.surface.lead_rad = 0.3;
    EXPECT_EQ(refusal(leaning, plan), "PIPE0132");
    SurfaceCase fixed = work;
    fixed.machine.axis_count = 3;
    fixed.machine.rotary_count = 0;
    fixed.machine.chain = {0, 1, 2};
    EXPECT_EQ(refusal(fixed, plan), "PATH0101");
    SurfaceCase narrow = work;
    narrow.machine.axes[0].range_max = -5;
    EXPECT_EQ(refusal(narrow, plan), "PATH0102");
    SurfaceCase threads = work;
    threads.options.plan.threads = 3;
    EXPECT_EQ(refusal(threads, plan), "PIPE0001");
    Recorder cancelled;
    cancelled.calls_until_cancel = 0;
    EXPECT_EQ(work.move(plan, cancelled).error().code, "PIPE0002");
}

}  // namespace
}  // namespace trunnion::pipeline
