#include "trunnion/pipeline/plan.hpp"

#include <chrono>
#include <cmath>
#include <string>

#include <fmt/format.h>
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

Result<Summary> plan_once(const PlannedJob& job, MotionStage& motion, const std::function<bool(double)>& go_on) {
    auto stretches = StretchSource::make(job.program, job.machine, job.setup, job.options, job.stands);
    if (!stretches) return fail(stretches.error());
    IntervalSource intervals(*stretches, job.options.feed);
    if (auto done = run_to_end(intervals, motion, job.options.threads, go_on); !done) return fail(done.error());
    Summary summary = motion.finish();
    summary.work.smooth_s = stretches->smooth_s();
    summary.work.plan_s += intervals.grid_s();
    const auto& met = stretches->diagnostics();
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
    MotionStage motion(job.program, job.machine, job.options, observer);
    auto summary = plan_once(job, motion, progress_of_part(observer, 0, first));
    if (!summary) return summary;
    auto found = find_worth(job, motion.gradients(), progress_of_part(observer, first, 1), *summary);
    return found ? std::move(summary) : fail(found.error());
}

}  // namespace

Result<Summary> plan(const program::Program& program, const machine::Machine& machine, const machine::Setup& setup,
                     const PlanOptions& options, PlanObserver& observer) {
    if (auto good = check_options(options); !good) return fail(good.error());
    const auto start = std::chrono::steady_clock::now();
    PlanOptions used = options;
    const bool exact = smoothing::follows_exactly(used.smoothing);
    const bool told = exact && used.smoothing.rounding != smoothing::Rounding::none;
    if (exact) used.smoothing.rounding = smoothing::Rounding::none;
    used.feed.period_s = options.period_s;
    const auto stands =
        path::choose_rotary_stands(program, machine, setup, smoothing::pole_tolerance_rad(used.smoothing));
    if (!stands) return fail(stands.error());
    auto summary = plan_with_worth({program, machine, setup, used, *stands}, observer);
    if (!summary) return summary;
    summary->program = program.source;
    summary->dialect = program.dialect;
    summary->machine = machine.name;
    summary->setup = setup.file;
    summary->diagnostics.insert(summary->diagnostics.begin(), program.diagnostics.begin(), program.diagnostics.end());
    if (told)
        summary->diagnostics.push_back(
            {.code = "PIPE0104",
             .severity = Severity::warning,
             .text = "a tolerance of 0 leaves nothing to round: exact stop at every corner"});
    summary->work.elapsed_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    summary->work.peak_memory_mb = peak_memory_mb();
    return summary;
}

}  // namespace trunnion::pipeline
