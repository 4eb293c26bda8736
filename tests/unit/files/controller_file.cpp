#include "trunnion/files/controller_file.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <regex>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace {

using namespace trunnion;
using motion::ParameterId;
using motion::Source;

const std::filesystem::path folder = TRUNNION_SOURCE_DIR "/data/controllers";

const std::string good = R"(
name = "some control"
description = "for tests"
kind = "blocks"
[parameters]
profile = { value = "jerk-limited", source = "documented" }
transition = { value = "velocity step", source = "guessed" }
axis_set_change = { value = "stop", source = "identified" }
branch = { value = "nearest", source = "guessed" }
feed_counts = { value = "tip and rotary", source = "documented" }
interpolator_cycle = { value = "3 ms", source = "documented" }
block_preparation = { value = "1 ms", source = "guessed", spread = "0.9 ms" }
block_buffer = { value = 20, source = "identified" }
look_ahead_blocks = { value = 40, source = "documented" }
look_ahead_distance = { value = "unlimited", source = "guessed" }
reference_radius = { value = "57.3 mm", source = "documented" }
centripetal_share = { value = "50%", source = "guessed" }
velocity_step = { value = "100 mm/min", source = "guessed" }
rotary_velocity_step = { value = "2 deg/s", source = "guessed" }
curvature_jump_share = { value = 0.5, source = "guessed" }
velocity_share = { value = 1, source = "identified" }
acceleration_share = { value = 1, source = "identified" }
jerk_share = { value = 1, source = "identified" }
rapid_share = { value = 1, source = "identified" }
setpoint_filter = { value = "5 ms", source = "identified" }
in_position_time = { value = "10 ms", source = "guessed" }
tool_change_time = { value = "6 s", source = "guessed" }
spindle_time = { value = "2 s", source = "guessed" }
other_stop_time = { value = "0.1 s", source = "guessed" }
)";

/// The code that the good file is refused with when one thing in it is another.
std::string code_with(const std::string& what, const std::string& instead) {
    std::string text = good;
    const auto at = text.find(what);
    EXPECT_NE(at, std::string::npos) << what;
    text.replace(at, what.size(), instead);
    const auto read = files::read_controller(text, "c.toml");
    return read ? "" : read.error().code;
}

TEST(ControllerFile, TakesEverythingThatTheFormatHas) {
    const auto read = files::read_controller(good, "c.toml");
    ASSERT_TRUE(read) << to_string(read.error());
    EXPECT_EQ(read->name, "some control");
    EXPECT_EQ(read->file, "c.toml");
    EXPECT_EQ(read->transition.way, motion::Transition::velocity_step);
    EXPECT_EQ(read->transition.source, Source::guessed);
    EXPECT_EQ(read->axis_set_change.way, motion::AxisSetChange::stop);
    EXPECT_EQ(read->branch.way, motion::BranchRule::nearest);
    EXPECT_EQ(read->feed_counts.way, motion::FeedCounts::tip_and_rotary);
    const auto& control = *read;
    EXPECT_DOUBLE_EQ(control[ParameterId::interpolator_cycle].value, 3e-3);
    EXPECT_DOUBLE_EQ(control[ParameterId::interpolator_cycle].spread, 3e-4);
    EXPECT_DOUBLE_EQ(control[ParameterId::block_preparation].spread, 9e-4);
    EXPECT_EQ(control[ParameterId::block_buffer].value, 20);
    EXPECT_EQ(control[ParameterId::block_buffer].spread, 0);
    EXPECT_TRUE(std::isinf(control[ParameterId::look_ahead_distance].value));
    EXPECT_EQ(control[ParameterId::look_ahead_distance].spread, 0);
    EXPECT_DOUBLE_EQ(control[ParameterId::centripetal_share].value, 0.5);
    EXPECT_DOUBLE_EQ(control[ParameterId::centripetal_share].spread, 0.15);
    EXPECT_DOUBLE_EQ(control[ParameterId::velocity_step].value, 100.0 / 60);
    EXPECT_FALSE(control[ParameterId::rounding_tolerance].given);
}

TEST(ControllerFile, EveryParameterIsNeeded) {
    const std::regex line("\n([a-z_]+) = \\{[^\n]*");
    int lines = 0;
    for (std::sregex_iterator at(good.begin(), good.end(), line), end; at != end; ++at, ++lines)
        EXPECT_EQ(code_with(at->str(), ""), "FILE0103") << (*at)[1];
    EXPECT_EQ(lines, 24);
}

