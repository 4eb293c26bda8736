#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "surface_motion_samples.hpp"

namespace trunnion::pipeline {
namespace {

using namespace surface_motion_samples;

struct Moved {
    surfacing::SurfacePlan plan;
    Recorder recorder;
    Result<SurfaceMotionSummary> summary;

    explicit Moved(const SurfaceCase& work) : plan(work.plan()), summary(work.move(plan, recorder)) {}
};

/// The largest turn of C within a pass.
double largest_turn(const Recorder& recorder) {
    double largest = 0, begin = 0;
    bool in_pass = false;
    for (const auto& row : recorder.rows) {
        if (row.line == 1 && !in_pass) begin = row.position[4];
        in_pass = row.line == 1;
        if (in_pass) largest = std::max(largest, std::abs(row.position[4] - begin));
    }
    return largest;
}

void expect_sound(const SurfaceCase& work, const Moved& moved) {
    ASSERT_TRUE(moved.summary) << to_string(moved.summary.error());
    EXPECT_TRUE(moved.summary->motion.diagnostics.empty());  // none far slower than it needs to be
    const auto verdict = verdict_of(work, moved.plan, moved.recorder);
    EXPECT_TRUE(verdict.ok) << (verdict.broken.empty() ? "" : verdict.broken.front().what);
    EXPECT_LT(moved.summary->motion.cycle_time_s, 1.5 * moved.summary->motion.jerk_free_bound_s);
}

/// Straight through: A goes through 0 and C stands still, with passes along the borders too.
TEST(SurfaceMotionPole, goes_through_a_pole_that_lies_on_the_pass) {
    for (const bool borders : {false, true})
        for (const auto strategy : {surfacing::Strategy::along_u, surfacing::Strategy::constant_scallop}) {
            SurfaceCase work(hump());
            work.surface.strategy = strategy;
            work.surface.borders = borders;
            const Moved moved(work);
            expect_sound(work, moved);
            EXPECT_LT(largest_turn(moved.recorder), borders ? 0.6 * std::numbers::pi : 1e-6);
            EXPECT_GT(moved.summary->bridged_mm, 0);
        }
}

TEST(SurfaceMotionPole, leads_the_tool_through_a_pole_close_beside_the_pass) {
    SurfaceCase work(hump(8e-6));
    const Moved moved(work);
    expect_sound(work, moved);
    EXPECT_LT(largest_turn(moved.recorder), 0.02);
    EXPECT_NEAR(moved.summary->bridge_axis_rad, 8e-6, 1e-7);
    EXPECT_LT(moved.summary->bridge_tip_mm, 4 * 1e-5);
}

/// Half a turn of C, as fast as C can.
TEST(SurfaceMotionPole, goes_round_a_pole_farther_away) {
    for (const double beside : {2e-5, 1e-3, 2e-2}) {
        SurfaceCase work(hump(beside));
        const Moved moved(work);
        expect_sound(work, moved);
        EXPECT_GT(largest_turn(moved.recorder), 0.5 * std::numbers::pi);
    }
}

/// z = −(x² + y²)/120 + 0.001 x² y: the first pass leaves the apex with C as the surface bends there; straight moves
/// along it want another C.
TEST(SurfaceMotionPole, refuses_a_pass_that_begins_at_a_pole_on_a_bend) {
    SurfaceCase work(surfacing::whole_face(geometry::polynomial_surface(2, 2,
                                                                        {{0, 0, 0},
                                                                         {0, 6, 0},
                                                                         {0, 0, -0.3},
                                                                         {20, 0, 0},
                                                                         {0, 0, 0},
                                                                         {0, 0, 0},
                                                                         {0, 0, -400.0 / 120},
                                                                         {0, 0, 2.4},
                                                                         {0, 0, 0}})
                                               .value()));
    Recorder recorder;
    const auto summary =
        move_surface_ahead(work.face, work.cutter(), work.surface, work.machine, work.setup, work.options, recorder);
    ASSERT_FALSE(summary);
    EXPECT_EQ(summary.error().code, "PIPE0131");
    work.surface.lead_rad = 0.1;
    EXPECT_TRUE(
        move_surface_ahead(work.face, work.cutter(), work.surface, work.machine, work.setup, work.options, recorder));
}

}  // namespace
}  // namespace trunnion::pipeline
