#include "job.hpp"

#include <charconv>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/files/setup_file.hpp"
#include "trunnion/files/shipped_machines.hpp"
#include "trunnion/nc/read.hpp"
#include "trunnion/pipeline/expand_surfaces.hpp"

#include "commands.hpp"

namespace trunnion::app {

void JobOptions::add_machine_to(CLI::App& command) {
    command.add_option("-m,--machine", machine, "shipped machine by name, or a machine file");
}

void JobOptions::add_tolerances_to(CLI::App& command) {
    command.add_option("--tip-tolerance", tip_tolerance, "of the controlled point")->capture_default_str();
    command.add_option("--orientation-tolerance", orientation_tolerance, "of the tool axis")->capture_default_str();
}

void JobOptions::add_to(CLI::App& command) {
    add_machine_to(command);
    command.add_option("--setup", setup, "setup file: workpiece, tools, offsets");
    command.add_option("--units", units, "overrides the unit that the program states")
        ->check(CLI::IsMember({"mm", "inch"}));
    command.add_option("--dialect", dialect, "instead of recognising it by content")
        ->check(CLI::IsMember(dialect_names));
    add_tolerances_to(command);
    command.add_option("--flank-tolerance", flank_tolerance, "of the point at the flank height, instead of an angle");
    command.add_option("--flank-height", flank_height, "how far up the tool that point is")->capture_default_str();
    command.add_flag("-q,--quiet", quiet, "no warnings, no progress");
}

void JobOptions::add_planning_to(CLI::App& command) {
    command
        .add_option(
            "--rounding", rounding,
            "smooth: corners and dense blocks alike; beudaert: every corner on its own; none: exact stop at each")
        ->check(CLI::IsMember({"smooth", "beudaert", "none"}))
        ->capture_default_str();
    command.add_option("--corners", corners, "that stand alone, with smooth rounding: as the rest, or by beudaert")
        ->check(CLI::IsMember({"smooth", "beudaert"}))
        ->capture_default_str();
    command
        .add_option("--link", link,
                    "of tip and orientation in a corner rounded by beudaert; linear: as controls do, for comparison")
        ->check(CLI::IsMember({"optimised", "linear"}))
        ->capture_default_str();
    command.add_option("--calm", calm, "weight of smoothness against time, 0 … 1")
        ->check(CLI::Range(0.0, 1.0))
        ->capture_default_str();
    command.add_option("--feed-override", feed_override, "of all programmed feeds")->capture_default_str();
    command.add_option("--feed", feed, "replaces programmed feeds, e.g. 20m/min");
    command.add_option("--jerk-margin", jerk_margin, "share of the axes' jerk to leave unused")->capture_default_str();
    command.add_option("--chord-error", chord_error,
                       "largest distance of straight steps between setpoints from the tip's path, e.g. 5um");
    command.add_option("--tip-acceleration", tip_acceleration, "limit along the tip's path, e.g. \"2 m/s^2\"");
    command.add_option("--tip-jerk", tip_jerk, "limit along the tip's path, e.g. \"50 m/s^3\"");
    command.add_option("--tool-turn", tool_turn, "limit of how fast the tool turns, e.g. \"90 deg/s\"");
    command.add_option("--period", period, "time between setpoints")->capture_default_str();
    command.add_option("--threads", threads, "1 or 2: a second one makes the path ahead; the results are the same")
        ->capture_default_str();
}

namespace {

Result<double> option_value(const char* name, const std::string& text, Dimension wanted) {
    auto value = parse_quantity(text, wanted);
    if (value) return value;
    auto error = value.error();
    error.text = fmt::format("{}: {}", name, error.text);
    return fail(error);
}

/// Sets `target` unless the option is empty or wrong.
Result<void> set(double& target, const char* name, const std::string& text, Dimension wanted) {
    if (text.empty()) return {};
    const auto value = option_value(name, text, wanted);
    if (!value) return fail(value.error());
    target = *value;
    return {};
}

Result<int> thread_count(const std::string& text) {
    int count = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), count);
    if (error == std::errc() && end == text.data() + text.size()) return count;
    return fail({.code = "PIPE0001", .text = "--threads must be 1 or 2", .value = text});
}

smoothing::Rounding rounding_of(const std::string& name) {
    if (name == "none") return smoothing::Rounding::none;
    return name == "beudaert" ? smoothing::Rounding::beudaert : smoothing::Rounding::smooth;
}

