#include <chrono>
#include <csignal>
#include <cstdio>
#include <memory>

#include <fmt/format.h>

#include "trunnion/pipeline/plan_files.hpp"
#include "trunnion/pipeline/programmed.hpp"
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

/// The parts of a program, and the time that reading them took.
class TimedParts final : public program::ProgramParts {
  public:
    explicit TimedParts(std::unique_ptr<program::ProgramParts> parts) : parts_(std::move(parts)) {}
    Result<bool> next(program::Program& part) override {
        const auto start = std::chrono::steady_clock::now();
        auto more = parts_->next(part);
        read_s_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        return more;
    }
    double share() const override { return parts_->share(); }
    double read_s() const { return read_s_; }

  private:
    std::unique_ptr<program::ProgramParts> parts_;
    double read_s_ = 0;
};

/// The program is read once more.
Result<void> write_programmed(const PlanCommand& command, const Workplace& workplace) {
    const auto& machine = workplace.machine;
    auto parts = open_program(command.job, workplace);
    if (!parts) return fail(parts.error());
    auto programmed = pipeline::programmed_poses(**parts, machine, workplace.setup, workplace.options.smoothing);
    if (!programmed) return fail(programmed.error());
    return pipeline::write_text_file(command.programmed, verify::programmed_csv(programmed->poses, machine));
}

Result<pipeline::Summary> plan_program(const PlanCommand& command, const Workplace& workplace,
                                       pipeline::PlanObserver& observer) {
    auto opened = open_program(command.job, workplace);
    if (!opened) return fail(opened.error());
    TimedParts parts(std::move(*opened));
    auto summary = pipeline::plan(parts, workplace.machine, workplace.setup, workplace.options, observer);
    if (!summary) return summary;
    summary->work.read_s = parts.read_s();
    const auto& assumed = workplace.diagnostics;
    summary->diagnostics.insert(summary->diagnostics.begin(), assumed.begin(), assumed.end());
    if (!command.programmed.empty())
        if (auto written = write_programmed(command, workplace); !written) return fail(written.error());
    return summary;
}

/// Plans with the files as observer; they take their names when all is well.
Result<pipeline::Summary> run(const PlanCommand& command) {
    auto workplace = load_workplace(command.job);
    if (!workplace) return fail(workplace.error());
    workplace->options.path_samples = !command.path.empty();
    ProgressLine progress(command.job.quiet);
    auto files = pipeline::PlanFiles::create({command.setpoints, command.path, command.events}, workplace->machine,
                                             [&progress](double share) {
                                                 progress.show(share);
                                                 return stop_wanted == 0;
                                             });
    if (!files) return fail(files.error());
    auto summary = plan_program(command, *workplace, **files);
    if (!summary) return summary;
    if (auto written = (*files)->commit(); !written) return fail(written.error());
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
    plan->add_option("program", command->job.program,
                     "part program, plain or gzip'd: APT CL data, RS-274, Sinumerik, Heidenhain or Fanuc")
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
