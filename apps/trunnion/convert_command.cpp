#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/files/setup_file.hpp"
#include "trunnion/files/shipped_machines.hpp"
#include "trunnion/nc/read.hpp"
#include "trunnion/pipeline/convert.hpp"
#include "trunnion/pipeline/expand_surfaces.hpp"

#include "commands.hpp"
#include "job.hpp"
#include "written_program.hpp"

namespace trunnion::app {

namespace {

struct ConvertCommand {
    std::string program, machine, setup, units, dialect, orientation = "as needed", turning_precision = "0.001deg";
    WrittenProgram out;
    bool quiet = false;
};

/// What the command line names, read. The machine may be missing.
struct Source {
    program::Program program;
    std::optional<machine::Machine> machine;
    machine::Setup setup;
};

/// Surfaces become the moves of their passes, which is told.
Result<program::Program> without_surfaces(program::Program program, const machine::Setup& setup) {
    const std::size_t jobs = program.surface_jobs.size();
    if (jobs == 0) return program;
    const int line = program.surface_jobs.front().line;
    auto expanded = pipeline::expand_surfaces(std::move(program), setup);
    if (!expanded) return expanded;
    expanded->diagnostics.push_back({.code = "PIPE0121",
                                     .severity = Severity::warning,
                                     .text = "the passes of surfaces are written as straight moves",
                                     .place = {.file = expanded->source, .line = line},
                                     .count = static_cast<int>(jobs)});
    return expanded;
}

Result<Source> read_source(const ConvertCommand& command) {
    Source out;
    if (!command.machine.empty()) {
        auto machine = files::find_machine(command.machine, machine_folders());
        if (!machine) return fail(machine.error());
        out.machine = std::move(*machine);
    }
    if (!command.setup.empty()) {
        auto setup = files::read_setup_file(command.setup);
        if (!setup) return fail(setup.error());
        out.setup = std::move(*setup);
    }
    nc::ReadOptions reading;
    reading.feed_given_elsewhere = true;  // what has no feed is written without one
    if (out.machine) reading.machine = &*out.machine;
    if (!command.dialect.empty()) reading.dialect = nc::dialect_named(command.dialect);
    if (command.units == "mm") reading.units = nc::Units::mm;
    if (command.units == "inch") reading.units = nc::Units::inch;
    auto program = nc::read_program_file(command.program, reading);
    if (!program) return fail(program.error());
    program = without_surfaces(std::move(*program), out.setup);
    if (!program) return fail(program.error());
    out.program = std::move(*program);
    return out;
}

/// The law that moves with TCP on are to have; none: each keeps its own.
std::optional<program::OrientationLaw> law_wanted(const ConvertCommand& command, nc::Dialect dialect) {
    if (command.orientation == "words") return program::OrientationLaw::rotary;
    if (command.orientation == "vectors") return program::OrientationLaw::vector;
    if (dialect == nc::Dialect::rs274) return program::OrientationLaw::rotary;
    if (dialect == nc::Dialect::apt) return program::OrientationLaw::vector;
    return {};
}

Result<nc::WriteSummary> run(const ConvertCommand& command) {
    auto options = command.out.options();
    if (!options) return fail(options.error());
    const auto turning = parse_quantity(command.turning_precision, dimension::angle);
    if (!turning) return fail(turning.error());
    auto source = read_source(command);
    if (!source) return fail(source.error());
    const machine::Machine* machine = source->machine ? &*source->machine : nullptr;
    options->head = {fmt::format("converted from {} ({}) by trunnion " TRUNNION_VERSION,
                                 std::filesystem::path(command.program).filename().string(), source->program.dialect),
                     fmt::format("machine: {}", machine ? machine->name : "none"), command.out.precision_text()};
    const auto law = law_wanted(command, options->dialect);
    const bool turns = machine && machine->rotary_count > 0;
    if (law && turns) {
        auto translated = pipeline::translate(source->program, *machine, source->setup, *law, *turning);
        if (!translated) return fail(translated.error());
        source->program = std::move(*translated);
    }
    auto written = pipeline::write_program_file(command.out.file, source->program, machine, *options);
    if (!written) return written;
    for (const Diagnostic& diagnostic : source->program.diagnostics) print(diagnostic, command.quiet);
    return written;
}

int convert_and_report(const ConvertCommand& command) {
    const auto written = run(command);
    if (!written) return report_failure(written.error());
    for (const Diagnostic& diagnostic : written->diagnostics) print(diagnostic, command.quiet);
    if (!command.quiet) fmt::print("{} moves in {} lines\n", written->moves, written->lines);
    return done;
}

}  // namespace

void add_convert_command(CLI::App& app, int& status) {
    auto command = std::make_shared<ConvertCommand>();
    CLI::App* convert = app.add_subcommand("convert", "part program → the same program in another dialect");
    convert->add_option("program", command->program, "part program in any dialect that is read")->required();
    convert->add_option("-m,--machine", command->machine, "shipped machine by name, or a machine file");
    convert->add_option("--setup", command->setup, "setup file: workpiece, tools, offsets");
    convert->add_option("--units", command->units, "overrides the unit that the program states")
        ->check(CLI::IsMember({"mm", "inch"}));
    convert->add_option("--dialect", command->dialect, "of the program, instead of recognising it by content")
        ->check(CLI::IsMember(dialect_names));
    convert
        ->add_option("--orientation", command->orientation,
                     "tool vectors, rotary words, or as needed: rs274 takes words, apt vectors, the others both")
        ->check(CLI::IsMember({"as needed", "words", "vectors"}))
        ->capture_default_str();
    convert
        ->add_option("--turning-precision", command->turning_precision,
                     "how far the tool may lie from how it turned under the other of both; moves are divided for it")
        ->capture_default_str();
    command->out.add_to(*convert, true);
    convert->add_flag("-q,--quiet", command->quiet, "no warnings");
    convert->footer(
        "Words and vectors are turned into each other by the machine (-m) and its setup.\n"
        "Example:\n  trunnion convert part.cls --to sinumerik -o part.mpf");
    convert->callback([command, &status] { status = convert_and_report(*command); });
}

}  // namespace trunnion::app
