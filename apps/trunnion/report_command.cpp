#include <csignal>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/files/controller_file.hpp"
#include "trunnion/files/output_file.hpp"
#include "trunnion/pipeline/predict.hpp"
#include "trunnion/report/page.hpp"
#include "trunnion/smoothing/pole_tolerance.hpp"

#include "commands.hpp"
#include "controllers.hpp"
#include "job.hpp"
#include "progress_line.hpp"

namespace trunnion::app {

namespace {

volatile std::sig_atomic_t stop_wanted = 0;

struct ReportCommand {
    JobOptions job;
    std::string page, controller, before, contact_tilt = "0deg";
};

/// A word as a shell takes it back.
std::string shell_word(const std::string& word) {
    constexpr std::string_view plain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=:,./@%";
    if (!word.empty() && word.find_first_not_of(plain) == std::string::npos) return word;
    std::string out = "'";
    for (const char c : word) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return out + "'";
}

/// The command line as it was typed.
std::string command_line() {
    std::ifstream file("/proc/self/cmdline", std::ios::binary);
    const std::string words{std::istreambuf_iterator<char>(file), {}};
    std::string out = "trunnion";
    for (std::size_t at = words.find('\0') + 1; at != 0 && at < words.size(); at = words.find('\0', at) + 1)
        out += " " + shell_word(words.c_str() + at);
    return out;
}

class ObservedPlan : public report::PlanRecording {
  public:
    ObservedPlan(report::RecordedJob job, std::string label, double period_s, ProgressLine& line)
        : PlanRecording(job, std::move(label), period_s), line_(line) {}
    bool progress(double share) override {
        line_.show(share);
        return stop_wanted == 0;
    }

