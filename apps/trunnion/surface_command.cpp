#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/files/setup_file.hpp"
#include "trunnion/files/shipped_machines.hpp"
#include "trunnion/pipeline/convert.hpp"
#include "trunnion/pipeline/plan_files.hpp"
#include "trunnion/pipeline/surface.hpp"
#include "trunnion/pipeline/surface_summary.hpp"

#include "commands.hpp"
#include "job.hpp"
#include "surface_options.hpp"
#include "surface_part.hpp"
#include "written_program.hpp"

namespace trunnion::app {

namespace {

struct SurfacePlanCommand {
    SurfaceText surface;
    SurfacePartText part;
    WrittenProgram out;
    std::string machine, setup, curves = "points", spindle, summary;
    bool check = false, quiet = false;
};

/// Rotary words of what is written anyway as short moves.
constexpr double turning_precision_rad = 1e-3 * degree;

/// Of the name of the program that is written; empty: it does not say.
std::string dialect_of(const std::filesystem::path& file) {
    const std::filesystem::path name = file.extension() == ".gz" ? file.stem() : file;
    const std::string ending = name.extension().string();
    const std::pair<const char*, const char*> known[] = {{".ngc", "rs274"}, {".mpf", "sinumerik"}, {".h", "heidenhain"},
                                                         {".cls", "apt"},   {".apt", "apt"},       {".nc", "fanuc"}};
    const auto* found = std::ranges::find(known, ending, [](const auto& row) { return row.first; });
    return found == std::end(known) ? "" : found->second;
}

Result<nc::WriteOptions> writing_options(const SurfacePlanCommand& command) {
    WrittenProgram out = command.out;
    if (out.dialect.empty()) out.dialect = dialect_of(out.file);
    if (out.dialect.empty())
        return fail({.code = "PIPE0001",
                     .text = "the dialect to write is not known by the name of the output",
                     .value = out.file,
                     .hint = "give --to, or a name that ends in .ngc, .mpf, .h, .nc or .cls"});
    const bool splines = command.curves == "splines";
    if (splines && out.dialect != "sinumerik")
        return fail({.code = "PIPE0115",
                     .text = "splines of passes with tool vectors are written in sinumerik alone",
                     .value = out.dialect,
                     .hint = "--to sinumerik, or --curves points"});
    out.curves = splines ? "dialect" : "points";
    return out.options();
}

/// Machine and setup, where they are given.
struct Place {
    std::optional<machine::Machine> machine;
    machine::Setup setup;
};

Result<Place> read_place(const SurfacePlanCommand& command, nc::Dialect dialect) {
    Place out;
    if (command.machine.empty() && dialect == nc::Dialect::rs274)
        return fail({.code = "PIPE0004",
                     .text = "no machine given: rs274 is written with its rotary words",
                     .hint = "give -m and the setup of the workpiece, or --to sinumerik, heidenhain, fanuc or apt"});
    if (!command.machine.empty()) {
        auto machine = files::find_machine(command.machine, machine_folders());
        if (!machine) return fail(machine.error());
        out.machine = std::move(*machine);
    }
    if (!command.setup.empty()) {
        auto setup = files::read_setup_file(command.setup);
        if (!setup) return fail(setup.error());
        out.setup = std::move(*setup);
    }
    return out;
}

Result<pipeline::SurfaceProgramOptions> program_options(const SurfacePlanCommand& command, const SurfaceWork& work) {
    pipeline::SurfaceProgramOptions out{
        .passes = work.options, .splines = command.curves == "splines", .tool_name = work.tool_name};
    if (command.spindle.empty()) return out;
    auto turning = parse_quantity(command.spindle, dimension::angular_velocity);
    if (!turning) {
        turning.error().text = fmt::format("--spindle: {}", turning.error().text);
        return fail(turning.error());
    }
    out.spindle_rad_s = *turning;
    return out;
}

/// RS-274 has no tool vectors.
Result<void> to_rotary_words(program::Program& program, const Place& place) {
    if (place.machine->rotary_count == 0) return {};
    auto words = pipeline::translate(program, *place.machine, place.setup, program::OrientationLaw::rotary,
                                     turning_precision_rad);
    if (!words) return fail(words.error());
    program = std::move(*words);
    return {};
}

std::string tool_text(const SurfaceWork& work) {
    const auto& tool = work.tool;
    const char* kind = tool.kind == machine::ToolKind::flat   ? "flat"
                       : tool.kind == machine::ToolKind::ball ? "ball"
                                                              : "torus";
    const std::string corner = tool.kind == machine::ToolKind::torus
                                   ? fmt::format(", corner radius {:g} mm", tool.corner_radius_mm)
                                   : std::string();
    const std::string name = work.tool_name.empty() ? "" : fmt::format("T{}: ", work.tool_name);
    return fmt::format("{}{} of {:g} mm{}", name, kind, tool.diameter_mm, corner);
}

Result<void> write(const SurfacePlanCommand& command, const Place& place, const SurfaceWork& work,
                   nc::WriteOptions writing, program::Program program, pipeline::SurfaceSummary& summary) {
    program.name = std::filesystem::path(command.out.file).stem().string();
    writing.head = {
        fmt::format("surface {} planned by trunnion " TRUNNION_VERSION,
                    std::filesystem::path(command.surface.file).filename().string()),
        fmt::format("{}; {}; scallop {}", tool_text(work), command.surface.strategy, command.surface.scallop),
        command.out.precision_text()};
    if (writing.dialect == nc::Dialect::rs274)
        if (auto turned = to_rotary_words(program, place); !turned) return turned;
    const auto written =
        pipeline::write_program_file(command.out.file, program, place.machine ? &*place.machine : nullptr, writing);
    if (!written) return fail(written.error());
    for (const auto& told : {program.diagnostics, written->diagnostics})
        summary.diagnostics.insert(summary.diagnostics.end(), told.begin(), told.end());
    summary.output = fmt::format("{} ({})", command.out.file, nc::name_of(writing.dialect));
    return {};
}

pipeline::SurfaceSummary summary_of(const SurfacePlanCommand& command, const SurfaceWork& work,
                                    const pipeline::SurfaceResult& made) {
    const auto& plan = made.plan;
    pipeline::SurfaceSummary out{.surface = command.surface.file,
                                 .tool = tool_text(work),
                                 .strategy = command.surface.strategy,
                                 .faces_in_file = work.list.faces_in_file,
                                 .options = work.options,
                                 .passes = plan.passes.size(),
                                 .contacts = made.contacts,
                                 .moves = plan.program.moves.size(),
                                 .cut_length_mm = plan.cut_length_mm,
                                 .least_interval_mm = plan.least_interval_mm,
                                 .largest_interval_mm = plan.largest_interval_mm,
                                 .highest_ridge_mm = plan.highest_ridge_mm,
                                 .splines = made.splines,
                                 .freed = made.freed,
                                 .left = made.left,
                                 .diagnostics = work.list.diagnostics};
    for (const auto& face : work.faces) out.faces.push_back(pipeline::facts_of(face));
    return out;
}

/// Where a tool does not fit, with what would: passes are refused at the first such place, and that is not the worst.
Diagnostic with_what_fits(Diagnostic error, const SurfaceWork& work) {
    if (error.code == "SURF0204") error.hint += ", or --free-gouges";
    if (error.code == "SURF0203" || error.code == "SURF0204" || error.code == "SURF0209" || error.code == "SURF0210")
        error.hint += ", or --leave-out";
    if (error.code != "SURF0203") return error;
    double hollow_mm = HUGE_VAL;
    for (const auto& face : work.faces) hollow_mm = std::min(hollow_mm, pipeline::facts_of(face).hollow_radius_mm);
    error.hint += fmt::format("; the hollowest place of what is machined has {:.4g} mm", hollow_mm);
    return error;
}

Result<pipeline::SurfaceResult> make_program(const SurfacePlanCommand& command, const SurfaceWork& work,
                                             const SurfacePart& part) {
    auto options = program_options(command, work);
    if (!options) return fail(options.error());
    if (command.part.free_gouges) {
        const auto limits = lean_limits(command.part, work);
        if (!limits) return fail(limits.error());
        options->freeing = *limits;
    }
    options->passes.leave_out = command.part.leave_out;
    options->others = part.others;
    options->holder = part.holder;
    auto made = pipeline::make_surface_program(work.faces, work.cutter, *options);
    if (!made) return fail(with_what_fits(made.error(), work));
    return made;
}

/// The part is looked at always; where it is too fine for that, and nothing was said of it, that is told.
Result<void> look_at(const SurfacePlanCommand& command, const SurfaceWork& work, const SurfacePart& part,
                     const pipeline::SurfaceResult& made, pipeline::SurfaceSummary& summary) {
    const auto faces = part.with(work.faces);
    if (command.check || command.part.free_gouges || command.part.leave_out) {
        auto check = pipeline::check_surface_program(work.faces, faces, work.cutter, made, work.options, part.holder);
        if (!check) return fail(check.error());
        summary.part = *check;
        summary.check = std::move(*check);
        return {};
    }
    auto in_part = pipeline::check_part(faces, work.cutter, made, work.options.gouge_tolerance_mm, part.holder);
    if (!in_part && !command.part.part.empty()) return fail(in_part.error());
    if (in_part)
        summary.part = std::move(*in_part);
    else
        summary.diagnostics.push_back(
            {.code = "PIPE0118",
             .severity = Severity::warning,
             .text = "whether the tool goes into the part was not looked at: " + in_part.error().text,
             .hint = "--part FILE:3,5 with the faces that are near"});
    return {};
}

Result<pipeline::SurfaceSummary> run(const SurfacePlanCommand& command) {
    const auto writing = writing_options(command);
    if (!writing) return fail(writing.error());
    const auto place = read_place(command, writing->dialect);
    if (!place) return fail(place.error());
    const auto work = load_surface(command.surface, place->setup);
    if (!work) return fail(work.error());
    const auto part = read_part(command.part, command.surface, *work);
    if (!part) return fail(part.error());
    auto made = make_program(command, *work, *part);
    if (!made) return fail(made.error());
    auto summary = summary_of(command, *work, *made);
    summary.part_file = part->file;
    summary.diagnostics.insert(summary.diagnostics.end(), part->told.begin(), part->told.end());
    if (auto done = look_at(command, *work, *part, *made, summary); !done) return fail(done.error());
    if (summary.check && summary.check->verdict.left_mm2 > 0)
        summary.diagnostics.push_back({.code = "PIPE0122",
                                       .severity = Severity::warning,
                                       .text = "the tool does not reach all of the faces; what it does not is left out",
                                       .value = fmt::format("{:.4g} mm² of {:.4g} mm²", summary.check->verdict.left_mm2,
                                                            summary.check->verdict.area_mm2),
                                       .hint = "a smaller tool, or another lead or tilt, for what is left"});
    if (auto done = write(command, *place, *work, *writing, std::move(made->plan.program), summary); !done)
        return fail(done.error());
    if (!command.summary.empty())
        if (auto done = pipeline::write_text_file(command.summary, to_json(summary)); !done) return fail(done.error());
    return summary;
}

int plan_and_report(const SurfacePlanCommand& command) {
    const auto summary = run(command);
    if (!summary) return report_failure(summary.error());
    for (const Diagnostic& diagnostic : summary->diagnostics) print(diagnostic, command.quiet);
    fmt::print("{}", report(*summary));
    return summary->usable() ? done : not_usable;
}

int list_faces(const std::string& file, bool quiet) {
    const auto list = pipeline::read_surface_faces(file);
    if (!list) return report_failure(list.error());
    for (const Diagnostic& diagnostic : list->diagnostics) print(diagnostic, quiet);
    fmt::print("{}", pipeline::report(*list));
    return done;
}

void add_plan(CLI::App& surface, int& status) {
    auto command = std::make_shared<SurfacePlanCommand>();
    CLI::App* plan = surface.add_subcommand("plan", "faces → part program of passes over them");
    command->surface.add_surface_to(*plan);
    plan->add_option("--setup", command->setup, "setup file: tools, and where the workpiece stands");
    plan->add_option("-m,--machine", command->machine,
                     "shipped machine by name, or a machine file; rs274 is written with its rotary words");
    command->surface.add_passes_to(*plan, "along the passes: of the tip, as the F of a program");
    command->part.add_to(*plan);
    plan->add_option("--spindle", command->spindle, "speed, e.g. 12000rpm; default: the program does not say");
    plan->add_flag("--check", command->check, "simulates what the tool leaves; status 1 where it is not as wanted");
    plan->add_option("--summary", command->summary, "what came of it, as JSON");
    command->out.add_to(*plan, false);
    plan->remove_option(plan->get_option("--curves"));
    plan->add_option("--curves", command->curves, "passes as straight moves, or as dual splines (sinumerik)")
        ->check(CLI::IsMember({"points", "splines"}))
        ->capture_default_str();
    plan->add_flag("-q,--quiet", command->quiet, "no warnings");
    plan->footer(
        "Without --to the output's name says the dialect: .ngc rs274, .mpf sinumerik, .h heidenhain, .nc fanuc, .cls "
        "apt.\n"
        "Example:\n  trunnion surface plan hills.toml --tool \"ball 10mm\" --scallop 10um --check -o hills.mpf");
    plan->callback([command, &status] { status = plan_and_report(*command); });
}

void add_list(CLI::App& surface, int& status) {
    auto file = std::make_shared<std::string>();
    auto quiet = std::make_shared<bool>(false);
    CLI::App* list = surface.add_subcommand("list", "the faces of a file: numbers, sizes, radii");
    list->add_option("surface", *file, "surface: STEP (.step .stp), IGES (.iges .igs) or a surface file (.toml)")
        ->required();
    list->add_flag("-q,--quiet", *quiet, "no warnings");
    list->footer(
        "hollow: smallest radius of curvature where the face is hollow, which a ball or corner radius must not "
        "exceed;\n"
        "hump: the same where it is humped.\n"
        "Example:\n  trunnion surface list part.step");
    list->callback([file, quiet, &status] { status = list_faces(*file, *quiet); });
}

}  // namespace

void add_surface_command(CLI::App& app, int& status) {
    CLI::App* surface = app.add_subcommand("surface", "surfaces → tool paths");
    surface->require_subcommand(1);
    surface->footer("Example:\n  trunnion surface plan hills.toml --tool \"ball 10mm\" -o hills.mpf");
    add_plan(*surface, status);
    add_list(*surface, status);
    add_surface_run_command(*surface, status);
}

}  // namespace trunnion::app
