#include <cmath>
#include <cstdio>
#include <memory>
#include <string>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/files/shipped_machines.hpp"
#include "trunnion/machine/kinematics.hpp"

#include "commands.hpp"
#include "job.hpp"

namespace trunnion::app {

namespace {

int list_machines() {
    for (const auto& shipped : files::shipped_machines(machine_folders()))
        fmt::print("{:<23} {}\n", shipped.name, shipped.title);
    return done;
}

std::string range_text(const machine::Axis& axis) {
    const double unit = axis.rotary ? degree : 1.0;
    if (!std::isfinite(axis.range_min)) return "endless";
    return fmt::format("{:g} … {:g}", axis.range_min / unit, axis.range_max / unit);
}

void print_machine(const machine::Machine& machine) {
    std::string chain;
    for (int i = 0; i < machine.axis_count; ++i) chain += fmt::format("{} ", machine.axes[machine.chain[i]].letter);
    fmt::print("{}\n{}\nchain {}(workpiece → tool)\n", machine.name, machine.file, chain);
    for (int i = 0; i < machine.axis_count; ++i) {
        const machine::Axis& axis = machine.axes[i];
        const double unit = axis.rotary ? degree : 1.0;
        const char* name = axis.rotary ? "deg" : "mm";
        fmt::print("  {}  {:<22} {:>9.6g} {}/s  {:>8.6g} {}/s^2  {:>9.6g} {}/s^3{}\n", axis.letter,
                   fmt::format("{} {}", range_text(axis), name), axis.feed.velocity / unit, name,
                   axis.feed.acceleration / unit, name, axis.feed.jerk / unit, name,
                   axis.reversed ? "  counted against ISO 841" : "");
    }
}

int show_machine(const std::string& name) {
    const auto machine = files::find_machine(name, machine_folders());
    if (!machine) return report_failure(machine.error());
    print_machine(*machine);
    return done;
}

int check_machine(const std::string& file) {
    const auto machine = files::find_machine(file, machine_folders());
    if (!machine) return report_failure(machine.error());
    const auto kinematics = machine::Kinematics::make(*machine, {}, 0);
    if (!kinematics) return report_failure(kinematics.error());
    fmt::print("{}: good\n", machine->name);
    return done;
}

}  // namespace

void add_machine_command(CLI::App& app, int& status) {
    CLI::App* machine = app.add_subcommand("machine", "what machines there are, and whether a machine file is good");
    machine->require_subcommand(1);
    machine->footer("Example:\n  trunnion machine list");
    auto name = std::make_shared<std::string>();
    machine->add_subcommand("list", "the shipped ones")->callback([&status] { status = list_machines(); });
    CLI::App* show = machine->add_subcommand("show", "one machine's axes and limits");
    show->add_option("machine", *name, "shipped name or file")->required();
    show->callback([name, &status] { status = show_machine(*name); });
    CLI::App* check = machine->add_subcommand("check", "reads a machine file and says what is wrong with it");
    check->add_option("machine", *name, "shipped name or file")->required();
    check->callback([name, &status] { status = check_machine(*name); });
}

}  // namespace trunnion::app
