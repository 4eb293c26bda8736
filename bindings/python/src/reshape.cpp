#include <memory>

#include <pybind11/stl.h>

#include "trunnion/pipeline/deform.hpp"
#include "trunnion/pipeline/smooth_program.hpp"

#include "bindings.hpp"
#include "machine.hpp"
#include "planning.hpp"

/// Programs in, programs out: smoothed for a real control, or deformed.
namespace trunnion::python {

using program::Program;

namespace {

py::object shared(Program&& program) {
    return py::cast(std::make_shared<Program>(std::move(program)));
}

py::tuple smooth(const Program& program, const machine::Machine& machine, py::handle setup, const py::kwargs& given) {
    Keywords keywords(given, "smooth");
    smoothing::SmoothingOptions tolerances;
    take_tolerances(keywords, tolerances);
    auto form = pipeline::SmoothedForm::points;
    keywords.word("form", form,
                  {{"points", pipeline::SmoothedForm::points}, {"curves", pipeline::SmoothedForm::curves}});
    keywords.finish();
    const machine::Setup& placed = setup_of(setup);
    auto smoothed = [&] {
        const py::gil_scoped_release released;
        return pipeline::smooth_program(program, machine, placed, tolerances, form);
    }();
    auto found = value_of(std::move(smoothed));
    py::dict facts;
    facts["smoothed_moves"] = found.smoothed_moves;
    facts["written_moves"] = found.written_moves;
    facts["kept_moves"] = found.kept_moves;
    facts["tip_deviation_mm"] = found.tip_deviation_mm;
    facts["orientation_deviation_deg"] = found.orientation_deviation_rad / degree;
    return py::make_tuple(shared(std::move(found.program)), facts);
}

/// What every deformation of a program takes.
pipeline::DeformOptions take_deform_options(Keywords& keywords) {
    pipeline::DeformOptions out;
    keywords.number("distance_mm", out.distance_mm);
    keywords.number("fit_tolerance_mm", out.fit_tolerance_mm);
    std::optional<double> chord_mm, chord_deg;
    keywords.number("chord_tolerance_mm", chord_mm);
    keywords.number("chord_turn_deg", chord_deg);
    if (chord_mm.has_value() != chord_deg.has_value())
        refuse({.code = "PY0003", .text = "chord_tolerance_mm, chord_turn_deg: both or none wanted"});
    if (!chord_mm) return out;
    if (*chord_mm <= 0 || *chord_deg <= 0)
        refuse({.code = "PY0003", .text = "chord_tolerance_mm, chord_turn_deg: above 0 wanted"});
    out.chords = deformation::Chords{*chord_mm, *chord_deg * degree};
    return out;
}

py::tuple deform(const Program& program, const machine::Machine& machine, py::handle setup,
                 const pipeline::DeformOptions& options, double unit) {
    const machine::Setup& placed = setup_of(setup);
    auto deformed = [&] {
        const py::gil_scoped_release released;
        return pipeline::deform(program, machine, placed, options);
    }();
    auto found = value_of(std::move(deformed));
    py::list stretches;
    for (const pipeline::DeformedStretch& stretch : found.stretches) {
        py::dict row;
        row["first_line"] = stretch.first_line;
        row["last_line"] = stretch.last_line;
        row["before"] = stretch.before / unit;
        row["after"] = stretch.after / unit;
        row["tip_movement_mm"] = stretch.tip_movement_mm;
        row["orientation_change_deg"] = stretch.orientation_change_rad / degree;
        stretches.append(row);
    }
    return py::make_tuple(shared(std::move(found.program)), stretches);
}

double take_turn(Keywords& keywords) {
    double turn_rad = 0.1 * degree;
    keywords.number("orientation_tolerance_deg", turn_rad, degree);
    return turn_rad;
}

py::tuple avoid_pole(const Program& program, const machine::Machine& machine, py::handle setup,
                     const py::kwargs& given) {
    Keywords keywords(given, "avoid_pole");
    auto options = take_deform_options(keywords);
    options.aim = pipeline::AvoidPole{take_turn(keywords)};
    keywords.finish();
    return deform(program, machine, setup, options, 1);
}

py::tuple reduce_rotary(const Program& program, const machine::Machine& machine, py::handle setup,
                        const py::kwargs& given) {
    Keywords keywords(given, "reduce_rotary");
    auto options = take_deform_options(keywords);
    options.aim = pipeline::ReduceRotary{take_turn(keywords)};
    keywords.finish();
    return deform(program, machine, setup, options, degree);
}

std::vector<std::vector<Eigen::Vector3d>> guide_curves_of(py::handle object) {
    std::vector<std::vector<Eigen::Vector3d>> out;
    for (const py::handle curve : items_of(object, "guide_curves_mm", "a sequence of arrays of shape (n, 3)"))
        out.push_back(points_of(curve, "guide_curves_mm"));
    return out;
}

py::tuple deform_flank(const Program& program, const machine::Machine& machine, py::handle guide_curves,
                       py::handle setup, const py::kwargs& given) {
    Keywords keywords(given, "deform_flank");
    auto options = take_deform_options(keywords);
    pipeline::FitFlank aim{.guide_curves_mm = guide_curves_of(guide_curves)};
    keywords.number("from_height_mm", aim.options.range.from_height_mm);
    keywords.number("to_height_mm", aim.options.range.to_height_mm);
    keywords.number("most_movement_mm", aim.options.most_movement_mm);
    keywords.number("deepest_mm", aim.options.deepest_mm);
    keywords.number("half_angle_deg", aim.half_angle_rad, degree);
    keywords.number("outline_radius_mm", aim.outline_radius_mm);
    keywords.number("widest_height_mm", aim.widest_height_mm);
    keywords.finish();
    if (aim.outline_radius_mm && !aim.widest_height_mm) aim.widest_height_mm = 0;
    options.aim = std::move(aim);
    return deform(program, machine, setup, options, 1);
}

py::tuple compensate_deflection(const Program& program, const machine::Machine& machine, py::handle samples,
                                py::handle setup, const py::kwargs& given) {
    Keywords keywords(given, "compensate_deflection");
    auto options = take_deform_options(keywords);
    pipeline::CompensateDeflection aim;
    keywords.number("residual_mm", aim.tolerance_mm);
    keywords.finish();
    const Rows rows = rows_of(samples, "samples", 4);
    for (py::ssize_t i = 0; i < rows.count; ++i) {
        const double* row = rows.row(i);
        aim.samples.push_back({row[0], Eigen::Vector3d(row[1], row[2], row[3])});
    }
    options.aim = std::move(aim);
    return deform(program, machine, setup, options, 1);
}

constexpr const char* smooth_doc = R"(smooth(program, machine, setup=None, **options)
--

A smoother program for a real control: half of each tolerance for rounding, a quarter for points or splines, a quarter
left to the control. The GIL is released.

Parameters
----------
program : Program
machine : Machine
setup : Setup, optional
form : {'points', 'curves'}
    Straight moves, or C² cubic splines (which sinumerik has).
tip_tolerance_mm, orientation_tolerance_deg, flank_tolerance_mm, flank_height_mm, rounding, corners, link : optional
    As in plan().

Returns
-------
program : Program
facts : dict
    `smoothed_moves` became `written_moves`, `kept_moves` stayed; `tip_deviation_mm`, `orientation_deviation_deg`.

Raises
------
Error
    PIPE0016, PIPE0017, codes PATH… with the line; PY0001 to PY0004 by the argument's name.)";

constexpr const char* shared_doc = R"(
distance_mm : float
    Of the two curves of a path; 50.
fit_tolerance_mm : float
    Of the curves from the programmed poses; 0: through them.
chord_tolerance_mm, chord_turn_deg : float, optional
    Straight moves within these, instead of curves.

Returns
-------
program : Program
stretches : list of dict
    `first_line`, `last_line`, `before`, `after`, `tip_movement_mm`, `orientation_change_deg`.

Raises
------
Error
    codes DEFO…, PIPE0021, PIPE0022 with the stretch's line; PY0001 to PY0003 by the argument's name.

Source: Affouard et al. 2004; docs/theory.)";

/// pybind11 copies docstrings.
std::string with_shared(const char* beginning) {
    return std::string(beginning) + shared_doc;
}

}  // namespace

