#include <csignal>
#include <cstdio>
#include <memory>

#include <fmt/format.h>

#include "trunnion/path/rotary_stands.hpp"
#include "trunnion/pipeline/plan_files.hpp"
#include "trunnion/smoothing/pole_tolerance.hpp"
#include "trunnion/verify/programmed_csv.hpp"

#include "commands.hpp"
#include "job.hpp"
#include "progress_line.hpp"

namespace trunnion::app {

namespace {

volatile std::sig_atomic_t stop_wanted = 0;

struct PlanCommand {
    JobOptions job;
    std::string setpoints, summary, path, programmed, events;
};

Result<void> write_programmed(const PlanCommand& command, const Job& job) {
    if (command.programmed.empty()) return {};
    const auto stands = path::choose_rotary_stands(job.program, job.machine, job.setup,
                                                   smoothing::pole_tolerance_rad(job.options.smoothing));
    if (!stands) return fail(stands.error());
    auto poses = verify::programmed_poses(job.program, job.machine, job.setup, *stands);
    if (!poses) return fail(poses.error());
    return pipeline::write_text_file(command.programmed, verify::programmed_csv(*poses, job.machine));
}

Result<pipeline::Summary> run(const PlanCommand& command) {
    auto job = load(command.job);
    if (!job) return fail(job.error());
    job->options.path_samples = !command.path.empty();
    ProgressLine progress(command.job.quiet);
    auto files = pipeline::PlanFiles::create({command.setpoints, command.path, command.events}, job->machine,
                                             [&progress](double share) {
                                                 progress.show(share);
                                                 return stop_wanted == 0;
                                             });
    if (!files) return fail(files.error());
    auto summary = pipeline::plan(job->program, job->machine, job->setup, job->options, **files);
    if (!summary) return summary;
    summary->work.read_s = job->read_s;
    if (auto written = (*files)->commit(); !written) return fail(written.error());
    if (auto written = write_programmed(command, *job); !written) return fail(written.error());
    if (!command.summary.empty())
        if (auto written = pipeline::write_text_file(command.summary, to_json(*summary)); !written)
            return fail(written.error());
    return summary;
}

int plan_and_report(const PlanCommand& command) {
    std::signal(SIGINT, [](int) { stop_wanted = 1; });
    const auto summary = run(command);
    if (!summary) return report_failure(summary.error());
    for (const Diagnostic& diagnostic : summary->diagnostics) print(diagnostic, command.job.quiet);
    fmt::print("{}", summary->report());
    return summary->usable() ? done : not_usable;
}

}  // namespace

void add_plan_command(CLI::App& app, int& status) {
    auto command = std::make_shared<PlanCommand>();
    CLI::App* plan = app.add_subcommand("plan", "part program → jerk-limited axis setpoints and a summary");
    plan->add_option("program", command->job.program, "part program: APT CL data, RS-274 (LinuxCNC) or Sinumerik")
        ->required();
    plan->add_option("-o,--output", command->setpoints, "setpoints: .csv, .csv.gz or .npy");
    plan->add_option("--summary", command->summary, "summary as JSON");
    plan->add_option("--path", command->path, "path samples as CSV");
    plan->add_option("--programmed", command->programmed, "programmed poses as CSV");
    plan->add_option("--events", command->events, "events as CSV");
    command->job.add_to(*plan);
    command->job.add_planning_to(*plan);
    plan->add_flag("--worth", command->job.worth,
                   "what 10 % more of each limit and twice each tolerance would save, by planning again with it");
    plan->footer("Example:\n  trunnion plan part.ngc -m xyzac-trt --setup vice.toml -o setpoints.csv --summary s.json");
    plan->callback([command, &status] { status = plan_and_report(*command); });
}

}  // namespace trunnion::app
