// One shipped machine with a workpiece somewhere on its table: what the laws are tried on.
#pragma once

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "trunnion/files/machine_file.hpp"
#include "trunnion/machine/kinematics.hpp"

#include "random_numbers.hpp"

namespace trunnion {

inline std::filesystem::path machines_folder() {
    return std::filesystem::path(TRUNNION_SOURCE_DIR) / "data" / "machines";
}

inline std::vector<std::string> machine_files() {
    std::vector<std::string> out;
    for (const auto& entry : std::filesystem::directory_iterator(machines_folder()))
        if (entry.path().extension() == ".toml") out.push_back(entry.path().string());
    std::ranges::sort(out);
    return out;
}

/// The machine's name, fit for the name of a test.
inline std::string stem(const testing::TestParamInfo<std::string>& info) {
    std::string out = std::filesystem::path(info.param).stem().string();
    std::ranges::replace_if(out, [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); }, '_');
    return out;
}

class OnShippedMachine : public testing::TestWithParam<std::string> {
  protected:
    static constexpr double tool_length_mm = 87.5;

    void SetUp() override {
        auto read = files::read_machine_file(GetParam());
        ASSERT_TRUE(read) << to_string(read.error());
        machine = *read;
        workpiece.origin_mm = {12.5, -34.0, 56.25};
        workpiece.rotation = Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, -2, 3).normalized()).toRotationMatrix();
        auto made = trunnion::machine::Kinematics::make(machine, workpiece, tool_length_mm);
        ASSERT_TRUE(made) << to_string(made.error());
        kinematics.emplace_back(*made);
    }
    const trunnion::machine::Kinematics& k() const { return kinematics.front(); }

    RandomNumbers random{random_seed()};
    trunnion::machine::Machine machine;
    trunnion::machine::Frame workpiece;
    std::vector<trunnion::machine::Kinematics> kinematics;
};

}  // namespace trunnion
