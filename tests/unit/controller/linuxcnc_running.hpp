#pragma once

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/controller/linuxcnc.hpp"
#include "trunnion/nc/read.hpp"

namespace trunnion::controller {

/// C on A table with pivots at the machine zero and the limits that LinuxCNC was recorded with.
inline machine::Machine recorded_table() {
    machine::Machine m;
    m.axis_count = 5;
    m.rotary_count = 2;
    m.chain = {4, 3, 0, 1, 2};
    const char letters[] = "XYZAC";
    const double accelerations[] = {2500, 3000, 2100, 300, 300}, velocities[] = {500, 500, 500, 90, 120};
    const int directions[] = {0, 1, 2, 0, 2};
    for (std::size_t i = 0; i < 5; ++i) {
        machine::Axis& axis = m.axes[i];
        axis.letter = letters[i];
        axis.rotary = i > 2;
        axis.reversed = axis.rotary;
        axis.direction = Eigen::Vector3d::Unit(directions[i]);
        const double unit = axis.rotary ? degree : 1;
        axis.feed = axis.rapid = {velocities[i] * unit, accelerations[i] * unit, 5000};
    }
    return m;
}

/// The settings of the recorded runs.
inline LinuxcncSettings recorded_settings() {
    LinuxcncSettings settings;
    settings.ramp_frequency_hz = 20;
    settings.max_linear_velocity_mm_s = 500;
    return settings;
}

inline machine::Setup at_zero() {
    machine::Setup setup;
    for (const char letter : {'X', 'Y', 'Z', 'A', 'C'}) setup.start[letter] = 0;
    return setup;
}

inline Result<program::Program> program_of(const std::string& text, const machine::Machine& machine) {
    nc::ReadOptions options{.dialect = nc::Dialect::rs274};
    options.machine = &machine;
    return nc::read_program(text, "test.ngc", options);
}

/// A program and all rows of its run.
struct Running {
    explicit Running(const std::string& text, const LinuxcncSettings& settings = recorded_settings(),
                     const machine::Setup& setup = at_zero())
        : machine(recorded_table()) {
        auto program = program_of("G21 G90 G94 G17\n" + text, machine);
        if (!program) {
            ADD_FAILURE() << to_string(program.error());
            return;
        }
        run = run_as_linuxcnc(*program, machine, setup, settings, [&](const LinuxcncRow& row) { rows.push_back(row); });
    }

    double seconds() const { return run ? run->cycle_time_s : -1; }

    machine::Machine machine;
    Result<LinuxcncRun> run = fail({});
    std::vector<LinuxcncRow> rows;
};

}  // namespace trunnion::controller
