#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "trunnion/smoothing/smoothing.hpp"

#include "walk.hpp"

namespace trunnion::smoothing {
namespace {

using namespace test;

constexpr double pi_by_100 = std::numbers::pi / 100;

SmoothingOptions tight() {
    SmoothingOptions o;
    o.tip_tolerance_mm = 0.01;
    return o;
}

std::vector<path::ToolPath> smoothed(const path::Run& run) {
    std::vector<path::ToolPath> out;
    smooth(run, tight(), out);
    return out;
}

Pose place(const path::ToolPath& path, double p) {
    auto piece = std::upper_bound(path.pieces.begin() + 1, path.pieces.end(), p,
                                  [](double at, const path::PathPiece& x) { return at < x.begin_mm; });
    --piece;
    return derivative(*piece, p - piece->begin_mm, 0);
}

/// Largest distance of a path from another one walked backwards, at equal p.
double apart(const path::ToolPath& there, const path::ToolPath& back) {
    double largest = 0;
    for (const auto& piece : there.pieces)
        for (int k = 0; k <= 8; ++k) {
            const double offset = piece.length_mm * k / 8;
            const Pose a = derivative(piece, offset, 0), b = place(back, there.length_mm() - piece.begin_mm - offset);
            Pose d{};
            for (int i = 0; i < 6; ++i) d[i] = a[i] - b[i];
            largest = std::max(largest, size_of(d));
        }
    return largest;
}

/// Blocks of a curve, corners, both, with or without rounding noise.
std::vector<Pose> poses(std::uint64_t seed) {
    Random random(seed);
    const bool dense = random.uniform(0, 1) < 0.7, corners = !dense || random.uniform(0, 1) < 0.5;
    const double noise = random.uniform(0, 1) < 0.5 ? 1e-3 : 0;
    const double step = std::pow(10, dense ? random.uniform(-2, 0) : random.uniform(0, 1.3));
    double heading = 0, turning = 0, a = 0.3, c = 0.2;
    Eigen::Vector3d at = Eigen::Vector3d::Zero();
    std::vector<Pose> out;
    for (int i = 0; i < 400; ++i) {
        const double x = random.uniform(-noise, noise), y = random.uniform(-noise, noise);
        out.push_back({at.x() + x, at.y() + y, at.z(), a, c, 0});
        if (random.uniform(0, 1) < 0.01) turning = random.uniform(-0.2, 0.2);
        const bool corner = corners && random.uniform(0, 1) < (dense ? 0.01 : 1);
        heading += turning * step * (dense ? 1 : 0) + (corner ? random.uniform(-1, 1) : 0);
        const double way = step * random.uniform(0.6, 1.4);
        at += way * Eigen::Vector3d(std::cos(heading), std::sin(heading), 0.1);
        a += 1e-3 * way * turning;
        c += 1e-3 * way;
    }
    return out;
}

TEST(Reversed, RunIsTheSamePath) {
    for (std::uint64_t seed = 1; seed <= 24; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        auto there = poses(seed);
        const auto path = smoothed(run_through(there, path::OrientationLaw::rotary));
        std::reverse(there.begin(), there.end());
        const auto back = smoothed(run_through(there, path::OrientationLaw::rotary));
        ASSERT_EQ(path.size(), 1U);
        ASSERT_EQ(back.size(), 1U);
        EXPECT_LE(apart(path[0], back[0]), 1e-6);
    }
}

TEST(Reversed, ClosedCircleRunManyTimesOver) {
    std::vector<Pose> there;
    for (int i = 0; i <= 1000; ++i)
        there.push_back({20 * std::cos(i * pi_by_100), 20 * std::sin(i * pi_by_100), 0, 0, 0, 1});
    const auto path = smoothed(run_through(there, path::OrientationLaw::vector));
    std::reverse(there.begin(), there.end());
    const auto back = smoothed(run_through(there, path::OrientationLaw::vector));
    ASSERT_EQ(path.size(), 1U);
    ASSERT_EQ(back.size(), 1U);
    EXPECT_LE(apart(path[0], back[0]), 1e-6);
}

}  // namespace
}  // namespace trunnion::smoothing
