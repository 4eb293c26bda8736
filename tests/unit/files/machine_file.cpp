#include "trunnion/files/machine_file.hpp"

#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "trunnion/files/shipped_machines.hpp"
#include "trunnion/machine/kinematics.hpp"

namespace {

using namespace trunnion;

constexpr double deg = std::numbers::pi / 180;

const std::string good = R"(name = "A trunnion"
chain = "C A X Y Z"
[axes.X]
range = ["-355 mm", "355 mm"]
max_velocity = "30 m/min"
max_acceleration = "2.5 m/s^2"
max_jerk = "5 m/s^3"
rapid = { max_acceleration = "4 m/s^2" }
[axes.Y]
range = ["-1 m", "10 in"]
max_velocity = "30 m/min"
max_acceleration = "3 m/s^2"
max_jerk = "5 m/s^3"
[axes.Z]
range = "endless"
max_velocity = "30 m/min"
max_acceleration = "2.1 m/s^2"
max_jerk = "50 m/s^3"
reversed = true
[axes.A]
range = ["-30 deg", "120 deg"]
max_velocity = "15 rpm"
max_acceleration = "0.83 rev/s^2"
max_jerk = "1800 deg/s^3"
point = ["1 mm", "2 mm", "3 mm"]
[axes.C]
range = "endless"
max_velocity = "20 rpm"
max_acceleration = "10 rad/s^2"
max_jerk = "50 rad/s^3"
reversed = true
[words]
tcp_on = ["M428"]
tcp_off = ["M429", "M430"]
ignore = ["M64"]
following = ["E"]
)";

/// `good` with one thing changed.
std::string with(const std::string& old_text, const std::string& new_text) {
    std::string out = good;
    const auto at = out.find(old_text);
    EXPECT_NE(at, std::string::npos) << old_text;
    return out.replace(at, old_text.size(), new_text);
}

Diagnostic refusal_of(const std::string& text) {
    const auto read = files::read_machine(text, "m.toml");
    if (read) return {};
    EXPECT_EQ(read.error().place.file, "m.toml");
    return read.error();
}

TEST(MachineFile, TakesEverythingThatTheFormatHas) {
    const auto read = files::read_machine(good, "folder/m.toml");
    ASSERT_TRUE(read) << to_string(read.error());
    const auto& m = *read;
    EXPECT_EQ(m.name, "A trunnion");
    EXPECT_EQ(m.file, "folder/m.toml");
    ASSERT_EQ(m.axis_count, 5);
    EXPECT_EQ(m.rotary_count, 2);
    std::string letters, chain;
    for (int i = 0; i < 5; ++i) {
        letters += m.axes[i].letter;
        chain += m.axes[m.chain[i]].letter;
    }
    EXPECT_EQ(letters, "XYZAC");
    EXPECT_EQ(chain, "CAXYZ");
    EXPECT_DOUBLE_EQ(m.axes[0].feed.velocity, 500);
    EXPECT_DOUBLE_EQ(m.axes[0].feed.acceleration, 2500);
    EXPECT_DOUBLE_EQ(m.axes[0].feed.jerk, 5000);
    EXPECT_DOUBLE_EQ(m.axes[0].rapid.velocity, 500);
    EXPECT_DOUBLE_EQ(m.axes[0].rapid.acceleration, 4000);
    EXPECT_DOUBLE_EQ(m.axes[1].range_min, -1000);
    EXPECT_DOUBLE_EQ(m.axes[1].range_max, 254);
    EXPECT_TRUE(std::isinf(m.axes[2].range_min) && std::isinf(m.axes[2].range_max));
    EXPECT_TRUE(m.axes[2].reversed);
    EXPECT_FALSE(m.axes[3].reversed);
    EXPECT_DOUBLE_EQ(m.axes[3].range_max, 120 * deg);
    EXPECT_DOUBLE_EQ(m.axes[3].feed.velocity, 90 * deg);
    EXPECT_DOUBLE_EQ(m.axes[3].feed.jerk, 1800 * deg);
    EXPECT_EQ(m.axes[3].point_mm, Eigen::Vector3d(1, 2, 3));
    EXPECT_EQ(m.axes[4].point_mm, Eigen::Vector3d(0, 0, 0));
    EXPECT_EQ(m.axes[4].direction, Eigen::Vector3d::UnitZ());
    EXPECT_EQ(m.words.tcp_off, (std::vector<std::string>{"M429", "M430"}));
    EXPECT_EQ(m.words.following, std::vector<std::string>{"E"});
}

