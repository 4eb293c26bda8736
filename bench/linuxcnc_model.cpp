// Runs the model of LinuxCNC 2.9 on one program; scripts/compare_linuxcnc.py compares what it prints with the control.
//
//     bench_linuxcnc_model PROGRAM MACHINE SETUP [SETTING=VALUE…] [--rows]
//
// Settings by their INI names in place of those of linuxcnc-2.9; FEED_OVERRIDE and RAPID_OVERRIDE; FEED_FACTOR
// multiplies F words, ACCELERATION_FACTOR the limit of X (how far a program's time depends on the last digits is seen
// with 1.0000000000001). The machine stands at the program's zero at first. Without --rows one line of JSON, with it
// one row a servo period as CSV, mm and degrees, and the JSON on stderr.
#include <algorithm>
#include <cctype>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/controller/linuxcnc.hpp"
#include "trunnion/files/controller_file.hpp"
#include "trunnion/files/machine_file.hpp"
#include "trunnion/files/setup_file.hpp"
#include "trunnion/machine/kinematics.hpp"
#include "trunnion/nc/read.hpp"

namespace {

using namespace trunnion;
using controller::LinuxcncRow;
using controller::LinuxcncRun;
using controller::LinuxcncSettings;

int refused(const Diagnostic& diagnostic) {
    fmt::print(stderr, "{}\n", to_string(diagnostic));
    return 2;
}

/// A parameter of the controller file by its name in LinuxCNC's INI, in seconds, mm and Hz.
bool set(motion::Controller& control, std::string name, double value) {
    std::ranges::transform(name, name.begin(), [](unsigned char letter) { return std::tolower(letter); });
    if (name == motion::facts_of(motion::ChoiceId::arc_blend_enable).key) {
        control.arc_blend_enable.way = value != 0 ? motion::Switch::on : motion::Switch::off;
        return true;
    }
    const auto parameters = motion::used_parameters(control);
    const auto found = std::ranges::find(parameters, name, &motion::NamedParameter::name);
    if (found == parameters.end()) return false;
    found->parameter->value = value;
    return true;
}

/// F words times `factor`, as an operator would edit them.
void scale_feeds(program::Program& program, double factor) {
    for (program::Move& move : program.moves)
        move.feed.value =
            move.feed.rule == program::FeedRule::block_time ? move.feed.value / factor : move.feed.value * factor;
}

void scale_accelerations(LinuxcncSettings& settings, const machine::Machine& machine, double factor) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(machine.axis_count); ++i)
        settings.axis_limits[machine.axes[i].letter].acceleration = machine.axes[i].feed.acceleration * factor;
}

void print_row(const LinuxcncRow& row, const machine::Machine& machine) {
    fmt::print("{:.4f},{:.17g},{:.17g},{:.17g}", row.time_s, row.tip_mm.x(), row.tip_mm.y(), row.tip_mm.z());
    for (const double angle : row.rotary_rad) fmt::print(",{:.17g}", angle / degree);
    for (std::size_t i = 0; i < static_cast<std::size_t>(machine.axis_count); ++i)
        fmt::print(",{:.17g}", row.axes[i] / (machine.axes[i].rotary ? degree : 1));
    fmt::print(",{},{:.9g}\n", row.line, row.speed_mm_s);
}

std::string json(const LinuxcncRun& run, const machine::Machine& machine, double elapsed_s) {
    std::string velocity, acceleration;
    for (std::size_t i = 0; i < static_cast<std::size_t>(machine.axis_count); ++i) {
        const double unit = machine.axes[i].rotary ? degree : 1;
        velocity += fmt::format("{}{:.10g}", i ? "," : "", run.peak_velocity[i] / unit);
        acceleration += fmt::format("{}{:.10g}", i ? "," : "", run.peak_acceleration[i] / unit);
    }
    return fmt::format(
        R"({{"cycle_time_s":{:.9g},"length_over_feed_s":{:.9g},"wait_s":{:.9g},"rows":{},"segments":{},"arc_blends":{},)"
        R"("velocity":[{}],"acceleration":[{}],"elapsed_s":{:.3f}}})",
        run.cycle_time_s, run.length_over_feed_s, run.wait_s(), run.rows, run.segments, run.arc_blends, velocity,
        acceleration, elapsed_s);
}

/// The axes' positions at which the tip stands at the program's zero.
std::map<char, double> at_zero(const machine::Machine& machine, const machine::Kinematics& kinematics) {
    const auto linear = kinematics.linear_for(Eigen::Vector3d::Zero(), {});
    std::map<char, double> start;
    for (std::size_t i = 0; i < static_cast<std::size_t>(machine.axis_count); ++i)
        start[machine.axes[i].letter] = i < 3 ? linear[i] : 0.0;
    return start;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 4) {
        fmt::print(stderr, "usage: bench_linuxcnc_model PROGRAM MACHINE SETUP [SETTING=VALUE...] [--rows]\n");
        return 2;
    }
    const auto machine = files::read_machine_file(argv[2]);
    if (!machine) return refused(machine.error());
    auto setup = files::read_setup_file(argv[3]);
    if (!setup) return refused(setup.error());
    nc::ReadOptions options{.dialect = nc::Dialect::rs274};
    options.machine = &*machine;
    auto program = nc::read_program_file(argv[1], options);
    if (!program) return refused(program.error());
    const auto kinematics = machine::Kinematics::make(*machine, setup->workpiece, setup->tool.length_mm);
    if (!kinematics) return refused(kinematics.error());
    setup->start = at_zero(*machine, *kinematics);

    auto control = files::read_controller_file(TRUNNION_SOURCE_DIR "/data/controllers/linuxcnc-2.9.toml");
    if (!control) return refused(control.error());
    double acceleration_factor = 1, feed_override = 1, rapid_override = 1;
    bool rows = false;
    for (int i = 4; i < argc; ++i) {
        const std::string_view word = argv[i];
        const std::size_t equals = word.find('=');
        const double value = equals == word.npos ? 0 : std::atof(argv[i] + equals + 1);
        if (word == "--rows")
            rows = true;
        else if (word.substr(0, equals) == "FEED_FACTOR")
            scale_feeds(*program, value);
        else if (word.substr(0, equals) == "ACCELERATION_FACTOR")
            acceleration_factor = value;
        else if (word.substr(0, equals) == "FEED_OVERRIDE")
            feed_override = value;
        else if (word.substr(0, equals) == "RAPID_OVERRIDE")
            rapid_override = value;
        else if (!set(*control, std::string(word.substr(0, equals)), value)) {
            fmt::print(stderr, "no such setting: {}\n", word);
            return 2;
        }
    }
    auto settings = controller::linuxcnc_settings(*control);
    if (!settings) return refused(settings.error());
    settings->feed_override = feed_override;
    settings->rapid_override = rapid_override;
    if (acceleration_factor != 1) scale_accelerations(*settings, *machine, acceleration_factor);
    const auto begin = std::chrono::steady_clock::now();
    const auto run = controller::run_as_linuxcnc(*program, *machine, *setup, *settings, [&](const LinuxcncRow& row) {
        if (rows) print_row(row, *machine);
    });
    if (!run) return refused(run.error());
    const double elapsed_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    fmt::print(rows ? stderr : stdout, "{}\n", json(*run, *machine, elapsed_s));
    return 0;
}
