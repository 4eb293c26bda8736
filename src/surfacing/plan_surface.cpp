#include "trunnion/surfacing/plan_surface.hpp"

#include <cmath>
#include <numbers>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "detail/passes.hpp"
#include "detail/surface_program.hpp"
#include "detail/sweep.hpp"

namespace trunnion::surfacing {

namespace {

struct Bound {
    const char* name;
    double value, above, below;
};

Result<void> check_options(const SurfaceOptions& options, const Cutter& cutter) {
    constexpr double quarter_turn = std::numbers::pi / 2, infinite = 1e9;
    const Bound bounds[] = {
        {"scallop_mm", options.scallop_mm, 0, 0.5 * cutter.radius_mm()},
        {"chord_tolerance_mm", options.chord_tolerance_mm, 0, 0.5 * options.scallop_mm},
        {"gouge_tolerance_mm", options.gouge_tolerance_mm, 0, infinite},
        {"feed_angle_rad", options.feed_angle_rad, -8 * quarter_turn, 8 * quarter_turn},
        {"lead_rad", options.lead_rad, -quarter_turn, quarter_turn},
        {"tilt_rad", options.tilt_rad, -quarter_turn, quarter_turn},
        {"lift_mm", options.lift_mm, 0, infinite},
        {"retract_mm", options.retract_mm, options.lift_mm, infinite},
        {"longest_step_mm", options.longest_step_mm, 0, infinite},
        {"feed_mm_s", options.feed_mm_s, 0, infinite},
        {"approach_mm_s", options.approach_mm_s, 0, infinite},
    };
    for (const Bound& bound : bounds)
        if (!(bound.value > bound.above && bound.value < bound.below))
            return fail({.code = "SURF0202",
                         .text = fmt::format("{} is out of its range", bound.name),
                         .value = fmt::format("{}", bound.value),
                         .limit = fmt::format("above {:.6g}, below {:.6g}", bound.above, bound.below)});
    return {};
}

double length_mm(const Pass& pass) {
    double sum = 0;
    for (std::size_t i = 1; i < pass.contacts.size(); ++i)
        sum += (pass.contacts[i].point_mm - pass.contacts[i - 1].point_mm).norm();
    return sum;
}

}  // namespace

Result<SurfacePlan> plan_surface(const Face& face, const Cutter& cutter, const SurfaceOptions& options) {
    if (auto sound = check_options(options, cutter); !sound) return fail(std::move(sound.error()));
    const detail::Job job{face, cutter, options};
    auto ways = detail::sweep(job);
    if (!ways) return fail(std::move(ways.error()));
    SurfacePlan plan{.least_interval_mm = ways->least_interval_mm,
                     .largest_interval_mm = ways->largest_interval_mm,
                     .highest_ridge_mm = ways->highest_ridge_mm};
    for (const auto& [way, index] : ways->ways)
        if (auto done = detail::append_passes(job, way, index, plan.passes); !done)
            return fail(std::move(done.error()));
    for (Pass& pass : plan.passes) pass.index -= ways->ways.front().index;
    if (options.borders)
        if (auto done = detail::append_border_passes(job, plan.passes); !done) return fail(std::move(done.error()));
    if (plan.passes.empty()) return fail({.code = "SURF0205", .text = "no pass crosses the face"});
    for (const Pass& pass : plan.passes) plan.cut_length_mm += length_mm(pass);
    plan.program = detail::program_of(plan.passes, options);
    return plan;
}

}  // namespace trunnion::surfacing