TEST(MachineFile, OtherLettersSayTheirKindAndDirection) {
    std::string text = good;
    for (std::size_t at; (at = text.find("[axes.A]")) != std::string::npos;)
        text.replace(at, 8, "[axes.V]\ntype = \"rotary\"\ndirection = [2, 0, 0]");
    text.replace(text.find("C A X"), 5, "C V X");
    const auto read = files::read_machine(text, "m.toml");
    ASSERT_TRUE(read) << to_string(read.error());
    EXPECT_EQ(read->axes[4].letter, 'V');
    EXPECT_EQ(read->axes[4].direction, Eigen::Vector3d::UnitX());
}

TEST(MachineFile, WithoutANameIsCalledAsTheFile) {
    const auto read = files::read_machine(with("name = \"A trunnion\"\n", ""), "folder/shed.toml");
    ASSERT_TRUE(read);
    EXPECT_EQ(read->name, "shed");
}

TEST(MachineFile, RefusesAMissingFile) {
    EXPECT_EQ(files::read_machine_file("/nowhere/m.toml").error().code, "FILE0101");
    EXPECT_EQ(files::read_machine_file("/").error().code, "FILE0101");
}

TEST(MachineFile, SaysWhereItIsNotToml) {
    const auto refusal = refusal_of(with("\"355 mm\"]", "\"355 mm\""));
    EXPECT_EQ(refusal.code, "FILE0102");
    EXPECT_EQ(refusal.place.line, 5);
    EXPECT_EQ(refusal_of(std::string("\x00\xff\x01", 3)).code, "FILE0102");
    EXPECT_EQ(refusal_of("chain = \"X Y Z\"\nchain = \"X Y Z\"").code, "FILE0102");
}

TEST(MachineFile, SaysWhichLimitIsMissing) {
    const auto refusal = refusal_of(with("max_jerk = \"1800 deg/s^3\"\n", ""));
    EXPECT_EQ(refusal.code, "FILE0103");
    EXPECT_NE(refusal.text.find("axis A has no max_jerk"), std::string::npos) << refusal.text;
    EXPECT_EQ(refusal.place.line, 20);
    EXPECT_EQ(refusal_of(with("range = [\"-355 mm\", \"355 mm\"]\n", "")).code, "FILE0103");
    EXPECT_EQ(refusal_of("").code, "FILE0103");
    EXPECT_EQ(refusal_of("chain = \"X Y Z\"").code, "FILE0103");
}

TEST(MachineFile, RefusesUnknownKeysWithTheirLine) {
    const auto refusal =
        refusal_of(with("max_velocity = \"15 rpm\"", "max_speed = \"15 rpm\"\nmax_velocity = \"15 rpm\""));
    EXPECT_EQ(refusal.code, "FILE0104");
    EXPECT_EQ(refusal.place.line, 22);
    EXPECT_NE(refusal.text.find("max_speed"), std::string::npos);
    EXPECT_EQ(refusal_of("nmae = \"x\"\n" + good).code, "FILE0104");
    EXPECT_EQ(refusal_of(with("rapid = { max_", "rapid = { min_")).code, "FILE0104");
    EXPECT_EQ(refusal_of(with("tcp_on", "tcpon")).code, "FILE0104");
    EXPECT_EQ(refusal_of(with("\nrapid", "\npoint = [\"0 mm\", \"0 mm\", \"0 mm\"]\nrapid")).code,
              "FILE0104");  // X has no point
}

