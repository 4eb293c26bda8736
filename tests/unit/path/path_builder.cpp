#include "trunnion/path/path_builder.hpp"

#include <cmath>
#include <limits>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "trunnion/path/rotary_stands.hpp"

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

/// The builder with the stands that it goes by.
struct Built {
    std::vector<program::RotaryStand> stands;
    Result<PathBuilder> builder;

    Built(const Program& program, const machine::Machine& machine, const machine::Setup& setup)
        : stands(chosen(program, machine, setup)), builder(PathBuilder::make(program, machine, setup, stands)) {}
    static std::vector<program::RotaryStand> chosen(const Program& program, const machine::Machine& machine,
                                                    const machine::Setup& setup) {
        const auto found = choose_rotary_stands(program, machine, setup);
        EXPECT_TRUE(found) << to_string(found.error());
        return found ? *found : std::vector<program::RotaryStand>(program.moves.size());
    }
    explicit operator bool() const { return builder.has_value(); }
    PathBuilder* operator->() { return &*builder; }
    PathBuilder& operator*() { return *builder; }
};

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
    Built builder(program, machine, setup);
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
    Built builder(program, machine, setup);
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
    Built builder(program, machine, setup);
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
    Built builder(program, machine, setup);
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
    const std::vector<program::RotaryStand> stands(3);
    auto offset = PathBuilder::make(program, machine, setup, stands);
    path::Run run;
    auto built = offset->next(run);
    ASSERT_FALSE(built);
    EXPECT_EQ(built.error().code, "PATH0003");
    EXPECT_EQ(choose_rotary_stands(program, machine, setup).error().code, "PATH0003");

    Program tools = rotary_program({to(0, 0, 0), to(1, 0, 0), to(2, 0, 0)});
    tools.tools = {"", "1", "2"};
    tools.moves[1].tool = 1;
    tools.moves[2].tool = 2;
    auto two = PathBuilder::make(tools, machine, setup, stands);
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
    Built builder(program, machine, setup);
    const auto runs = runs_of(*builder);
    ASSERT_EQ(runs.size(), 2u);
    EXPECT_EQ(runs[0].stop, StopCause::space);
    const auto linear =
        runs[0].kinematics->linear_for(Eigen::Vector3d{10, 0, 0}, machine::RotaryPosition{40 * degree, 30 * degree});
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(runs[1].vertices[0].position_mm[k], linear[k], 1e-12);
}

Move untransformed(Move move) {
    move.space = Space::untransformed;
    return move;
}

/// An offset turned about Z, a long tool, and a quarter of a helix in the offset's XY plane.
struct WithOffset {
    machine::Machine machine = trunnion_table();
    machine::Setup setup;
    Program program;

    WithOffset() {
        machine::Frame& offset = setup.offsets["G55"];
        offset.origin_mm = {100, 20, -5};
        offset.rotation = Eigen::AngleAxisd(30 * degree, Eigen::Vector3d::UnitZ()).toRotationMatrix();
        setup.tool.length_mm = 60;
        program = rotary_program({to(20, 0, 0, 40, 10), to(0, 20, 7, 40, 10)});
        program.offsets.push_back("G55");
        for (Move& move : program.moves) move.offset = 1;
        program.arcs.push_back({{0, 0, 3}, Eigen::Vector3d::UnitZ(), 90 * degree});
        program.moves[1].arc = 0;
    }
    Eigen::Vector3d programmed(double w) const {
        const auto& [a, b] = std::pair(program.moves[0].position_mm, program.moves[1].position_mm);
        const geometry::Helix helix(a, b, program.arcs[0].centre_mm, program.arcs[0].normal, program.arcs[0].angle_rad);
        const machine::Frame& offset = setup.offsets.at("G55");
        return offset.rotation * helix.at(w) + offset.origin_mm;
    }
};

