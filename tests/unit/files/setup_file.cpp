#include "trunnion/files/setup_file.hpp"

#include <filesystem>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

namespace {

using namespace trunnion;
using Eigen::Vector3d;

std::string code_of(const std::string& text) {
    const auto read = files::read_setup(text, "s.toml");
    return read ? "" : read.error().code;
}

TEST(SetupFile, TakesEverythingThatTheFormatHas) {
    const auto read = files::read_setup(R"(
[workpiece]
origin = ["1 mm", "2 mm", "2 in"]
rotation = { axis = [0, 0, 2], angle = "90 deg" }
[tool]
kind = "torus"
diameter = "10 mm"
corner_radius = "1 mm"
length = "0.1 m"
controlled_point = "centre"
[tools.8]
kind = "ball"
diameter = "6 mm"
[tools.SCHAFT_D12]
diameter = "12 mm"
length = "80 mm"
[offsets.G54]
origin = ["5 mm", "0 mm", "0 mm"]
[offsets."G54.1 P3"]
rotation = { axis = [1, 0, 0], angle = "-0.5 rad" }
[start]
X = "10 mm"
A = "-90 deg"
U = "1 mm"
V = "180 deg"
[home]
Z = "300 mm"
)",
                                        "s.toml");
    ASSERT_TRUE(read) << to_string(read.error());
    EXPECT_EQ(read->file, "s.toml");
    EXPECT_EQ(read->workpiece.origin_mm, Vector3d(1, 2, 50.8));
    EXPECT_LT((read->workpiece.rotation * Vector3d::UnitX() - Vector3d::UnitY()).norm(), 1e-15);
    EXPECT_EQ(read->tool.kind, machine::ToolKind::torus);
    EXPECT_EQ(read->tool.diameter_mm, 10);
    EXPECT_EQ(read->tool.length_mm, 100);
    EXPECT_EQ(read->tool.controlled_height_mm(), 1);
    EXPECT_EQ(read->tools.at("8").corner_radius_mm, 3);
    EXPECT_EQ(read->tools.at("8").controlled_height_mm(), 0);
    EXPECT_EQ(read->tools.at("SCHAFT_D12").kind, machine::ToolKind::flat);
    EXPECT_EQ(read->offsets.at("G54").origin_mm, Vector3d(5, 0, 0));
    EXPECT_NEAR(read->offsets.at("G54.1 P3").rotation(2, 1), -std::sin(0.5), 1e-15);
    EXPECT_EQ(read->start.at('X'), 10);
    EXPECT_DOUBLE_EQ(read->start.at('A'), -std::numbers::pi / 2);
    EXPECT_EQ(read->start.at('U'), 1);
    EXPECT_DOUBLE_EQ(read->start.at('V'), std::numbers::pi);
    EXPECT_EQ(read->home.at('Z'), 300);
}

TEST(SetupFile, NeedsNothing) {
    const auto read = files::read_setup("", "s.toml");
    ASSERT_TRUE(read);
    EXPECT_EQ(read->workpiece.origin_mm, Vector3d::Zero());
    EXPECT_EQ(read->tool.length_mm, 0);
}

TEST(SetupFile, RefusesWhatItDoesNotKnow) {
    EXPECT_EQ(code_of("[workpeice]\n"), "FILE0104");
    EXPECT_EQ(code_of("[workpiece]\nzero = 1\n"), "FILE0104");
    EXPECT_EQ(code_of("[workpiece]\nrotation = { axis = [0, 0, 1], angel = \"1 deg\" }\n"), "FILE0104");
    EXPECT_EQ(code_of("[tool]\nlenght = \"1 mm\"\n"), "FILE0104");
    EXPECT_EQ(code_of("[tools.3]\nlenght = \"1 mm\"\n"), "FILE0104");
    EXPECT_EQ(code_of("[offsets.G54]\nX = \"1 mm\"\n"), "FILE0104");
    EXPECT_EQ(code_of("[start]\nx = \"1 mm\"\n"), "FILE0104");
}

TEST(SetupFile, RefusesWrongValues) {
    EXPECT_EQ(code_of("[workpiece]\norigin = [0, 0, 50]\n"), "BASE0002");
    EXPECT_EQ(code_of("[workpiece]\norigin = [\"0 mm\", \"0 mm\"]\n"), "FILE0105");
    EXPECT_EQ(code_of("[workpiece]\nrotation = { axis = [0, 0, 0], angle = \"1 deg\" }\n"), "FILE0109");
    EXPECT_EQ(code_of("[workpiece]\nrotation = { axis = [0, 0, 1] }\n"), "FILE0103");
    EXPECT_EQ(code_of("[workpiece]\nrotation = { axis = [0, 0, 1], angle = \"1 mm\" }\n"), "BASE0004");
    EXPECT_EQ(code_of("workpiece = 3\n"), "FILE0105");
    EXPECT_EQ(code_of("[start]\nX = \"1 deg\"\n"), "BASE0004");
    EXPECT_EQ(code_of("[start]\nC = \"1 mm\"\n"), "BASE0004");
    EXPECT_EQ(code_of("[start]\nU = 5\n"), "BASE0002");
    EXPECT_EQ(code_of("[start\n"), "FILE0102");
}

