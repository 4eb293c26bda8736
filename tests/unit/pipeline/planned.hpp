#pragma once

#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "trunnion/files/machine_file.hpp"
#include "trunnion/nc/read.hpp"
#include "trunnion/pipeline/plan.hpp"

namespace trunnion::pipeline {

inline constexpr const char* test_table = R"(
name = "test table"
chain = "C A X Y Z"
[axes.X]
range = ["-1000 mm", "1000 mm"]
max_velocity = "500 mm/s"
max_acceleration = "2500 mm/s^2"
max_jerk = "20000 mm/s^3"
[axes.Y]
range = ["-1000 mm", "1000 mm"]
max_velocity = "500 mm/s"
max_acceleration = "2500 mm/s^2"
max_jerk = "20000 mm/s^3"
[axes.Z]
range = ["-1000 mm", "1000 mm"]
max_velocity = "500 mm/s"
max_acceleration = "2500 mm/s^2"
max_jerk = "20000 mm/s^3"
[axes.A]
range = ["-120 deg", "120 deg"]
max_velocity = "90 deg/s"
max_acceleration = "300 deg/s^2"
max_jerk = "1800 deg/s^3"
[axes.C]
range = "endless"
max_velocity = "120 deg/s"
max_acceleration = "300 deg/s^2"
max_jerk = "1800 deg/s^3"
[words]
tcp_on = ["M428"]
tcp_off = ["M429"]
)";

/// Keeps what it is given; all on one thread.
struct Recorder : PlanObserver {
    std::vector<motion::Setpoint> rows;
    std::vector<EventRow> events;
    std::vector<PathSample> samples;
    std::vector<double> shares;
    int calls_until_cancel = -1;
    std::thread::id caller = std::this_thread::get_id();
    void setpoint(const motion::Setpoint& row) override { expect_caller(), rows.push_back(row); }
    void event(const EventRow& row) override { expect_caller(), events.push_back(row); }
    void path_sample(const PathSample& sample) override { expect_caller(), samples.push_back(sample); }
    bool progress(double share) override {
        expect_caller();
        shares.push_back(share);
        return calls_until_cancel-- != 0;
    }
    void expect_caller() const { EXPECT_EQ(std::this_thread::get_id(), caller); }
};

/// A program text planned on a machine.
struct Planned {
    machine::Machine machine;
    program::Program program;
    Recorder recorder;
    Result<Summary> summary;

    explicit Planned(std::string_view text, const PlanOptions& options = {}, int cancel = -1)
        : Planned(files::read_machine(test_table, "test.toml").value(), text, options, cancel) {}

    Planned(machine::Machine on, std::string_view text, const PlanOptions& options = {}, int cancel = -1)
        : machine(std::move(on)) {
        nc::ReadOptions reading;
        reading.machine = &machine;
        auto read = nc::read_program(text, "test.ngc", reading);
        if (!read) {
            summary = fail(read.error());
            return;
        }
        program = *read;
        recorder.calls_until_cancel = cancel;
        summary = plan(program, machine, {}, options, recorder);
    }
};

}  // namespace trunnion::pipeline
