#include <algorithm>

#include <fmt/format.h>
#include <pybind11/stl.h>

#include "trunnion/pipeline/summary.hpp"

#include "bindings.hpp"
#include "machine.hpp"
#include "planning.hpp"

namespace trunnion::python {

namespace {

BoundPlan plan(const program::Program& program, const machine::Machine& machine, py::handle setup,
               const py::kwargs& given) {
    Keywords keywords(given, "plan");
    auto options = take_plan_options(keywords);
    keywords.flag("path", options.path_samples);
    const py::handle progress = keywords.take("progress");
    keywords.finish();
    const machine::Setup& placed = setup_of(setup);
    Recorder recorder(machine, progress ? progress : py::handle(Py_None));
    const auto summary = [&] {
        const py::gil_scoped_release released;
        return pipeline::plan(program, machine, placed, options, recorder);
    }();
    recorder.rethrow();
    const auto found = value_of(summary);
    BoundPlan out = recorder.finish(options.path_samples);
    out.json = pipeline::to_json(found);
    out.report = found.report();
    out.diagnostics = found.diagnostics;
    out.cycle_time_s = found.cycle_time_s;
    out.period_s = options.period_s;
    out.usable = found.usable();
    return out;
}

/// One column of a table that has one row a setpoint, without copying it.
py::object column(const py::object& table, const std::vector<std::string>& names, const std::string& name) {
    const auto found = std::ranges::find(names, name);
    if (found == names.end()) throw py::key_error(name);
    return table[py::make_tuple(py::ellipsis(), found - names.begin())];
}

}  // namespace

constexpr const char* path_doc = R"(ndarray, shape (m, path_columns), or None: only with `path=True`.

Geometry and speed along the path; speeds are dp/dt, derivatives of the axes by p in mm or degrees per mm^k. Where a
derivative jumps two rows stand at the same p.)";

constexpr const char* path_column_doc = R"(path_column($self, name)
--

One column of `path`, without a copy.

Raises
------
Error
    PY0003 planned without `path=True`.
KeyError
    No such column.)";

constexpr const char* report_doc = R"(report($self)
--

A dozen lines for a person.)";

constexpr const char* plan_doc = R"(plan(program, machine, setup=None, **options)
--

Program to jerk-limited axis setpoints: smoothed within the tolerances, in the least time that the limits of all axes
allow. The GIL is released; Ctrl-C ends it with KeyboardInterrupt.

Parameters
----------
program : Program
machine : Machine
setup : Setup, optional
    None: program zero at the machine zero, tool length 0.
tip_tolerance_mm : float
    Of the controlled point; 0.02.
orientation_tolerance_deg : float
    Of the tool axis; 0.1.
flank_tolerance_mm, flank_height_mm : float
    Of the point so far up the tool axis, instead of the angle; 0 (off) and 30.
rounding : {'smooth', 'beudaert', 'none'}
    Corners and dense blocks alike; every corner on its own; exact stop at each.
corners : {'smooth', 'beudaert'}
    Of corners that stand alone, with rounding 'smooth'.
link : {'optimised', 'linear'}
    Of tip and orientation in corners by beudaert.
calm : float
    Weight of smoothness against time, 0 to 1; 0.001.
jerk_margin : float
    Share of the axes' jerk to leave unused, 0 (default) to below 1.
period_s : float
    Between setpoints; 0.001.
feed_override : float
    Factor on all programmed feeds; 1.
feed_mm_min : float, optional
    Replaces the programmed feeds.
chord_error_mm, tip_acceleration_mm_s2, tip_jerk_mm_s3, tool_turn_deg_s : float, optional
    Further limits; None: not limited.
threads : int
    1 or 2: a second one makes the path ahead; the results are the same bits.
worth : bool
    Whether to find out what more of each limit would save (`summary['worth']`).
path : bool
    Whether to give `Plan.path`.
progress : callable, optional
    Called with the share done, 0 to 1, at most 50 times a second; an exception of it ends the planning.

Returns
-------
Plan

Raises
------
Error
    PIPE0001 an option out of range; codes of path, smoothing and feed with the line; PY0001 to PY0004 by the
    argument's name.
KeyboardInterrupt
    Nothing is left half done.

Source: docs/theory/feed-planning.md; rounding 'beudaert' is Beudaert 2013.)";

void bind_plan(py::module_& module) {
    py::class_<BoundPlan>(module, "Plan", R"(What planning came to.

`plan["X_mm"]` is one column of `setpoints`, without a copy.)")
        .def_readonly("setpoints", &BoundPlan::setpoints,
                      R"(ndarray, shape (n, columns): one row a period, from rest to rest.

Axes in mm and degrees (unwrapped), the rest as `columns` says. The memory that planning filled, not copied.)")
        .def_readonly("columns", &BoundPlan::columns,
                      "list of str: of `setpoints`: t_s, one an axis such as X_mm or A_deg, line, s_mm, feed_mm_min.")
        .def("__getitem__",
             [](const BoundPlan& self, const std::string& name) { return column(self.setpoints, self.columns, name); })
        .def_readonly("path", &BoundPlan::path, path_doc)
        .def_readonly("path_columns", &BoundPlan::path_columns, "list of str: of `path`.")
        .def(
            "path_column",
            [](const BoundPlan& self, const std::string& name) {
                if (self.path.is_none())
                    refuse({.code = "PY0003", .text = "name: the plan has no path", .hint = "plan(…, path=True)"});
                return column(self.path, self.path_columns, name);
            },
            py::arg("name"), path_column_doc)
        .def_readonly("events", &BoundPlan::events,
                      "list of dict: `time_s`, `s_mm`, `kind`, `word`, `line` of what happens besides motion.")
        .def_property_readonly(
            "summary", [](const BoundPlan& self) { return from_json(self.json); },
            "dict: what `trunnion plan --summary` writes as JSON.")
        .def_readonly("diagnostics", &BoundPlan::diagnostics, "list of Diagnostic: what was noticed.")
        .def_readonly("cycle_time_s", &BoundPlan::cycle_time_s, "float: s.")
        .def_readonly("period_s", &BoundPlan::period_s, "float: s between setpoints.")
        .def_readonly("usable", &BoundPlan::usable, "bool: all limits and tolerances hold.")
        .def(
            "report", [](const BoundPlan& self) { return self.report; }, report_doc)
        .def("__repr__", [](const BoundPlan& self) {
            return fmt::format("<trunnion.Plan: {:.3f} s{}>", self.cycle_time_s, self.usable ? "" : ", not usable");
        });

    module.def("plan", &plan, py::arg("program"), py::arg("machine"), py::arg("setup") = py::none(), plan_doc);
}

}  // namespace trunnion::python
