#include <cmath>
#include <memory>

#include <fmt/format.h>
#include <pybind11/stl.h>

#include "trunnion/surfacing/gouge.hpp"

#include "bindings.hpp"
#include "series.hpp"
#include "surfacing.hpp"

/// The part as a body, and where a tool is in it.
namespace trunnion::python {

using surfacing::CutterPose;
using surfacing::PartBody;

surfacing::Holder holder_of(py::handle object) {
    if (object.is_none()) return {};
    const std::vector<double> sizes = list_of(object, "holder_mm");
    if (sizes.size() != 3)
        refuse({.code = "PY0001",
                .text = "holder_mm: three numbers wanted",
                .value = fmt::format("{}", sizes.size()),
                .hint = "diameter, and from where to where it goes up the axis from the tip"});
    if (!(sizes[0] > 0 && sizes[1] >= 0 && sizes[2] > sizes[1]))
        refuse({.code = "PY0003",
                .text = "holder_mm: out of range",
                .value = fmt::format("{}, {}, {}", sizes[0], sizes[1], sizes[2]),
                .limit = "diameter above 0, 0 ≤ from < to"});
    return {.radius_mm = sizes[0] / 2, .from_mm = sizes[1], .to_mm = sizes[2]};
}

namespace {

PartBody make_body(py::handle faces, py::handle tolerance) {
    const auto given = faces_of(faces, "faces");
    const double tolerance_mm = number_of(tolerance, "tolerance_mm");
    const py::gil_scoped_release released;
    return value_of(PartBody::make(given, tolerance_mm));
}

/// Poses of a tool, in the shape of `tips` without its last dimension.
struct ToolPoses {
    Shape shape;
    std::vector<CutterPose> poses;
};

ToolPoses tool_poses(py::handle tips, py::handle axes) {
    const Rows tip = rows_of(tips, "tips", 3), axis = directions_like(axes, "axes", tip, "tips");
    ToolPoses out{tip.leading, {}};
    for (py::ssize_t i = 0; i < tip.count; ++i) out.poses.push_back({tip.vector(i), axis.vector(i)});
    return out;
}

py::dict penetrations(const PartBody& self, const machine::Tool& tool, py::handle tips, py::handle axes,
                      py::handle holder, py::handle reach) {
    const surfacing::Cutter cutter = cutter_of(tool, number_of(reach, "reach_mm"));
    const surfacing::Holder held = holder_of(holder);
    const ToolPoses at = tool_poses(tips, axes);
    std::vector<surfacing::Penetration> found(at.poses.size());
    {
        const py::gil_scoped_release released;
        for (std::size_t i = 0; i < found.size(); ++i)
            found[i] = self.deepest(cutter, at.poses[i], 0, held)
                           .value_or(surfacing::Penetration{.at_mm = Eigen::Vector3d::Constant(NAN), .face = -1});
    }
    Array depth = array_of(at.shape, {}), where = array_of(at.shape, {3});
    py::array_t<std::int32_t> face(at.shape);
    py::array_t<bool> by_holder(at.shape);
    double* point = where.mutable_data();
    for (std::size_t i = 0; i < found.size(); ++i) {
        depth.mutable_data()[i] = found[i].depth_mm;
        point = put(point, found[i].at_mm);
        face.mutable_data()[i] = found[i].face;
        by_holder.mutable_data()[i] = found[i].by_holder;
    }
    py::dict out;
    out["depth_mm"] = depth;
    out["at_mm"] = where;
    out["face"] = face;
    out["by_holder"] = by_holder;
    return out;
}

Array signed_distances(const PartBody& self, py::handle points) {
    const Rows rows = rows_of(points, "points_mm", 3);
    Array out = array_of(rows.leading, {});
    double* distance = out.mutable_data();
    const py::gil_scoped_release released;
    for (py::ssize_t i = 0; i < rows.count; ++i) distance[i] = self.signed_distance_mm(rows.vector(i));
    return out;
}

constexpr Word<surfacing::GougeKind> gouge_kinds[]{{"local", surfacing::GougeKind::local},
                                                   {"rear", surfacing::GougeKind::rear},
                                                   {"global", surfacing::GougeKind::global},
                                                   {"holder", surfacing::GougeKind::holder}};

py::dict row_of(const surfacing::Gouge& gouge) {
    Array at(3), axis(3);
    put(at.mutable_data(), gouge.at_mm);
    put(axis.mutable_data(), gouge.axis);
    py::dict out;
    out["kind"] = name_of(gouge.kind, gouge_kinds);
    out["depth_mm"] = gouge.depth_mm;
    out["at_mm"] = at;
    out["face"] = gouge.face;
    out["contact"] = gouge.contact;
    out["share"] = gouge.share;
    out["place"] = py::make_tuple(gouge.place.u, gouge.place.v);
    out["axis"] = axis;
    return out;
}

/// The passes that are on one face of a plan, and their places among all passes.
struct PassesOnFace {
    std::vector<surfacing::Pass> passes;
    std::vector<std::size_t> index;
};

PassesOnFace passes_on(const BoundSurfacePlan& plan, int face) {
    PassesOnFace out;
    const auto& all = plan.result.plan.passes;
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (all[i].contacts.front().face != face) continue;
        out.passes.push_back(all[i]);
        out.index.push_back(i);
    }
    return out;
}

py::dict gouges(const BoundSurfacePlan& self, const PartBody& part, const py::kwargs& given) {
    Keywords keywords(given, "gouges");
    surfacing::GougeOptions options;
    keywords.number("tolerance_mm", options.tolerance_mm);
    keywords.number("step_mm", options.step_mm);
    if (const py::handle holder = keywords.take("holder_mm")) options.holder = holder_of(holder);
    keywords.finish();
    py::list rows;
    std::size_t poses = 0;
    double deepest_mm = 0;
    for (std::size_t f = 0; f < self.faces.size(); ++f) {
        const PassesOnFace on = passes_on(self, static_cast<int>(f));
        if (on.passes.empty()) continue;
        const auto found = value_of([&] {
            const py::gil_scoped_release released;
            return surfacing::find_gouges(self.faces[f], static_cast<int>(f), self.cutter, part, on.passes, options);
        }());
        poses += found.poses;
        deepest_mm = std::max(deepest_mm, found.deepest_mm);
        for (const surfacing::Gouge& gouge : found.gouges) {
            py::dict row = row_of(gouge);
            row["pass"] = on.index[gouge.pass];
            rows.append(row);
        }
    }
    py::dict out;
    out["gouges"] = rows;
    out["deepest_mm"] = deepest_mm;
    out["poses"] = poses;
    return out;
}

constexpr const char* part_body_doc = R"(PartBody(faces, tolerance_mm=0.005)
--

A part as a body: its faces as triangles within a tolerance, asked how deep a tool is in it. What lies behind a face is
material however far. Immutable.

Parameters
----------
faces : Face, FaceList or sequence of Face
tolerance_mm : float
    Of the triangles from the faces, a bound; above 0.

Raises
------
Error
    SURF0301 the tolerance, SURF0302 no face or more than 4 million triangles.)";

