#include "trunnion/machine/machine.hpp"

#include <gtest/gtest.h>

#include "machines.hpp"

namespace {

using namespace trunnion::machine;

TEST(Machine, FindsItsAxesByLetter) {
    const Machine machine = examples::machine_of("CAXYZ", "AC");
    EXPECT_EQ(machine.index_of('X'), 0);
    EXPECT_EQ(machine.index_of('C'), 4);
    EXPECT_EQ(machine.index_of('B'), -1);
    EXPECT_EQ(machine.linear_count(), 3);
}

TEST(Tool, ControlledPointIsTheTipOrTheCentre) {
    Tool tool{.kind = ToolKind::ball, .diameter_mm = 10, .corner_radius_mm = 5};
    EXPECT_EQ(tool.controlled_height_mm(), 0);
    tool.controls_centre = true;
    EXPECT_EQ(tool.controlled_height_mm(), 5);
    tool.kind = ToolKind::torus;
    tool.corner_radius_mm = 2;
    EXPECT_EQ(tool.controlled_height_mm(), 2);
}

}  // namespace
