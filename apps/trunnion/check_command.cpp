#include <cstdio>
#include <memory>

#include <fmt/format.h>

#include "trunnion/pipeline/check_setpoints.hpp"
#include "trunnion/pipeline/plan_files.hpp"
#include "trunnion/pipeline/programmed.hpp"

#include "commands.hpp"
#include "job.hpp"

namespace trunnion::app {

namespace {

struct CheckCommand {
    JobOptions job;
    std::string setpoints, summary;
};

struct Checked {
    verify::Verdict verdict;
    std::vector<Diagnostic> diagnostics;
};

Result<Checked> run(const CheckCommand& command) {
    const auto workplace = load_workplace(command.job);
    if (!workplace) return fail(workplace.error());
    const auto& [machine, setup, options, assumed] = *workplace;
    auto parts = open_program(command.job, *workplace);
    if (!parts) return fail(parts.error());
    auto programmed = pipeline::programmed_poses(**parts, machine, setup, options.smoothing);
    if (!programmed) return fail(programmed.error());
    auto verdict = pipeline::check_setpoints(command.setpoints, programmed->poses, machine, setup, options.smoothing);
    if (!verdict) return fail(verdict.error());
    Checked out{std::move(*verdict), std::move(programmed->diagnostics)};
    out.diagnostics.insert(out.diagnostics.end(), assumed.begin(), assumed.end());
    return out;
}

int check_and_report(const CheckCommand& command) {
    const auto checked = run(command);
    if (!checked) return report_failure(checked.error());
    const auto& verdict = checked->verdict;
    if (!command.summary.empty())
        if (auto written = pipeline::write_text_file(command.summary, pipeline::to_json(verdict)); !written)
            return report_failure(written.error());
    for (const Diagnostic& diagnostic : checked->diagnostics) print(diagnostic, command.job.quiet);
    fmt::print("{}", pipeline::report(verdict));
    return verdict.ok ? done : not_usable;
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
