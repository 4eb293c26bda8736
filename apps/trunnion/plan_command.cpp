#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <system_error>

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

Result<void> write_programmed(const PlanCommand& command, const Job& job) {
    const auto stands = path::choose_rotary_stands(job.program, job.machine, job.setup,
                                                   smoothing::pole_tolerance_rad(job.options.smoothing));
    if (!stands) return fail(stands.error());
    auto poses = verify::programmed_poses(job.program, job.machine, job.setup, *stands);
    if (!poses) return fail(poses.error());
    return pipeline::write_text_file(command.programmed, verify::programmed_csv(*poses, job.machine));
}

/// Up to this size a program is planned as a whole: branch and winding are chosen over all of it, as `check` does.
/// About two million blocks, 400 MB; packed ones hold some eight times as much.
bool is_small(const std::filesystem::path& program) {
    constexpr std::uintmax_t plain = 100'000'000, packed = plain / 8;
    std::error_code error;
    const std::uintmax_t size = std::filesystem::file_size(program, error);
    return error || size <= (program.extension() == ".gz" ? packed : plain);
}

/// Else it is planned while it is read.
bool needs_whole_program(const PlanCommand& command) {
    return !command.programmed.empty() || command.job.worth || is_small(command.job.program);
}

Result<pipeline::Summary> plan_whole(const PlanCommand& command, const Job& job, pipeline::PlanObserver& observer) {
    auto summary = pipeline::plan(job.program, job.machine, job.setup, job.options, observer);
    if (summary) summary->work.read_s = job.read_s;
    if (summary && !command.programmed.empty())
        if (auto written = write_programmed(command, job); !written) return fail(written.error());
    return summary;
}

Result<pipeline::Summary> plan_in_parts(const PlanCommand& command, const Workplace& workplace,
                                        pipeline::PlanObserver& observer) {
    auto opened = open_program(command.job, workplace.machine);
    if (!opened) return fail(opened.error());
    TimedParts parts(std::move(*opened));
    auto summary = pipeline::plan(parts, workplace.machine, workplace.setup, workplace.options, observer);
    if (!summary) return summary;
    summary->work.read_s = parts.read_s();
    const auto& assumed = workplace.diagnostics;
    summary->diagnostics.insert(summary->diagnostics.begin(), assumed.begin(), assumed.end());
    return summary;
}

/// Plans with the files as observer; they take their names when all is well.
template <class Plan>
Result<pipeline::Summary> plan_into_files(const PlanCommand& command, const Workplace& workplace, const Plan& plan) {
    ProgressLine progress(command.job.quiet);
    auto files = pipeline::PlanFiles::create({command.setpoints, command.path, command.events}, workplace.machine,
                                             [&progress](double share) {
                                                 progress.show(share);
                                                 return stop_wanted == 0;
                                             });
    if (!files) return fail(files.error());
    auto summary = plan(**files);
    if (!summary) return summary;
    if (auto written = (*files)->commit(); !written) return fail(written.error());
    if (!command.summary.empty())
        if (auto written = pipeline::write_text_file(command.summary, to_json(*summary)); !written)
            return fail(written.error());
    return summary;
}

Result<pipeline::Summary> run(const PlanCommand& command) {
    if (needs_whole_program(command)) {
        auto job = load(command.job);
        if (!job) return fail(job.error());
        job->options.path_samples = !command.path.empty();
        return plan_into_files(command, *job, [&](auto& files) { return plan_whole(command, *job, files); });
    }
    auto workplace = load_workplace(command.job);
    if (!workplace) return fail(workplace.error());
    workplace->options.path_samples = !command.path.empty();
    return plan_into_files(command, *workplace, [&](auto& files) { return plan_in_parts(command, *workplace, files); });
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
