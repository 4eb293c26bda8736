#include "trunnion/files/controller_file.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <regex>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"

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

const std::string good_linuxcnc = R"(
kind = "linuxcnc"
[parameters]
servo_period = { value = "0.5 ms", source = "identified" }
max_linear_velocity = { value = "unlimited", source = "documented" }
max_feed_override = { value = "120%", source = "identified" }
arc_blend_enable = { value = "on", source = "identified" }
arc_blend_fallback_enable = { value = "off", source = "documented" }
arc_blend_optimization_depth = { value = 100, source = "identified" }
arc_blend_gap_cycles = { value = 4, source = "documented" }
arc_blend_ramp_freq = { value = "20 Hz", source = "documented", spread = "5 Hz" }
arc_blend_kink_ratio = { value = 0.1, source = "documented" }
missed_command_periods = { value = 0, source = "guessed", spread = 0.1 }
dwell_excess = { value = "5 ms", source = "identified" }
spindle_time = { value = "2 s", source = "guessed" }
other_stop_time = { value = "4 ms", source = "guessed" }
coolant_time = { value = "0.1 s", source = "guessed" }
tool_change_time = { value = "6 s", source = "guessed" }
tool_preparation_time = { value = "1 s", source = "guessed" }
[axes.X]
max_velocity = { value = "30 m/min", source = "identified" }
[axes.C]
max_velocity = { value = "15 rpm", source = "documented" }
max_acceleration = { value = "300 deg/s^2", source = "guessed", spread = "50 deg/s^2" }
)";

/// The code that a good file is refused with when one thing in it is another.
std::string code_with(const std::string& what, const std::string& instead, std::string text = good) {
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

TEST(ControllerFile, TakesTheSettingsOfLinuxcnc) {
    const auto read = files::read_controller(good_linuxcnc, "c.toml");
    ASSERT_TRUE(read) << to_string(read.error());
    const auto& control = *read;
    EXPECT_EQ(control.kind, motion::ControllerKind::linuxcnc);
    EXPECT_DOUBLE_EQ(control[ParameterId::servo_period].value, 5e-4);
    EXPECT_DOUBLE_EQ(control[ParameterId::max_feed_override].value, 1.2);
    EXPECT_DOUBLE_EQ(control[ParameterId::arc_blend_ramp_freq].value, 20);
    EXPECT_DOUBLE_EQ(control[ParameterId::arc_blend_ramp_freq].spread, 5);
    EXPECT_EQ(control.arc_blend_enable.way, motion::Switch::on);
    EXPECT_EQ(control.arc_blend_fallback_enable.source, Source::documented);
    ASSERT_EQ(control.axis_limits.size(), 2u);
    EXPECT_DOUBLE_EQ(control.axis_limits.at('X')[0].value, 500);
    EXPECT_FALSE(control.axis_limits.at('X')[1].given);
    EXPECT_DOUBLE_EQ(control.axis_limits.at('C')[0].value, 90 * degree);
    EXPECT_DOUBLE_EQ(control.axis_limits.at('C')[1].spread, 50 * degree);
}

TEST(ControllerFile, EveryParameterOfLinuxcncIsNeeded) {
    const std::regex line("\n([a-z_]+) = \\{[^\n]*");
    const std::string parameters = good_linuxcnc.substr(0, good_linuxcnc.find("[axes.X]"));
    int lines = 0;
    for (std::sregex_iterator at(parameters.begin(), parameters.end(), line), end; at != end; ++at, ++lines)
        EXPECT_EQ(code_with(at->str(), "", good_linuxcnc), "FILE0103") << (*at)[1];
    EXPECT_EQ(lines, 16);
    EXPECT_TRUE(files::read_controller(parameters, "c.toml"));  // of axes nothing
}

TEST(ControllerFile, RefusesSettingsOfLinuxcncWithoutMeaning) {
    const auto code = [](const std::string& what, const std::string& instead) {
        return code_with(what, instead, good_linuxcnc);
    };
    EXPECT_EQ(code("\"20 Hz\"", "\"20\""), "BASE0002");
    EXPECT_EQ(code("\"20 Hz\"", "20"), "BASE0002");
    EXPECT_EQ(code("\"20 Hz\"", "\"20 s\""), "BASE0004");
    EXPECT_EQ(code("\"20 Hz\"", "\"Hz\""), "BASE0001");
    EXPECT_EQ(code("\"20 Hz\"", "\"0 Hz\""), "FILE0117");
    EXPECT_EQ(code("\"20 Hz\"", "[]"), "FILE0105");
    EXPECT_EQ(code("value = 0.1", "value = 0.8"), "FILE0117");
    EXPECT_EQ(code("value = 100", "value = 99.5"), "FILE0117");
    EXPECT_EQ(code("\"0.5 ms\"", "\"0 ms\""), "FILE0117");
    EXPECT_EQ(code("value = \"on\"", "value = \"yes\""), "FILE0113");
    EXPECT_EQ(code("value = \"on\"", "value = \"off\""), "FILE0116");  // gap cycles without arcs
    EXPECT_EQ(code("servo_period", "interpolator_cycle"), "FILE0104");
    EXPECT_EQ(code("[axes.X]", "look_ahead_blocks = { value = 10, source = \"guessed\" }\n[axes.X]"), "FILE0104");
    EXPECT_EQ(code("[axes.X]", "[axes.U]"), "FILE0104");
    EXPECT_EQ(code("[axes.X]", "[axes.XY]"), "FILE0104");
    EXPECT_EQ(code("[axes.X]\nmax_velocity", "[axes.X]\nmax_jerk"), "FILE0104");
    EXPECT_EQ(code("\"30 m/min\"", "\"30 rpm\""), "BASE0004");
    EXPECT_EQ(code("\"15 rpm\"", "\"15 m/min\""), "BASE0004");
    EXPECT_EQ(code("\"30 m/min\"", "\"0 m/min\""), "FILE0117");
    EXPECT_EQ(
        code_with("[parameters]", "[axes.X]\nmax_velocity = { value = \"1 m/s\", source = \"guessed\" }\n[parameters]"),
        "FILE0116");
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
