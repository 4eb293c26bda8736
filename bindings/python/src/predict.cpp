#include "trunnion/pipeline/predict.hpp"

#include <algorithm>
#include <limits>
#include <memory>

#include <fmt/format.h>
#include <pybind11/stl.h>

#include "trunnion/files/controller_file.hpp"

#include "bindings.hpp"
#include "machine.hpp"
#include "planning.hpp"

namespace trunnion::python {

using motion::Controller;

namespace {

struct BoundPrediction {
    py::object samples;
    std::vector<std::string> columns;
    std::string json, report;
    std::vector<Diagnostic> diagnostics;
    double cycle_time_s = 0;
    std::vector<motion::LineTime> lines;
};

/// Thrown through the model out of its rows.
struct Interrupted {};

std::vector<std::string> sample_columns(const machine::Machine& machine) {
    std::vector<std::string> out{"t_s"}, velocities;
    for (int i = 0; i < machine.axis_count; ++i) {
        const char* unit = machine.axes[i].rotary ? "deg" : "mm";
        out.push_back(fmt::format("{}_{}", machine.axes[i].letter, unit));
        velocities.push_back(fmt::format("{}_{}_s", machine.axes[i].letter, unit));
    }
    out.insert(out.end(), {"line", "s_mm", "feed_mm_min", "contact_feed_mm_min"});
    out.insert(out.end(), velocities.begin(), velocities.end());
    return out;
}

void append(std::vector<double>& samples, const motion::PredictedRow& row, const machine::Machine& machine) {
    samples.push_back(row.time_s);
    for (int i = 0; i < machine.axis_count; ++i)
        samples.push_back(row.position[static_cast<std::size_t>(i)] / unit_of(machine.axes[i]));
    samples.insert(samples.end(), {static_cast<double>(row.line), row.path_length_mm, row.tip_feed_mm_s * 60,
                                   row.contact_feed_mm_s * 60});
    for (int i = 0; i < machine.axis_count; ++i)
        samples.push_back(row.velocity[static_cast<std::size_t>(i)] / unit_of(machine.axes[i]));
}

/// How much of a program the motion has passed, by the lines that it has come to.
class LineShare {
  public:
    explicit LineShare(const program::Program& program) {
        for (const program::Move& move : program.moves) {
            first_ = std::min(first_, move.line);
            last_ = std::max(last_, move.line);
        }
    }
    /// Never falls.
    double at(std::int32_t line) {
        if (last_ > first_) share_ = std::max(share_, static_cast<double>(line - first_) / (last_ - first_));
        return std::min(share_, 1.0);
    }