TEST(MachineFile, RefusesValuesOfAnotherKind) {
    EXPECT_EQ(refusal_of(with("[\"M428\"]", "\"M428\"")).code, "FILE0105");
    EXPECT_EQ(refusal_of(with("reversed = true", "reversed = 1")).code, "FILE0105");
    EXPECT_EQ(refusal_of(with("[\"-355 mm\", \"355 mm\"]", "[\"355 mm\"]")).code, "FILE0105");
    EXPECT_EQ(refusal_of(with("\"30 m/min\"", "true")).code, "FILE0105");
    EXPECT_EQ(refusal_of(with("\"A trunnion\"", "5")).code, "FILE0105");
    EXPECT_EQ(refusal_of("axes = 3\nchain = \"X Y Z\"").code, "FILE0105");
}

TEST(MachineFile, RefusesQuantitiesWithTheirOwnCode) {
    EXPECT_EQ(refusal_of(with("\"30 m/min\"", "\"fast\"")).code, "BASE0001");
    EXPECT_EQ(refusal_of(with("\"30 m/min\"", "\"nan m/min\"")).code, "BASE0001");
    EXPECT_EQ(refusal_of(with("\"30 m/min\"", "\"1e999 m/min\"")).code, "BASE0001");
    EXPECT_EQ(refusal_of(with("\"30 m/min\"", "\"30\"")).code, "BASE0002");
    EXPECT_EQ(refusal_of(with("\"30 m/min\"", "30")).code, "BASE0002");
    EXPECT_EQ(refusal_of(with("\"30 m/min\"", "30.5")).code, "BASE0002");
    EXPECT_EQ(refusal_of(with("\"30 m/min\"", "\"30 furlong/min\"")).code, "BASE0003");
    const auto refusal = refusal_of(with("\"15 rpm\"", "\"15 mm/s\""));
    EXPECT_EQ(refusal.code, "BASE0004");
    EXPECT_EQ(refusal.place.line, 22);
    EXPECT_NE(refusal.text.find("max_velocity of axis A"), std::string::npos);
    EXPECT_FALSE(refusal.hint.empty());
}

TEST(MachineFile, RefusesLimitsThatAreNotPositive) {
    EXPECT_EQ(refusal_of(with("\"5 m/s^3\"", "\"-5 m/s^3\"")).code, "FILE0106");
    EXPECT_EQ(refusal_of(with("\"15 rpm\"", "\"0 rpm\"")).code, "FILE0106");
    EXPECT_EQ(refusal_of(with("\"4 m/s^2\"", "\"0 m/s^2\"")).code, "FILE0106");
}

TEST(MachineFile, RefusesChainsThatDoNotFitTheAxes) {
    for (const char* chain :
         {"C A X Y", "C A X Y Z B", "C A X Y Z Z", "CAXYZ", "c a x y z", "C,A,X,Y,Z", "", "C A X Y 1"})
        EXPECT_EQ(refusal_of(with("C A X Y Z", chain)).code, "FILE0107") << chain;
    EXPECT_EQ(refusal_of(with("C A X Y Z", "C A X Y")).place.line, 14);
}

TEST(MachineFile, RefusesRangesAndDirectionsThatAreNone) {
    EXPECT_EQ(refusal_of(with("[\"-30 deg\", \"120 deg\"]", "[\"120 deg\", \"-30 deg\"]")).code, "FILE0108");
    EXPECT_EQ(refusal_of(with("[\"-30 deg\", \"120 deg\"]", "[\"5 deg\", \"5 deg\"]")).code, "FILE0108");
    EXPECT_EQ(refusal_of(with("\"endless\"", "\"endles\"")).code, "FILE0113");
    EXPECT_EQ(refusal_of(with("point =", "direction = [0, 0, 0]\npoint =")).code, "FILE0109");
    EXPECT_EQ(refusal_of(with("point =", "direction = [0, nan, 0]\npoint =")).code, "FILE0105");
    EXPECT_EQ(refusal_of(with("point =", "type = \"round\"\npoint =")).code, "FILE0113");
}

