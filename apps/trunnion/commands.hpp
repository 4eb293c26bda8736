#pragma once

#include <CLI/CLI.hpp>

namespace trunnion::app {

/// Exit statuses of the program.
enum ExitStatus : int { done = 0, not_usable = 1, bad_input = 2, own_fault = 3, interrupted = 130 };

/// Each adds one subcommand; when it is called it leaves its exit status in `status`.
void add_plan_command(CLI::App& app, int& status);
void add_play_command(CLI::App& app, int& status);
void add_serve_command(CLI::App& app, int& status);
void add_check_command(CLI::App& app, int& status);
void add_predict_command(CLI::App& app, int& status);
void add_convert_command(CLI::App& app, int& status);
void add_smooth_command(CLI::App& app, int& status);
void add_deform_command(CLI::App& app, int& status);
void add_surface_command(CLI::App& app, int& status);
/// `run`, a subcommand of `surface`.
void add_surface_run_command(CLI::App& surface, int& status);
void add_report_command(CLI::App& app, int& status);
void add_machine_command(CLI::App& app, int& status);
void add_controller_command(CLI::App& app, int& status);

}  // namespace trunnion::app
