#include <algorithm>
#include <csignal>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "trunnion/pipeline/plan_files.hpp"
#include "trunnion/pipeline/surface.hpp"
#include "trunnion/pipeline/surface_motion.hpp"
#include "trunnion/pipeline/surface_motion_check.hpp"
#include "trunnion/verify/programmed_csv.hpp"

#include "commands.hpp"
#include "job.hpp"
#include "progress_line.hpp"
#include "surface_options.hpp"
#include "surface_part.hpp"

namespace trunnion::app {

namespace {

volatile std::sig_atomic_t stop_wanted = 0;

struct SurfaceRunCommand {
    SurfaceText surface;
    SurfacePartText part;
    JobOptions job;
    std::string setpoints, summary, programmed, order = "corrector", feed_of = "contact";
    bool ahead = false;
};

const std::map<std::string, interpolation::StepOrder> orders{{"1", interpolation::StepOrder::first},
                                                             {"2", interpolation::StepOrder::second},
                                                             {"corrector", interpolation::StepOrder::corrected}};

pipeline::SurfaceMotionOptions motion_options(const SurfaceRunCommand& command, const Workplace& workplace) {
    pipeline::SurfaceMotionOptions out{.plan = workplace.options, .order = orders.at(command.order)};
    if (command.feed_of == "tip") out.feed_point = interpolation::FeedPoint::tip;
    return out;
}

/// What is moved over, and where the plan of it came from.
Result<pipeline::SurfaceResult> planned(const SurfaceRunCommand& command, const SurfaceWork& work,
                                        const SurfacePart& part) {
    pipeline::SurfaceProgramOptions options{.passes = work.options, .others = part.others, .holder = part.holder};
    if (command.part.free_gouges) {
        const auto limits = lean_limits(command.part, work);
        if (!limits) return fail(limits.error());
        options.freeing = *limits;
    }
    return pipeline::make_surface_program(work.faces, work.cutter, options);
}

/// Passes that are laid while others are moved know nothing of a program.
Result<pipeline::SurfaceMotionSummary> run_ahead(const SurfaceRunCommand& command, const SurfaceWork& work,
                                                 const SurfacePart& part, const Workplace& workplace,
                                                 pipeline::PlanObserver& observer) {
    if (work.faces.size() != 1 || work.options.strategy != surfacing::Strategy::lin_koren ||
        !command.programmed.empty() || command.part.free_gouges)
        return fail({.code = "PIPE0134",
                     .text = "--ahead lays passes of one face by strategy lin-koren, without --programmed and "
                             "--free-gouges"});
    return pipeline::move_surface_ahead(work.faces.front(), work.cutter, work.options, workplace.machine,
                                        workplace.setup, motion_options(command, workplace), observer, part.others,
                                        part.holder);
}

Result<pipeline::SurfaceMotionSummary> run_planned(const SurfaceRunCommand& command, const SurfaceWork& work,
                                                   const SurfacePart& part, const Workplace& workplace,
                                                   pipeline::PlanObserver& observer) {
    const auto made = planned(command, work, part);
    if (!made) return fail(made.error());
    const surfacing::SurfacePlan& plan = made->plan;
    if (!command.programmed.empty()) {
        const auto poses = pipeline::programmed_poses(plan, workplace.machine, workplace.setup);
        if (!poses) return fail(poses.error());
        const auto written =
            pipeline::write_text_file(command.programmed, verify::programmed_csv(*poses, workplace.machine));
        if (!written) return fail(written.error());
    }
    auto moved = pipeline::move_surface(plan, work.faces, work.options, workplace.machine, workplace.setup,
                                        motion_options(command, workplace), observer);
    if (!moved) return moved;
    moved->freed = made->freed;
    const auto& told = plan.program.diagnostics;
    moved->motion.diagnostics.insert(moved->motion.diagnostics.end(), told.begin(), told.end());
    return moved;
}

/// What there is to move over, and what is not to be touched.
struct Scene {
    Workplace workplace;
    SurfaceWork work;
    SurfacePart part;
    std::vector<Diagnostic> told;
};

Result<Scene> load_scene(const SurfaceRunCommand& command) {
    auto workplace = load_workplace(command.job);
    if (!workplace) return fail(workplace.error());
    auto work = load_surface(command.surface, workplace->setup);
    if (!work) return fail(work.error());
    workplace->setup.tool = work->tool;
    std::vector<Diagnostic> told = work->list.diagnostics;
    told.insert(told.end(), workplace->diagnostics.begin(), workplace->diagnostics.end());
    auto part = read_part(command.part, command.surface, *work);
    if (!part) return fail(part.error());
    told.insert(told.end(), part->told.begin(), part->told.end());
    return Scene{std::move(*workplace), std::move(*work), std::move(*part), std::move(told)};
}

/// The part is looked at always; where it is too fine for that, and nothing was said of it, that is told.
Result<void> look_at(const SurfaceRunCommand& command, const Scene& scene, pipeline::MotionInPart& motion,
                     pipeline::SurfaceMotionSummary& summary) {
    auto in_part = motion.check(scene.part.with(scene.work.faces), scene.work.options.gouge_tolerance_mm);
    if (!in_part && !command.part.part.empty()) return fail(in_part.error());
    if (in_part)
        summary.part = std::move(*in_part);
    else
        summary.motion.diagnostics.push_back(
            {.code = "PIPE0118",
             .severity = Severity::warning,
             .text = "whether the tool goes into the part was not looked at: " + in_part.error().text,
             .hint = "--part FILE:3,5 with the faces that are near"});
    return {};
}

Result<pipeline::SurfaceMotionSummary> run(const SurfaceRunCommand& command) {
    const auto scene = load_scene(command);
    if (!scene) return fail(scene.error());
    const auto& [workplace, work, part, told] = *scene;
    const auto kinematics =
        machine::Kinematics::make(workplace.machine, workplace.setup.workpiece, workplace.setup.tool.length_mm);
    if (!kinematics) return fail(kinematics.error());
    ProgressLine progress(command.job.quiet);
    auto files =
        pipeline::PlanFiles::create({.setpoints = command.setpoints}, workplace.machine, [&progress](double share) {
            progress.show(share);
            return stop_wanted == 0;
        });
    if (!files) return fail(files.error());
    pipeline::MotionInPart motion(*kinematics, work.cutter, part.holder, **files);
    auto summary = command.ahead ? run_ahead(command, work, part, workplace, motion)
                                 : run_planned(command, work, part, workplace, motion);
    if (!summary) return summary;
    summary->motion.diagnostics.insert(summary->motion.diagnostics.begin(), told.begin(), told.end());
    summary->motion.program = command.surface.file;
    if (auto looked = look_at(command, *scene, motion, *summary); !looked) return fail(looked.error());
    if (auto written = (*files)->commit(); !written) return fail(written.error());
    if (!command.summary.empty())
        if (auto written = pipeline::write_text_file(command.summary, to_json(*summary)); !written)
            return fail(written.error());
    return summary;
}

int run_and_report(const SurfaceRunCommand& command) {
    std::signal(SIGINT, [](int) { stop_wanted = 1; });
    const auto summary = run(command);
    if (!summary) return report_failure(summary.error());
    for (const Diagnostic& diagnostic : summary->motion.diagnostics) print(diagnostic, command.job.quiet);
    fmt::print("{}", summary->report());
    return summary->usable() ? done : not_usable;
}

/// Without what takes passes apart, and what simulates them.
void add_part_to(CLI::App& run, SurfacePartText& part) {
    part.add_to(run);
    run.remove_option(run.get_option("--leave-out"));
    run.get_option("--free-gouges")
        ->description(
            "leans the tool out of what it goes into; ridges of tools that are no balls change with the lean: surface "
            "plan simulates them");
}

}  // namespace

void add_surface_run_command(CLI::App& surface, int& status) {
    auto command = std::make_shared<SurfaceRunCommand>();
    JobOptions& job = command->job;
    CLI::App* run = surface.add_subcommand("run", "faces → axis setpoints, interpolated on the surface itself");
    command->surface.add_surface_to(*run);
    run->add_option("-m,--machine", job.machine, "shipped machine by name, or a machine file");
    run->add_option("--setup", job.setup, "setup file: tools, and where the workpiece stands");
    command->surface.add_passes_to(*run, "along the passes: of the contact, or see --feed-of");
    add_part_to(*run, command->part);
    run->add_option("-o,--output", command->setpoints, "setpoints: .csv, .csv.gz or .npy");
    run->add_option("--summary", command->summary, "summary as JSON");
    run->add_option("--programmed", command->programmed, "poses of the passes and links as CSV");
    run->add_option("--order", command->order, "of the parameter's step: Taylor's series, or Newton's correction of it")
        ->check(CLI::IsMember({"1", "2", "corrector"}))
        ->capture_default_str();
    run->add_option("--feed-of", command->feed_of, "which point the feed is of")
        ->check(CLI::IsMember({"contact", "tip"}))
        ->capture_default_str();
    run->add_flag(
        "--ahead", command->ahead,
        "lin-koren: passes are laid and planned, one after another, while others are moved, as a control would");
    run->add_option("--tip-tolerance", job.tip_tolerance, "of links")->capture_default_str();
    run->add_option("--orientation-tolerance", job.orientation_tolerance, "of links")->capture_default_str();
    run->add_option("--calm", job.calm, "weight of smoothness against time, 0 … 1")
        ->check(CLI::Range(0.0, 1.0))
        ->capture_default_str();
    run->add_option("--jerk-margin", job.jerk_margin, "share of the axes' jerk to leave unused")->capture_default_str();
    run->add_option("--period", job.period, "of the setpoints")->capture_default_str();
    run->add_flag("-q,--quiet", job.quiet, "no warnings, no progress");
    run->footer(
        "Example:\n  trunnion surface run dome.toml --tool \"flat 12mm\" -m xyzac-trt --setup vice.toml "
        "-o setpoints.csv");
    run->callback([command, &status] { status = run_and_report(*command); });
}

}  // namespace trunnion::app