TEST(MachineFile, RefusesAxesInOtherNumbers) {
    EXPECT_EQ(refusal_of(with("point =", "type = \"linear\"\nreversed =")).code.substr(0, 4),
              "BASE");  // limits of another kind
    const std::string axis =
        "range = \"endless\"\nmax_velocity = \"1 rpm\"\nmax_acceleration = \"1 rad/s^2\"\nmax_jerk = \"1 rad/s^3\"\n";
    std::string three = "[axes.B]\n" + axis;
    EXPECT_EQ(refusal_of(with("C A X Y Z", "B C A X Y Z") + three).code, "FILE0111");
    const std::string two_linear =
        "chain = \"X Y\"\n[axes.X]\nrange = \"endless\"\nmax_velocity = \"1 m/s\"\nmax_acceleration = \"1 "
        "m/s^2\"\nmax_jerk = \"1 m/s^3\"\n"
        "[axes.Y]\nrange = \"endless\"\nmax_velocity = \"1 m/s\"\nmax_acceleration = \"1 m/s^2\"\nmax_jerk = \"1 "
        "m/s^3\"\n";
    EXPECT_EQ(refusal_of(two_linear).code, "FILE0110");
}

TEST(MachineFile, RefusesGeometryThatCannotBeSolved) {
    EXPECT_EQ(refusal_of(with("point =", "direction = [1, 1, 0]\npoint =")).code, "");
    EXPECT_EQ(refusal_of(with("point =", "direction = [0, 0, 1]\npoint =")).code, "MACH0103");
    EXPECT_EQ(refusal_of(with("\nrapid", "\ndirection = [0, 1, 0]\nrapid")).code, "MACH0101");
}

TEST(ShippedMachines, AreFoundByNameAndByFile) {
    const std::array<std::filesystem::path, 2> folders{"/nowhere",
                                                       std::filesystem::path(TRUNNION_SOURCE_DIR) / "data/machines"};
    const auto by_name = files::find_machine("ucp710", folders);
    ASSERT_TRUE(by_name) << to_string(by_name.error());
    EXPECT_EQ(by_name->name, "Mikron UCP 710");
    const auto by_file = files::find_machine((folders[1] / "ucp710.toml").string(), {});
    ASSERT_TRUE(by_file);
    EXPECT_EQ(by_file->name, by_name->name);
}

TEST(ShippedMachines, AnUnknownNameListsThem) {
    const std::array folders{std::filesystem::path(TRUNNION_SOURCE_DIR) / "data/machines"};
    for (const char* name : {"ucp711", "", "tests"}) {
        const auto found = files::find_machine(name, folders);
        ASSERT_FALSE(found);
        EXPECT_EQ(found.error().code, "FILE0112");
        EXPECT_NE(found.error().hint.find("ucp710, xyzab-tdr"), std::string::npos) << found.error().hint;
    }
    EXPECT_EQ(files::find_machine("no/such.toml", folders).error().code, "FILE0101");
    EXPECT_TRUE(files::shipped_machines({}).empty());
}

TEST(MachineFile, TakesTheMachineOfTheNamedCases) {
    const auto path = std::filesystem::path(TRUNNION_SHARED_DIR) / "data/cases/peer-trunnion.toml";
    if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not here";
    const auto read = files::read_machine_file(path);
    ASSERT_TRUE(read) << to_string(read.error());
    EXPECT_DOUBLE_EQ(read->axes[2].feed.jerk, 50000);
    EXPECT_TRUE(read->axes[4].reversed);
}

}  // namespace
