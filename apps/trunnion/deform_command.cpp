#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/nc/read.hpp"
#include "trunnion/pipeline/convert.hpp"
#include "trunnion/pipeline/deform.hpp"

#include "commands.hpp"
#include "job.hpp"
#include "written_program.hpp"

namespace trunnion::app {

namespace {

struct DeformCommand {
    JobOptions job;
    WrittenProgram out;
    std::string flank, deflection;
    bool avoid_pole = false, reduce_rotary = false;
    std::string from_height = "0mm", to_height, deepest, most_movement = "1mm", half_angle, outline_radius,
                widest_height = "0mm", residual = "1um", distance = "50mm", fit_tolerance = "0um",
                chord_tolerance = "1um", chord_turn = "0.002deg";
};

/// Rotary words of what is written anyway as short moves.
constexpr double turning_precision_rad = 1e-3 * degree;

/// Reads quantities one after the other and keeps the first error.
class Quantities {
  public:
    double operator()(const char* name, const std::string& text, Dimension wanted) {
        const auto value = parse_quantity(text, wanted);
        if (value) return *value;
        if (!error) {
            error = value.error();
            error->text = fmt::format("{}: {}", name, error->text);
        }
        return 0;
    }
    std::optional<Diagnostic> error;
};

Result<pipeline::FitFlank> flank_of(const DeformCommand& command, Quantities& read) {
    pipeline::FitFlank out;
    if (command.to_height.empty())
        return fail({.code = "PIPE0001",
                     .text = "--flank needs --to-height",
                     .hint = "up to where the tool's side cuts the surface, from its tip"});
    auto curves = pipeline::read_guide_curves(command.flank);
    if (!curves) return fail(curves.error());
    out.guide_curves_mm = std::move(*curves);
    auto& options = out.options;
    options.range.from_height_mm = read("--from-height", command.from_height, dimension::length);
    options.range.to_height_mm = read("--to-height", command.to_height, dimension::length);
    options.most_movement_mm = read("--most-movement", command.most_movement, dimension::length);
    if (!command.deepest.empty()) options.deepest_mm = read("--deepest", command.deepest, dimension::length);
    if (!command.half_angle.empty()) out.half_angle_rad = read("--half-angle", command.half_angle, dimension::angle);
    if (!command.outline_radius.empty()) {
        out.outline_radius_mm = read("--outline-radius", command.outline_radius, dimension::length);
        out.widest_height_mm = read("--widest-height", command.widest_height, dimension::length);
    }
    return out;
}

Result<pipeline::DeformOptions> deform_options(const DeformCommand& command, const Job& job, nc::Dialect dialect) {
    pipeline::DeformOptions out;
    Quantities read;
    out.distance_mm = read("--distance", command.distance, dimension::length);
    out.fit_tolerance_mm = read("--fit-tolerance", command.fit_tolerance, dimension::length);
    if (dialect != nc::Dialect::sinumerik)
        out.chords = deformation::Chords{read("--chord-tolerance", command.chord_tolerance, dimension::length),
                                         read("--chord-turn", command.chord_turn, dimension::angle)};
    const double turn_rad = job.options.smoothing.orientation_tolerance_rad;
    if (!command.flank.empty()) {
        auto flank = flank_of(command, read);
        if (!flank) return fail(flank.error());
        out.aim = std::move(*flank);
    } else if (!command.deflection.empty()) {
        auto samples = pipeline::read_deflections(command.deflection);
        if (!samples) return fail(samples.error());
        out.aim = pipeline::CompensateDeflection{std::move(*samples),
                                                 read("--residual", command.residual, dimension::length)};
    } else if (command.avoid_pole) {
        out.aim = pipeline::AvoidPole{turn_rad};
    } else {
        out.aim = pipeline::ReduceRotary{turn_rad};
    }
    if (read.error) return fail(*read.error);
    return out;
}

Result<pipeline::DeformedProgram> run(const DeformCommand& command) {
    DeformCommand wanted = command;
    auto job = load(command.job);
    if (!job) return fail(job.error());
    if (wanted.out.dialect.empty()) wanted.out.dialect = job->program.dialect;
    auto writing = wanted.out.options();
    if (!writing) return fail(writing.error());
    const auto options = deform_options(command, *job, writing->dialect);
    if (!options) return fail(options.error());
    auto made = pipeline::deform(job->program, job->machine, job->setup, *options);
    if (!made) return made;
    writing->head = {fmt::format("deformed from {} by trunnion " TRUNNION_VERSION,
                                 std::filesystem::path(command.job.program).filename().string()),
                     fmt::format("machine: {}", job->machine.name), wanted.out.precision_text()};
    if (writing->dialect == nc::Dialect::rs274 && job->machine.rotary_count > 0) {
        auto words = pipeline::translate(made->program, job->machine, job->setup, program::OrientationLaw::rotary,
                                         turning_precision_rad);
        if (!words) return fail(words.error());
        made->program = std::move(*words);
    }
    const auto written = pipeline::write_program_file(command.out.file, made->program, &job->machine, *writing);
    if (!written) return fail(written.error());
    for (const auto& diagnostics : {made->program.diagnostics, written->diagnostics})
        for (const Diagnostic& diagnostic : diagnostics) print(diagnostic, command.job.quiet);
    return made;
}

std::string what_changed(const DeformCommand& command, const pipeline::DeformedStretch& stretch) {
    if (!command.flank.empty())
        return fmt::format("peak deviation {:.3g} mm before, {:.3g} mm after", stretch.before, stretch.after);
    if (!command.deflection.empty())
        return fmt::format("deflection up to {:.3g} mm, {:.2g} mm of it left", stretch.before, stretch.after);
    if (command.avoid_pole)
        return fmt::format("rotary velocity {:.3g} of its limit before, {:.3g} after", stretch.before, stretch.after);
    return fmt::format("rotary travel {:.4g} deg before, {:.4g} deg after", stretch.before / degree,
                       stretch.after / degree);
}

int deform_and_report(const DeformCommand& command) {
    const auto made = run(command);
    if (!made) return report_failure(made.error());
    for (const auto& stretch : made->stretches)
        fmt::print("lines {}-{}: {}; tip moved by {:.3g} mm, tool turned by {:.3g} deg\n", stretch.first_line,
                   stretch.last_line, what_changed(command, stretch), stretch.tip_movement_mm,
                   stretch.orientation_change_rad / degree);
    if (made->left_alone > 0) fmt::print("{} stretches with fewer than 4 poses left as they are\n", made->left_alone);
    return done;
}

void add_aims(CLI::App& deform, DeformCommand& command) {
    auto* aim = deform.add_option_group("aim", "one of these");
    aim->add_option("--flank", command.flank, "guide curves of the surface that the tool's side is to leave, CSV");
    aim->add_option("--deflection", command.deflection, "how far the tip is bent away along the path, CSV");
    aim->add_flag("--avoid-pole", command.avoid_pole, "out of the singular cone, within --orientation-tolerance");
    aim->add_flag("--reduce-rotary", command.reduce_rotary, "less rotary motion, within --orientation-tolerance");
    aim->require_option(1);
    deform.add_option("--from-height", command.from_height, "flank: of the tool's side that cuts, from its tip")
        ->capture_default_str();
    deform.add_option("--to-height", command.to_height, "flank: up to here");
    deform.add_option("--deepest", command.deepest, "flank: the tool cuts no deeper into the part than this, e.g. 2um");
    deform.add_option("--most-movement", command.most_movement, "flank: of a control point")->capture_default_str();
    deform.add_option("--half-angle", command.half_angle, "flank: of a cone, e.g. 4deg");
    deform.add_option("--outline-radius", command.outline_radius, "flank: of a barrel, e.g. 250mm");
    deform.add_option("--widest-height", command.widest_height, "flank: of a barrel")->capture_default_str();
    deform.add_option("--residual", command.residual, "deflection: what may be left of it")->capture_default_str();
}

}  // namespace

void add_deform_command(CLI::App& app, int& status) {
    auto command = std::make_shared<DeformCommand>();
    CLI::App* deform = app.add_subcommand("deform", "part program → splines, reshaped for an aim");
    deform->add_option("program", command->job.program, "part program in any dialect that is read")->required();
    add_aims(*deform, *command);
    command->out.add_to(*deform, false);
    command->job.add_to(*deform);
    deform->add_option("--distance", command->distance, "of the two curves of a path")->capture_default_str();
    deform->add_option("--fit-tolerance", command->fit_tolerance, "of the curves from the programmed poses; 0: none")
        ->capture_default_str();
    deform->add_option("--chord-tolerance", command->chord_tolerance, "of straight moves where there are no splines")
        ->capture_default_str();
    deform->add_option("--chord-turn", command->chord_turn, "the same, of the tool axis")->capture_default_str();
    deform->footer(
        "Sinumerik gets B-splines, the other dialects straight moves.\n"
        "Example:\n  trunnion deform blade.cls -m ucp710 --setup blade.toml --flank blade.csv --to-height 30mm --to "
        "sinumerik -o blade.mpf");
    deform->callback([command, &status] { status = deform_and_report(*command); });
}

}  // namespace trunnion::app
