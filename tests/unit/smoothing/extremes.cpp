#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "trunnion/smoothing/smoothing.hpp"

#include "walk.hpp"

namespace trunnion::smoothing {
namespace {

using namespace test;

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

Walk expect_lawful(const path::Run& run) {
    const Walk w = walk(run, smoothed(run), 30, 0, 6);
    EXPECT_TRUE(w.finite);
    EXPECT_EQ(w.stretches, 1U);
    EXPECT_LE(w.over_tip, 1e-9) << "the bound does not hold";
    EXPECT_LE(w.bound_tip_mm, tight().tip_tolerance_mm);
    EXPECT_LE(w.jump, 1e-9) << "not C3";
    EXPECT_GT(w.least_speed, 0.05);
    return w;
}

/// Largest |c‴| of the tip, 1/mm².
double largest_third(const std::vector<path::ToolPath>& paths, double from_mm = 0, double to_mm = 1e9) {
    double largest = 0;
    for (const auto& path : paths)
        for (const auto& piece : path.pieces)
            for (int k = 0; k <= 4; ++k) {
                const double offset = piece.length_mm * k / 4, p = piece.begin_mm + offset;
                if (p < from_mm || p > to_mm) continue;
                const Pose d = derivative(piece, offset, 3);
                largest = std::max(largest, std::hypot(d[0], d[1], d[2]));
            }
    return largest;
}

TEST(Extremes, ShortBlockInACornerOfLongOnesChangesNothing) {
    const auto plain = upright({{0, 0, 0}, {1000, 0, 0}, {1000, 1000, 0}});
    const double third = largest_third(smoothed(plain));
    for (const double length : {1e-6, 1e-5, 1e-4}) {
        SCOPED_TRACE(length);
        const double part = length / std::sqrt(2.0);
        const auto run = upright({{0, 0, 0}, {1000 - part, 0, 0}, {1000, part, 0}, {1000, 1000, 0}});
        const Walk w = expect_lawful(run);
        EXPECT_GE(w.tip_mm, 0.009);
        EXPECT_NEAR(largest_third(smoothed(run)) / third, 1, 0.01);
    }
}

TEST(Extremes, NanometreNoiseOnMetresGivesNothingAway) {
    Random random(5);
    std::vector<std::array<double, 3>> points;
    for (int i = 0; i <= 40; ++i) points.push_back({1000.0 * i, random.uniform(-1e-6, 1e-6), 0});
    const auto run = upright(points);
    const Walk w = expect_lawful(run);
    EXPECT_LE(w.tip_mm, 1e-4) << "more than a piece may differ from its curve";
    EXPECT_LE(largest_third(smoothed(run)), 1e-8);
}

TEST(Extremes, NanometresMillimetresAndMetresInTurn) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random(seed);
        std::vector<std::array<double, 3>> points{{0, 0, 0}};
        double heading = 0;
        for (int i = 0; i < 60; ++i) {
            heading += random.uniform(-0.6, 0.6);
            const double length = std::pow(10, random.uniform(-6, 3));
            const auto& at = points.back();
            points.push_back({at[0] + length * std::cos(heading), at[1] + length * std::sin(heading), at[2]});
        }
        expect_lawful(upright(points));
    }
}

/// Far from the origin the coordinates' last digit is 2 pm: kinks of blocks and the smoothed path stay the same.
TEST(Extremes, TenMetresFromTheOrigin) {
    const auto arc = [](double from_mm) {
        std::vector<std::array<double, 3>> points;
        for (int i = 0; i <= 300; ++i)
            points.push_back({from_mm + 50 * std::sin(0.004 * i), from_mm - 50 * std::cos(0.004 * i), from_mm});
        return upright(points);
    };
    const auto near = smoothed(arc(0)), far = smoothed(arc(1e4));
    expect_lawful(arc(1e4));
    EXPECT_NEAR(largest_third(far, 10, 50), largest_third(near, 10, 50), 1e-6);
}

/// The same curve as blocks of 1 µm to 0.1 mm: the same path, bent as evenly.
TEST(Extremes, LengthOfBlocksDoesNotMatterOnACurve) {
    const auto wave = [](double step_mm) {
        std::vector<std::array<double, 3>> points;
        const int count = static_cast<int>(std::lround(24 / step_mm));
        for (int i = 0; i <= count; ++i) points.push_back({i * step_mm, std::sin(i * step_mm / 4), 0});
        return upright(points);
    };
    const auto coarse = smoothed(wave(0.1));
    const double third = largest_third(coarse, 8, 18);
    for (const double step : {0.001, 0.003, 0.01, 0.03}) {
        SCOPED_TRACE(step);
        const auto run = wave(step);
        const auto fine = smoothed(run);
        ASSERT_EQ(fine.size(), 1U);
        EXPECT_LE(fine[0].bound.tip_mm, 0.01);
        EXPECT_NEAR(largest_third(fine, 8, 18) / third, 1, 0.005);
        EXPECT_LE(fine[0].pieces.size(), coarse[0].pieces.size() + 20);
    }
}

TEST(Extremes, CornerOfMicrometreBlocksIsRoundedAsOne) {
    std::vector<std::array<double, 3>> points;
    for (int i = 0; i <= 4000; ++i) points.push_back({0.002 * i, 0, 0});
    for (int i = 1; i <= 4000; ++i) points.push_back({8, 0.002 * i, 0});
    const auto run = upright(points);
    const Walk w = expect_lawful(run);
    EXPECT_GE(w.tip_mm, 0.009);
    const double lone = largest_third(smoothed(upright({{0, 0, 0}, {8, 0, 0}, {8, 8, 0}})));
    EXPECT_NEAR(largest_third(smoothed(run)) / lone, 1, 0.02);
}

}  // namespace
}  // namespace trunnion::smoothing
