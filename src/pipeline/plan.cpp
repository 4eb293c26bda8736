#include "trunnion/pipeline/plan.hpp"

#include <chrono>
#include <cmath>
#include <memory>
#include <string>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/resource.h>

#include "trunnion/path/rotary_stands.hpp"
#include "trunnion/smoothing/pole_tolerance.hpp"

#include "detail/motion_stage.hpp"
#include "detail/run_ahead.hpp"
#include "detail/worth.hpp"

namespace trunnion::pipeline {

namespace {

double peak_memory_mb() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

/// The observer's progress, for a part of the work.
std::function<bool(double)> progress_of_part(PlanObserver& observer, double begin, double end) {
    return [&observer, begin, end](double share) { return observer.progress(begin + (end - begin) * share); };
}

/// Takes element after element to the end of the source, or to the first error in the program's order.
template <class Source>
Result<void> run_to_end(Source& source, MotionStage& motion, const std::function<bool(double)>& go_on) {
    for (;;) {
        const auto element = source.next();
        if (!element) return fail(element.error());
        if (!*element) return {};
        if (auto taken = motion.take(**element); !taken) return taken;
        if (!go_on((*element)->share)) return fail({.code = "PIPE0002", .text = "cancelled"});
    }
}

Result<void> run_to_end(IntervalSource& source, MotionStage& motion, int threads,
                        const std::function<bool(double)>& go_on) {
    if (threads == 1) return run_to_end(source, motion, go_on);
    RunAhead ahead(source);
    return run_to_end(ahead, motion, go_on);
}

Result<Summary> plan_once(PartSource& parts, const machine::Machine& machine, const PlanOptions& options,
                          MotionStage& motion, const std::function<bool(double)>& go_on) {
    StretchSource stretches(parts, machine, options);
    IntervalSource intervals(stretches, options.feed);
    if (auto done = run_to_end(intervals, motion, options.threads, go_on); !done) return fail(done.error());
    Summary summary = motion.finish();
    summary.work.smooth_s = stretches.smooth_s();
    summary.work.plan_s += intervals.grid_s();
    const auto met = stretches.diagnostics();
    summary.diagnostics.insert(summary.diagnostics.end(), met.begin(), met.end());
    return summary;
}

Result<void> check_options(const PlanOptions& options) {
    const auto positive = [](double x) { return std::isfinite(x) && x > 0; };
    const auto bad = [](std::string what) -> Result<void> {
        return fail({.code = "PIPE0001", .text = std::move(what)});
    };
    if (!positive(options.period_s)) return bad("the period must be longer than 0");
    if (!positive(options.feed_override)) return bad("the feed override must be more than 0");
    if (options.feed_mm_s && !positive(*options.feed_mm_s)) return bad("the feed must be more than 0");
    const auto tolerance = [](double x) { return std::isfinite(x) && x >= 0; };
    if (!tolerance(options.smoothing.tip_tolerance_mm)) return bad("the tip tolerance must not be below 0");
    if (!tolerance(options.smoothing.orientation_tolerance_rad))
        return bad("the orientation tolerance must not be below 0");
    if (!tolerance(options.smoothing.flank_tolerance_mm)) return bad("the flank tolerance must not be below 0");
    if (!positive(options.smoothing.flank_height_mm)) return bad("the flank height must be more than 0");
    if (options.threads != 1 && options.threads != 2)
        return bad(fmt::format("planning runs on 1 or 2 threads, not on {}", options.threads));
    return {};
}

Result<Summary> plan_with_worth(const PlannedJob& job, PlanObserver& observer) {
    const double first = 1.0 / (1 + most_replans(job));
    MotionStage motion(job.machine, job.options, observer);
    WholeProgram program(job.program, job.machine, job.setup, {job.stands.begin(), job.stands.end()});
    auto summary = plan_once(program, job.machine, job.options, motion, progress_of_part(observer, 0, first));
    if (!summary) return summary;
    auto found = find_worth(job, motion.gradients(), progress_of_part(observer, first, 1), *summary);
    return found ? std::move(summary) : fail(found.error());
}

/// The options as they are used: where nothing may be rounded, nothing is.
PlanOptions options_in_use(const PlanOptions& options) {
    PlanOptions out = options;
    if (smoothing::follows_exactly(out.smoothing)) out.smoothing.rounding = smoothing::Rounding::none;
    out.feed.period_s = options.period_s;
    return out;
}

/// What is known of a plan beside the motion: names, what reading noticed, the work.
void complete(Summary& summary, const program::Program& names, const std::vector<Diagnostic>& of_reading,
              const machine::Machine& machine, const machine::Setup& setup, const PlanOptions& options,
              std::chrono::steady_clock::time_point start) {
    summary.program = names.source;
    summary.dialect = names.dialect;
    summary.machine = machine.name;
    summary.setup = setup.file;
    summary.diagnostics.insert(summary.diagnostics.begin(), of_reading.begin(), of_reading.end());
    if (!names.following_letters.empty())
        summary.diagnostics.push_back({.code = "PIPE0107",
                                       .severity = Severity::warning,
                                       .text = fmt::format("following axes ({}) are not in the setpoints",
                                                           fmt::join(names.following_letters, ", ")),
                                       .hint = "smooth and convert write them"});
    if (smoothing::follows_exactly(options.smoothing) && options.smoothing.rounding != smoothing::Rounding::none)
        summary.diagnostics.push_back({.code = "PIPE0104",
                                       .severity = Severity::warning,
                                       .text = "a tolerance of 0 leaves nothing to round: exact stop at every corner"});
    summary.work.elapsed_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    summary.work.peak_memory_mb = peak_memory_mb();
}

/// In several parts there is no planning again.
void leave_out_worth(Summary& summary) {
    const PlanOptions& options = summary.options;
    if (options.feed.calm == 0) summary.calm.price_s = 0;
    if (!options.worth) return;
    summary.diagnostics.push_back(
        {.code = "PIPE0106",
         .severity = Severity::warning,
         .text = "what more of each limit is worth is not looked for where the program is planned in parts",
         .hint = "give a part of the program"});
}

}  // namespace

Result<Summary> plan(const program::Program& program, const machine::Machine& machine, const machine::Setup& setup,
                     const PlanOptions& options, PlanObserver& observer) {
    if (auto good = check_options(options); !good) return fail(good.error());
    const auto start = std::chrono::steady_clock::now();
    const PlanOptions used = options_in_use(options);
    const auto stands =
        path::choose_rotary_stands(program, machine, setup, smoothing::pole_tolerance_rad(used.smoothing));
    if (!stands) return fail(stands.error());
    auto summary = plan_with_worth({program, machine, setup, used, *stands}, observer);
    if (!summary) return summary;
    complete(*summary, program, program.diagnostics, machine, setup, options, start);
    return summary;
}

Result<Summary> plan(program::ProgramParts& parts, const machine::Machine& machine, const machine::Setup& setup,
                     const PlanOptions& options, PlanObserver& observer) {
    if (auto good = check_options(options); !good) return fail(good.error());
    const auto start = std::chrono::steady_clock::now();
    auto first = std::make_shared<program::Program>(), second = std::make_shared<program::Program>();
    for (const auto& part : {first, second}) {
        const auto more = parts.next(*part);
        if (!more) return fail(more.error());
        if (!*more) return plan(*first, machine, setup, options, observer);
    }
    const program::Program names{
        .source = first->source, .dialect = first->dialect, .following_letters = first->following_letters};
    const PlanOptions used = options_in_use(options);
    MotionStage motion(machine, used, observer);
    ReadParts source({std::move(first), std::move(second)}, parts, machine, setup, used);
    auto summary = plan_once(source, machine, used, motion, progress_of_part(observer, 0, 1));
    if (!summary) return summary;
    leave_out_worth(*summary);
    complete(*summary, names, source.diagnostics(), machine, setup, options, start);
    return summary;
}

}  // namespace trunnion::pipeline