constexpr const char* avoid_pole_doc = R"(avoid_pole(program, machine, setup=None, **options)
--

Leads the cutting stretches of a program past the poles of the machine; `before` and `after`: peak rotary velocity over its
limit.

Parameters
----------
program : Program
machine : Machine
setup : Setup, optional
orientation_tolerance_deg : float
    How far the tool may be turned; 0.1.)";

constexpr const char* reduce_rotary_doc = R"(reduce_rotary(program, machine, setup=None, **options)
--

Turns the tool so that the rotary axes move less; `before` and `after`: their travel, degrees.

Parameters
----------
program : Program
machine : Machine
setup : Setup, optional
orientation_tolerance_deg : float
    How far the tool may be turned; 0.1.)";

constexpr const char* deform_flank_doc = R"(deform_flank(program, machine, guide_curves_mm, setup=None, **options)
--

Reshapes a program so that the tool's side leaves a surface; `before` and `after`: peak deviation, mm.

Parameters
----------
program : Program
machine : Machine
guide_curves_mm : sequence of array_like, each of shape (n, 3)
    Rows of the surface from the tool's tip upwards, mm.
setup : Setup, optional
    Has the tool's diameter.
from_height_mm, to_height_mm : float
    Of the tool's side that cuts, up from the tip; 0 and 20.
most_movement_mm : float
    Of a control point; 1.
deepest_mm : float, optional
    The tool cuts no deeper into the part than this.
half_angle_deg : float, optional
    The tool is a cone.
outline_radius_mm, widest_height_mm : float, optional
    The tool is a barrel.)";

constexpr const char* compensate_deflection_doc =
    R"(compensate_deflection(program, machine, samples, setup=None, **options)
--

The program whose tip, bent away, runs where the given one says; `before` and `after`: largest deflection and what is left
of it, mm.

Parameters
----------
program : Program
machine : Machine
samples : array_like, shape (n, 4)
    Way along the tip's path and deflection there, mm: s, x, y, z.
setup : Setup, optional
residual_mm : float
    What may be left; 0.001.)";

void bind_reshape(py::module_& module) {
    module.def("smooth", &smooth, py::arg("program"), py::arg("machine"), py::arg("setup") = py::none(), smooth_doc);
    module.def("avoid_pole", &avoid_pole, py::arg("program"), py::arg("machine"), py::arg("setup") = py::none(),
               with_shared(avoid_pole_doc).c_str());
    module.def("reduce_rotary", &reduce_rotary, py::arg("program"), py::arg("machine"), py::arg("setup") = py::none(),
               with_shared(reduce_rotary_doc).c_str());
    module.def("deform_flank", &deform_flank, py::arg("program"), py::arg("machine"), py::arg("guide_curves_mm"),
               py::arg("setup") = py::none(), with_shared(deform_flank_doc).c_str());
    module.def("compensate_deflection", &compensate_deflection, py::arg("program"), py::arg("machine"),
               py::arg("samples"), py::arg("setup") = py::none(), with_shared(compensate_deflection_doc).c_str());
}

}  // namespace trunnion::python
