#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/files/linuxcnc_machine.hpp"
#include "trunnion/files/machine_file.hpp"
#include "trunnion/files/output_file.hpp"
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

// ---- LinuxCNC

struct LinuxcncOptions {
    std::string machine, output, period = "1ms", display = "dummy", jerk_linear, jerk_rotary;
    bool linuxcnc = false, play = false, serve = false;
};

/// A value of an option; empty where it was not given.
Result<std::optional<double>> given(const char* name, const std::string& text, Dimension wanted) {
    if (text.empty()) return std::optional<double>();
    const auto value = parse_quantity(text, wanted);
    Diagnostic wrong = value ? Diagnostic{.code = "PIPE0001", .text = "not above 0", .value = text} : value.error();
    wrong.text = fmt::format("{}: {}", name, wrong.text);
    if (!value || !(*value > 0)) return fail(std::move(wrong));
    return std::optional(*value);
}

/// All of the files or none: each takes its name when all are written.
Result<void> write_files(const std::vector<std::pair<std::filesystem::path, std::string>>& texts) {
    std::vector<files::OutputFile> outputs;
    for (const auto& [path, text] : texts) {
        auto output = files::OutputFile::create(path);
        if (!output) return fail(output.error());
        output->write(text);
        outputs.push_back(std::move(*output));
    }
    for (files::OutputFile& output : outputs)
        if (auto written = output.commit(); !written) return written;
    return {};
}

Result<void> export_machine(const LinuxcncOptions& options) {
    const auto machine = files::find_machine(options.machine, machine_folders());
    if (!machine) return fail(machine.error());
    const auto period_s = given("--period", options.period, dimension::time);
    if (!period_s) return fail(period_s.error());
    files::LinuxcncExport wanted{.display = options.display, .play = options.play};
    if (*period_s) wanted.servo_period_s = **period_s;
    if (options.serve) wanted.served_machine = std::filesystem::absolute(machine->file).string();
    const std::string stem = std::filesystem::path(machine->file).stem().string();
    const auto made = files::linuxcnc_configuration(*machine, stem, wanted);
    if (!made) return fail(made.error());
    const std::filesystem::path folder = options.output.empty() ? "." : options.output;
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    const auto file = [&](const char* extension) { return folder / (stem + extension); };
    if (auto written = write_files({{file(".hal"), made->hal},
                                    {file(".tbl"), made->tool_table},
                                    {file(".var"), made->parameters},
                                    {file(".ini"), made->ini}});
        !written)
        return written;
    fmt::print("{}\n", file(".ini").string());
    return {};
}

Result<void> import_machine(const LinuxcncOptions& options) {
    const auto linear = given("--jerk-linear", options.jerk_linear, dimension::jerk);
    if (!linear) return fail(linear.error());
    const auto rotary = given("--jerk-rotary", options.jerk_rotary, dimension::angular_jerk);
    if (!rotary) return fail(rotary.error());
    const auto read = files::read_linuxcnc_machine_file(options.machine, {*linear, *rotary});
    if (!read) return fail(read.error());
    std::string text = fmt::format("# From {}\n", std::filesystem::path(options.machine).filename().string());
    for (const std::string& note : read->notes) text += fmt::format("# {}\n", note);
    text += files::machine_text(read->machine);
    if (!options.output.empty()) return write_files({{options.output, text}});
    fmt::print("{}", text);
    return {};
}

int status_of(const Result<void>& result) {
    return result ? done : report_failure(result.error());
}

void add_export(CLI::App& machine, int& status) {
    auto options = std::make_shared<LinuxcncOptions>();
    CLI::App* command = machine.add_subcommand("export", "a configuration of a control for a machine");
    command->add_option("machine", options->machine, "shipped name or file")->required();
    command->add_flag("--linuxcnc", options->linuxcnc, "INI, HAL, tool table and parameters of LinuxCNC 2.9")
        ->required();
    command->add_option("-o,--output", options->output, "folder of the files; the working folder unless given");
    command->add_option("--period", options->period, "servo period")->capture_default_str();
    command->add_option("--display", options->display, "user interface; dummy: none")->capture_default_str();
    command->add_flag("--play", options->play, "with what `trunnion play` hands its rows to");
    command->add_flag("--serve", options->serve, "LinuxCNC's queue planned by `trunnion serve`");
    command->footer("Example:\n  trunnion machine export xyzac-trt --linuxcnc -o trt");
    command->callback([options, &status] { status = status_of(export_machine(*options)); });
}

void add_import(CLI::App& machine, int& status) {
    auto options = std::make_shared<LinuxcncOptions>();
    CLI::App* command = machine.add_subcommand("import", "a machine file from a LinuxCNC configuration");
    command->add_option("ini", options->machine, "INI file; the HAL files that it names lie beside it")->required();
    command->add_option("-o,--output", options->output, "the machine file; else it is printed");
    command->add_option("--jerk-linear", options->jerk_linear, "jerk limit of the linear axes, e.g. \"50 m/s^3\"");
    command->add_option("--jerk-rotary", options->jerk_rotary, "jerk limit of the rotary axes, e.g. \"1800 deg/s^3\"");
    command->footer(
        "Example:\n  trunnion machine import trt/xyzac-trt.ini --jerk-linear \"50 m/s^3\" --jerk-rotary \"1800 deg/s^3\" -o "
        "mill.toml");
    command->callback([options, &status] { status = status_of(import_machine(*options)); });
}

}  // namespace

void add_machine_command(CLI::App& app, int& status) {
    CLI::App* machine = app.add_subcommand(
        "machine", "what machines there are, whether a machine file is good, and from and to LinuxCNC");
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
    add_export(*machine, status);
    add_import(*machine, status);
}

}  // namespace trunnion::app
