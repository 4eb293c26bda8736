#include <cmath>
#include <memory>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/pipeline/live_motion.hpp"

#include "play_linuxcnc.hpp"
#include "play_session.hpp"
#include "progress_line.hpp"

namespace trunnion::app {

namespace {

constexpr std::uint64_t more_than_depth = 64;  // of rows that were given

struct PlayOptions {
    JobOptions job;
    bool linuxcnc = false, dry_run = false, wait = false;
    std::string record, lead = "200ms", depth = "100ms";
    double speed = 1;
};

constexpr double least_lead_periods = 5, most_lead_periods = 4000;

Result<std::uint64_t> periods_of(const char* name, const std::string& text, double period_s) {
    const auto time_s = parse_quantity(text, dimension::time);
    if (!time_s) return fail(time_s.error());
    const double periods = std::round(*time_s / period_s);
    if (periods >= least_lead_periods && periods <= most_lead_periods) return static_cast<std::uint64_t>(periods);
    return fail({.code = "RT0011",
                 .text = fmt::format("{} must be 5 to 4000 periods", name),
                 .value = text,
                 .limit = fmt::format("{} s … {} s", least_lead_periods * period_s, most_lead_periods * period_s)});
}

/// All of the program's way, before anything moves.
Result<void> check_program(const PlayOptions& options, const Workplace& workplace) {
    ProgressLine progress(options.job.quiet);
    const auto parts = open_program(options.job, workplace);
    if (!parts) return fail(parts.error());
    return pipeline::check_way(**parts, workplace.machine, workplace.setup, workplace.options, [&](double share) {
        progress.show(share);
        return true;
    });
}

Result<std::unique_ptr<RowSink>> make_sink(const PlayOptions& options, Workplace& workplace, int plans) {
    const double period_s = workplace.options.period_s;
    if (options.dry_run) return std::make_unique<ClockSink>(period_s, options.speed);
    const auto depth = periods_of("--depth", options.depth, period_s);
    if (!depth) return fail(depth.error());
    auto sink = LinuxcncSink::connect(plans);
    if (!sink) return fail(sink.error());
    if (auto good = (*sink)->accept(workplace.machine, period_s, *depth); !good) return fail(good.error());
    workplace.machine = narrowed(workplace.machine, (*sink)->facts(), (*sink)->joints());
    return std::unique_ptr<RowSink>(std::move(*sink));
}

Result<PlaySession> prepare(const PlayOptions& options, Workplace workplace, trunnion_plans& plans) {
    PlaySession out{.job = options.job,
                    .workplace = std::move(workplace),
                    .record = options.record,
                    .waits_for_start = options.wait};
    const auto lead = periods_of("--lead", options.lead, out.workplace.options.period_s);
    if (!lead) return fail(lead.error());
    out.lead_rows = *lead;
    const auto depth = periods_of("--depth", options.depth, out.workplace.options.period_s);
    if (!depth) return fail(depth.error());
    out.kept_rows = *depth + more_than_depth;
    for (const Diagnostic& assumed : out.workplace.diagnostics) print(assumed, options.job.quiet);
    if (auto good = check_program(options, out.workplace); !good) return fail(good.error());
    out.plans = &plans;
    trunnion_plans_begin(out.plans, static_cast<std::uint64_t>(out.workplace.machine.axis_count),
                         out.workplace.options.period_s);
    return out;
}

Result<int> play(const PlayOptions& options) {
    auto workplace = load_workplace(options.job);
    if (!workplace) return fail(workplace.error());
    const SharedPlans shared = share_plans();
    if (!shared.plans) return fail({.code = "RT0012", .text = "no memory to share"});
    const auto sink = make_sink(options, *workplace, shared.descriptor);
    if (!sink) return fail(sink.error());
    auto session = prepare(options, std::move(*workplace), *shared.plans);
    if (!session) return fail(session.error());
    auto record = RowRecord::create(session->record, session->workplace.machine, session->workplace.options.period_s);
    if (!record) return fail(record.error());
    auto planner = fork_process([&](int commands, int news) { return run_planning_side(*session, commands, news); });
    if (!planner) return fail(planner.error());
    return PlayingSide(*session, *planner, **sink, *record).run();
}

int play_and_report(const PlayOptions& options) {
    if (options.linuxcnc == options.dry_run)
        return report_failure(
            {.code = "RT0013", .text = "where the motion goes to is not said", .hint = "give --linuxcnc or --dry-run"});
    const auto status = play(options);
    return status ? *status : report_failure(status.error());
}

}  // namespace

void add_play_command(CLI::App& app, int& status) {
    auto options = std::make_shared<PlayOptions>();
    CLI::App* play = app.add_subcommand("play", "move along a program period by period under the operator's hand");
    play->add_option("program", options->job.program, "part program, plain or gzip'd")->required();
    play->add_flag("--linuxcnc", options->linuxcnc, "into the LinuxCNC that runs on this computer");
    play->add_flag("--dry-run", options->dry_run, "into nothing, by the clock");
    play->add_flag("--wait", options->wait, "begin at the command `start`, not as soon as the program is checked");
    play->add_option("-o,--output", options->record, "the rows as they were handed out: .csv, .csv.gz");
    play->add_option("--lead", options->lead, "time that planning keeps ahead of the rows; commands take that long")
        ->capture_default_str();
    play->add_option("--depth", options->depth, "time that rows keep ahead of LinuxCNC")->capture_default_str();
    play->add_option("--speed", options->speed, "of the clock of --dry-run")
        ->check(CLI::Range(0.1, 1000.0))
        ->capture_default_str();
    options->job.add_to(*play);
    options->job.add_planning_to(*play);
    play->footer(
        "Commands, one a line on stdin: start, hold, resume, stop, single on|off, override PERCENT (0…200),\n"
        "rapid PERCENT (0…100). `resume` also answers M0, T words and other events that stop the motion.\n"
        "Ctrl-C is stop. Not a safety function: E-stop and limit switches stay what they are.\n"
        "Example:\n  trunnion play part.ngc -m xyzac-trt --setup vice.toml --dry-run --speed 50 -o rows.csv");
    play->callback([options, &status] { status = play_and_report(*options); });
}

}  // namespace trunnion::app
