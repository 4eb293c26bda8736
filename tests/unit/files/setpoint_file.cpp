#include "trunnion/files/setpoint_file.hpp"

#include <charconv>
#include <cstring>
#include <filesystem>
#include <sstream>

#include <gtest/gtest.h>
#include <unistd.h>

#include "trunnion/base/quantity.hpp"

namespace trunnion::files {
namespace {

machine::Machine four_axes() {
    machine::Machine m;
    m.axis_count = 4;
    m.rotary_count = 1;
    for (int i = 0; i < 4; ++i) m.axes[i].letter = "XYZB"[i];
    m.axes[3].rotary = true;
    return m;
}

motion::Setpoint row(int k) {
    motion::Setpoint out;
    out.time_s = 0.001 * k;
    for (int i = 0; i < 4; ++i) out.position[i] = std::sin(1.0 + k + 10 * i) / 3;
    out.line = k + 1;
    out.path_length_mm = 0.1 * k;
    out.feed_mm_s = 50;
    return out;
}

std::filesystem::path fresh(const char* name) {
    return std::filesystem::path(testing::TempDir()) / name;
}

TEST(SetpointFile, csv_reads_back_to_the_same_doubles) {
    const auto machine = four_axes();
    const auto path = fresh("trunnion_setpoints.csv");
    auto file = SetpointFile::create(path, machine);
    ASSERT_TRUE(file);
    for (int k = 0; k < 100; ++k) file->write(row(k));
    ASSERT_TRUE(file->commit());
    std::istringstream text(read_whole_file(path).value());
    std::string line;
    std::getline(text, line);
    EXPECT_EQ(line, "t_s,X_mm,Y_mm,Z_mm,B_deg,line,s_mm,feed_mm_min");
    for (int k = 0; k < 100; ++k) {
        std::getline(text, line);
        const char* at = line.data();
        const auto number = [&] {
            double value = 0;
            at = std::from_chars(at, line.data() + line.size(), value).ptr + 1;
            return value;
        };
        const auto want = row(k);
        EXPECT_EQ(number(), want.time_s);
        for (int i = 0; i < 3; ++i) EXPECT_EQ(number(), want.position[i]);
        EXPECT_EQ(number(), want.position[3] / degree);
        EXPECT_EQ(number(), want.line);
    }
    std::filesystem::remove(path);
}

TEST(SetpointFile, npy_is_one_array_of_float64) {
    const auto machine = four_axes();
    const auto path = fresh("trunnion_setpoints.npy");
    auto file = SetpointFile::create(path, machine);
    for (int k = 0; k < 3; ++k) file->write(row(k));
    ASSERT_TRUE(file->commit());
    const std::string bytes = read_whole_file(path).value();
    ASSERT_EQ(bytes.size(), 128u + 3 * 8 * sizeof(double));
    EXPECT_EQ(bytes.substr(1, 5), "NUMPY");
    EXPECT_NE(bytes.find("'shape': (3, 8)"), std::string::npos);
    EXPECT_EQ(bytes[127], '\n');
    double x = 0;
    std::memcpy(&x, bytes.data() + 128 + (2 * 8 + 1) * sizeof(double), sizeof x);
    EXPECT_EQ(x, row(2).position[0]);
    std::filesystem::remove(path);
}

}  // namespace
}  // namespace trunnion::files