  private:
    std::int32_t first_ = std::numeric_limits<std::int32_t>::max(), last_ = 0;
    double share_ = 0;
};

pipeline::PredictionOptions take_prediction_options(Keywords& keywords) {
    pipeline::PredictionOptions out{.plan = take_plan_options(keywords)};
    keywords.number("contact_tilt_deg", out.contact_lead_rad, degree);
    keywords.flag("uncertainty", out.uncertainty);
    return out;
}

BoundPrediction predict(const program::Program& program, const machine::Machine& machine, const Controller& controller,
                        py::handle setup, const py::kwargs& given) {
    Keywords keywords(given, "predict");
    const auto options = take_prediction_options(keywords);
    bool wanted = false;
    keywords.flag("samples", wanted);
    const py::handle progress = keywords.take("progress");
    keywords.finish();
    const machine::Setup& placed = setup_of(setup);
    Watch watch(progress ? progress : py::handle(Py_None));
    LineShare share(program);
    std::vector<double> samples;
    const auto take_row = [&](const motion::PredictedRow& row) {
        if (wanted) append(samples, row, machine);
        if (!watch.goes_on(share.at(row.line))) throw Interrupted{};
    };
    const auto prediction = [&]() -> Result<motion::Prediction> {
        const py::gil_scoped_release released;
        try {
            return pipeline::predict(program, machine, placed, controller, options, take_row);
        } catch (const Interrupted&) {
            return fail({.code = "PIPE0002"});
        }
    }();
    watch.rethrow();
    const auto found = value_of(prediction);
    BoundPrediction out{.samples = py::none(), .columns = sample_columns(machine)};
    if (wanted) out.samples = array_from(std::move(samples), static_cast<py::ssize_t>(out.columns.size()));
    out.json = pipeline::to_json(found, machine, options);
    out.report = pipeline::report(found, machine, options);
    out.diagnostics = found.diagnostics;
    out.cycle_time_s = found.cycle_time_s;
    out.lines = found.lines;
    return out;
}

/// line, begin_s, duration_s
Array line_times(const BoundPrediction& self) {
    std::vector<double> out;
    for (const motion::LineTime& line : self.lines)
        out.insert(out.end(), {static_cast<double>(line.line), line.begin_s, line.duration_s});
    return array_from(std::move(out), 3);
}

void bind_controller(py::module_& module) {
    py::class_<Controller, std::shared_ptr<Controller>>(module, "Controller",
                                                        "A model of an existing control; made by `controller()`.")
        .def_readonly("name", &Controller::name, "str: as the file says.")
        .def_readonly("file", &Controller::file, "str: where it was read from.")
        .def_property_readonly(
            "kind", [](const Controller& c) { return to_string(c.kind); },
            "str: `blocks`, `linuxcnc`, `ideal` or `length-over-feed`.");
    module.def(
        "find_controller",
        [](py::handle source) {
            return std::make_shared<Controller>(
                value_of(files::find_controller(path_of(source, "source"), data_folders("controllers"))));
        },
        py::arg("source"));
    module.def(
        "read_controller_text",
        [](const std::string& toml, const std::string& name) {
            return std::make_shared<Controller>(value_of(files::read_controller(toml, name)));
        },
        py::arg("toml"), py::arg("name"));
    module.def("shipped_controllers", [] {
        std::vector<std::string> out;
        for (const auto& one : files::shipped_controllers(data_folders("controllers"))) out.push_back(one.name);
        return out;
    });
}

}  // namespace

constexpr const char* samples_doc = R"(ndarray, shape (n, columns), or None: only with `samples=True`.

Rows where the law of the speed changes; between two of them the axes go straight. Where velocities jump two rows have one
time. NaN: the contact feed where the tool is not known, and of LinuxCNC's and length over feed's.)";

constexpr const char* report_doc = R"(report($self)
--

A dozen lines for a person.)";

constexpr const char* predict_doc = R"(predict(program, machine, controller, setup=None, **options)
--

What an existing control will make of a program. The GIL is released; Ctrl-C is seen between rows of the motion.

Parameters
----------
program : Program
machine : Machine
controller : Controller
setup : Setup, optional
contact_tilt_deg : float
    How far the tool leans along the feed, for the feed at the contact; 0.
uncertainty : bool
    Whether to vary what is not identified: some 30 predictions more; True.
samples : bool
    Whether to give `Prediction.samples`.
progress : callable, optional
    Called with about the share done, by the lines that the motion has come to, 0 to 1, at most 50 times a second; an
    exception of it ends the prediction.
**options
    feed_override, feed_mm_min, and for the control 'ideal' all of plan().

Returns
-------
Prediction

Raises
------
Error
    codes CTRL02…, codes PATH… with the line; those of plan() with 'ideal'; PY0001 to PY0004 by the argument's name.

Source: Lavernhe, Tournier, Lartigue 2006; docs/theory/prediction.md.)";

void bind_predict(py::module_& module) {
    bind_controller(module);
    py::class_<BoundPrediction>(module, "Prediction", "What a control will make of a program; made by `predict()`.")
        .def_readonly("cycle_time_s", &BoundPrediction::cycle_time_s, "float: s.")
        .def_property_readonly(
            "summary", [](const BoundPrediction& self) { return from_json(self.json); },
            "dict: what `trunnion predict --summary` writes as JSON.")
        .def_readonly("samples", &BoundPrediction::samples, samples_doc)
        .def_readonly("columns", &BoundPrediction::columns,
                      "list of str: t_s, axes, line, s_mm, feed_mm_min, contact_feed_mm_min, velocities of the axes.")
        .def_property_readonly("line_times", &line_times,
                               "ndarray, shape (m, 3): line, when it begins and how long it takes, s.")
        .def_readonly("diagnostics", &BoundPrediction::diagnostics, "list of Diagnostic.")
        .def(
            "report", [](const BoundPrediction& self) { return self.report; }, report_doc)
        .def("__repr__", [](const BoundPrediction& self) {
            return fmt::format("<trunnion.Prediction: {:.3f} s>", self.cycle_time_s);
        });
    module.def("predict", &predict, py::arg("program"), py::arg("machine"), py::arg("controller"),
               py::arg("setup") = py::none(), predict_doc);
}

}  // namespace trunnion::python
