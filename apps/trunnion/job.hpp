#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "trunnion/base/result.hpp"
#include "trunnion/machine/machine.hpp"
#include "trunnion/pipeline/plan.hpp"
#include "trunnion/program/program_parts.hpp"

namespace trunnion::app {

/// Dialects that are read and written.
inline const std::vector<std::string> dialect_names{"apt", "rs274", "sinumerik", "heidenhain", "fanuc"};

/// What the command line says about program, machine and tolerances, as text.
struct JobOptions {
    std::string program, machine, setup, units, dialect;
    std::string tip_tolerance = "0.02 mm", orientation_tolerance = "0.1 deg", flank_tolerance, flank_height = "30 mm";
    std::string rounding = "smooth", corners = "smooth", link = "optimised", feed_override = "100%", feed,
                jerk_margin = "0%", period = "1ms";
    std::string chord_error, tip_acceleration, tip_jerk, tool_turn, threads = "1";
    double calm = 0.001;
    bool worth = false, quiet = false;

    void add_machine_to(CLI::App& command);
    void add_tolerances_to(CLI::App& command);
    /// Options that plan, check and their kin share.
    void add_to(CLI::App& command);
    /// Options of planning alone.
    void add_planning_to(CLI::App& command);
};

/// What a program is worked on with, read and resolved.
struct Workplace {
    machine::Machine machine;
    machine::Setup setup;
    pipeline::PlanOptions options;
    std::vector<Diagnostic> diagnostics;  ///< what was assumed
};

/// That, and the program as a whole; it has the diagnostics of both.
struct Job : Workplace {
    program::Program program;
    double read_s = 0;
};

Result<Workplace> load_workplace(const JobOptions& options);
Result<Job> load(const JobOptions& options);
/// The program part by part, a small one as one: plan and check take the same parts. The workplace must stay.
Result<std::unique_ptr<program::ProgramParts>> open_program(const JobOptions& options, const Workplace& workplace);

/// Folders that hold shipped machine files, best first.
std::vector<std::filesystem::path> machine_folders();

/// Prints a diagnostic on stderr (warnings not under --quiet).
void print(const Diagnostic& diagnostic, bool quiet = false);
/// Prints the error and gives the exit status that belongs to it.
int report_failure(const Diagnostic& diagnostic);

}  // namespace trunnion::app
