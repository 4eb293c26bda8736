#include <algorithm>
#include <memory>

#include <fmt/format.h>
#include <pybind11/stl.h>

#include "trunnion/pipeline/surface_faces.hpp"
#include "trunnion/surfacing/chord_steps.hpp"
#include "trunnion/surfacing/face.hpp"
#include "trunnion/surfacing/path_interval.hpp"

#include "bindings.hpp"
#include "machine.hpp"
#include "series.hpp"
#include "surfacing.hpp"
#include "words.hpp"

/// Faces, and how far apart passes and places on them are.
namespace trunnion::python {

using surfacing::Face;
using surfacing::FaceList;

std::vector<Face> faces_of(py::handle object, const char* name) {
    std::vector<Face> out;
    if (py::isinstance<Face>(object)) return {object.cast<const Face&>()};
    if (py::isinstance<FaceList>(object)) return object.cast<const FaceList&>().faces;
    for (const py::handle face : items_of(object, name, "a Face or a sequence of them"))
        out.push_back(object_of<Face>(face, name));
    return out;
}

namespace {

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

FaceList read_faces(py::handle path) {
    const std::string file = path_of(path, "path");
    const py::gil_scoped_release released;
    return value_of(pipeline::read_surface_faces(file));
}

const Face& face_at(const FaceList& list, py::ssize_t i) {
    const auto size = static_cast<py::ssize_t>(list.faces.size());
    if (i < -size || i >= size) throw py::index_error();
    return list.faces[static_cast<std::size_t>(i < 0 ? i + size : i)];
}

Array flat_intervals(py::handle radius, py::handle scallop) {
    const double height = positive_of(scallop, "scallop_mm");
    const Array radii = numbers_of(radius, "radius_mm");
    if (std::any_of(radii.data(), radii.data() + radii.size(), [](double r) { return r <= 0; }))
        refuse({.code = "PY0003", .text = "radius_mm: above 0 wanted"});
    return at_each(radii, {}, [&](double r, double* out) { *out = surfacing::flat_interval_mm(r, height); });
}

constexpr const char* face_doc = R"(Face(surface, side='along', loops=None)
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
    PY0001, PY0002, PY0004 by the argument's name.)";

constexpr const char* interval_mm_doc = R"(interval_mm($self, tool, u, v, scallop_mm, feed_angle_deg=0.0)
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

Source: Lin & Koren, Eq. 2, with the conjugate radius of surface and tool.)";

constexpr const char* read_faces_doc = R"(read_faces(path)
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
    SURF0101 to SURF0104, codes FILE01….)";

constexpr const char* flat_interval_mm_doc = R"(flat_interval_mm(radius_mm, scallop_mm)
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

Source: Lin & Koren, Eq. 2.)";

constexpr const char* chord_steps_doc = R"(chord_steps(curve, tolerance_mm, longest)
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
ndarray, shape (n,))";

}  // namespace

void bind_faces(py::module_& module) {
    py::class_<Face, std::shared_ptr<Face>>(module, "Face", face_doc)
        .def(py::init(&make_face), py::arg("surface"), py::arg("side") = "along", py::arg("loops") = py::none())
        .def_readonly("number", &Face::number, "int: in its file, from 1.")
        .def_readonly("surface", &Face::surface, "BsplineSurface.")
        .def_property_readonly(
            "side", [](const Face& face) { return name_of(face.side, sides); }, "str: 'along' or 'against'.")
        .def_property_readonly("facts", &face_facts,
                               "dict: sizes, area and radii, found on a grid: near the true ones and no bounds.")
        .def("interval_mm", &interval, py::arg("tool"), py::arg("u"), py::arg("v"), py::arg("scallop_mm"),
             py::arg("feed_angle_deg") = 0.0, interval_mm_doc);
    py::class_<FaceList>(module, "FaceList", "The faces of a file, in its order; made by `read_faces()`.")
        .def("__len__", [](const FaceList& list) { return list.faces.size(); })
        .def("__getitem__", [](const FaceList& list, py::ssize_t i) { return face_at(list, i); })
        .def_readonly("unit", &FaceList::unit, "str: the length that the file counts in.")
        .def_readonly("faces_in_file", &FaceList::faces_in_file, "int: those left out included.")
        .def_readonly("diagnostics", &FaceList::diagnostics, "list of Diagnostic: what was left out or is odd.");
    module.def("read_faces", &read_faces, py::arg("path"), read_faces_doc);
    module.def("flat_interval_mm", &flat_intervals, py::arg("radius_mm"), py::arg("scallop_mm"), flat_interval_mm_doc);
    module.def("chord_steps", &curve_steps, py::arg("curve"), py::arg("tolerance_mm"), py::arg("longest"),
               chord_steps_doc);
}

}  // namespace trunnion::python