constexpr const char* penetrations_doc = R"(penetrations($self, /, tool, tips, axes, holder_mm=None, reach_mm=0.0)
--

How deep a tool is in the part. The GIL is released.

Parameters
----------
tool : Tool
    Flat, ball or torus.
tips : array_like, shape (..., 3)
    mm.
axes : array_like, shape (..., 3)
    Unit to 1e-6, tip to spindle.
holder_mm : array_like, shape (3,), optional
    Its diameter, and from where to where it goes up the axis from the tip.
reach_mm : float
    How far up from the tip the tool counts as its body; 0: its diameter.

Returns
-------
dict of ndarray
    `depth_mm` (...), 0 outside; `at_mm` (..., 3), the deepest place of the skin, NaN outside; `face` (...), its index, -1
    outside; `by_holder` (...).

Raises
------
Error
    SURF0201 the tool; PY0001 to PY0003 by the argument's name.)";

constexpr const char* signed_distance_doc = R"(signed_distance_mm($self, /, points_mm)
--

Distances of points from the skin, negative behind it. The GIL is released.

Parameters
----------
points_mm : array_like, shape (..., 3)

Returns
-------
ndarray, shape (...)
    mm.)";

constexpr const char* gouges_doc = R"(gouges($self, /, part, **options)
--

Walks the tool along the passes and looks where it is in the part. The GIL is released.

Parameters
----------
part : PartBody
    Of the plan's faces first, in their order, then of any others.
tolerance_mm : float
    Depths up to it are none; at least twice the part's; 0.01.
step_mm : float
    No point of the tool goes farther between two poses that are looked at; 0.5.
holder_mm : array_like, shape (3,), optional
    As PartBody.penetrations().

Returns
-------
dict
    `gouges`, list of dict: `kind` 'local', 'rear', 'global' or 'holder', `depth_mm`, `at_mm` (3,), `face`, `pass`,
    `contact`, `share` of the way to the next contact, `place` (u, v), `axis` (3,); `deepest_mm`; `poses` looked at.

Raises
------
Error
    SURF0301 an option; PY0001 to PY0003 by the argument's name.

Source: docs/theory.)";

}  // namespace

void bind_gouges(py::module_& module, py::class_<BoundSurfacePlan>& plan) {
    py::class_<PartBody, std::shared_ptr<PartBody>>(module, "PartBody", part_body_doc)
        .def(py::init(&make_body), py::arg("faces"), py::arg("tolerance_mm") = 0.005)
        .def_property_readonly("tolerance_mm", &PartBody::tolerance_mm, "float.")
        .def_property_readonly("triangles", &PartBody::triangles, "int.")
        .def("penetrations", &penetrations, py::arg("tool"), py::arg("tips"), py::arg("axes"),
             py::arg("holder_mm") = py::none(), py::arg("reach_mm") = 0.0, penetrations_doc)
        .def("signed_distance_mm", &signed_distances, py::arg("points_mm"), signed_distance_doc);
    plan.def("gouges", &gouges, py::arg("part"), gouges_doc);
}

}  // namespace trunnion::python