  private:
    ProgressLine& line_;
};

/// One motion of the page, and what is told of it beside its rows.
struct Run {
    std::optional<report::Recording> recording;
    std::vector<report::PlanRecording::TimedEvent> events;
    std::string json;
    std::optional<Diagnostic> failure;
};

report::RecordedJob recorded(const Job& job, double contact_lead_rad) {
    return {job.program, job.machine, job.setup, smoothing::pole_tolerance_rad(job.options.smoothing),
            contact_lead_rad};
}

Run planned(const Job& job, const std::string& label, double contact_lead_rad, bool quiet,
            std::optional<pipeline::Summary>& summary) {
    pipeline::PlanOptions options = job.options;
    options.setpoint_limits = true;
    ProgressLine line(quiet);
    ObservedPlan observer(recorded(job, contact_lead_rad), label, options.period_s, line);
    auto made = pipeline::plan(job.program, job.machine, job.setup, options, observer);
    Run out;
    if (made) {
        made->work.read_s = job.read_s;
        out.json = to_json(*made);
        summary = std::move(*made);
    } else {
        out.failure = made.error();
    }
    out.recording.emplace(observer.take());
    out.events = observer.events();
    return out;
}

Result<Run> predicted(const Job& job, const motion::Controller& controller, double contact_lead_rad) {
    const pipeline::PredictionOptions options{.plan = job.options, .contact_lead_rad = contact_lead_rad};
    report::PredictionRecording rows(recorded(job, contact_lead_rad), controller.name);
    const auto prediction = pipeline::predict(job.program, job.machine, job.setup, controller, options,
                                              [&rows](const motion::PredictedRow& row) { rows.add(row); });
    if (!prediction) return fail(prediction.error());
    Run out;
    out.recording.emplace(rows.take());
    out.json = to_json(*prediction, job.machine, options);
    return out;
}

/// The other program's plan, with the same options. The job has to outlive the run.
Result<Run> planned_before(const ReportCommand& command, double contact_lead_rad, std::optional<Job>& job) {
    JobOptions options = command.job;
    options.program = command.before;
    auto loaded = load(options);
    if (!loaded) return fail(loaded.error());
    job.emplace(std::move(*loaded));
    std::optional<pipeline::Summary> summary;
    Run out = planned(*job, "before: " + job->program.name, contact_lead_rad, command.job.quiet, summary);
    if (out.failure) return fail(*out.failure);
    return out;
}

void add(const Run& run, report::PageContent& content) {
    content.runs.push_back(&*run.recording);
    content.other_json.push_back(run.json);
}

Result<double> contact_lead(const ReportCommand& command) {
    const auto tilt = parse_quantity(command.contact_tilt, dimension::angle);
    if (tilt) return tilt;
    auto error = tilt.error();
    error.text = "--contact-tilt: " + error.text;
    return fail(error);
}

Result<std::optional<motion::Controller>> controller_of(const ReportCommand& command) {
    if (command.controller.empty()) return std::nullopt;
    auto found = files::find_controller(command.controller, controller_folders());
    if (!found) return fail(found.error());
    return std::move(*found);
}

int tell(const ReportCommand& command, const pipeline::Summary& summary) {
    for (const Diagnostic& diagnostic : summary.diagnostics) print(diagnostic, command.job.quiet);
    fmt::print("{}: {:.3f} s, {} setpoints, {}\n", command.page, summary.cycle_time_s, summary.setpoints,
               summary.usable() ? "all limits and tolerances hold" : "NOT USABLE: a limit or a tolerance is broken");
    return summary.usable() ? done : not_usable;
}

/// The exit status where the plan went well. Where it did not, the page is written as far as it came.
Result<int> run(const ReportCommand& command) {
    const auto lead_rad = contact_lead(command);
    if (!lead_rad) return fail(lead_rad.error());
    const auto controller = controller_of(command);
    if (!controller) return fail(controller.error());
    const auto job = load(command.job);
    if (!job) return fail(job.error());
    if (auto there = report::page_is_there(); !there) return fail(there.error());
    auto text = files::read_whole_file(command.job.program);
    if (!text) return fail(text.error());

    std::optional<pipeline::Summary> summary;
    const Run plan = planned(*job, "plan", *lead_rad, command.job.quiet, summary);
    if (plan.failure && plan.failure->code == "PIPE0002") return fail(*plan.failure);
    report::PageContent content{.program_name = job->program.name,
                                .program_text = std::move(*text),
                                .command = command_line(),
                                .machine = &job->machine,
                                .setup = &job->setup,
                                .summary_json = plan.json,
                                .failure = plan.failure,
                                .events = plan.events,
                                .runs = {&*plan.recording}};
    std::optional<Job> job_before;
    std::optional<Result<Run>> before, prediction;
    if (!command.before.empty()) {
        before.emplace(planned_before(command, *lead_rad, job_before));
        if (!*before) return fail(before->error());
        add(**before, content);
    }
    if (*controller) {
        prediction.emplace(predicted(*job, **controller, *lead_rad));
        if (!*prediction) return fail(prediction->error());
        add(**prediction, content);
    }
    if (auto written = report::write_page(command.page, content); !written) return fail(written.error());
    if (plan.failure) {
        fmt::print("{}: the plan as far as it came\n", command.page);
        return fail(*plan.failure);
    }
    return tell(command, *summary);
}

int report_and_tell(const ReportCommand& command) {
    std::signal(SIGINT, [](int) { stop_wanted = 1; });
    const auto status = run(command);
    return status ? *status : report_failure(status.error());
}

}  // namespace

void add_report_command(CLI::App& app, int& status) {
    auto command = std::make_shared<ReportCommand>();
    CLI::App* report = app.add_subcommand("report", "one page for a browser that shows where the time goes");
    report
        ->add_option("program", command->job.program,
                     "part program: APT CL data, RS-274 (LinuxCNC), Sinumerik, Heidenhain or Fanuc")
        ->required();
    report->add_option("-o,--output", command->page, "the page, one HTML file")->required();
    report->add_option("-c,--controller", command->controller,
                       "also what this control will make of the program: shipped by name, or a controller file");
    report->add_option("--before", command->before, "also this program as it was before a change");
    report
        ->add_option("--contact-tilt", command->contact_tilt,
                     "how far the tool leans along the feed, for the feed at the contact point")
        ->capture_default_str();
    command->job.add_to(*report);
    command->job.add_planning_to(*report);
    report->add_flag("--worth", command->job.worth,
                     "what 10 % more of each limit and twice each tolerance would save, by planning again with it");
    report->footer(
        "The page needs no network and no server: open it by a double click.\n"
        "Example:\n  trunnion report part.ngc -m xyzac-trt --setup vice.toml --worth -o part.html");
    report->callback([command, &status] { status = report_and_tell(*command); });
}

}  // namespace trunnion::app
