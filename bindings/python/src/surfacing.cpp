#include <algorithm>
#include <memory>

#include <fmt/format.h>
#include <pybind11/stl.h>

#include "trunnion/interpolation/surface_step.hpp"
#include "trunnion/pipeline/surface.hpp"
#include "trunnion/pipeline/surface_faces.hpp"
#include "trunnion/pipeline/surface_motion.hpp"
#include "trunnion/surfacing/chord_steps.hpp"
#include "trunnion/surfacing/path_interval.hpp"

#include "bindings.hpp"
#include "machine.hpp"
#include "planning.hpp"
#include "series.hpp"
#include "words.hpp"

/// Surfaces in, tool paths and motion out.
namespace trunnion::python {

using surfacing::Cutter;
using surfacing::Face;
using surfacing::FaceList;

namespace {

constexpr Word<surfacing::Strategy> strategies[]{{"constant-scallop", surfacing::Strategy::constant_scallop},
                                                 {"along-u", surfacing::Strategy::along_u},
                                                 {"along-v", surfacing::Strategy::along_v},
                                                 {"parallel-planes", surfacing::Strategy::parallel_planes},
                                                 {"lin-koren", surfacing::Strategy::lin_koren}};

/// What was planned, with what it was planned on.
struct BoundSurfacePlan {
    std::vector<Face> faces;
    Cutter cutter;
    surfacing::SurfaceOptions options;
    pipeline::SurfaceResult result;
    std::shared_ptr<program::Program> program;
};

surfacing::SurfaceOptions take_surface_options(Keywords& keywords) {
    surfacing::SurfaceOptions out;
    constexpr double chord_share = 0.05;  // of the scallop, as on the command line
    std::optional<double> chord;
    keywords.word("strategy", out.strategy, strategies);
    keywords.number("scallop_mm", out.scallop_mm);
    keywords.number("chord_tolerance_mm", chord);
    out.chord_tolerance_mm = chord.value_or(chord_share * out.scallop_mm);
    keywords.number("gouge_tolerance_mm", out.gouge_tolerance_mm);
    keywords.number("feed_angle_deg", out.feed_angle_rad, degree);
    keywords.number("lead_deg", out.lead_rad, degree);
    keywords.number("tilt_deg", out.tilt_rad, degree);
    keywords.flag("zigzag", out.zigzag);
    keywords.flag("borders", out.borders);
    keywords.number("lift_mm", out.lift_mm);
    keywords.number("retract_mm", out.retract_mm);
    keywords.number("longest_step_mm", out.longest_step_mm);
    keywords.number("feed_mm_min", out.feed_mm_s, 1.0 / 60);
    out.approach_mm_s = out.feed_mm_s;
    keywords.number("approach_feed_mm_min", out.approach_mm_s, 1.0 / 60);
    return out;
}

Cutter cutter_of(const machine::Tool& tool) {
    return value_of(Cutter::make(tool));
}

std::vector<Face> faces_of(py::handle object, const char* name) {
    std::vector<Face> out;
    if (py::isinstance<Face>(object)) return {object.cast<const Face&>()};
    if (py::isinstance<FaceList>(object)) return object.cast<const FaceList&>().faces;
    for (const py::handle face : items_of(object, name, "a Face or a sequence of them"))
        out.push_back(object_of<Face>(face, name));
    return out;
}

BoundSurfacePlan plan_surface(py::handle faces, const machine::Tool& tool, const py::kwargs& given) {
    Keywords keywords(given, "plan_surface");
    pipeline::SurfaceProgramOptions options{.passes = take_surface_options(keywords)};
    keywords.flag("splines", options.splines);
    keywords.text("tool_name", options.tool_name);
    double spindle_rpm = 0;
    keywords.number("spindle_rpm", spindle_rpm);
    options.spindle_rad_s = spindle_rpm * 6 * degree;
    keywords.finish();
    auto planned = faces_of(faces, "faces");
    const Cutter cutter = cutter_of(tool);
    auto result = value_of([&] {
        const py::gil_scoped_release released;
        return pipeline::make_surface_program(planned, cutter, options);
    }());
    auto program = std::make_shared<program::Program>(result.plan.program);
    return {std::move(planned), cutter, options.passes, std::move(result), std::move(program)};
}

/// One column of all contacts, in order.
template <class Take>
Array of_contacts(const BoundSurfacePlan& plan, py::ssize_t width, Take&& take) {
    std::vector<double> out;
    for (const surfacing::Pass& pass : plan.result.plan.passes)
        for (const surfacing::Contact& contact : pass.contacts) {
            const auto row = take(contact);
            out.insert(out.end(), row.data(), row.data() + width);
        }
    return array_from(std::move(out), width);
}

py::dict contacts(const BoundSurfacePlan& plan) {
    std::vector<std::int64_t> first{0}, index;
    for (const surfacing::Pass& pass : plan.result.plan.passes) {
        first.push_back(first.back() + static_cast<std::int64_t>(pass.contacts.size()));
        index.push_back(pass.index);
    }
    py::dict out;
    out["first"] = py::array(py::cast(first));
    out["index"] = py::array(py::cast(index));
    out["places"] = of_contacts(plan, 2, [](const auto& c) { return Eigen::Vector2d(c.place.u, c.place.v); });
    out["points_mm"] = of_contacts(plan, 3, [](const auto& c) { return c.point_mm; });
    out["normals"] = of_contacts(plan, 3, [](const auto& c) { return c.normal; });
    out["tips_mm"] = of_contacts(plan, 3, [](const auto& c) { return c.pose.tip_mm; });
    out["axes"] = of_contacts(plan, 3, [](const auto& c) { return c.pose.axis; });
    return out;
}

py::dict facts(const BoundSurfacePlan& plan) {
    py::dict out;
    out["passes"] = plan.result.plan.passes.size();
    out["contacts"] = plan.result.contacts;
    out["cut_length_mm"] = plan.result.plan.cut_length_mm;
    out["least_interval_mm"] = plan.result.plan.least_interval_mm;
    out["largest_interval_mm"] = plan.result.plan.largest_interval_mm;
    out["highest_ridge_mm"] = plan.result.plan.highest_ridge_mm;
    return out;
}

py::dict check_surface(const BoundSurfacePlan& plan, py::handle part) {
    const auto body = part.is_none() ? plan.faces : faces_of(part, "part");
    const auto found = value_of([&] {
        const py::gil_scoped_release released;
        return pipeline::check_surface_program(plan.faces, body, plan.cutter, plan.result, plan.options);
    }());
    const auto& verdict = found.verdict;
    py::dict out;
    out["usable"] = found.usable();
    out["ridges_hold"] = found.ridges_hold;
    out["surface_holds"] = found.surface_holds;
    out["in_part_mm"] = found.in_part ? found.in_part->depth_mm : 0.0;
    out["highest_mm"] = verdict.highest_mm;
    out["deepest_mm"] = verdict.deepest_mm;
    out["least_ridge_mm"] = verdict.least_ridge_mm;
    out["largest_ridge_mm"] = verdict.largest_ridge_mm;
    out["median_ridge_mm"] = verdict.median_ridge_mm;
    out["ridges"] = verdict.ridges;
    out["heights"] = verdict.heights;
    return out;
}

BoundPlan move_surface(const BoundSurfacePlan& plan, const machine::Machine& machine, const machine::Setup& setup,
                       const py::kwargs& given) {
    using interpolation::FeedPoint, interpolation::StepOrder;
    Keywords keywords(given, "move_surface");
    pipeline::SurfaceMotionOptions options{.plan = take_plan_options(keywords)};
    keywords.flag("path", options.plan.path_samples);
    keywords.word("order", options.order,
                  {{"first", StepOrder::first}, {"second", StepOrder::second}, {"corrected", StepOrder::corrected}});
    keywords.word("feed_point", options.feed_point, {{"contact", FeedPoint::contact}, {"tip", FeedPoint::tip}});
    keywords.number("place_tolerance_mm", options.place_tolerance_mm);
    const py::handle progress = keywords.take("progress");
    keywords.finish();
    Recorder recorder(machine, progress ? progress : py::handle(Py_None));
    const auto summary = [&] {
        const py::gil_scoped_release released;
        return pipeline::move_surface(plan.result.plan, plan.faces, plan.options, machine, setup, options, recorder);
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

Face make_face(const geometry::BsplineSurface& surface, py::handle side, py::handle loops) {
    Face out = surfacing::whole_face(surface, word_of(side, "side", sides));
    if (loops.is_none()) return out;
    out.loops.clear();
    for (const py::handle loop : items_of(loops, "loops", "a sequence of arrays of shape (n, 2)")) {
        const Rows rows = rows_of(loop, "loops", 2);
        if (rows.leading.size() != 1 || rows.count < 3)
            refuse({.code = "PY0001", .text = "loops: shape (n, 2) with three or more places wanted"});
        surfacing::Loop& to = out.loops.emplace_back();
        for (py::ssize_t i = 0; i < rows.count; ++i) to.emplace_back(rows.row(i)[0], rows.row(i)[1]);
    }
    if (out.loops.empty()) refuse({.code = "PY0001", .text = "loops: at least the outer border wanted"});
    return out;
}

py::dict face_facts(const Face& face) {
    const auto found = pipeline::facts_of(face);
    py::dict out;
    out["number"] = found.number;
    out["along_u_mm"] = found.along_u_mm;
    out["along_v_mm"] = found.along_v_mm;
    out["area_mm2"] = found.area_mm2;
    out["hollow_radius_mm"] = found.hollow_radius_mm;
    out["hump_radius_mm"] = found.hump_radius_mm;
    out["whole"] = found.whole;
    return out;
}

double interval(const Face& face, const machine::Tool& tool, py::handle u, py::handle v, py::handle scallop,
                py::handle angle) {
    const auto shape = geometry::shape_at(face.surface, {number_of(u, "u"), number_of(v, "v")}, face.side);
    if (!shape) refuse({.code = "SURF0303", .text = "u, v: the face has no normal there"});
    const double turn = number_of(angle, "feed_angle_deg") * degree;
    const Eigen::Vector2d across(-std::sin(turn), std::cos(turn));
    return surfacing::path_interval_mm(cutter_of(tool), *shape, shape->normal, across,
                                       positive_of(scallop, "scallop_mm"));
}

Array curve_steps(const geometry::BsplineCurve& curve, py::handle tolerance, py::handle longest) {
    const auto at = [&](double u) -> Eigen::Vector3d { return curve.evaluate(u)[0]; };
    auto steps = surfacing::chord_steps([&](double from, double to) { return surfacing::chord_error_mm(at, from, to); },
                                        curve.begin(), curve.end(), positive_of(tolerance, "tolerance_mm"),
                                        positive_of(longest, "longest"));
    return array_from(std::move(steps), 1).attr("ravel")();
}

void bind_faces(py::module_& module) {
    py::class_<Face, std::shared_ptr<Face>>(module, "Face", R"(Face(surface, side='along', loops=None)
--

A piece of surface that is to be machined.

Parameters
----------
surface : BsplineSurface
side : {'along', 'against'}
    Where the normal leads out of the material: S_u × S_v or against it.
loops : sequence of array_like, each of shape (n, 2), optional
    Closed polylines in (u, v), the outer border first; None: the whole surface.

Raises
------
Error
    PY0001, PY0002, PY0004 by the argument's name.)")
        .def(py::init(&make_face), py::arg("surface"), py::arg("side") = "along", py::arg("loops") = py::none())
        .def_readonly("number", &Face::number, "int: in its file, from 1.")
        .def_readonly("surface", &Face::surface, "BsplineSurface.")
        .def_property_readonly(
            "side", [](const Face& face) { return name_of(face.side, sides); }, "str: 'along' or 'against'.")
        .def_property_readonly("facts", &face_facts,
                               "dict: sizes, area and radii, found on a grid: near the true ones and no bounds.")
        .def("interval_mm", &interval, py::arg("tool"), py::arg("u"), py::arg("v"), py::arg("scallop_mm"),
             py::arg("feed_angle_deg") = 0.0, R"(interval_mm($self, tool, u, v, scallop_mm, feed_angle_deg=0.0)
--

Distance of neighbouring passes of an upright tool at a place, for ridges of a height; by the conjugate radius.

Parameters
----------
tool : Tool
    Flat, ball or torus.
u, v : float
scallop_mm : float
    Above 0.
feed_angle_deg : float
    Direction of the feed, from S_u towards S_v.

Returns
-------
float
    mm.

Raises
------
Error
    SURF0201 the tool, SURF0303 no normal there.

Source: Lin & Koren, Eq. 2, with the conjugate radius of surface and tool.)");
    py::class_<FaceList>(module, "FaceList", "The faces of a file, in its order; made by `read_faces()`.")
        .def("__len__", [](const FaceList& list) { return list.faces.size(); })
        .def("__getitem__",
             [](const FaceList& list, py::ssize_t i) {
                 const auto size = static_cast<py::ssize_t>(list.faces.size());
                 if (i < -size || i >= size) throw py::index_error();
                 return list.faces[static_cast<std::size_t>(i < 0 ? i + size : i)];
             })
        .def_readonly("unit", &FaceList::unit, "str: the length that the file counts in.")
        .def_readonly("faces_in_file", &FaceList::faces_in_file, "int: those left out included.")
        .def_readonly("diagnostics", &FaceList::diagnostics, "list of Diagnostic: what was left out or is odd.");
    module.def(
        "read_faces",
        [](py::handle path) {
            const std::string file = path_of(path, "path");
            return value_of([&] {
                const py::gil_scoped_release released;
                return pipeline::read_surface_faces(file);
            }());
        },
        py::arg("path"), R"(read_faces(path)
--

The faces of a STEP or IGES file, or of a surface file (.toml; docs/surface-files.md). The GIL is released; not from two
threads at once.

Parameters
----------
path : str or os.PathLike

Returns
-------
FaceList

Raises
------
Error
    SURF0101 to SURF0104, FILE01xx.)");
}

constexpr const char* plan_doc = R"(plan_surface(faces, tool, **options)
--

Passes over faces so that the ridges between them are as high as allowed and no higher. The GIL is released.

Parameters
----------
faces : Face, FaceList or sequence of Face
    Planned as one region.
tool : Tool
    Flat, ball or torus.
strategy : {'constant-scallop', 'along-u', 'along-v', 'parallel-planes', 'lin-koren'}
scallop_mm : float
    Highest ridge; 0.01.
chord_tolerance_mm : float, optional
    How far straight moves may lead the tool off its contact; a twentieth of the scallop.
gouge_tolerance_mm : float
    0.001.
feed_angle_deg, lead_deg, tilt_deg : float
    Direction of the passes in the middle; the tool's lean towards and across the feed; 0.
zigzag, borders : bool
    To and fro; a pass along every border as well; True.
lift_mm, retract_mm, longest_step_mm : float
    1, 20 and 5.
feed_mm_min, approach_feed_mm_min : float
    3000; the approach as the feed.
splines : bool
    Every pass one dual spline.
tool_name : str, optional
spindle_rpm : float, optional

Returns
-------
SurfacePlan

Raises
------
Error
    SURF0201 to SURF0207; PY0001 to PY0004 by the argument's name.

Source: Lin & Koren; docs/theory.)";

}  // namespace

void bind_surfacing(py::module_& module) {
    bind_faces(module);
    py::class_<BoundSurfacePlan>(module, "SurfacePlan", "Passes over faces; made by `plan_surface()`.")
        .def_readonly("program", &BoundSurfacePlan::program, "Program: all passes with their links, law vector.")
        .def_property_readonly("facts", &facts,
                               "dict: passes, contacts, cut_length_mm, least_interval_mm, largest_interval_mm, "
                               "highest_ridge_mm, as planned.")
        .def_property_readonly("contacts", &contacts, R"(dict of ndarray: every contact, pass after pass.

`first` (passes + 1,): where a pass begins; `index` (passes,): -1 along a border; `places` (n, 2): u, v; `points_mm`,
`normals`, `tips_mm`, `axes` (n, 3).)")
        .def("check", &check_surface, py::arg("part") = py::none(), R"(check($self, part=None)
--

Simulates what the tool leaves of the material. The GIL is released.

Parameters
----------
part : Face, FaceList or sequence of Face, optional
    All faces of the part; None: those that were planned.

Returns
-------
dict
    `usable`, `ridges_hold`, `surface_holds`, `in_part_mm`, heights and ridges in mm.

Raises
------
Error
    SURF0301, SURF0302.)")
        .def("__repr__", [](const BoundSurfacePlan& plan) {
            return fmt::format("<trunnion.SurfacePlan: {} passes>", plan.result.plan.passes.size());
        });
    module.def("plan_surface", &plan_surface, py::arg("faces"), py::arg("tool"), plan_doc);
    module.def("move_surface", &move_surface, py::arg("plan"), py::arg("machine"), py::arg("setup"),
               R"(move_surface(plan, machine, setup, **options)
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
    period_s, limits, tolerances of links, path and progress as in plan().

Returns
-------
Plan

Raises
------
Error
    PIPE0130 to PIPE0132, INTPxxxx, PATHxxxx.

Source: Lin & Koren, real-time interpolators for surfaces.)");
    module.def(
        "flat_interval_mm",
        [](py::handle radius, py::handle scallop) {
            const double height = positive_of(scallop, "scallop_mm");
            const Array radii = numbers_of(radius, "radius_mm");
            if (std::any_of(radii.data(), radii.data() + radii.size(), [](double r) { return r <= 0; }))
                refuse({.code = "PY0003", .text = "radius_mm: above 0 wanted"});
            return at_each(radii, {}, [&](double r, double* out) { *out = surfacing::flat_interval_mm(r, height); });
        },
        py::arg("radius_mm"), py::arg("scallop_mm"), R"(flat_interval_mm(radius_mm, scallop_mm)
--

Distance of neighbouring passes of an upright flat tool on a convex surface.

Parameters
----------
radius_mm : array_like
    Conjugate radius of the surface, above 0.
scallop_mm : float
    Above 0.

Returns
-------
ndarray, the shape of radius_mm
    mm.

Source: Lin & Koren, Eq. 2.)");
    module.def("chord_steps", &curve_steps, py::arg("curve"), py::arg("tolerance_mm"), py::arg("longest"),
               R"(chord_steps(curve, tolerance_mm, longest)
--

Parameters at which a curve is divided into chords as long as the tolerance lets them be, both ends included.

Parameters
----------
curve : BsplineCurve
tolerance_mm : float
    Largest distance of the curve from a chord, above 0.
longest : float
    Step of the parameter, above 0.

Returns
-------
ndarray, shape (n,))");
}

}  // namespace trunnion::python
