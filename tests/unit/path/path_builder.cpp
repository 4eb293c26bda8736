#include "trunnion/path/path_builder.hpp"

#include <gtest/gtest.h>

#include "trunnion_table.hpp"

namespace trunnion::path {
namespace {

using program::Event;
using program::EventKind;
using program::Move;
using program::MoveKind;
using program::Program;

Program rotary_program(std::vector<Move> moves) {
    Program program;
    program.rotary_letters = {'C', 'A'};
    program.moves = std::move(moves);
    for (Move& move : program.moves) move.law = OrientationLaw::rotary;
    return program;
}

Move to(double x, double y, double z, double c_deg = 0, double a_deg = 0) {
    Move move;
    move.position_mm = {x, y, z};
    move.rotary_rad = {c_deg * degree, a_deg * degree, 0};
    move.feed = {FeedRule::tip_speed, 10};
    return move;
}

std::vector<Run> runs_of(PathBuilder& builder) {
    std::vector<Run> out;
    for (path::Run run; builder.next(run).value();) out.push_back(run);
    return out;
}

TEST(PathBuilder, cuts_at_rapids_stops_and_stopping_events) {
    Program program = rotary_program(
        {to(0, 0, 0), to(10, 0, 0), to(20, 0, 0), to(20, 10, 0), to(20, 20, 0), to(20, 30, 0), to(0, 0, 50)});
    program.moves[2].exact_stop = true;
    program.moves[6].kind = MoveKind::rapid;
    program.events = {{EventKind::coolant, false, 0, "M8", 1, 1},
                      {EventKind::coolant, false, 0, "M9", 5, 1},
                      {EventKind::dwell, true, 0.5, "G4", 4, 1}};
    std::swap(program.events[1], program.events[2]);
    const auto machine = trunnion_table();
    const machine::Setup setup;
    auto builder = PathBuilder::make(program, machine, setup);
    ASSERT_TRUE(builder);
    const auto runs = runs_of(*builder);
    ASSERT_EQ(runs.size(), 4u);
    EXPECT_EQ(runs[0].blocks.size(), 2u);
    EXPECT_EQ(runs[0].stop, StopCause::exact_stop);
    EXPECT_EQ(runs[1].blocks.size(), 1u);
    EXPECT_EQ(runs[1].stop, StopCause::event);
    EXPECT_EQ(runs[2].blocks.size(), 2u);
    EXPECT_EQ(runs[2].stop, StopCause::rapid);
    EXPECT_TRUE(runs[3].rapid);
    EXPECT_EQ(runs[3].stop, StopCause::end);
    ASSERT_EQ(runs[2].events.size(), 2u);  // the dwell at its start, M9 before its second block
    EXPECT_EQ(runs[2].events[0].block, 0u);
    EXPECT_EQ(runs[2].events[1].block, 1u);
}

TEST(PathBuilder, gives_a_length_to_blocks_that_only_turn) {
    const auto machine = trunnion_table();
    const machine::Setup setup;
    const Program program =
        rotary_program({to(0, 0, 0), to(0, 0, 0, 0, 90), to(0, 0, 0, 90, 90), to(0, 0, 0, 90, 0), to(0, 0, 0, 0, 0)});
    auto builder = PathBuilder::make(program, machine, setup);
    path::Run run;
    ASSERT_TRUE(builder->next(run).value());
    ASSERT_EQ(run.blocks.size(), 4u);
    const double quarter = 30 * 90 * degree;
    EXPECT_NEAR(run.blocks[0].length_mm, quarter, 1e-9);
    EXPECT_NEAR(run.blocks[1].length_mm, quarter, 1e-9);        // C at A = 90° turns the tool fully
    EXPECT_NEAR(run.blocks[3].length_mm, 0.1 * quarter, 1e-9);  // C at the pole: the floor
}

TEST(PathBuilder, leaves_out_blocks_without_length) {
    const auto machine = trunnion_table();
    const machine::Setup setup;
    const Program program = rotary_program({to(0, 0, 0), to(1, 0, 0), to(1, 0, 0), to(1 + 1e-9, 0, 0), to(2, 0, 0)});
    auto builder = PathBuilder::make(program, machine, setup);
    path::Run run;
    ASSERT_TRUE(builder->next(run).value());
    ASSERT_EQ(run.blocks.size(), 2u);
    EXPECT_DOUBLE_EQ(run.vertices.back().position_mm[0], 2);
}

TEST(PathBuilder, applies_work_offsets_and_tool_lengths) {
    const auto machine = trunnion_table();
    machine::Setup setup;
    setup.offsets["G55"].origin_mm = {100, 0, 0};
    setup.tools["8"].length_mm = 60;
    Program program = rotary_program({to(0, 0, 0), to(1, 0, 0), to(2, 0, 0)});
    program.offsets.push_back("G55");
    program.tools.push_back("8");
    program.moves[1].offset = program.moves[2].offset = 1;
    program.moves[2].tool = 1;
    auto builder = PathBuilder::make(program, machine, setup);
    const auto runs = runs_of(*builder);
    ASSERT_EQ(runs.size(), 2u);
    EXPECT_DOUBLE_EQ(runs[0].vertices.back().position_mm[0], 101);
    EXPECT_EQ(runs[0].stop, StopCause::tool);
    EXPECT_DOUBLE_EQ(runs[1].vertices.front().position_mm[2],
                     -60);  // the longer tool's tip is lower where the machine stands
    EXPECT_DOUBLE_EQ(runs[1].vertices.back().position_mm[2], 0);
}

TEST(PathBuilder, refuses_what_the_setup_lacks) {
    const auto machine = trunnion_table();
    machine::Setup setup;
    Program program = rotary_program({to(0, 0, 0), to(1, 0, 0), to(2, 0, 0)});
    program.offsets.push_back("G56");
    program.moves[2].offset = 1;
    auto offset = PathBuilder::make(program, machine, setup);
    path::Run run;
    auto built = offset->next(run);
    ASSERT_FALSE(built);
    EXPECT_EQ(built.error().code, "PATH0003");

    Program tools = rotary_program({to(0, 0, 0), to(1, 0, 0), to(2, 0, 0)});
    tools.tools = {"", "1", "2"};
    tools.moves[1].tool = 1;
    tools.moves[2].tool = 2;
    auto two = PathBuilder::make(tools, machine, setup);
    EXPECT_TRUE(two->next(run).value());  // the first name takes [tool], and that is said
    ASSERT_EQ(two->diagnostics().size(), 1u);
    EXPECT_EQ(two->diagnostics()[0].code, "PATH0007");
    built = two->next(run);
    ASSERT_FALSE(built);
    EXPECT_EQ(built.error().code, "PATH0002");
}

TEST(PathBuilder, machine_coordinates_begin_where_the_workpiece_moves_ended) {
    const auto machine = trunnion_table();
    const machine::Setup setup;
    Program program = rotary_program({to(0, 0, 0, 0, 0), to(10, 0, 0, 30, 40), to(50, 60, 70, 30, 40)});
    program.moves[2].space = Space::machine;
    auto builder = PathBuilder::make(program, machine, setup);
    const auto runs = runs_of(*builder);
    ASSERT_EQ(runs.size(), 2u);
    EXPECT_EQ(runs[0].stop, StopCause::space);
    const auto linear =
        runs[0].kinematics->linear_for(Eigen::Vector3d{10, 0, 0}, machine::RotaryPosition{40 * degree, 30 * degree});
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(runs[1].vertices[0].position_mm[k], linear[k], 1e-12);
}

TEST(PathBuilder, refuses_opposite_tool_axes) {
    Program program;
    program.moves.resize(2);
    program.moves[1].axis = -Eigen::Vector3d::UnitZ();
    program.moves[1].line = 7;
    const auto machine = trunnion_table();
    const machine::Setup setup;
    auto builder = PathBuilder::make(program, machine, setup);
    path::Run run;
    const auto built = builder->next(run);
    ASSERT_FALSE(built);
    EXPECT_EQ(built.error().code, "PATH0005");
    EXPECT_EQ(built.error().place.line, 7);
}

}  // namespace
}  // namespace trunnion::path
