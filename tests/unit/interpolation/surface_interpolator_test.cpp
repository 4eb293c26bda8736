#include "trunnion/interpolation/surface_interpolator.hpp"

#include <cmath>
#include <cstdlib>
#include <new>
#include <thread>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "trunnion/geometry/great_circle.hpp"

#include "surface_samples.hpp"

namespace {

thread_local std::size_t allocations = 0;

void* counted_or_null(std::size_t size) noexcept {
    ++allocations;
    return std::malloc(size);
}

void* counted(std::size_t size) {
    if (void* out = counted_or_null(size)) return out;
    throw std::bad_alloc();
}

}  // namespace

void* operator new(std::size_t size) {
    return counted(size);
}
void* operator new[](std::size_t size) {
    return counted(size);
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {  // std::stable_sort's
    return counted_or_null(size);
}
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept {
    return counted_or_null(size);
}
void operator delete(void* p) noexcept {
    std::free(p);
}
void operator delete[](void* p) noexcept {
    std::free(p);
}
void operator delete(void* p, std::size_t) noexcept {
    std::free(p);
}
void operator delete[](void* p, std::size_t) noexcept {
    std::free(p);
}

namespace trunnion::interpolation {
namespace {

using namespace samples;
using motion::ProfilePiece;

/// A curve with its path and a profile of constant feed, without rest at its ends.
struct Pass {
    machine::Machine machine = trunnion_table();
    machine::Kinematics kinematics = machine::Kinematics::make(machine, {{10, -20, 30}}, 100).value();
    BsplineSurface surface;
    SurfaceCurve curve;
    SurfacePath path;
    path::AxisPath axes;
    motion::FeedProfile profile;

    Pass(BsplineSurface on, const BsplineCurve& places, const SurfaceTool& tool, double feed_mm_s)
        : surface(std::move(on)),
          curve(SurfaceCurve::make(surface, geometry::Side::along, places, tool).value()),
          path(surface_path(curve, kinematics, {.feed_mm_s = feed_mm_s}).value()),
          axes(path::AxisPath::make(path.tool_path, machine, {}).value()) {
        double time = 0;
        for (std::size_t i = 0; i < path.pieces.size(); ++i) {
            const double length = path.tool_path.pieces[i].length_mm;
            profile.pieces.push_back({.path_piece = i,
                                      .length_mm = length,
                                      .x0 = feed_mm_s * feed_mm_s,
                                      .begin_s = time,
                                      .duration_s = length / feed_mm_s});
            time += length / feed_mm_s;
        }
    }

    /// The parameter at a way from the start of a piece.
    double parameter(std::size_t piece, double way_mm) const {
        double low = path.pieces[piece].w_begin, high = path.pieces[piece].w_end;
        for (int halving = 0; halving < 60; ++halving) {
            const double middle = 0.5 * (low + high);
            (curve.way_mm(path.pieces[piece].w_begin, middle) < way_mm ? low : high) = middle;
        }
        return low;
    }
};

Pass smooth_pass(double feed_mm_s) {
    return {hills(60, 12), bow(), {6, 2, 0.1, 0.05}, feed_mm_s};
}

/// Largest distance of tips from the true pose at the way that the profile wants; axis angles in mm at 30 mm.
double largest_error(const Pass& pass, StepOrder order, double period_s) {
    const SurfaceProfile profile(pass.profile);
    SurfaceInterpolator interpolator(pass.curve, pass.path, pass.axes, profile, order);
    double largest = 0;
    for (double t = 0; t <= pass.profile.duration_s(); t += period_s) {
        const SurfaceInstant now = interpolator.at(t);
        const double offset = now.way_mm - pass.path.tool_path.pieces[now.path_piece].begin_mm;
        const auto pose = pass.curve.pose(pass.curve.contact(pass.parameter(now.path_piece, offset)));
        largest = std::max({largest, (now.pose.tip_in_workpiece_mm - pose.tip_in_workpiece_mm).norm(),
                            30 * geometry::angle_between(now.pose.axis_in_workpiece, pose.axis_in_workpiece)});
    }
    return largest;
}

/// Steps of 0.05 mm; what a step is off does not add up over the 1200 of them.
TEST(SurfaceInterpolator, follows_the_profile_on_the_surface) {
    const Pass pass = smooth_pass(50);
    EXPECT_LT(largest_error(pass, StepOrder::corrected, 1e-3), 1e-9);
    const double second = largest_error(pass, StepOrder::second, 1e-3),
                 first = largest_error(pass, StepOrder::first, 1e-3);
    EXPECT_LT(second, 0.05 * 5e-5);
    EXPECT_LT(first, 0.05 * 5e-3);
    EXPECT_GT(first, second);
}

TEST(SurfaceInterpolator, goes_over_bridges_within_their_tolerance) {
    const Pass pass(patched_hills(60, 12), line(0.1, 0.2, 0.9, 0.7), {5, 0, 0, 0}, 50);
    ASSERT_GT(pass.path.bridged_mm, 0);
    const double error = largest_error(pass, StepOrder::corrected, 1e-3);
    EXPECT_LT(error, 2e-4 + 30 * 2e-5);
    EXPECT_GT(error, 1e-8);  // there are bridges
}

/// The lean changes along the pass: the axis is that of the orientation surface every period.
TEST(SurfaceInterpolator, follows_an_orientation_surface) {
    const BsplineSurface smooth = leaning(false), knotted = leaning(true);
    const Pass exact(hills(60, 4), bow(), on(smooth, 6, 2), 50), bridged(hills(60, 4), bow(), on(knotted, 6, 2), 50);
    EXPECT_LT(largest_error(exact, StepOrder::corrected, 1e-3), 1e-9);
    EXPECT_GT(bridged.path.bridged_mm, 0);
    EXPECT_LT(largest_error(bridged, StepOrder::corrected, 1e-3), 2e-4 + 30 * 2e-5);
}

TEST(SurfaceInterpolator, moves_the_axes_to_the_pose_without_a_jump) {
    const Pass pass = smooth_pass(50);
    const SurfaceProfile profile(pass.profile);
    SurfaceInterpolator interpolator(pass.curve, pass.path, pass.axes, profile, StepOrder::corrected);
    machine::AxisPosition before = interpolator.at(0).position;
    for (double t = 1e-3; t < pass.profile.duration_s(); t += 1e-3) {
        const SurfaceInstant now = interpolator.at(t);
        const machine::Pose there = pass.kinematics.forward(now.position);
        ASSERT_LT((there.tip_in_workpiece_mm - now.pose.tip_in_workpiece_mm).norm(), 1e-10) << t;
        ASSERT_LT((there.axis_in_workpiece - now.pose.axis_in_workpiece).norm(), 1e-12) << t;
        for (int i = 3; i < 5; ++i) ASSERT_LT(std::abs(now.position[i] - before[i]), 0.05) << t;
        before = now.position;
    }
}

TEST(SurfaceInterpolator, stands_at_the_end_and_says_where_its_plan_ends) {
    const Pass pass = smooth_pass(50);
    SurfaceProfile profile;
    SurfaceInterpolator interpolator(pass.curve, pass.path, pass.axes, profile, StepOrder::corrected);
    EXPECT_EQ(interpolator.at(0).status, SurfaceStatus::starved);
    profile.add(pass.profile.pieces[0]);
    EXPECT_EQ(interpolator.at(1e-3).status, SurfaceStatus::moving);
    const double planned = profile.planned_s();
    EXPECT_EQ(planned, pass.profile.pieces[0].duration_s);
    const SurfaceInstant starved = interpolator.at(planned + 1e-3);
    EXPECT_EQ(starved.status, SurfaceStatus::starved);
    EXPECT_NEAR(starved.way_mm, pass.path.tool_path.pieces[0].length_mm, 1e-9);
    for (std::size_t i = 1; i < pass.profile.pieces.size(); ++i) profile.add(pass.profile.pieces[i]);
    profile.finish();
    for (double t = planned; t < pass.profile.duration_s(); t += 1e-3) interpolator.at(t);
    const SurfaceInstant end = interpolator.at(100);
    EXPECT_EQ(end.status, SurfaceStatus::finished);
    const auto pose = pass.curve.pose(pass.curve.contact(pass.curve.end()));
    EXPECT_LT((end.pose.tip_in_workpiece_mm - pose.tip_in_workpiece_mm).norm(), 1e-8);
}

TEST(SurfaceProfile, keeps_pieces_where_they_are_while_it_grows) {
    SurfaceProfile profile;
    EXPECT_EQ(profile.planned_s(), 0);
    profile.add({.begin_s = 0, .duration_s = 1});
    const ProfilePiece* const first = &profile[0];
    for (int i = 1; i < 3000; ++i) profile.add({.begin_s = 1.0 * i, .duration_s = 1});
    EXPECT_EQ(first, &profile[0]);
    for (std::size_t i = 0; i < 3000; ++i) ASSERT_EQ(profile[i].begin_s, static_cast<double>(i));
    EXPECT_EQ(profile.planned_s(), 3000);
}

/// Pieces come from another thread while the interpolator runs, so fast that it starves now and then. What it says of a
/// time for which the plan was there is what it says of a plan that was complete before.
TEST(SurfaceInterpolator, takes_over_pieces_from_another_thread) {
    const Pass pass(patched_hills(60, 12), line(0.1, 0.2, 0.9, 0.7), {5, 0, 0, 0}, 50);
    const SurfaceProfile complete(pass.profile);
    SurfaceProfile growing;
    std::jthread planner([&] {
        for (const ProfilePiece& piece : pass.profile.pieces) {
            growing.add(piece);
            std::this_thread::yield();
        }
        growing.finish();
    });
    SurfaceInterpolator behind(pass.curve, pass.path, pass.axes, complete, StepOrder::corrected);
    SurfaceInterpolator beside(pass.curve, pass.path, pass.axes, growing, StepOrder::corrected);
    const double end = pass.profile.duration_s();
    std::size_t compared = 0;
    for (double t = 0; t < end;) {
        if (growing.size() == 0 || t > growing.planned_s()) {
            std::this_thread::yield();
            continue;
        }
        const SurfaceInstant wanted = behind.at(t), now = beside.at(t);
        ASSERT_EQ(now.status, SurfaceStatus::moving);
        ASSERT_EQ(now.position, wanted.position) << t;
        ++compared;
        t += 1e-3;
    }
    planner.join();
    EXPECT_GT(compared, 500u);
    EXPECT_EQ(beside.at(end + 1).status, SurfaceStatus::finished);
}

TEST(SurfaceInterpolator, allocates_nothing_while_it_runs) {
    for (const StepOrder order : {StepOrder::first, StepOrder::second, StepOrder::corrected}) {
        const Pass pass(patched_hills(60, 12), line(0.1, 0.2, 0.9, 0.7), {5, 1, 0.1, 0}, 50);
        const SurfaceProfile profile(pass.profile);
        const std::size_t before_all = allocations;
        SurfaceInterpolator interpolator(pass.curve, pass.path, pass.axes, profile, order);
        double sum = 0;
        for (double t = 0; t < pass.profile.duration_s(); t += 1e-3) sum += interpolator.at(t).position[0];
        EXPECT_EQ(allocations, before_all) << sum;
    }
    const BsplineSurface second = leaning(true);
    const Pass oriented(hills(60, 4), bow(), on(second, 6, 2), 50);
    const SurfaceProfile profile(oriented.profile);
    const std::size_t before_all = allocations;
    SurfaceInterpolator interpolator(oriented.curve, oriented.path, oriented.axes, profile, StepOrder::corrected);
    double sum = 0;
    for (double t = 0; t < oriented.profile.duration_s(); t += 1e-3) sum += interpolator.at(t).position[0];
    EXPECT_EQ(allocations, before_all) << sum;
    const std::size_t before = allocations;  // the guard counts
    const std::vector<double> something(static_cast<std::size_t>(before % 7 + 3));
    EXPECT_GT(allocations, before);
}

}  // namespace
}  // namespace trunnion::interpolation