TEST(PathBuilder, turns_arcs_with_the_work_offset) {
    const WithOffset w;
    Built builder(w.program, w.machine, w.setup);
    const auto runs = runs_of(*builder);
    ASSERT_EQ(runs.size(), 1u);
    ASSERT_EQ(runs[0].blocks[0].arc, 0);
    EXPECT_NEAR(runs[0].blocks[0].length_mm, std::hypot(20 * 90 * degree, 7), 1e-9);
    const auto helix = helix_between(runs[0].arcs[0], runs[0].vertices[0], runs[0].vertices[1]);
    for (const double share : {0.0, 0.3, 1.0}) EXPECT_LT((helix.at(share) - w.programmed(share)).norm(), 1e-12);
}

TEST(PathBuilder, untransformed_coordinates_are_the_tip_with_the_rotary_axes_at_zero) {
    for (const bool reversed : {false, true}) {
        WithOffset w;
        w.machine.axes[1].reversed = reversed;  // a reflection: the arc turns the other way in machine axes
        for (Move& move : w.program.moves) move = untransformed(move);
        Built builder(w.program, w.machine, w.setup);
        const auto runs = runs_of(*builder);
        ASSERT_EQ(runs.size(), 1u);
        EXPECT_EQ(runs[0].space, Space::machine);
        EXPECT_EQ(runs[0].law, OrientationLaw::rotary);
        EXPECT_DOUBLE_EQ(runs[0].vertices[1].orientation[1], 40 * degree);
        const auto helix = helix_between(runs[0].arcs[0], runs[0].vertices[0], runs[0].vertices[1]);
        for (const double share : {0.0, 0.3, 1.0}) {
            machine::AxisPosition axes;
            for (int i = 0; i < 3; ++i) axes[i] = helix.at(share)[i];
            EXPECT_LT((runs[0].kinematics->forward(axes).tip_in_workpiece_mm - w.programmed(share)).norm(), 1e-11)
                << reversed << " " << share;
        }
    }
}

TEST(PathBuilder, refuses_arcs_that_cannot_be) {
    WithOffset skewed;
    for (Move& move : skewed.program.moves) move = untransformed(move);
    skewed.machine.axes[1].direction = Eigen::Vector3d(0.1, 1, 0).normalized();
    Built builder(skewed.program, skewed.machine, skewed.setup);
    path::Run run;
    EXPECT_EQ(builder->next(run).error().code, "PATH0008");
    WithOffset on_axis;
    on_axis.program.arcs[0].centre_mm = {20, 0, 3};
    Built other(on_axis.program, on_axis.machine, on_axis.setup);
    EXPECT_EQ(other->next(run).error().code, "PATH0009");
}

TEST(PathBuilder, coordinates_left_open_stay_where_the_machine_stands) {
    WithOffset w;
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    Move up = to(nan, nan, 300, 40, 10), across = untransformed(to(5, nan, nan, 40, 10)),
         down = to(nan, nan, 1, 40, 10);
    up.space = Space::machine;
    up.offset = across.offset = down.offset = 1;
    w.program.moves[1].arc = program::no_arc;
    w.program.moves.insert(w.program.moves.end(), {up, across, down});
    Built builder(w.program, w.machine, w.setup);
    const auto runs = runs_of(*builder);
    ASSERT_EQ(runs.size(), 4u);
    const machine::Kinematics& k = *runs[0].kinematics;
    const auto before = runs[1].vertices[0].position_mm, raised = runs[1].vertices[1].position_mm;
    EXPECT_DOUBLE_EQ(raised[0], before[0]);
    EXPECT_DOUBLE_EQ(raised[1], before[1]);
    EXPECT_DOUBLE_EQ(raised[2], 300);
    const machine::Frame& offset = w.setup.offsets.at("G55");
    const auto counted = [&](const std::array<double, 3>& linear, bool turned) {  // in the offset, mm
        machine::AxisPosition axes{
            {linear[0], linear[1], linear[2], turned ? 10 * degree : 0, turned ? 40 * degree : 0}};
        return Eigen::Vector3d(offset.rotation.transpose() * (k.forward(axes).tip_in_workpiece_mm - offset.origin_mm));
    };
    const auto moved = runs[2].vertices[1].position_mm;
    EXPECT_NEAR(counted(moved, false).x(), 5, 1e-12);
    EXPECT_NEAR(counted(moved, false).y(), counted(raised, false).y(), 1e-11);
    EXPECT_NEAR(counted(moved, false).z(), counted(raised, false).z(), 1e-11);
    const Eigen::Vector3d tip = Eigen::Vector3d(runs[3].vertices[1].position_mm.data());
    const Eigen::Vector3d in_offset = offset.rotation.transpose() * (tip - offset.origin_mm);
    EXPECT_NEAR(in_offset.x(), counted(moved, true).x(), 1e-11);
    EXPECT_NEAR(in_offset.y(), counted(moved, true).y(), 1e-11);
    EXPECT_NEAR(in_offset.z(), 1, 1e-12);
}

