#include <cstdio>
#include <filesystem>
#include <memory>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/nc/read.hpp"
#include "trunnion/pipeline/convert.hpp"
#include "trunnion/pipeline/smooth_program.hpp"

#include "commands.hpp"
#include "job.hpp"
#include "written_program.hpp"

namespace trunnion::app {

namespace {

struct SmoothCommand {
    JobOptions job;
    WrittenProgram out;
    bool points = false;
};

/// Between vectors and words, of what is written anyway as short moves.
constexpr double turning_precision_rad = 1e-3 * degree;

/// Where the control has splines they are used.
pipeline::SmoothedForm form_of(const SmoothCommand& command, nc::Dialect dialect) {
    const bool splines = dialect == nc::Dialect::sinumerik && !command.points;
    return splines ? pipeline::SmoothedForm::curves : pipeline::SmoothedForm::points;
}

/// rs274 has no vectors and apt no rotary words.
Result<void> turn_as_needed(Job& job, nc::Dialect dialect, double precision_rad) {
    const bool needed = dialect == nc::Dialect::rs274 || dialect == nc::Dialect::apt;
    if (!needed || job.machine.rotary_count == 0) return {};
    const auto law = dialect == nc::Dialect::apt ? program::OrientationLaw::vector : program::OrientationLaw::rotary;
    auto translated = pipeline::translate(job.program, job.machine, job.setup, law, precision_rad);
    if (!translated) return fail(translated.error());
    job.program = std::move(*translated);
    return {};
}

void replace_feeds(program::Program& program, double feed_mm_s) {
    for (program::Move& move : program.moves)
        if (move.kind == program::MoveKind::feed) move.feed = {program::FeedRule::tip_speed, feed_mm_s};
}

std::string tolerance_text(const Job& job, const pipeline::SmoothedShares& shares) {
    const auto& tolerances = job.options.smoothing;
    const std::string turn = tolerances.flank_tolerance_mm > 0
                                 ? fmt::format("{:.6g} mm at the flank height", tolerances.flank_tolerance_mm)
                                 : fmt::format("{:.6g} deg", tolerances.orientation_tolerance_rad / degree);
    return fmt::format("tolerances {:.6g} mm and {}, of which {:.0f} % are left to the control",
                       tolerances.tip_tolerance_mm, turn, 100 * (1 - shares.rounding - shares.fitting));
}

Result<pipeline::SmoothedProgram> run(const SmoothCommand& command) {
    SmoothCommand wanted = command;
    auto job = load(command.job);
    if (!job) return fail(job.error());
    if (wanted.out.dialect.empty()) wanted.out.dialect = job->program.dialect;
    auto options = wanted.out.options();
    if (!options) return fail(options.error());
    if (job->options.feed_mm_s) replace_feeds(job->program, *job->options.feed_mm_s);
    if (auto turned = turn_as_needed(*job, options->dialect, turning_precision_rad); !turned)
        return fail(turned.error());
    const pipeline::SmoothedShares shares;
    auto smoothed = pipeline::smooth_program(job->program, job->machine, job->setup, job->options.smoothing,
                                             form_of(wanted, options->dialect), shares);
    if (!smoothed) return smoothed;
    options->head = {fmt::format("smoothed from {} by trunnion " TRUNNION_VERSION,
                                 std::filesystem::path(command.job.program).filename().string()),
                     fmt::format("machine: {}", job->machine.name), tolerance_text(*job, shares),
                     wanted.out.precision_text()};
    std::swap(job->program, smoothed->program);
    const auto written = pipeline::write_program_file(command.out.file, job->program, &job->machine, *options);
    if (!written) return fail(written.error());
    for (const auto& diagnostics : {job->program.diagnostics, written->diagnostics})
        for (const Diagnostic& diagnostic : diagnostics) print(diagnostic, command.job.quiet);
    return smoothed;
}

int smooth_and_report(const SmoothCommand& command) {
    const auto smoothed = run(command);
    if (!smoothed) return report_failure(smoothed.error());
    fmt::print("{} moves smoothed into {}, {} kept; within {:.3g} mm and {:.3g} deg of the program\n",
               smoothed->smoothed_moves, smoothed->written_moves, smoothed->kept_moves, smoothed->tip_deviation_mm,
               smoothed->orientation_deviation_rad / degree);
    return done;
}

}  // namespace

void add_smooth_command(CLI::App& app, int& status) {
    auto command = std::make_shared<SmoothCommand>();
    CLI::App* smooth = app.add_subcommand("smooth", "part program → a smooth part program for the same control");
    smooth->add_option("program", command->job.program, "part program in any dialect that is read")->required();
    command->out.add_to(*smooth, false);
    smooth->add_flag("--points", command->points, "straight moves where the dialect has splines, too");
    command->job.add_to(*smooth);
    smooth->add_option("--feed", command->job.feed, "replaces programmed feeds, e.g. 20m/min");
    smooth
        ->add_option("--rounding", command->job.rounding,
                     "smooth: corners and dense blocks alike; beudaert: every corner on its own")
        ->check(CLI::IsMember({"smooth", "beudaert"}))
        ->capture_default_str();
    smooth
        ->add_option("--corners", command->job.corners,
                     "that stand alone, with smooth rounding: as the rest, or by beudaert")
        ->check(CLI::IsMember({"smooth", "beudaert"}))
        ->capture_default_str();
    smooth->footer(
        "Half of each tolerance is for rounding, a quarter for points or splines, a quarter is left to the control.\n"
        "Example:\n  trunnion smooth part.ngc -m xyzac-trt --setup vice.toml -o smooth.ngc");
    smooth->callback([command, &status] { status = smooth_and_report(*command); });
}

}  // namespace trunnion::app