TEST(SetupFile, RefusesToolsThatContradictThemselves) {
    EXPECT_EQ(code_of("[tool]\nkind = \"drill\"\n"), "FILE0113");
    EXPECT_EQ(code_of("[tool]\ncontrolled_point = \"center\"\n"), "FILE0113");
    EXPECT_EQ(code_of("[tool]\nlength = \"-1 mm\"\n"), "FILE0114");
    EXPECT_EQ(code_of("[tool]\nkind = \"ball\"\n"), "FILE0114");
    EXPECT_EQ(code_of("[tool]\nkind = \"ball\"\ndiameter = \"6 mm\"\ncorner_radius = \"2 mm\"\n"), "FILE0114");
    EXPECT_EQ(code_of("[tool]\nkind = \"torus\"\ndiameter = \"6 mm\"\n"), "FILE0114");
    EXPECT_EQ(code_of("[tool]\nkind = \"torus\"\ndiameter = \"6 mm\"\ncorner_radius = \"4 mm\"\n"), "FILE0114");
    EXPECT_EQ(code_of("[tool]\ndiameter = \"6 mm\"\ncorner_radius = \"1 mm\"\n"), "FILE0114");
    EXPECT_EQ(code_of("[tool]\ndiameter = \"6 mm\"\ncontrolled_point = \"centre\"\n"), "FILE0114");
    EXPECT_EQ(
        code_of(
            "[tool]\nkind = \"torus\"\ndiameter = \"6 mm\"\ncorner_radius = \"3 mm\"\ncontrolled_point = \"centre\"\n"),
        "");
}

TEST(SetupFile, ToolsAndOffsetsByTheNamesThatProgramsCall) {
    const auto read = files::read_setup(R"(
[tools.8]
length = "80 mm"
[tools."8 D2"]
length = "75 mm"
[tools."SCHAFT 12"]
length = "60 mm"
[tools.0]
length = "0 mm"
[offsets.G54]
origin = ["1 mm", "2 mm", "3 mm"]
rotation = { axis = [0, 0, 1], angle = "30 deg" }
[offsets."G59.1"]
origin = ["4 mm", "0 mm", "0 mm"]
)",
                                        "s.toml");
    ASSERT_TRUE(read) << to_string(read.error());
    EXPECT_EQ(read->tool_named("8")->length_mm, 80);
    EXPECT_EQ(read->tool_named("8 D2")->length_mm, 75);
    EXPECT_EQ(read->tool_named("8 D0")->length_mm, 0);
    EXPECT_EQ(read->tool_named("SCHAFT 12")->length_mm, 60);
    EXPECT_EQ(read->tool_named("8 D3"), nullptr);
    EXPECT_NEAR(read->offsets.at("G54").rotation(1, 0), 0.5, 1e-15);
    EXPECT_EQ(read->offsets.at("G54").origin_mm, Vector3d(1, 2, 3));
    EXPECT_EQ(read->offsets.at("G59.1").origin_mm.x(), 4);
}

TEST(SetupFile, RefusesToolNamesThatNoProgramCalls) {
    for (const char* name : {"08", "\"8 D1\"", "\"8 D0\"", "\" 8\"", "\"8 \"", "\"\""})
        EXPECT_EQ(code_of(std::string("[tools.").append(name) + "]\nlength = \"1 mm\"\n"), "FILE0115") << name;
    EXPECT_EQ(code_of("[tools.\"8 D2\"]\nlenght = \"1 mm\"\n"), "FILE0104");
    EXPECT_EQ(code_of("[tools.8]\nlength = \"1 mm\"\n[tools.8]\n"), "FILE0102");
    EXPECT_EQ(code_of("[tools]\n8 = 3\n"), "FILE0105");
    EXPECT_EQ(code_of("[offsets.G54]\nrotation = \"30 deg\"\n"), "FILE0105");
    EXPECT_EQ(code_of("[offsets.G54]\norigin = [\"1 deg\", \"0 mm\", \"0 mm\"]\n"), "BASE0004");
}

TEST(SetupFile, TakesTheSetupOfTheNamedCases) {
    const auto path = std::filesystem::path(TRUNNION_SHARED_DIR) / "data/cases/peer-setup.toml";
    if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not here";
    const auto read = files::read_setup_file(path);
    ASSERT_TRUE(read) << to_string(read.error());
    EXPECT_EQ(read->workpiece.origin_mm, Vector3d(0, 0, 50));
    EXPECT_EQ(files::read_setup_file("/nowhere.toml").error().code, "FILE0101");
}

}  // namespace
