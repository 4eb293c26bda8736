#include <cmath>

#include <gtest/gtest.h>

#include "trunnion/smoothing/smoothing.hpp"

#include "walk.hpp"

namespace trunnion::smoothing {
namespace {

using namespace test;

/// Polylines with block lengths over many decades, from nearly straight to noise, with pure turns and pure ways.
struct Generator {
    Random random;
    double lowest, highest, bend;
    path::OrientationLaw law;
    path::Space space;

    explicit Generator(std::uint64_t seed) : random(seed) {
        const bool wild = random.uniform(0, 1) < 0.5, noise = random.uniform(0, 1) < 0.4;
        lowest = wild ? -6 : -2;
        highest = wild ? 3 : 1;
        bend = noise ? 3 : random.uniform(0, 1);
        const double kind = random.uniform(0, 3);
        law = kind < 1 ? path::OrientationLaw::vector : path::OrientationLaw::rotary;
        space = kind < 2 ? path::Space::workpiece : path::Space::machine;
    }

    double length() { return std::pow(10, random.uniform(lowest, highest)); }

    Pose pose(const Eigen::Vector3d& at, double a, double c) const {
        if (law == path::OrientationLaw::rotary) return {at.x(), at.y(), at.z(), a, c, 0};
        return {at.x(), at.y(), at.z(), std::sin(a) * std::cos(c), std::sin(a) * std::sin(c), std::cos(a)};
    }

    path::Run run() {
        const int blocks = 2 + static_cast<int>(random.uniform(0, 80));
        Eigen::Vector3d at = Eigen::Vector3d::Zero(), direction = Eigen::Vector3d::UnitX();
        double a = 0.3, c = 0.2, scale = length();
        std::vector<Pose> poses{pose(at, a, c)};
        while (static_cast<int>(poses.size()) <= blocks) {
            if (random.uniform(0, 1) < 0.3) scale = length();
            Eigen::Vector3d turn;
            for (int k = 0; k < 3; ++k) turn[k] = random.uniform(-1, 1);
            direction = (direction + bend * turn).normalized();
            const double step = scale * random.uniform(0.2, 1), angle = bend * std::min(scale / 30, 0.5);
            if (random.uniform(0, 1) > 0.1) at += step * direction;
            if (random.uniform(0, 1) > 0.1) {
                a += angle * random.uniform(-1, 1);
                c += angle * random.uniform(-1, 1);
            }
            const Pose next = pose(at, a, c);
            if (run_through({poses.back(), next}, law, space).blocks[0].length_mm > 2e-7) poses.push_back(next);
        }
        return run_through(poses, law, space);
    }

    SmoothingOptions options() {
        SmoothingOptions o;
        o.tip_tolerance_mm = std::pow(10, random.uniform(-3, -1));
        if (random.uniform(0, 1) < 0.3) {
            o.flank_tolerance_mm = 2 * o.tip_tolerance_mm;
            o.flank_height_mm = 20;
        }
        if (random.uniform(0, 1) < 0.3) o.controlled_height_mm = 5;
        return o;
    }
};

TEST(RandomRuns, KeepEveryPromise) {
    constexpr std::uint64_t first_seed = 1, runs = 250;
    double bound = 0, sample = 0;
    for (std::uint64_t seed = first_seed; seed < first_seed + runs; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Generator generator(seed);
        const path::Run run = generator.run();
        const SmoothingOptions o = generator.options();
        std::vector<path::ToolPath> paths;
        smooth(run, o, paths);
        const Walk w = walk(run, paths, o.flank_height_mm, o.controlled_height_mm, 6);
        ASSERT_TRUE(w.finite);
        ASSERT_LE(w.over_tip, 1e-9);
        ASSERT_LE(w.over_turn, 1e-9);
        ASSERT_LE(w.over_height, 1e-8);
        ASSERT_LE(w.bound_tip_mm, o.tip_tolerance_mm);
        if (o.flank_tolerance_mm > 0) {
            ASSERT_LE(w.bound_height_mm, o.flank_tolerance_mm);
        } else {
            ASSERT_LE(w.bound_turn_rad, o.orientation_tolerance_rad);
        }
        ASSERT_LE(w.jump, 1e-9);
        ASSERT_GT(w.least_speed, 0.05);
        ASSERT_LE(w.end_miss, 1e-9);
        for (const auto& path : paths) {
            ASSERT_EQ(path.transition_use.size(), path.blocks.size() - 1);
            ASSERT_NE(path.stop, path::StopCause::corner) << "stops where a rounding would do";
        }
        bound += w.bound_tip_mm;
        sample += w.tip_mm;
    }
    EXPECT_LE(bound, 1.5 * sample) << "bounds are far above what happens";
}

}  // namespace
}  // namespace trunnion::smoothing
