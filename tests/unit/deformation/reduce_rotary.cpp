#include "trunnion/deformation/reduce_rotary.hpp"

#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "pole_cases.hpp"

namespace trunnion::deformation {
namespace {

using Eigen::Vector3d;

constexpr double radius_mm = 4;  // of the ball

/// The pressure side of an impeller-like blade over 90 mm of flow (x) and 40 mm of span (y): an S-shaped camber, as of
/// a blade that is loaded at the front and unloaded at the back, twisted by 30° over the span, and leaning.
struct Blade {
    static Vector3d point(double x, double y) {
        const double s = 2 * std::numbers::pi * x / 90;
        return {x, y, 3 * (1 - std::cos(s)) + std::tan(30 * degree * y / 40) * (x - 45) * 0.3 + 0.45 * y};
    }
    static Vector3d normal(double x, double y) {
        const double step = 1e-5;
        const Vector3d along = point(x + step, y) - point(x - step, y), up = point(x, y + step) - point(x, y - step);
        return along.cross(up).normalized();
    }
};

/// One pass along the flow with a ball whose centre is off the surface by its radius, the tool along the normal.
std::vector<Pose> normal_following(double span_mm, int poses) {
    std::vector<Pose> out;
    for (int i = 0; i <= poses; ++i) {
        const double x = 90.0 * i / poses;
        out.push_back({Blade::point(x, span_mm), Blade::normal(x, span_mm)});
    }
    return out;
}

DualPath blade_pass(double span_mm, int poses = 120) {
    return fit_dual_path(normal_following(span_mm, poses)).value().path;
}

machine::Tool blade_ball() {
    return ball(2 * radius_mm, true);
}

OrientationFreedom within(double tolerance_deg) {
    OrientationFreedom out;
    out.orientation_tolerance_rad = tolerance_deg * degree;
    return out;
}

/// The normal where the tip of the path given stands.
std::function<Vector3d(double)> normals_of(const DualPath& path, double span_mm) {
    return [&path, span_mm](double u) { return Blade::normal(path.at(u).tip_in_workpiece_mm.x(), span_mm); };
}

void expect_kept(const DualPath& before, const RotaryReduced& reduced, const machine::Tool& tool,
                 double tolerance_rad) {
    EXPECT_LE(reduced.change.orientation_deviation_rad, tolerance_rad);
    EXPECT_LE(sampled_deviation_rad(before, reduced.path), reduced.change.orientation_deviation_rad * (1 + 1e-9));
    EXPECT_LE(sampled_distance_mm(before, reduced.path, tool.controlled_height_mm()),
              tool.controlled_height_mm() > 0 ? 1e-4 : 1e-9);
    EXPECT_LE(largest_jump(reduced.path), 1e-6);
    EXPECT_EQ(reduced.path.spline.bottom().knots(), before.spline.bottom().knots());
    for (const double u : {before.begin(), before.end()})
        EXPECT_LE((before.at(u).axis_in_workpiece - reduced.path.at(u).axis_in_workpiece).norm(), 1e-12);
    EXPECT_LE(reduced.after.travel_rad, reduced.before.travel_rad);
    EXPECT_LE(reduced.after.velocity_limited_time_s, reduced.before.velocity_limited_time_s * (1 + 1e-6));
}

TEST(ReduceRotary, an_impeller_blade_needs_less_than_seven_tenths) {
    for (const char* name : {"ucp710", "trunnion-bc", "nutating-table", "head-head"})
        for (const double span : {5.0, 20.0, 35.0}) {
            SCOPED_TRACE(fmt::format("{} at {} mm", name, span));
            const Workshop shop(shipped_machine(name), 3000, blade_ball());
            const DualPath path = blade_pass(span);
            const auto reduced = reduce_rotary(path, shop.machining(), within(5));
            ASSERT_TRUE(reduced) << to_string(reduced.error());
            EXPECT_TRUE(reduced->changed);
            expect_kept(path, *reduced, shop.tool, 5 * degree);
            EXPECT_GE(sampled_deviation_rad(path, reduced->path), 4.5 * degree) << "freedom that is not used";
            EXPECT_LE(reduced->after.travel_rad, 0.7 * reduced->before.travel_rad);
            EXPECT_LE(reduced->change.surface_mm, 1e-4) << "the ball stays on the surface";
        }
}

TEST(ReduceRotary, saves_time_where_rotary_axes_are_slow) {
    const Workshop shop(shipped_machine("ucp710"), 15000, blade_ball());
    const DualPath path = blade_pass(20);
    const auto reduced = reduce_rotary(path, shop.machining(), within(5));
    ASSERT_TRUE(reduced) << to_string(reduced.error());
    EXPECT_LE(reduced->after.velocity_limited_time_s, 0.75 * reduced->before.velocity_limited_time_s);
}

TEST(ReduceRotary, more_freedom_is_less_motion) {
    const Workshop shop(shipped_machine("ucp710"), 3000, blade_ball());
    const DualPath path = blade_pass(20);
    double before = rotary_use(path, shop.machining()).value().travel_rad;
    for (const double tolerance : {1.0, 3.0, 6.0, 10.0}) {
        const auto reduced = reduce_rotary(path, shop.machining(), within(tolerance));
        ASSERT_TRUE(reduced) << to_string(reduced.error());
        EXPECT_LT(reduced->after.travel_rad, 0.97 * before);
        before = reduced->after.travel_rad;
    }
}

TEST(ReduceRotary, lead_and_tilt_stay_in_their_ranges) {
    const Workshop shop(shipped_machine("ucp710"), 3000, blade_ball());
    const DualPath path = blade_pass(20);
    OrientationFreedom freedom = within(8);
    freedom.surface_normal = normals_of(path, 20);
    freedom.lead = {-1 * degree, 6 * degree};
    freedom.tilt = {-2 * degree, 3 * degree};
    const auto reduced = reduce_rotary(path, shop.machining(), freedom);
    ASSERT_TRUE(reduced) << to_string(reduced.error());
    EXPECT_TRUE(reduced->changed);
    expect_kept(path, *reduced, shop.tool, 8 * degree);
    LeadAndTilt least{1, 1}, most{-1, -1};
    for (int i = 0; i <= 5000; ++i) {
        const double u = path.begin() + (path.end() - path.begin()) * i / 5000, step = 1e-4;
        const Vector3d normal = freedom.surface_normal(u);
        const Vector3d ahead = path.point_mm(u + step, radius_mm) - path.point_mm(u - step, radius_mm);
        const Vector3d feed = (ahead - ahead.dot(normal) * normal).normalized();
        const auto is = lead_and_tilt(reduced->path.at(u).axis_in_workpiece, normal, feed);
        least = {std::min(least.lead_rad, is.lead_rad), std::min(least.tilt_rad, is.tilt_rad)};
        most = {std::max(most.lead_rad, is.lead_rad), std::max(most.tilt_rad, is.tilt_rad)};
    }
    const double slack = 0.01 * degree;
    EXPECT_GE(least.lead_rad, -1 * degree - slack);
    EXPECT_LE(most.lead_rad, 6 * degree + slack);
    EXPECT_GE(least.tilt_rad, -2 * degree - slack);
    EXPECT_LE(most.tilt_rad, 3 * degree + slack);
    EXPECT_LE(least.lead_rad, -0.8 * degree) << "the range is used";
    EXPECT_LE(reduced->after.travel_rad, 0.9 * reduced->before.travel_rad);
}

constexpr double shaft_mm = 60;  // above the tip

double least_distance_mm(const DualPath& path, const Vector3d& point) {
    double out = HUGE_VAL;
    for (int i = 0; i <= 5000; ++i) {
        const double u = path.begin() + (path.end() - path.begin()) * i / 5000;
        out = std::min(out, (path.point_mm(u, shaft_mm) - point).norm());
    }
    return out;
}

/// The tip of a neighbouring blade: where the shaft of a path that does not know of it goes, off the path given.
Vector3d in_the_way(const DualPath& path, const DualPath& careless) {
    double largest = 0;
    Vector3d out = Vector3d::Zero();
    for (int i = 0; i <= 100; ++i) {
        const Vector3d there = careless.point_mm(path.begin() + (path.end() - path.begin()) * i / 100, shaft_mm);
        const double off = least_distance_mm(path, there);
        if (off > largest) out = there, largest = off;
    }
    return out;
}

TEST(ReduceRotary, keeps_clear_of_a_neighbouring_blade) {
    const Workshop shop(shipped_machine("ucp710"), 3000, blade_ball());
    const DualPath path = blade_pass(20);
    const auto careless = reduce_rotary(path, shop.machining(), within(5));
    ASSERT_TRUE(careless);
    const Vector3d neighbour = in_the_way(path, careless->path);
    const double thick_mm = 0.6 * least_distance_mm(path, neighbour);
    const auto least = [&](const DualPath& of) { return least_distance_mm(of, neighbour) - thick_mm; };
    ASSERT_LT(least(careless->path), -1) << "it has to be in the way";
    OrientationFreedom freedom = within(5);
    freedom.clearance_mm = [&](double, const Pose& pose) {
        return (pose.tip_in_workpiece_mm + shaft_mm * pose.axis_in_workpiece - neighbour).norm() - thick_mm;
    };
    freedom.least_clearance_mm = 0.1;
    const auto reduced = reduce_rotary(path, shop.machining(), freedom);
    ASSERT_TRUE(reduced) << to_string(reduced.error());
    EXPECT_TRUE(reduced->changed);
    expect_kept(path, *reduced, shop.tool, 5 * degree);
    EXPECT_GE(least(reduced->path), 0.1 - 1e-4);
    EXPECT_LE(least(reduced->path), 0.2) << "and as near as it may";
    EXPECT_NEAR(reduced->least_clearance_mm, least(reduced->path), 1e-3);
    EXPECT_LE(reduced->after.travel_rad, 0.8 * reduced->before.travel_rad);
}

TEST(ReduceRotary, keeps_the_ranges_of_the_axes) {
    auto machine = shipped_machine("ucp710");
    const DualPath path = blade_pass(20);
    const Workshop open(machine, 3000, blade_ball());
    const auto reach = [&](const DualPath& of) {
        double out = 0;
        for (int i = 0; i <= 2000; ++i)
            out =
                std::max(out, std::acos(of.at(of.begin() + (of.end() - of.begin()) * i / 2000).axis_in_workpiece.z()));
        return out;
    };
    const auto unbound = reduce_rotary(path, open.machining(), within(5));
    ASSERT_TRUE(unbound);
    machine.axes[3].range_max = reach(path) + 1e-3;
    machine.axes[3].range_min = 0;
    const Workshop tight(machine, 3000, blade_ball());
    const auto reduced = reduce_rotary(path, tight.machining(), within(5));
    ASSERT_TRUE(reduced) << to_string(reduced.error());
    EXPECT_TRUE(reduced->changed);
    EXPECT_LE(reach(reduced->path), machine.axes[3].range_max);
    expect_kept(path, *reduced, tight.tool, 5 * degree);
}

TEST(ReduceRotary, a_four_axis_machine_has_one_rotary_axis_to_calm) {
    machine::Machine machine = shipped_machine("xyzab-tdr");
    machine.chain = {3, 0, 1, 2, 0};
    machine.axis_count = 4;
    machine.rotary_count = 1;
    const Workshop shop(machine, 3000, {machine::ToolKind::ball, 6, 3, 0, true});
    std::vector<Pose> poses;
    for (int i = 0; i <= 60; ++i) {
        const double tilt = (20 * std::sin(0.2 * i)) * degree;
        poses.push_back({Vector3d(i, 0, 0), Vector3d(0, -std::sin(tilt), std::cos(tilt))});
    }
    const DualPath path = fit_dual_path(poses).value().path;
    const auto reduced = reduce_rotary(path, shop.machining(), within(5));
    ASSERT_TRUE(reduced) << to_string(reduced.error());
    EXPECT_LE(reduced->after.travel_rad, 0.85 * reduced->before.travel_rad);
    expect_kept(path, *reduced, shop.tool, 5 * degree);
}

TEST(ReduceRotary, a_steady_tool_is_left_alone) {
    const Workshop shop(shipped_machine("ucp710"), 3000, blade_ball());
    std::vector<Pose> poses;
    for (int i = 0; i <= 20; ++i) poses.push_back({Vector3d(i, 0, 0), Vector3d(0.3, 0, 1).normalized()});
    const DualPath path = fit_dual_path(poses).value().path;
    const auto reduced = reduce_rotary(path, shop.machining(), within(5));
    ASSERT_TRUE(reduced) << to_string(reduced.error());
    EXPECT_NEAR(reduced->after.travel_rad, 0, 1e-9);
    EXPECT_NEAR(reduced->change.orientation_deviation_rad, 0, 1e-9);
}

TEST(ReduceRotary, random_paths_never_come_out_worse) {
    const std::uint32_t seed = 4711;
    std::mt19937 generator(seed);
    const auto uniform = [&](double from, double to) {
        return from + (to - from) * static_cast<double>(generator()) / 4294967295.0;
    };
    SCOPED_TRACE("seed " + std::to_string(seed));
    int changed = 0;
    for (int round = 0; round < 20; ++round) {
        SCOPED_TRACE("round " + std::to_string(round));
        const double tilt = uniform(0.1, 0.9), swing = uniform(0.05, 0.4), bend = uniform(0.1, 0.5);
        const double sway = uniform(0.05, 0.5), feed = uniform(500, 6000), tolerance = uniform(0.5, 10);
        std::vector<Pose> poses;
        for (int i = 0; i <= 50; ++i) {
            const Vector3d axis(tilt + swing * std::sin(bend * i), sway * std::cos(0.7 * bend * i), 1);
            poses.push_back({Vector3d(i, 5 * std::sin(0.2 * i), 0), axis.normalized()});
        }
        const DualPath path = fit_dual_path(poses).value().path;
        const Workshop shop(shipped_machine(round % 2 ? "trunnion-bc" : "nutating-head"), feed,
                            ball(6, round % 3 == 0));
        const auto reduced = reduce_rotary(path, shop.machining(), within(tolerance));
        ASSERT_TRUE(reduced) << to_string(reduced.error());
        expect_kept(path, *reduced, shop.tool, tolerance * degree);
        changed += reduced->changed;
    }
    EXPECT_GE(changed, 18);
}

TEST(ReduceRotary, the_same_bits_each_time) {
    const Workshop shop(shipped_machine("ucp710"), 3000, blade_ball());
    const DualPath path = blade_pass(20, 40);
    const auto first = reduce_rotary(path, shop.machining(), within(5)),
               second = reduce_rotary(path, shop.machining(), within(5));
    ASSERT_TRUE(first && second);
    EXPECT_EQ(first->path.spline.top().control_points_mm(), second->path.spline.top().control_points_mm());
}

TEST(ReduceRotary, poses_keep_their_controlled_point) {
    const Workshop shop(shipped_machine("ucp710"), 3000, blade_ball());
    const auto poses = normal_following(20, 60);
    const auto reduced = reduce_rotary(poses, {}, shop.machining(), within(5));
    ASSERT_TRUE(reduced) << to_string(reduced.error());
    ASSERT_EQ(reduced->poses.size(), poses.size());
    for (std::size_t i = 0; i < poses.size(); ++i) {
        const auto centre = [](const Pose& pose) -> Vector3d {
            return pose.tip_in_workpiece_mm + radius_mm * pose.axis_in_workpiece;
        };
        EXPECT_LE((centre(poses[i]) - centre(reduced->poses[i])).norm(), 1e-9);
    }
}

std::string code_of(const Result<RotaryReduced>& result) {
    return result ? "" : result.error().code;
}

TEST(ReduceRotary, refuses_what_makes_no_sense) {
    const DualPath path = blade_pass(20, 40);
    const Workshop shop(shipped_machine("ucp710"), 3000, blade_ball());
    EXPECT_EQ(code_of(reduce_rotary(path, shop.machining(), within(0))), "DEFO0202");
    EXPECT_EQ(code_of(reduce_rotary(path, shop.machining(), within(HUGE_VAL))), "DEFO0202");
    OrientationFreedom empty = within(5);
    empty.surface_normal = normals_of(path, 20);
    empty.lead = {1 * degree, -1 * degree};
    EXPECT_EQ(code_of(reduce_rotary(path, shop.machining(), empty)), "DEFO0202");
    const Workshop standing(shipped_machine("ucp710"), 0, blade_ball());
    EXPECT_EQ(code_of(reduce_rotary(path, standing.machining(), within(5))), "DEFO0202");
    const Workshop three(shipped_machine("three-axis"), 3000, blade_ball());
    EXPECT_EQ(code_of(reduce_rotary(path, three.machining(), within(5))), "DEFO0206");
    EXPECT_EQ(reduce_rotary(std::span<const Pose>{}, {}, shop.machining(), within(5)).error().code, "DEFO0101");
}

TEST(ReduceRotary, refuses_a_path_that_breaks_its_limits_from_the_beginning) {
    const DualPath path = blade_pass(20, 40);
    const Workshop shop(shipped_machine("ucp710"), 3000, blade_ball());
    OrientationFreedom freedom = within(5);
    freedom.surface_normal = normals_of(path, 20);
    freedom.lead = {2 * degree, 6 * degree};
    freedom.tilt = {-6 * degree, 6 * degree};
    EXPECT_EQ(code_of(reduce_rotary(path, shop.machining(), freedom)), "DEFO0205");
    OrientationFreedom blocked = within(5);
    blocked.clearance_mm = [](double, const Pose&) { return -1.0; };
    EXPECT_EQ(code_of(reduce_rotary(path, shop.machining(), blocked)), "DEFO0205");
}

}  // namespace
}  // namespace trunnion::deformation
