#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "trunnion/machine/kinematics.hpp"
#include "trunnion/path/run.hpp"

namespace trunnion::smoothing::test {

inline constexpr double degree = std::numbers::pi / 180;

/// C on A table, pivots at the machine zero, ISO counts.
inline machine::Machine trunnion_table() {
    machine::Machine m;
    const char letters[] = "XYZAC";
    m.axis_count = 5;
    m.rotary_count = 2;
    for (int i = 0; i < 5; ++i) {
        m.axes[i].letter = letters[i];
        m.axes[i].rotary = i > 2;
        m.axes[i].direction = Eigen::Vector3d::Unit(i < 3 ? i : (i == 3 ? 0 : 2));
    }
    m.chain = {4, 3, 0, 1, 2};
    return m;
}

inline const machine::Kinematics& table() {
    static const auto kinematics =
        machine::Kinematics::make(trunnion_table(), {Eigen::Vector3d(0, 0, 50), Eigen::Matrix3d::Identity()}, 100)
            .value();
    return kinematics;
}

/// The same with an A axis that leans by 45° towards Z, as on nutating tables: the two axes do not turn the tool at
/// right angles.
inline const machine::Kinematics& inclined_table() {
    static const auto kinematics = [] {
        machine::Machine machine = trunnion_table();
        machine.axes[3].direction = Eigen::Vector3d(0, 1, 1).normalized();
        return machine::Kinematics::make(machine, {Eigen::Vector3d(0, 0, 50), Eigen::Matrix3d::Identity()}, 100)
            .value();
    }();
    return kinematics;
}

/// The run's words on another machine.
inline void put_on(const machine::Kinematics& kinematics, path::Run& run) {
    run.kinematics = &kinematics;
    for (std::size_t i = 0; i < run.blocks.size(); ++i) {
        path::Block& block = run.blocks[i];
        const program::Arc* arc = block.arc == program::no_arc ? nullptr : &run.arcs[block.arc];
        block.length_mm = path::block_length_mm(run, run.vertices[i], run.vertices[i + 1], arc);
    }
}

using Pose = std::array<double, 6>;  // position, then orientation coordinates

/// A run through poses; block lengths by the definition of p.
inline path::Run run_through(const std::vector<Pose>& poses, path::OrientationLaw law,
                             path::Space space = path::Space::workpiece) {
    path::Run run;
    run.law = law;
    run.space = space;
    run.kinematics = &table();
    for (const Pose& q : poses) {
        const path::PathCoordinates at{{q[0], q[1], q[2]}, {q[3], q[4], q[5]}};
        if (!run.vertices.empty()) {
            path::Block block;
            block.length_mm = path::block_length_mm(run, run.vertices.back(), at);
            block.feed = {program::FeedRule::tip_speed, 100};
            block.line = static_cast<std::int32_t>(run.vertices.size());
            run.blocks.push_back(block);
        }
        run.vertices.push_back(at);
    }
    return run;
}

/// Makes a block of the run an arc about a centre; its ends must lie on it.
inline void make_arc(path::Run& run, std::size_t block, const Eigen::Vector3d& centre, const Eigen::Vector3d& normal,
                     double angle_rad) {
    run.blocks[block].arc = static_cast<std::int32_t>(run.arcs.size());
    run.arcs.push_back({centre, normal, angle_rad});
    run.blocks[block].length_mm =
        path::block_length_mm(run, run.vertices[block], run.vertices[block + 1], &run.arcs.back());
}

/// Vector law, axis along Z.
inline path::Run upright(const std::vector<std::array<double, 3>>& points) {
    std::vector<Pose> poses;
    for (const auto& p : points) poses.push_back({p[0], p[1], p[2], 0, 0, 1});
    return run_through(poses, path::OrientationLaw::vector);
}

/// Columns of a case file: x y z i j k kind, then rotary words in degrees.
inline path::Run run_from_case(const std::string& name) {
    std::ifstream file(std::string(TRUNNION_SHARED_DIR) + "/data/cases/" + name + ".csv");
    std::string line;
    std::getline(file, line);
    std::vector<Pose> poses;
    bool rotary = false;
    while (std::getline(file, line)) {
        std::istringstream cells(line);
        std::string cell;
        std::vector<std::string> row;
        while (std::getline(cells, cell, ',')) row.push_back(cell);
        rotary = row.size() > 7;
        Pose q{};
        for (int k = 0; k < 6; ++k) q[k] = std::stod(row[k]);
        if (rotary) q[3] = std::stod(row[7]) * degree, q[4] = std::stod(row[8]) * degree, q[5] = 0;
        poses.push_back(q);
    }
    return run_through(poses, rotary ? path::OrientationLaw::rotary : path::OrientationLaw::vector);
}

inline bool has_cases() {
    return std::ifstream(std::string(TRUNNION_SHARED_DIR) + "/data/cases/cases.json").good();
}

/// SplitMix64: the same numbers everywhere.
class Random {
  public:
    explicit Random(std::uint64_t seed) : state_(seed) {}
    double uniform(double low, double high) { return low + (high - low) * static_cast<double>(next() >> 11) * 0x1p-53; }
    std::uint64_t next() {
        std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ULL);
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
        return z ^ (z >> 31);
    }

  private:
    std::uint64_t state_;
};

}  // namespace trunnion::smoothing::test
