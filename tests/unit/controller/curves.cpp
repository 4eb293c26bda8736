// Curves of a program through the block model.
#include <cmath>

#include <gtest/gtest.h>

#include "made.hpp"

namespace {

using namespace trunnion;
using test::made_control;
using test::moves;
using test::predicted;

/// A parabola over 60 mm as one block, y = x (60 − x) / 60, at A10 C0.
program::Program parabola(double feed_mm_s) {
    auto out = moves(feed_mm_s, {{0, 0, 0, 10, 0}, {60, 0, 0, 10, 0}});
    program::Curve curve;
    curve.degree = 2;
    curve.knots = {0, 0, 0, 1, 1, 1};
    curve.position_mm = {{0, 0, 0}, {30, 30, 0}, {60, 0, 0}};
    out.curves = {curve};
    out.curve_parts = {{0, 0, 1}};
    out.moves[1].curve_part = 0;
    return out;
}

TEST(CurveBlocks, TakeAsLongAsTheirLength) {
    const double length = 60 * (std::sqrt(2.0) + std::asinh(1.0)) / 2;
    const double time_s = predicted(parabola(10), made_control()).told.cycle_time_s;
    EXPECT_GT(time_s, length / 10);
    EXPECT_LT(time_s, 1.03 * length / 10 + 0.1);
}

TEST(CurveBlocks, AreFollowedByTheAxes) {
    const auto rows = predicted(parabola(10), made_control()).rows;
    ASSERT_FALSE(rows.empty());
    double farthest = 0;
    for (const auto& row : rows) farthest = std::max(farthest, std::abs(row.position[1] - rows.front().position[1]));
    EXPECT_NEAR(farthest, 15 * std::cos(10 * degree), 0.05) << "they go along the curve, not along its chord";
}

}  // namespace
