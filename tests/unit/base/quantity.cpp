#include "trunnion/base/quantity.hpp"

#include <numbers>

#include <gtest/gtest.h>

namespace {

using namespace trunnion;

constexpr double pi = std::numbers::pi;

void expect_value(std::string_view text, Dimension wanted, double value) {
    const auto read = parse_quantity(text, wanted);
    ASSERT_TRUE(read) << to_string(read.error());
    EXPECT_DOUBLE_EQ(*read, value) << text;
}

std::string code_of(std::string_view text, Dimension wanted) {
    const auto read = parse_quantity(text, wanted);
    return read ? "" : read.error().code;
}

TEST(Quantity, ReadsWhatPeopleWrite) {
    expect_value("20um", dimension::length, 0.02);
    expect_value("20 µm", dimension::length, 0.02);
    expect_value(" +2.5e1 mm ", dimension::length, 25);
    expect_value("-1 in", dimension::length, -25.4);
    expect_value("30 m/min", dimension::velocity, 500);
    expect_value("2.5 m/s^2", dimension::acceleration, 2500);
    expect_value("50 m / s ^ 3", dimension::jerk, 50000);
    expect_value("0.1 deg", dimension::angle, pi / 1800);
    expect_value("15 rpm", dimension::angular_velocity, pi / 2);
    expect_value("0.83 rev/s^2", dimension::angular_acceleration, 1.66 * pi);
    expect_value("1800 deg/s^3", dimension::angular_jerk, 10 * pi);
    expect_value("10 mm/s/s", dimension::acceleration, 10);
    expect_value("1 ms", dimension::time, 0.001);
    expect_value("2 min", dimension::time, 120);
    expect_value("50%", dimension::ratio, 0.5);
}

TEST(Quantity, RefusesWhatIsNoNumber) {
    for (const char* text : {"", "mm", "nan mm", "inf mm", "1e999 mm", "- 1 mm", "."})
        EXPECT_EQ(code_of(text, dimension::length), "BASE0001") << text;
}

TEST(Quantity, RefusesABareNumberWithAHint) {
    const auto read = parse_quantity("20", dimension::length);
    ASSERT_FALSE(read);
    EXPECT_EQ(read.error().code, "BASE0002");
    EXPECT_NE(read.error().hint.find("mm"), std::string::npos);
}

TEST(Quantity, RefusesUnknownUnits) {
    for (const char* text : {"1 furlong", "1 mm//s", "1 mm/", "1 mm^0", "1 mm^x", "1 mm s", "1 MM"})
        EXPECT_EQ(code_of(text, dimension::length), "BASE0003") << text;
}

TEST(Quantity, RefusesUnitsOfAnotherKind) {
    EXPECT_EQ(code_of("1 deg", dimension::length), "BASE0004");
    EXPECT_EQ(code_of("1 mm/s", dimension::acceleration), "BASE0004");
    EXPECT_EQ(code_of("15 rpm", dimension::velocity), "BASE0004");
    EXPECT_EQ(code_of("1 mm^2", dimension::length), "BASE0004");
}

}  // namespace
