// What the planner makes of a path before and after it was led past the pole.
#include <cmath>

#include <gtest/gtest.h>

#include "trunnion/deformation/avoid_pole.hpp"
#include "trunnion/deformation/dual_path_program.hpp"
#include "trunnion/pipeline/plan.hpp"

#include "pole_cases.hpp"

namespace trunnion::deformation {
namespace {

/// The path as a program of one curve, from its first pose on.
program::Program program_of(const DualPath& path, double feed_mm_s) {
    program::Program out;
    const auto add = [&](double u) {
        const Pose pose = path.at(u);
        program::Move move;
        move.position_mm = pose.tip_in_workpiece_mm;
        move.axis = pose.axis_in_workpiece;
        move.feed = {program::FeedRule::tip_speed, feed_mm_s};
        move.line = static_cast<std::int32_t>(out.moves.size()) + 1;
        out.moves.push_back(move);
    };
    add(path.begin());
    add(path.end());
    return with_dual_paths(out, {{{1, 1}, path, {path.end()}}});
}

struct Planned : pipeline::PlanObserver {
    void setpoint(const motion::Setpoint& setpoint) override {
        const auto& at = setpoint.position;
        if (rows++ > 0)
            for (const std::size_t axis : {3U, 4U}) travel_rad += std::abs(at[axis] - before[axis]);
        before = at;
    }
    std::size_t rows = 0;
    machine::AxisPosition before;
    double travel_rad = 0, seconds = 0;
};

Planned planned(const DualPath& path, const Workshop& shop) {
    Planned out;
    pipeline::PlanOptions options;
    options.smoothing.orientation_tolerance_rad =
        0.001 * degree;  // too small for the planner to do by itself what was done here
    const auto summary = pipeline::plan(program_of(path, shop.feed_mm_s), shop.machine, {}, options, out);
    EXPECT_TRUE(summary) << to_string(summary.error());
    if (summary) out.seconds = summary->cycle_time_s;
    return out;
}

TEST(AvoidPolePlan, takes_half_the_time_and_an_eighth_of_the_rotary_travel) {
    const Workshop shop(shipped_machine("ucp710"), 3000);
    const DualPath path = path_past_pole(0.05);
    const auto led = avoid_pole(path, shop.machining(), {.orientation_tolerance_rad = 0.06 * degree, .passing = {}});
    ASSERT_TRUE(led) << to_string(led.error());
    const Planned before = planned(path, shop), after = planned(led->path, shop);
    EXPECT_LE(after.seconds, 0.5 * before.seconds);
    EXPECT_LE(after.travel_rad, 0.12 * before.travel_rad);
    EXPECT_NEAR(after.travel_rad, led->after.travel_rad, 1e-3 * led->after.travel_rad);
    EXPECT_NEAR(before.travel_rad, led->before->travel_rad, 1e-3 * led->before->travel_rad);
    EXPECT_GE(before.seconds, led->before->velocity_limited_time_s) << "that is a bound";
    EXPECT_GE(after.seconds, led->after.velocity_limited_time_s);
}

}  // namespace
}  // namespace trunnion::deformation
