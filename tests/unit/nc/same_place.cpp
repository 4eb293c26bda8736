#include "detail/same_place.hpp"

#include <limits>

#include <gtest/gtest.h>

namespace trunnion::nc {
namespace {

using Eigen::Vector3d;
using program::Move;
using program::Program;

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

TEST(SamePlace, goes) {
    EXPECT_FALSE(goes({1, 2, 3}, {1, 2, 3}));
    EXPECT_FALSE(goes({1, 2, 3}, {1 + 0.9e-7, 2, 3}));
    EXPECT_TRUE(goes({1, 2, 3}, {1, 2, 3 - 1.1e-7}));
    EXPECT_FALSE(goes({1, 2, 3}, {unknown, 2, unknown})) << "what is not known stays";
    EXPECT_TRUE(goes({1, unknown, 3}, {1, 2, 3})) << "from a place that is not known";
}

TEST(SamePlace, append_leaves_out_what_does_not_move) {
    Program program;
    Move move;
    move.position_mm = {1, 2, 3};
    append(program, move);
    append(program, move);
    EXPECT_EQ(program.moves.size(), 1u);
    move.arc = 0;  // a whole turn
    append(program, move);
    EXPECT_EQ(program.moves.size(), 2u);
    move.arc = program::no_arc;
    move.curve_part = 0;
    append(program, move);
    EXPECT_EQ(program.moves.size(), 3u);
    move.curve_part = program::no_curve_part;
    move.axis = Vector3d::UnitX();
    append(program, move);
    EXPECT_EQ(program.moves.size(), 4u);
    append(program, move);
    EXPECT_EQ(program.moves.size(), 4u);
}

}  // namespace
}  // namespace trunnion::nc