TEST(PathBuilder, a_tool_without_its_offset_has_no_length) {
    const auto machine = trunnion_table();
    machine::Setup setup;
    setup.tools["8"].length_mm = 60;
    Program program = rotary_program({to(0, 0, 0), to(1, 0, 0)});
    program.tools = {"", "8", "8 D0"};
    program.moves[0].tool = 1;
    program.moves[1].tool = 2;
    Built builder(program, machine, setup);
    const auto runs = runs_of(*builder);
    ASSERT_EQ(runs.size(), 1u);
    EXPECT_DOUBLE_EQ(runs[0].vertices.front().position_mm[2], 60);
}

TEST(PathBuilder, goes_from_vectors_to_words_and_back_where_the_axes_stand) {
    const auto machine = trunnion_table();
    const machine::Setup setup;
    Program program = rotary_program({to(0, 0, 0, 370, 20), to(1, 0, 0, 380, 20), to(2, 0, 0), to(3, 0, 0, 385, 25)});
    program.moves[2].law = OrientationLaw::vector;
    const double a = 20 * degree, c = 25 * degree;
    program.moves[2].axis = {std::sin(c) * std::sin(a), -std::cos(c) * std::sin(a), std::cos(a)};
    Built builder(program, machine, setup);
    const auto runs = runs_of(*builder);
    ASSERT_EQ(runs.size(), 3u);
    EXPECT_EQ(runs[0].stop, StopCause::law);
    EXPECT_EQ(runs[1].law, OrientationLaw::vector);
    EXPECT_NEAR(runs[1].stands[0][1], 380 * degree, 1e-12);
    EXPECT_NEAR(runs[1].stands[1][1], 385 * degree, 1e-12);
    EXPECT_NEAR(runs[2].vertices[0].orientation[1], 385 * degree, 1e-12);
}

TEST(PathBuilder, says_where_a_run_goes_through_the_pole) {
    const auto machine = trunnion_table();
    const machine::Setup setup;
    Program program;
    for (int k = 0; k <= 20; ++k) {
        Move move;
        const double tilt = (k - 9.7) * degree;
        move.position_mm = {1.0 * k, 0, 0};
        move.axis = Eigen::Vector3d(std::sin(tilt), 1e-3, std::cos(tilt)).normalized();
        move.feed = {FeedRule::tip_speed, 10};
        program.moves.push_back(move);
    }
    for (const double tolerance_rad : {0.0, 1.4e-3}) {
        const auto stands = choose_rotary_stands(program, machine, setup, tolerance_rad);
        ASSERT_TRUE(stands);
        auto builder = PathBuilder::make(program, machine, setup, *stands);
        ASSERT_TRUE(builder);
        const auto runs = runs_of(*builder);
        ASSERT_EQ(runs.size(), 1U);
        ASSERT_EQ(runs[0].passages.size(), tolerance_rad > 0 ? 1U : 0U);
        if (runs[0].passages.empty()) continue;
        const PolePassage& passage = runs[0].passages[0];
        EXPECT_EQ(passage.block, 9U);
        EXPECT_NEAR(passage.share, 0.7, 1e-3);
        EXPECT_NEAR(passage.pole.z(), 1, 1e-15);
    }
}

}  // namespace
}  // namespace trunnion::path
