#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/pipeline/surface_motion_check.hpp"
#include "trunnion/surfacing/path_interval.hpp"

#include "surface_motion_samples.hpp"

namespace trunnion::pipeline {
namespace {

using namespace surface_motion_samples;

Result<SurfaceMotionSummary> move_ahead(const SurfaceCase& work, PlanObserver& observer) {
    return move_surface_ahead(work.face, work.cutter(), work.surface, work.machine, work.setup, work.options, observer);
}

TEST(SurfaceMotionAhead, lays_passes_ahead_by_the_least_interval) {
    SurfaceCase work(slope(), {.kind = machine::ToolKind::flat, .diameter_mm = 10});
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
    const auto summary = move_ahead(work, recorder);
    ASSERT_TRUE(summary) << to_string(summary.error());
    const double interval = surfacing::flat_interval_mm(30, 0.05);
    // Chords of that length on the arc, both borders among them.
    const double step = 2 * std::asin(interval / 2 / 30);
    EXPECT_NEAR(static_cast<double>(summary->passes), std::ceil((to - from) / step) + 1, 1.01);
    EXPECT_TRUE(summary->usable());
    EXPECT_LT(largest_ratio(work, recorder), 1.001);
    EXPECT_GT(largest_ratio(work, recorder), 0.99);
}

/// Takes a setpoint when it is due, by a clock that is faster than the motion's.
struct Clocked : Recorder {
    std::chrono::steady_clock::time_point begin;
    void setpoint(const motion::Setpoint& row) override {
        constexpr double faster = 40;
        if (rows.empty()) begin = std::chrono::steady_clock::now();
        std::this_thread::sleep_until(begin + std::chrono::duration<double>(row.time_s / faster));
        Recorder::setpoint(row);
    }
};

bool same(const std::vector<motion::Setpoint>& a, const std::vector<motion::Setpoint>& b) {
    return std::ranges::equal(a, b, [](const motion::Setpoint& x, const motion::Setpoint& y) {
        return x.time_s == y.time_s && x.position == y.position && x.line == y.line &&
               x.path_length_mm == y.path_length_mm;
    });
}

/// What is moved does not depend on when it is asked for, nor on the thread that plans it.
TEST(SurfaceMotionAhead, plans_while_a_clock_takes_the_setpoints) {
    SurfaceCase work(slope());
    work.options.plan.period_s = 0.004;
    Recorder at_once;
    Clocked clocked;
    const auto planned = move_ahead(work, at_once), by_clock = move_ahead(work, clocked);
    ASSERT_TRUE(planned && by_clock);
    EXPECT_GT(planned->passes, 5u);
    EXPECT_TRUE(same(at_once.rows, clocked.rows));
    EXPECT_TRUE(std::isfinite(by_clock->least_ahead_s));
    EXPECT_TRUE(std::ranges::is_sorted(clocked.shares));
    EXPECT_EQ(clocked.shares.back(), 1);
}

TEST(SurfaceMotionAhead, moves_the_same_with_one_thread_and_with_two) {
    SurfaceCase work(slope());
    const auto plan = work.plan();
    Recorder one, two;
    ASSERT_TRUE(work.move(plan, one));
    work.options.plan.threads = 2;
    ASSERT_TRUE(work.move(plan, two));
    EXPECT_TRUE(same(one.rows, two.rows));
}

/// A pass begins while its end is not planned: parts come out window by window, the same whenever they are asked for.
TEST(SurfaceMotionAhead, hands_over_a_pass_while_it_is_planned) {
    SurfaceCase work(slope());
    const auto plan = work.plan();
    Recorder whole;
    const auto at_once = work.move(plan, whole);
    work.options.plan.feed.window = 100;
    Recorder one, two;
    const auto early = work.move(plan, one);
    work.options.plan.threads = 2;
    ASSERT_TRUE(at_once && early && work.move(plan, two));
    EXPECT_TRUE(same(one.rows, two.rows));
    EXPECT_GT(one.shares.size(), whole.shares.size() + plan.passes.size());
    EXPECT_TRUE(std::ranges::is_sorted(one.shares));
    EXPECT_LT(early->motion.cycle_time_s, 1.002 * at_once->motion.cycle_time_s);
    EXPECT_LT(largest_ratio(work, one), 1.001);
}

/// The first error of the motion comes behind what was moved before it, on whichever thread it was found.
TEST(SurfaceMotionAhead, stops_where_planning_or_its_observer_ends) {
    SurfaceCase work(slope());
    auto plan = work.plan();
    ASSERT_GT(plan.passes.size(), 3u);
    for (auto& contact : plan.passes[2].contacts) contact.normal = Eigen::Vector3d::UnitX();
    std::vector<std::size_t> rows;
    for (const int threads : {1, 2}) {
        work.options.plan.threads = threads;
        Recorder recorder, cancelled;
        EXPECT_EQ(work.move(plan, recorder).error().code, "PIPE0132") << threads;
        rows.push_back(recorder.rows.size());
        cancelled.calls_until_cancel = 1;
        EXPECT_EQ(work.move(plan, cancelled).error().code, "PIPE0002") << threads;
    }
    EXPECT_GT(rows[0], 1000u);
    EXPECT_EQ(rows[0], rows[1]);
}

struct Broken : PlanObserver {
    void setpoint(const motion::Setpoint&) override { throw std::runtime_error("no room on the device"); }
};

TEST(SurfaceMotionAhead, ends_its_thread_where_the_observer_throws) {
    SurfaceCase work(slope());
    Broken broken;
    EXPECT_THROW(static_cast<void>(move_ahead(work, broken)), std::runtime_error);
}

/// Back over the hump of the slope, from end to begin: straight from retract level to retract level the way goes
/// through the hump, or through a lid that passes go under.
TEST(SurfaceMotionAhead, leads_links_clear_of_the_face_and_of_the_rest_of_the_part) {
    SurfaceCase work(slope());
    work.surface.zigzag = false;
    work.surface.scallop_mm = 0.2;
    work.options.plan.period_s = 0.004;
    const Face lid = surfacing::whole_face(
        geometry::polynomial_surface(1, 1, {{10, -6, 12.4}, {0, 24, 14.4}, {6, 0, 0}, {0, 0, 0}}).value());
    const auto cutter = work.cutter();
    const auto kinematics = machine::Kinematics::make(work.machine, work.setup.workpiece, 100).value();
    const auto in_part = [&](double retract_mm, const std::vector<Face>& beside, const std::vector<Face>& part) {
        work.surface.retract_mm = retract_mm;
        Recorder recorder;
        const surfacing::Holder none;
        MotionInPart motion(kinematics, cutter, none, recorder);
        const auto moved =
            move_surface_ahead(work.face, cutter, work.surface, work.machine, work.setup, work.options, motion, beside);
        EXPECT_TRUE(moved) << to_string(moved.error());
        const auto found = motion.check(part, work.surface.gouge_tolerance_mm).value();
        return found.in_part ? found.in_part->depth_mm : 0;
    };
    EXPECT_EQ(in_part(3, {}, {work.face}), 0);
    EXPECT_EQ(in_part(14, {lid}, {work.face, lid}), 0);
    EXPECT_GT(in_part(14, {}, {work.face, lid}), 1) << "of a lid that nobody told of";
}

/// Hollow where the tool is flat, ridges of no height, passes that never end: nothing of it is begun.
TEST(SurfaceMotionAhead, refuses_to_lay_ahead_what_has_no_passes) {
    const auto code = [](const SurfaceCase& work) {
        Recorder recorder;
        const auto summary = move_ahead(work, recorder);
        return summary ? "" : summary.error().code;
    };
    SurfaceCase work(slope());
    EXPECT_EQ(code(work), "");
    for (const double scallop : {0.0, -0.01, 3.0, std::nan("")}) {
        SurfaceCase bad = work;
        bad.surface.scallop_mm = scallop;
        EXPECT_EQ(code(bad), "SURF0202");
    }
    SurfaceCase low = work;
    low.surface.retract_mm = low.surface.lift_mm;
    EXPECT_EQ(code(low), "SURF0202");
    SurfaceCase still = work;
    still.surface.feed_mm_s = 0;
    EXPECT_EQ(code(still), "SURF0202");
    SurfaceCase trimmed = work;
    trimmed.face.loops.front()[0] += Eigen::Vector2d(0.1, 0.1);
    trimmed.face.loops.front()[1] += Eigen::Vector2d(-0.1, 0.1);
    EXPECT_EQ(code(trimmed), "PIPE0133");
    // z = 0.6 y + 0.02 (x − 20)²
    work.face = surfacing::whole_face(
        geometry::polynomial_surface(2, 1, {{0, 0, 8}, {0, 12, 7.2}, {40, 0, -32}, {0, 0, 0}, {0, 0, 32}, {0, 0, 0}})
            .value());
    work.setup.tool = {.kind = machine::ToolKind::flat, .diameter_mm = 10, .length_mm = 100};
    EXPECT_EQ(code(work), "SURF0203");
}

}  // namespace
}  // namespace trunnion::pipeline
