// A program under the other orientation law, and a program that is written as a file.
#include "trunnion/pipeline/convert.hpp"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/files/machine_file.hpp"
#include "trunnion/geometry/great_circle.hpp"
#include "trunnion/machine/kinematics.hpp"
#include "trunnion/nc/read.hpp"

namespace trunnion::pipeline {
namespace {

using program::Move;
using program::OrientationLaw;
using program::Program;

machine::Machine trunnion_table() {
    return *files::read_machine_file(TRUNNION_SOURCE_DIR "/data/machines/xyzac-trt.toml");
}

Program read(std::string_view text, const machine::Machine& machine) {
    nc::ReadOptions options;
    options.machine = &machine;
    return *nc::read_program(text, "program", options);
}

/// The tool axis at the end of a move under rotary words.
Eigen::Vector3d axis_of(const Move& move, const machine::Machine& machine) {
    const auto kinematics = machine::Kinematics::make(machine, {}, 0);
    return kinematics->tool_axis(machine::RotaryPosition{move.rotary_rad[0], move.rotary_rad[1]});
}

constexpr std::string_view turning =
    "UNITS/MM\nFEDRAT/600,MMPM\nGOTO/0,0,0,0.6,0,0.8\nGOTO/30,0,0,0,0.6,0.8\nGOTO/30,30,0,-0.6,0,0.8\n";

/// Every part begins and ends on the great circle of the vectors, and between them words keep within the precision.
TEST(Convert, vectors_become_words_within_the_precision) {
    const auto machine = trunnion_table();
    const Program program = read(turning, machine);
    const double precision = 0.01 * degree;
    const auto words = translate(program, machine, {}, OrientationLaw::rotary, precision);
    ASSERT_TRUE(words) << to_string(words.error());
    EXPECT_GT(words->moves.size(), 20u);
    EXPECT_LT(words->moves.size(), 400u) << "as few as the precision needs";
    ASSERT_EQ(words->rotary_letters, (std::vector<char>{'A', 'C'}));
    const geometry::GreatCircle turn(program.moves[0].axis, program.moves[1].axis);
    for (std::size_t k = 1; k < words->moves.size(); ++k) {
        const Move &from = words->moves[k - 1], &to = words->moves[k];
        EXPECT_EQ(to.law, OrientationLaw::rotary);
        EXPECT_EQ(to.feed, program.moves[1].feed);
        if (to.position_mm.y() > 0) break;
        const double share = to.position_mm.x() / 30;
        EXPECT_LT(geometry::angle_between(axis_of(to, machine), turn.at(share)), 1e-9);
        Move middle = to;
        for (std::size_t i = 0; i < 2; ++i) middle.rotary_rad[i] = 0.5 * (from.rotary_rad[i] + to.rotary_rad[i]);
        const double at = 0.5 * (from.position_mm.x() + to.position_mm.x()) / 30;
        EXPECT_LT(geometry::angle_between(axis_of(middle, machine), turn.at(at)), 1.05 * precision);
    }
}

TEST(Convert, words_become_vectors_and_words_again) {
    const auto machine = trunnion_table();
    const Program program = read("G21 M428\nG0 X0 Y0 Z0 A-30 C0\nG1 X10 A-40 C30 F600\nG93 X20 C60 F60\n", machine);
    const auto vectors = translate(program, machine, {}, OrientationLaw::vector, 0.01 * degree);
    ASSERT_TRUE(vectors) << to_string(vectors.error());
    EXPECT_TRUE(vectors->rotary_letters.empty());
    EXPECT_LT((vectors->moves.back().axis - axis_of(program.moves.back(), machine)).norm(), 1e-12);
    double time = 0;
    for (const Move& move : vectors->moves)
        if (move.feed.rule == program::FeedRule::block_time) time += move.feed.value;
    EXPECT_NEAR(time, 1, 1e-12) << "the parts of a block share its time";
    const auto words = translate(*vectors, machine, {}, OrientationLaw::rotary, 0.01 * degree);
    ASSERT_TRUE(words);
    for (std::size_t i = 0; i < 2; ++i)
        EXPECT_NEAR(words->moves.back().rotary_rad[i], program.moves.back().rotary_rad[i], 1e-9);
}

TEST(Convert, events_keep_their_places) {
    const auto machine = trunnion_table();
    Program program = read(turning, machine);
    program.events.push_back({program::EventKind::dwell, true, 1, "DELAY/1", 2, 5});
    const auto words = translate(program, machine, {}, OrientationLaw::rotary, 0.01 * degree);
    ASSERT_TRUE(words);
    const std::size_t place = words->events[0].before_move;
    EXPECT_LT((words->moves[place - 1].position_mm - program.moves[1].position_mm).norm(), 1e-12);
    EXPECT_GT(words->moves[place].position_mm.y(), 0);
}

TEST(Convert, tells_of_words_that_vectors_cannot_say) {
    const auto machine = trunnion_table();
    const Program program = read("G21 M428\nG0 X0 Y0 Z0 A0 C0\nG1 X10 C30 F600\n", machine);
    const auto vectors = translate(program, machine, {}, OrientationLaw::vector, 0.01 * degree);
    ASSERT_TRUE(vectors);
    ASSERT_EQ(vectors->diagnostics.size(), 1 + program.diagnostics.size());
    EXPECT_EQ(vectors->diagnostics.back().code, "PIPE0015");
}

/// Past the pole within a nanoradian the words turn by half a turn at once.
TEST(Convert, refuses_what_falls_into_too_many_parts) {
    const auto machine = trunnion_table();
    const Program program =
        read("UNITS/MM\nFEDRAT/600,MMPM\nGOTO/0,0,0,0.6,0.0000001,0.8\nGOTO/30,0,0,-0.3,0.0000001,0.9\n", machine);
    const auto words = translate(program, machine, {}, OrientationLaw::rotary, 1e-9);
    ASSERT_FALSE(words);
    EXPECT_EQ(words.error().code, "PIPE0012");
}

TEST(Convert, refuses_curves_that_turn_the_tool) {
    const auto machine = trunnion_table();
    Program program = read(turning, machine);
    program::Curve curve{.degree = 1, .knots = {0, 0, 1, 1}};
    curve.position_mm = {{0, 0, 0}, {30, 0, 0}};
    curve.axis = {{0.6, 0, 0.8}, {0, 0.6, 0.8}};
    program.curves = {curve};
    program.curve_parts = {{0, 0, 1}};
    program.moves[1].curve_part = 0;
    const auto words = translate(program, machine, {}, OrientationLaw::rotary, 0.01);
    ASSERT_FALSE(words);
    EXPECT_EQ(words.error().code, "PIPE0014");
}

TEST(Convert, writes_whole_files_or_none) {
    const auto machine = trunnion_table();
    Program program = read(turning, machine);
    const auto folder = std::filesystem::temp_directory_path() / "trunnion_convert_test";
    std::filesystem::create_directories(folder);
    const auto file = folder / "out.cls", source = folder / "in.cls";
    std::ofstream(source) << turning;
    program.source = source.string();
    nc::WriteOptions options;
    options.dialect = nc::Dialect::apt;
    ASSERT_TRUE(write_program_file(file, program, &machine, options));
    EXPECT_TRUE(std::filesystem::exists(file));
    std::filesystem::remove(file);
    const auto over = write_program_file(source, program, &machine, options);
    ASSERT_FALSE(over);
    EXPECT_EQ(over.error().code, "PIPE0011");
    options.dialect = nc::Dialect::rs274;
    const auto refused = write_program_file(file, program, &machine, options);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, "NC0902");
    EXPECT_FALSE(std::filesystem::exists(file));
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 1) << "nothing else is left";
    std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace trunnion::pipeline
