#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "trunnion/base/result.hpp"
#include "trunnion/machine/machine.hpp"
#include "trunnion/pipeline/plan.hpp"
#include "trunnion/program/program.hpp"

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

    /// Options that plan, check and their kin share.
    void add_to(CLI::App& command);
    /// Options of planning alone.
    void add_planning_to(CLI::App& command);
};

/// Everything read and resolved.
struct Job {
    program::Program program;
    machine::Machine machine;
    machine::Setup setup;
    pipeline::PlanOptions options;
    double read_s = 0;
};

Result<Job> load(const JobOptions& options);

/// Folders that hold shipped machine files, best first.
std::vector<std::filesystem::path> machine_folders();

/// Prints a diagnostic on stderr (warnings not under --quiet).
void print(const Diagnostic& diagnostic, bool quiet = false);
/// Prints the error and gives the exit status that belongs to it.
int report_failure(const Diagnostic& diagnostic);

}  // namespace trunnion::app
