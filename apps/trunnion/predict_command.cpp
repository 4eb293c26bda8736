#include <cstdio>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/files/controller_file.hpp"
#include "trunnion/pipeline/plan_files.hpp"
#include "trunnion/pipeline/predict.hpp"

#include "commands.hpp"
#include "controllers.hpp"
#include "job.hpp"

namespace trunnion::app {

namespace {

struct PredictCommand {
    JobOptions job;
    std::string controller, against, before, summary, samples, contact_tilt = "0deg";
    bool no_uncertainty = false;
};

/// The controller is never guessed.
Result<motion::Controller> controller_of(const std::string& name) {
    if (!name.empty()) return files::find_controller(name, controller_folders());
    std::string shipped;
    for (const auto& controller : files::shipped_controllers(controller_folders())) shipped += " " + controller.name;
    return fail({.code = "PIPE0006",
                 .text = "no controller given",
                 .hint = fmt::format("give -c with a file or one of:{}", shipped)});
}

/// What is compared with: the same program on another control, or another program on the same one. Nothing: no
/// comparison is asked for.
Result<std::optional<motion::Prediction>> predict_other(const PredictCommand& command, const Job& job,
                                                        const motion::Controller& controller,
                                                        pipeline::PredictionOptions options) {
    if (command.against.empty() && command.before.empty()) return std::nullopt;
    options.uncertainty = false;
    const auto other_controller =
        command.against.empty() ? Result<motion::Controller>(controller) : controller_of(command.against);
    if (!other_controller) return fail(other_controller.error());
    JobOptions before = command.job;
    before.program = command.before;
    const auto other_job = command.before.empty() ? Result<Job>(job) : load(before);
    if (!other_job) return fail(other_job.error());
    auto found =
        pipeline::predict(other_job->program, other_job->machine, other_job->setup, *other_controller, options);
    if (!found) return fail(found.error());
    return std::move(*found);
}

Result<std::string> run(const PredictCommand& command) {
    const auto controller = controller_of(command.controller);
    if (!controller) return fail(controller.error());
    const auto tilt = parse_quantity(command.contact_tilt, dimension::angle);
    if (!tilt) {
        auto error = tilt.error();
        error.text = "--contact-tilt: " + error.text;
        return fail(error);
    }
    auto job = load(command.job);
    if (!job) {
        if (job.error().code == "NC0005")
            job.error().hint = "a control goes to a single position from where it stands, and that nobody knows";
        return fail(job.error());
    }
    const pipeline::PredictionOptions options{
        .plan = job->options, .contact_lead_rad = *tilt, .uncertainty = !command.no_uncertainty};
    std::optional<pipeline::PredictionFile> samples;
    controller::RowTaker take_row;
    if (!command.samples.empty()) {
        auto file = pipeline::PredictionFile::create(command.samples, job->machine);
        if (!file) return fail(file.error());
        samples.emplace(std::move(*file));
        take_row = [&samples](const motion::PredictedRow& row) { samples->write(row); };
    }
    const auto prediction = pipeline::predict(job->program, job->machine, job->setup, *controller, options, take_row);
    if (!prediction) return fail(prediction.error());
    const auto other = predict_other(command, *job, *controller, options);
    if (!other) return fail(other.error());
    const motion::Prediction* compared = *other ? &**other : nullptr;
    if (samples)
        if (auto written = samples->commit(); !written) return fail(written.error());
    if (!command.summary.empty())
        if (auto written =
                pipeline::write_text_file(command.summary, to_json(*prediction, job->machine, options, compared));
            !written)
            return fail(written.error());
    for (const Diagnostic& diagnostic : prediction->diagnostics) print(diagnostic, command.job.quiet);
    return report(*prediction, job->machine, options, compared);
}

int predict_and_report(const PredictCommand& command) {
    const auto text = run(command);
    if (!text) return report_failure(text.error());
    fmt::print("{}", *text);
    return done;
}

}  // namespace

void add_predict_command(CLI::App& app, int& status) {
    auto command = std::make_shared<PredictCommand>();
    CLI::App* predict = app.add_subcommand("predict", "what a given control will make of a part program");
    predict
        ->add_option("program", command->job.program,
                     "part program, plain or gzip'd: APT CL data, RS-274, Sinumerik, Heidenhain or Fanuc")
        ->required();
    predict->add_option("-c,--controller", command->controller, "shipped controller by name, or a controller file");
    CLI::Option* against =
        predict->add_option("--against", command->against, "another controller: by how much they differ, and where");
    predict->add_option("--before", command->before, "this program as it was before a change: what the change gains")
        ->excludes(against);
    predict->add_option("--summary", command->summary, "summary as JSON");
    predict->add_option("--samples", command->samples, "rows of the motion as CSV: axes, feeds, what limits");
    predict
        ->add_option("--contact-tilt", command->contact_tilt,
                     "how far the tool leans along the feed, for the feed at the contact point")
        ->capture_default_str();
    predict->add_flag("--no-uncertainty", command->no_uncertainty, "do not vary what is not identified");
    command->job.add_to(*predict);
    command->job.add_planning_to(*predict);
    predict->footer(
        "Tolerances and what follows --rounding are those of our own planner (controller `ideal`).\n"
        "Example:\n  trunnion predict part.ngc -m ucp710 -c lavernhe-2006 --against ideal --samples p.csv");
    predict->callback([command, &status] { status = predict_and_report(*command); });
}

}  // namespace trunnion::app
