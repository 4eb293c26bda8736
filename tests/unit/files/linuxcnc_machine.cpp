#include "trunnion/files/linuxcnc_machine.hpp"

#include <cmath>
#include <filesystem>
#include <map>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "trunnion/files/machine_file.hpp"

namespace trunnion::files {
namespace {

using machine::Axis;
using machine::AxisLimits;
using machine::Machine;

constexpr double deg = std::numbers::pi / 180;
const LinuxcncJerk jerks{.linear_mm_s3 = 50'000, .rotary_rad_s3 = 30};

/// A machine that the kinematics of tables can have, with limits that are no round numbers.
Machine table(const char* tilt, const std::string& more = {}) {
    const std::string text = std::string(R"(name = "Table, no. 7"
chain = "C )") + tilt + R"( X Y Z"
[axes.X]
range = ["-355 mm", "1.1 m"]
max_velocity = "31 m/min"
max_acceleration = "2.53 m/s^2"
max_jerk = "57 m/s^3"
rapid = { max_velocity = "47 m/min", max_jerk = "91 m/s^3" }
[axes.Y]
range = ["10 mm", "10 in"]
max_velocity = "30 m/min"
max_acceleration = "3 m/s^2"
max_jerk = "5 m/s^3"
[axes.Z]
range = "endless"
max_velocity = "30 m/min"
max_acceleration = "2.1 m/s^2"
max_jerk = "50 m/s^3"
[axes.)" + tilt + R"(]
range = ["-30.3 deg", "2 rad"]
max_velocity = "17 rpm"
max_acceleration = "0.83 rev/s^2"
max_jerk = "1800 deg/s^3"
point = ["4 mm", "2.5 mm", "-3.25 mm"]
reversed = true
[axes.C]
range = "endless"
max_velocity = "20 rpm"
max_acceleration = "10 rad/s^2"
max_jerk = "50 rad/s^3"
point = ["4 mm", "2.5 mm", "16.5 mm"]
reversed = true
)" + more;
    const auto out = read_machine(text, "table.toml");
    EXPECT_TRUE(out) << to_string(out.error());
    return *out;
}

/// Reads a configuration that was made here.
Result<LinuxcncMachine> read_back(const LinuxcncConfiguration& made, const LinuxcncJerk& jerk = {}) {
    return read_linuxcnc_machine(made.ini, "m.ini", jerk,
                                 [&](const std::string&) { return Result<std::string>(made.hal); });
}

/// Equal, or as far apart as `share` of the value: an INI in degrees does not have every value.
void expect_same(double a, double b, double share) {
    if (a != b) {
        EXPECT_LE(std::abs(a - b), share * std::abs(a));
    }
}

void expect_same(const AxisLimits& a, const AxisLimits& b, double share) {
    expect_same(a.velocity, b.velocity, share);
    expect_same(a.acceleration, b.acceleration, share);
    expect_same(a.jerk, b.jerk, share);
}

constexpr double to_the_last_bit = 0, in_degrees = 1e-15;

void expect_same(const Machine& a, const Machine& b, double share) {
    EXPECT_EQ(a.name, b.name);
    ASSERT_EQ(a.axis_count, b.axis_count);
    EXPECT_EQ(a.rotary_count, b.rotary_count);
    EXPECT_EQ(a.chain, b.chain);
    EXPECT_EQ(a.words.tcp_on, b.words.tcp_on);
    EXPECT_EQ(a.words.following, b.words.following);
    for (std::size_t i = 0; i < static_cast<std::size_t>(a.axis_count); ++i) {
        const Axis &left = a.axes[i], &right = b.axes[i];
        EXPECT_EQ(left.letter, right.letter);
        EXPECT_EQ(left.reversed, right.reversed);
        EXPECT_EQ(left.direction, right.direction);
        EXPECT_LT((left.point_mm - right.point_mm).norm(), 1e-12);
        expect_same(left.range_min, right.range_min, share);
        expect_same(left.range_max, right.range_max, share);
        expect_same(left.feed, right.feed, share);
        expect_same(left.rapid, right.rapid, share);
    }
}

TEST(MachineText, gives_the_same_machine_to_the_last_bit) {
    for (const auto& entry : std::filesystem::directory_iterator(TRUNNION_SOURCE_DIR "/data/machines")) {
        const auto machine = read_machine_file(entry.path());
        ASSERT_TRUE(machine) << entry.path();
        const auto again = read_machine(machine_text(*machine), "again");
        ASSERT_TRUE(again) << to_string(again.error()) << machine_text(*machine);
        expect_same(*machine, *again, to_the_last_bit);
    }
}

TEST(MachineText, keeps_rapids_words_and_names_with_quotes) {
    Machine machine = table("A", "[words]\ntcp_on = [\"M1 \\\"x\\\"\"]\nfollowing = [\"E\"]\n");
    machine.name = "a \"b\" 'c' \\ d";
    const auto again = read_machine(machine_text(machine), "again");
    ASSERT_TRUE(again) << to_string(again.error());
    expect_same(machine, *again, to_the_last_bit);
}

TEST(LinuxcncMachine, comes_back_from_its_own_configuration) {
    for (const char* tilt : {"A", "B"}) {
        const Machine machine = table(tilt, "[words]\ntcp_on = [\"M428\"]\nfollowing = [\"E\", \"Q\"]\n");
        const auto made = linuxcnc_configuration(machine, "table");
        ASSERT_TRUE(made) << to_string(made.error());
        const auto read = read_back(*made);
        ASSERT_TRUE(read) << to_string(read.error());
        expect_same(machine, read->machine, in_degrees);
    }
}

TEST(LinuxcncMachine, shipped_machines_come_back) {
    int there = 0;
    for (const auto& entry : std::filesystem::directory_iterator(TRUNNION_SOURCE_DIR "/data/machines")) {
        const auto machine = read_machine_file(entry.path());
        const auto made = linuxcnc_configuration(*machine, "m");
        if (!made) {
            EXPECT_EQ(made.error().code, "FILE0123") << entry.path();
            continue;
        }
        const auto read = read_back(*made);
        ASSERT_TRUE(read) << to_string(read.error());
        if (machine->axis_count == 5 || machine->rotary_count == 0) expect_same(*machine, read->machine, in_degrees);
        ++there;
    }
    EXPECT_GE(there, 4);
}

TEST(LinuxcncMachine, given_jerk_takes_the_place_of_the_files) {
    const auto read = read_back(*linuxcnc_configuration(table("A"), "m"), jerks);
    ASSERT_TRUE(read);
    EXPECT_EQ(read->machine.axes[0].feed.jerk, 50'000);
    EXPECT_EQ(read->machine.axes[4].feed.jerk, 30);
}

TEST(LinuxcncConfiguration, says_what_the_machine_is) {
    const auto made = linuxcnc_configuration(table("A"), "table", {.servo_period_s = 0.0005});
    ASSERT_TRUE(made);
    for (const char* line :
         {"KINEMATICS = xyzac-trt-kins coordinates=XYZAC\n", "SERVO_PERIOD = 500000\n", "TOOL_TABLE = table.tbl\n",
          "MAX_VELOCITY = 120\n", "RAPID_X = 783.33333333333", "HOME = 10\n"})
        EXPECT_NE(made->ini.find(line), std::string::npos) << line << made->ini;
    for (const char* line : {"setp xyzac-trt-kins.y-offset 0\n", "setp xyzac-trt-kins.z-offset -19.75\n",
                             "setp xyzac-trt-kins.z-rot-point 16.5\n", "servo_period_nsec=500000 num_joints=5\n"})
        EXPECT_NE(made->hal.find(line), std::string::npos) << line << made->hal;
    const auto endless = made->ini.substr(made->ini.find("[JOINT_4]"));
    EXPECT_EQ(endless.find("MIN_LIMIT"), std::string::npos);
    EXPECT_EQ(made->hal.find("streamer"), std::string::npos);
}

TEST(LinuxcncConfiguration, for_playing_every_joint_has_its_stream) {
    const auto made = linuxcnc_configuration(table("B"), "table", {.play = true});
    ASSERT_TRUE(made);
    for (const char* line :
         {"loadrt streamer depth=1024 cfg=fffff\n", "net trunnion-row-4 streamer.0.pin.4 => trunnion-out-4.in1\n",
          "loadrt mux2 names=trunnion-out-0,trunnion-out-1,trunnion-out-2,trunnion-out-3,trunnion-out-4\n",
          "addf trunnion-feedback-4 servo-thread\naddf motion-command-handler servo-thread\n"})
        EXPECT_NE(made->hal.find(line), std::string::npos) << line << made->hal;
}

TEST(LinuxcncConfiguration, names_the_planner_that_serves) {
    const auto made = linuxcnc_configuration(table("B"), "table", {.served_machine = "/somewhere/table.toml"});
    ASSERT_TRUE(made);
    EXPECT_NE(made->ini.find("[TRAJ]\nTPMOD = trunnion_tp\n"), std::string::npos) << made->ini;
    EXPECT_NE(made->hal.find("\nloadusr trunnion serve --linuxcnc -m /somewhere/table.toml\n"), std::string::npos);
    EXPECT_EQ(linuxcnc_configuration(table("B"), "table")->ini.find("TPMOD"), std::string::npos);
}

TEST(LinuxcncConfiguration, refuses_what_the_kinematics_have_not) {
    const auto code = [](const Machine& machine, const char* stem = "m", const LinuxcncExport& options = {}) {
        const auto made = linuxcnc_configuration(machine, stem, options);
        return made ? "made" : made.error().code;
    };
    Machine one_way = table("A");
    one_way.axes[3].reversed = false;
    EXPECT_EQ(code(one_way), "FILE0123");
    Machine oblique = table("A");
    oblique.axes[3].direction = Eigen::Vector3d(1, 0, 1).normalized();
    EXPECT_EQ(code(oblique), "FILE0123");
    Machine mirrored = table("A");
    mirrored.axes[1].reversed = true;
    EXPECT_EQ(code(mirrored), "FILE0123");
    EXPECT_EQ(code(*read_machine_file(TRUNNION_SOURCE_DIR "/data/machines/head-head.toml")), "FILE0123");
    EXPECT_EQ(code(table("A"), "a b"), "FILE0122");
    EXPECT_EQ(code(table("A"), ""), "FILE0122");
    EXPECT_EQ(code(table("A"), "m", {.servo_period_s = 2}), "FILE0122");
    EXPECT_EQ(code(table("A"), "m", {.servo_period_s = std::nan("")}), "FILE0122");
}

TEST(LinuxcncConfiguration, names_cannot_break_out_of_their_line) {
    Machine machine = table("A");
    machine.name = "a\n[HAL]\nHALCMD = quit";
    const auto made = linuxcnc_configuration(machine, "m");
    ASSERT_TRUE(made);
    EXPECT_NE(made->ini.find("MACHINE = a [HAL] HALCMD = quit\n"), std::string::npos);
}

const std::string ini = R"([EMC]
MACHINE = a mill
[KINS]
KINEMATICS = xyzbc-trt-kins sparm=identityfirst
JOINTS = 5
[HAL]
HALFILE = LIB:basic_sim.tcl
HALFILE = lengths.hal
HALCMD = net :x-offset xyzbc-trt-kins.x-offset gui.x-offset
HALCMD = sets :x-offset -1.5
[LENGTHS]
Z = 0.25
[TRAJ]
COORDINATES = XYZBC
LINEAR_UNITS = inch
ANGULAR_UNITS = deg
[AXIS_X]
MIN_LIMIT = -10
MAX_LIMIT = 12
MAX_VELOCITY = 2
MAX_ACCELERATION = 20
[JOINT_0]
TYPE = LINEAR
MIN_LIMIT = -11
MAX_LIMIT = 11
MAX_VELOCITY = 3
MAX_ACCELERATION = 15
[AXIS_Y]
MAX_VELOCITY = 2
MAX_ACCELERATION = 20
[JOINT_1]
MAX_VELOCITY = 2
MAX_ACCELERATION = 20
[AXIS_Z]
MAX_VELOCITY = 2
MAX_ACCELERATION = 20
[JOINT_2]
MAX_VELOCITY = 2
MAX_ACCELERATION = 20
[AXIS_B]
MIN_LIMIT = -1e99
MAX_VELOCITY = 30
MAX_ACCELERATION = 100
[JOINT_3]
TYPE = ANGULAR
MAX_VELOCITY = 30
MAX_ACCELERATION = 100
[AXIS_C]
MAX_VELOCITY = 30
MAX_ACCELERATION = 100
[JOINT_4]
TYPE = ANGULAR
MAX_VELOCITY = 40
MAX_ACCELERATION = 90
)";
const std::string lengths_hal =
    "# lengths\nsetp xyzbc-trt-kins.z-offset [LENGTHS](Z)\n  setp xyzbc-trt-kins.x-rot-point 1 # here\n"
    "net :tool motion.tooloffset.z xyzbc-trt-kins.tool-offset\n";

Result<LinuxcncMachine> read(const std::string& text, const std::string& hal = lengths_hal,
                             const LinuxcncJerk& jerk = jerks) {
    return read_linuxcnc_machine(text, "mill.ini", jerk, [&](const std::string& name) -> Result<std::string> {
        if (name == "lengths.hal") return hal;
        return fail({.code = "FILE0101", .text = "there is no such file"});
    });
}

std::string with(std::string text, const std::string& from, const std::string& to) {
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
}

TEST(LinuxcncMachine, takes_the_smaller_limits_in_their_units) {
    const auto machine = read(ini);
    ASSERT_TRUE(machine) << to_string(machine.error());
    const Machine& m = machine->machine;
    EXPECT_EQ(m.name, "a mill");
    EXPECT_DOUBLE_EQ(m.axes[0].range_min, -10 * 25.4);
    EXPECT_DOUBLE_EQ(m.axes[0].range_max, 11 * 25.4);
    EXPECT_DOUBLE_EQ(m.axes[0].feed.velocity, 2 * 25.4);
    EXPECT_DOUBLE_EQ(m.axes[0].feed.acceleration, 15 * 25.4);
    EXPECT_DOUBLE_EQ(m.axes[4].feed.velocity, 30 * deg);
    EXPECT_DOUBLE_EQ(m.axes[4].feed.acceleration, 90 * deg);
    EXPECT_TRUE(std::isinf(m.axes[3].range_min) && std::isinf(m.axes[4].range_max));
    EXPECT_EQ(m.axes[3].letter, 'B');
    EXPECT_TRUE(m.axes[3].reversed && m.axes[4].reversed);
    EXPECT_LT((m.axes[4].point_mm - Eigen::Vector3d(25.4, 0, 0)).norm(), 1e-12);
    EXPECT_LT((m.axes[3].point_mm - Eigen::Vector3d(-0.5 * 25.4, 0, 0.25 * 25.4)).norm(), 1e-12);
}

TEST(LinuxcncMachine, counts_with_iso_where_the_pin_says_so) {
    const auto machine = read(ini, lengths_hal + "setp xyzbc-trt-kins.conventional-directions TRUE\n");
    ASSERT_TRUE(machine);
    EXPECT_FALSE(machine->machine.axes[3].reversed || machine->machine.axes[4].reversed);
}

TEST(LinuxcncMachine, a_gantry_has_the_limits_of_both_joints) {
    std::string text = R"([KINS]
KINEMATICS = trivkins coordinates=xyyz
[TRAJ]
LINEAR_UNITS = mm
ANGULAR_UNITS = deg
)";
    const auto section = [&](const char* name, int velocity) {
        text += "[" + std::string(name) + "]\nMAX_VELOCITY = " + std::to_string(velocity) + "\nMAX_ACCELERATION = 9\n";
    };
    section("AXIS_X", 50), section("AXIS_Y", 50), section("AXIS_Z", 50);
    section("JOINT_0", 40), section("JOINT_1", 30), section("JOINT_2", 20), section("JOINT_3", 10);
    const auto machine = read(text);
    ASSERT_TRUE(machine) << to_string(machine.error());
    EXPECT_EQ(machine->machine.axes[0].feed.velocity, 40);
    EXPECT_EQ(machine->machine.axes[1].feed.velocity, 20);
    EXPECT_EQ(machine->machine.axes[2].feed.velocity, 10);
    EXPECT_EQ(machine->machine.rotary_count, 0);
}

TEST(LinuxcncMachine, refuses_with_code_and_line) {
    struct Case {
        std::string text, code;
        int line;
    };
    const Case cases[] = {
        {with(ini, "JOINTS = 5", "JOINTS 5"), "FILE0120", 5},
        {with(ini, "[EMC]\n", ""), "FILE0120", 1},
        {with(ini, "[HAL]", "[HAL"), "FILE0120", 6},
        {with(ini, "JOINTS = 5", "#INCLUDE more.inc"), "FILE0120", 5},
        {with(ini, "LINEAR_UNITS = inch\n", ""), "FILE0121", 0},
        {with(ini, "[JOINT_3]", "[JOINT_9]"), "FILE0121", 0},
        {with(ini, "LINEAR_UNITS = inch", "LINEAR_UNITS = furlong"), "FILE0122", 15},
        {with(ini, "MAX_LIMIT = 12", "MAX_LIMIT = 12 # in"), "FILE0122", 19},
        {with(ini, "MAX_LIMIT = 12", "MAX_LIMIT = inf"), "FILE0122", 19},
        {with(ini, "xyzbc-trt-kins sparm", "genserkins sparm"), "FILE0123", 4},
        {with(ini, "sparm=identityfirst", "coordinates=XYZAC"), "FILE0123", 4},
        {with(ini, "KINEMATICS = xyzbc-trt-kins sparm=identityfirst", "KINEMATICS = trivkins"), "FILE0123", 4},
        {with(ini, "MAX_VELOCITY = 3\n", "MAX_VELOCITY = 0\n"), "FILE0106", 26},
        {with(ini, "MAX_LIMIT = 12", "MAX_LIMIT = -12"), "FILE0108", 19},
        {with(ini, "MIN_LIMIT = -1e99", "MIN_LIMIT = -90"), "FILE0126", 41},
        {with(ini, "TYPE = LINEAR", "TYPE = ANGULAR"), "FILE0126", 23},
        {with(ini, "MIN_LIMIT = -1e99", "WRAPPED_ROTARY = 1"), "FILE0126", 41},
        {with(ini, "a mill", "a \xff mill"), "FILE0126", 0},
        {with(ini, "lengths.hal", "lengths.tcl"), "FILE0125", 8},
        {with(ini, "lengths.hal", "missing.hal"), "FILE0125", 8},
        {with(ini, "HALCMD = sets :x-offset -1.5\n", ""), "FILE0125", 9},
        {with(ini, "Z = 0.25", "Y = 0.25"), "FILE0125", 8},
    };
    for (const Case& one : cases) {
        const auto machine = read(one.text);
        ASSERT_FALSE(machine) << one.code << one.text;
        EXPECT_EQ(machine.error().code, one.code) << to_string(machine.error());
        EXPECT_EQ(machine.error().place.line, one.line) << to_string(machine.error());
        EXPECT_EQ(machine.error().place.file, "mill.ini");
    }
}

TEST(LinuxcncMachine, never_guesses_a_jerk) {
    EXPECT_EQ(read(ini, lengths_hal, {}).error().code, "FILE0124");
    EXPECT_EQ(read(ini, lengths_hal, {.linear_mm_s3 = 1}).error().code, "FILE0124");
    EXPECT_EQ(read(ini + "[TRUNNION]\nJERK_X = -1\n", lengths_hal, {}).error().code, "FILE0106");
    EXPECT_EQ(read(ini + "[TRUNNION]\nRAPID_X = 1 2\n").error().code, "FILE0122");
}

TEST(LinuxcncMachine, a_value_that_only_the_running_control_knows_is_refused) {
    EXPECT_EQ(read(ini, lengths_hal + "net :probe probe.out xyzbc-trt-kins.y-rot-point\n").error().code, "FILE0125");
    EXPECT_EQ(read(ini, lengths_hal + "setp xyzbc-trt-kins.y-rot-point nearly\n").error().code, "FILE0125");
    EXPECT_EQ(read(ini, "source other.hal\n").error().code, "FILE0125");
}

TEST(LinuxcncMachine, reads_the_samples_of_the_package) {
    const std::filesystem::path samples =
        "/usr/share/doc/linuxcnc/examples/sample-configs/sim/axis/vismach/5axis/table-rotary-tilting";
    if (!std::filesystem::exists(samples)) GTEST_SKIP() << "LinuxCNC is not installed";
    const auto ac = read_linuxcnc_machine_file(samples / "xyzac-trt.ini", jerks);
    ASSERT_TRUE(ac) << to_string(ac.error());
    EXPECT_EQ(ac->machine.axes[3].point_mm, Eigen::Vector3d(0, 20, 10));
    const auto bc = read_linuxcnc_machine_file(samples / "xyzbc-trt.ini", jerks);
    ASSERT_TRUE(bc) << to_string(bc.error());
    EXPECT_EQ(bc->machine.axes[3].point_mm, Eigen::Vector3d(-20, 0, -15));
    EXPECT_DOUBLE_EQ(bc->machine.axes[4].range_max, 36000 * deg);
}

}  // namespace
}  // namespace trunnion::files
