#include <cstdio>
#include <memory>

#include <fmt/format.h>

#include "trunnion/pipeline/check_setpoints.hpp"
#include "trunnion/pipeline/plan_files.hpp"

#include "commands.hpp"
#include "job.hpp"

namespace trunnion::app {

namespace {

struct CheckCommand {
    JobOptions job;
    std::string setpoints, summary;
};

int check_and_report(const CheckCommand& command) {
    const auto job = load(command.job);
    if (!job) return report_failure(job.error());
    const auto verdict =
        pipeline::check_setpoints(command.setpoints, job->program, job->machine, job->setup, job->options.smoothing);
    if (!verdict) return report_failure(verdict.error());
    if (!command.summary.empty())
        if (auto written = pipeline::write_text_file(command.summary, pipeline::to_json(*verdict)); !written)
            return report_failure(written.error());
    for (const Diagnostic& diagnostic : job->program.diagnostics) print(diagnostic, command.job.quiet);
    fmt::print("{}", pipeline::report(*verdict));
    return verdict->ok ? done : not_usable;
}

}  // namespace

void add_check_command(CLI::App& app, int& status) {
    auto command = std::make_shared<CheckCommand>();
    CLI::App* check = app.add_subcommand("check", "independent verdict on setpoints: limits, tolerances, path covered");
    check->add_option("setpoints", command->setpoints, "setpoints: .csv or .csv.gz")->required();
    check->add_option("--against", command->job.program, "the part program they were made from")->required();
    check->add_option("--summary", command->summary, "verdict as JSON");
    command->job.add_to(*check);
    check->add_option("--feed", command->job.feed, "as given to plan, for programs without a feed");
    check->footer("Example:\n  trunnion check setpoints.csv --against part.ngc -m xyzac-trt --setup vice.toml");
    check->callback([command, &status] { status = check_and_report(*command); });
}

}  // namespace trunnion::app