TEST(ControllerFile, RefusesWhatHasNoMeaning) {
    EXPECT_EQ(code_with("kind = \"blocks\"", ""), "FILE0103");
    EXPECT_EQ(code_with("\"blocks\"", "\"magic\""), "FILE0113");
    EXPECT_EQ(code_with("\"velocity step\"", "\"jump\""), "FILE0113");
    EXPECT_EQ(code_with("source = \"documented\"", "source = \"rumoured\""), "FILE0113");
    EXPECT_EQ(code_with(", source = \"documented\"", ""), "FILE0103");
    EXPECT_EQ(code_with("description", "descripton"), "FILE0104");
    EXPECT_EQ(code_with("block_buffer", "blok_buffer"), "FILE0104");
    EXPECT_EQ(code_with("spread =", "spred ="), "FILE0104");
    EXPECT_EQ(code_with("{ value = 20, source = \"identified\" }", "20"), "FILE0105");
    EXPECT_EQ(code_with("value = 20", "value = nan"), "FILE0105");
    EXPECT_EQ(code_with("value = 40", "value = inf"), "FILE0105");
    EXPECT_EQ(code_with("\"3 ms\"", "3"), "BASE0002");
    EXPECT_EQ(code_with("\"3 ms\"", "\"3\""), "BASE0002");
    EXPECT_EQ(code_with("\"3 ms\"", "\"3 parsec\""), "BASE0003");
    EXPECT_EQ(code_with("\"3 ms\"", "\"3 mm\""), "BASE0004");
    EXPECT_EQ(code_with("\"3 ms\"", "\"-3 ms\""), "FILE0117");
    EXPECT_EQ(code_with("\"3 ms\"", "\"unlimited\""), "BASE0001");
    EXPECT_EQ(code_with("value = 20", "value = 0"), "FILE0117");
    EXPECT_EQ(code_with("value = 20", "value = 20.5"), "FILE0117");
    EXPECT_EQ(code_with("\"50%\"", "\"150%\""), "FILE0117");
    EXPECT_EQ(code_with("\"0.9 ms\"", "\"-0.9 ms\""), "FILE0116");
    EXPECT_EQ(code_with("value = \"unlimited\"", "value = \"unlimited\", spread = \"1 mm\""), "FILE0116");
    EXPECT_EQ(code_with("[parameters]", "[parameters"), "FILE0102");
}

TEST(ControllerFile, RefusesContradictions) {
    // Steps and arcs at once; steps alone where arcs are chosen; jerk of a trapezoid.
    EXPECT_EQ(code_with("velocity_share",
                        "rounding_tolerance = { value = \"0.01 mm\", source = \"guessed\" }\nvelocity_share"),
              "FILE0116");
    EXPECT_EQ(code_with("\"velocity step\"", "\"exact stop\""), "FILE0116");
    EXPECT_EQ(code_with("\"velocity step\"", "\"arc\""), "FILE0103");
    EXPECT_EQ(code_with("\"jerk-limited\"", "\"trapezoidal\""), "FILE0116");
    EXPECT_EQ(code_with("\"blocks\"", "\"ideal\""), "FILE0116");
}

TEST(ControllerFile, ErrorsNameTheLine) {
    std::string text = good;
    text.replace(text.find("\"3 ms\""), 6, "\"3 mm\"");
    const auto read = files::read_controller(text, "c.toml");
    ASSERT_FALSE(read);
    EXPECT_EQ(read.error().place.file, "c.toml");
    EXPECT_EQ(read.error().place.line, 11);
}

TEST(ShippedControllers, AreAllGoodAndFoundByNameOrFile) {
    const std::vector<std::filesystem::path> folders{folder};
    const auto shipped = files::shipped_controllers(folders);
    std::vector<std::string> names;
    for (const auto& controller : shipped) {
        names.push_back(controller.name);
        EXPECT_FALSE(controller.title.empty());
        const auto read = files::read_controller_file(controller.file);
        ASSERT_TRUE(read) << to_string(read.error());
        EXPECT_EQ(files::find_controller(controller.name, folders)->name, read->name);
        EXPECT_EQ(files::find_controller(controller.file.string(), folders)->name, read->name);
    }
    for (const char* wanted : {"ideal", "lavernhe-2006", "length-over-feed", "linuxcnc-2.9"})
        EXPECT_NE(std::ranges::find(names, wanted), names.end()) << wanted;
    const auto unknown = files::find_controller("nosuch", folders);
    ASSERT_FALSE(unknown);
    EXPECT_EQ(unknown.error().code, "FILE0118");
    EXPECT_NE(unknown.error().hint.find("lavernhe-2006"), std::string::npos);
}

TEST(ControllerFile, OfTheExampleIsGood) {
    const auto read = files::read_controller_file(TRUNNION_SOURCE_DIR "/examples/04_prediction/old_control.toml");
    ASSERT_TRUE(read) << to_string(read.error());
    EXPECT_EQ(read->transition.way, motion::Transition::velocity_step);
}

}  // namespace
