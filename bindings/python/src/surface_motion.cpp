#include "trunnion/pipeline/surface_motion.hpp"

#include <algorithm>
#include <memory>

#include <fmt/format.h>
#include <pybind11/stl.h>

#include "bindings.hpp"
#include "machine.hpp"
#include "planning.hpp"
#include "surfacing.hpp"

/// Real-time surface interpolation.
namespace trunnion::python {

namespace {

pipeline::SurfaceMotionOptions take_motion_options(Keywords& keywords) {
    using interpolation::FeedPoint, interpolation::StepOrder;
    pipeline::SurfaceMotionOptions out;
    take_tolerances(keywords, out.plan.smoothing);
    take_feed_options(keywords, out.plan.feed);
    keywords.number("period_s", out.plan.period_s);
    keywords.count("threads", out.plan.threads);
    keywords.flag("path", out.plan.path_samples);
    keywords.word("order", out.order,
                  {{"first", StepOrder::first}, {"second", StepOrder::second}, {"corrected", StepOrder::corrected}});
    keywords.word("feed_point", out.feed_point, {{"contact", FeedPoint::contact}, {"tip", FeedPoint::tip}});
    keywords.number("place_tolerance_mm", out.place_tolerance_mm);
    return out;
}

/// Runs `move`, which is given the observer, without the GIL.
template <class Move>
BoundPlan moved(const machine::Machine& machine, const pipeline::SurfaceMotionOptions& options, py::handle progress,
                Move&& move) {
    Recorder recorder(machine, progress ? progress : py::handle(Py_None));
    const auto summary = [&] {
        const py::gil_scoped_release released;
        return move(recorder);
    }();
    recorder.rethrow();
    const auto found = value_of(summary);
    BoundPlan out = recorder.finish(options.plan.path_samples);
    out.json = pipeline::to_json(found);
    out.report = found.report();
    out.diagnostics = found.motion.diagnostics;
    out.cycle_time_s = found.motion.cycle_time_s;
    out.period_s = options.plan.period_s;
    out.usable = found.usable();
    return out;
}

BoundPlan move_surface(const BoundSurfacePlan& plan, const machine::Machine& machine, const machine::Setup& setup,
                       const py::kwargs& given) {
    Keywords keywords(given, "move_surface");
    const auto options = take_motion_options(keywords);
    const py::handle progress = keywords.take("progress");
    keywords.finish();
    return moved(machine, options, progress, [&](pipeline::PlanObserver& observer) {
        return pipeline::move_surface(plan.result.plan, plan.faces, plan.options, machine, setup, options, observer);
    });
}

BoundPlan move_surface_ahead(const surfacing::Face& face, const machine::Tool& tool, const machine::Machine& machine,
                             const machine::Setup& setup, const py::kwargs& given) {
    Keywords keywords(given, "move_surface_ahead");
    const auto surface = take_surface_options(keywords);
    const auto options = take_motion_options(keywords);
    const py::handle progress = keywords.take("progress");
    keywords.finish();
    const surfacing::Cutter cutter = cutter_of(tool);
    return moved(machine, options, progress, [&](pipeline::PlanObserver& observer) {
        return pipeline::move_surface_ahead(face, cutter, surface, machine, setup, options, observer);
    });
}

constexpr const char* move_surface_doc = R"(move_surface(plan, machine, setup, **options)
--

Real-time surface interpolation: every pass on the surface itself, from rest to rest; links as plan() makes them. The GIL
is released; Ctrl-C ends it.

Parameters
----------
plan : SurfacePlan
machine : Machine
setup : Setup
    Its tool is the tool.
order : {'corrected', 'first', 'second'}
    Of the step in the curve's parameter.
feed_point : {'contact', 'tip'}
place_tolerance_mm : float
    How far a pass may be moved sideways on the surface; 0.002.
**options
    period_s, threads, limits, tolerances of links, path and progress as in plan(). Feeds are those of the surface plan.

Returns
-------
Plan

Raises
------
Error
    PIPE0001, PIPE0130 to PIPE0132, codes INTP…, codes PATH….

Source: Lin & Koren, real-time interpolators for surfaces.)";

constexpr const char* move_surface_ahead_doc = R"(move_surface_ahead(face, tool, machine, setup, **options)
--

Lin & Koren's system end to end: passes from the border of least v on, each laid while the one before is moved over, by the
least interval that their Eq. 2 gives along it. The GIL is released; Ctrl-C ends it.

Parameters
----------
face : Face
    A whole surface.
tool : Tool
    Flat, ball or torus.
machine : Machine
setup : Setup
order, feed_point, place_tolerance_mm : optional
    As move_surface().
**options
    Of the passes as plan_surface() has them, but for strategy, feed_angle_deg and borders, which do not count; period_s,
    limits, tolerances of links, path and progress as in plan().

Returns
-------
Plan
    `summary['surface']` has how long it took until the first setpoints were ready.

Raises
------
Error
    PIPE0131 to PIPE0133, SURF0202, SURF0203, codes INTP…, codes PATH….

Source: Lin & Koren, real-time interpolators for surfaces.)";

}  // namespace

void bind_surface_motion(py::module_& module) {
    module.def("move_surface", &move_surface, py::arg("plan"), py::arg("machine"), py::arg("setup"), move_surface_doc);
    module.def("move_surface_ahead", &move_surface_ahead, py::arg("face"), py::arg("tool"), py::arg("machine"),
               py::arg("setup"), move_surface_ahead_doc);
}

}  // namespace trunnion::python