Result<pipeline::PlanOptions> plan_options(const JobOptions& job) {
    pipeline::PlanOptions out;
    auto& smoothing = out.smoothing;
    smoothing.rounding = rounding_of(job.rounding);
    if (job.corners == "beudaert") smoothing.corners = smoothing::Corners::beudaert;
    smoothing.link = job.link == "linear" ? smoothing::Link::linear : smoothing::Link::optimised;
    double feed_mm_s = 0;
    const Result<void> parts[] = {
        set(smoothing.tip_tolerance_mm, "--tip-tolerance", job.tip_tolerance, dimension::length),
        set(smoothing.orientation_tolerance_rad, "--orientation-tolerance", job.orientation_tolerance,
            dimension::angle),
        set(smoothing.flank_tolerance_mm, "--flank-tolerance", job.flank_tolerance, dimension::length),
        set(smoothing.flank_height_mm, "--flank-height", job.flank_height, dimension::length),
        set(out.feed_override, "--feed-override", job.feed_override, dimension::ratio),
        set(out.feed.jerk_margin, "--jerk-margin", job.jerk_margin, dimension::ratio),
        set(out.period_s, "--period", job.period, dimension::time),
        set(out.feed.chord_error_mm, "--chord-error", job.chord_error, dimension::length),
        set(out.feed.tip_acceleration_mm_s2, "--tip-acceleration", job.tip_acceleration, dimension::acceleration),
        set(out.feed.tip_jerk_mm_s3, "--tip-jerk", job.tip_jerk, dimension::jerk),
        set(out.feed.turn_velocity_rad_s, "--tool-turn", job.tool_turn, dimension::angular_velocity),
        set(feed_mm_s, "--feed", job.feed, dimension::velocity)};
    for (const auto& part : parts)
        if (!part) return fail(part.error());
    if (!job.flank_tolerance.empty() && smoothing.flank_tolerance_mm == 0) smoothing.orientation_tolerance_rad = 0;
    if (!job.feed.empty()) out.feed_mm_s = feed_mm_s;
    out.feed.calm = job.calm;
    const auto threads = thread_count(job.threads);
    if (!threads) return fail(threads.error());
    out.threads = *threads;
    out.worth = job.worth;
    return out;
}

/// The machine is never guessed.
Result<machine::Machine> machine_of(const JobOptions& options) {
    if (!options.machine.empty()) return files::find_machine(options.machine, machine_folders());
    std::string shipped;
    for (const auto& machine : files::shipped_machines(machine_folders())) shipped += " " + machine.name;
    return fail({.code = "PIPE0004",
                 .text = "no machine given",
                 .hint = fmt::format("give -m with a file or one of:{}", shipped)});
}

nc::ReadOptions reading_options(const JobOptions& options, const machine::Machine& machine) {
    nc::ReadOptions out;
    out.machine = &machine;
    out.feed_given_elsewhere = !options.feed.empty();
    if (!options.dialect.empty()) out.dialect = nc::dialect_named(options.dialect);
    if (options.units == "mm") out.units = nc::Units::mm;
    if (options.units == "inch") out.units = nc::Units::inch;
    return out;
}

/// Up to this size a program is one part: branch and winding are chosen over all of it. About two million blocks, 400
/// MB; packed ones hold some eight times as much.
bool is_small(const std::filesystem::path& program) {
    constexpr std::uintmax_t plain = 100'000'000, packed = plain / 8;
    std::error_code error;
    const std::uintmax_t size = std::filesystem::file_size(program, error);
    return error || size <= (program.extension() == ".gz" ? packed : plain);
}

constexpr nc::PartSizes in_one_part{.to_rapid = std::numeric_limits<std::size_t>::max(),
                                    .to_stop = std::numeric_limits<std::size_t>::max(),
                                    .most = std::numeric_limits<std::size_t>::max()};

}  // namespace

std::vector<std::filesystem::path> machine_folders() {
    std::vector<std::filesystem::path> out;
    std::error_code error;
    const auto self = std::filesystem::read_symlink("/proc/self/exe", error);
    if (!error) out.push_back(self.parent_path().parent_path() / "share/trunnion/machines");
    out.push_back(std::filesystem::path(TRUNNION_INSTALL_DATA_DIR) / "machines");
    out.push_back(std::filesystem::path(TRUNNION_SOURCE_DATA_DIR) / "machines");
    return out;
}

Result<Workplace> load_workplace(const JobOptions& options) {
    auto plan = plan_options(options);
    if (!plan) return fail(plan.error());
    auto machine = machine_of(options);
    if (!machine) return fail(machine.error());
    Workplace out{.machine = std::move(*machine), .options = *plan};
    if (options.setup.empty()) {
        out.diagnostics.push_back({.code = "PIPE0101",
                                   .severity = Severity::warning,
                                   .text = "no setup given: program zero at the machine zero, tool length 0",
                                   .hint = "give --setup"});
        return out;
    }
    auto setup = files::read_setup_file(options.setup);
    if (!setup) return fail(setup.error());
    out.setup = std::move(*setup);
    return out;
}

Result<Job> load(const JobOptions& options) {
    auto workplace = load_workplace(options);
    if (!workplace) return fail(workplace.error());
    const auto start = std::chrono::steady_clock::now();
    auto program = nc::read_program_file(options.program, reading_options(options, workplace->machine));
    if (!program) return fail(program.error());
    program = pipeline::expand_surfaces(std::move(*program), workplace->setup);
    if (!program) return fail(program.error());
    const double read_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    auto& noticed = program->diagnostics;
    noticed.insert(noticed.end(), workplace->diagnostics.begin(), workplace->diagnostics.end());
    return Job{std::move(*workplace), std::move(*program), read_s};
}

Result<std::unique_ptr<program::ProgramParts>> open_program(const JobOptions& options, const Workplace& workplace) {
    nc::ReadOptions reading = reading_options(options, workplace.machine);
    if (is_small(options.program)) reading.parts = in_one_part;
    auto parts = nc::open_program_file(options.program, reading);
    if (!parts) return parts;
    return pipeline::expand_surfaces(std::move(*parts), workplace.setup);
}

void print(const Diagnostic& diagnostic, bool quiet) {
    if (quiet && diagnostic.severity != Severity::error) return;
    fmt::print(stderr, "{}\n", to_string(diagnostic));
}

int report_failure(const Diagnostic& diagnostic) {
    print(diagnostic);
    if (diagnostic.code == "PIPE0002") return interrupted;
    return diagnostic.code == "PIPE0003" ? own_fault : bad_input;
}

}  // namespace trunnion::app
