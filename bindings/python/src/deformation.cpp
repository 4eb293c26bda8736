#include <memory>

#include <fmt/format.h>
#include <pybind11/stl.h>

#include "trunnion/deformation/dual_path.hpp"
#include "trunnion/deformation/flank_milling.hpp"
#include "trunnion/deformation/singular_cone.hpp"

#include "bindings.hpp"
#include "machine.hpp"
#include "series.hpp"
#include "words.hpp"

/// Dual paths and what flank milling asks of them.
namespace trunnion::python {

using deformation::DesignedSurface;
using deformation::DualPath;
using deformation::FlankTool;
using deformation::SplineSurface;

namespace {

/// A path, and how it lies to the poses that it was fitted to.
struct BoundPath {
    DualPath path;
    py::object facts = py::none();
};

std::vector<machine::Pose> poses_of(py::handle tips, py::handle axes) {
    const Rows tip = rows_of(tips, "tips", 3), axis = directions_like(axes, "axes", tip, "tips");
    std::vector<machine::Pose> out;
    for (py::ssize_t i = 0; i < tip.count; ++i) out.push_back({tip.vector(i), axis.vector(i)});
    return out;
}

/// One number for each pose; none where it is not given.
std::vector<double> take_numbers(Keywords& keywords, const char* name, std::size_t poses) {
    const py::handle given = keywords.take(name);
    if (!given) return {};
    std::vector<double> out = list_of(given, name);
    if (out.size() == poses) return out;
    refuse({.code = "PY0001",
            .text = fmt::format("{}: one for each of the {} poses wanted", name, poses),
            .value = fmt::format("{}", out.size())});
}

BoundPath fit_path(py::handle tips, py::handle axes, const py::kwargs& given) {
    Keywords keywords(given, "DualPath");
    deformation::DualFit fit;
    keywords.number("distance_mm", fit.distance_mm);
    keywords.number("distance_tolerance_mm", fit.distance_tolerance_mm);
    keywords.number("tip_tolerance_mm", fit.tip_tolerance_mm);
    keywords.number("orientation_tolerance_deg", fit.orientation_tolerance_rad, degree);
    constexpr Word<deformation::Parametrisation> parametrisations[]{
        {"chord_length", deformation::Parametrisation::chord_length},
        {"centripetal", deformation::Parametrisation::centripetal}};
    keywords.word("parametrisation", fit.parametrisation, parametrisations);
    constexpr Word<deformation::EndCondition> ends[]{{"natural", deformation::EndCondition::natural},
                                                     {"not_a_knot", deformation::EndCondition::not_a_knot}};
    keywords.word("ends", fit.ends, ends);
    const auto poses = poses_of(tips, axes);
    fit.parameters = take_numbers(keywords, "parameters", poses.size());
    fit.weights = take_numbers(keywords, "weights", poses.size());
    keywords.finish();
    auto fitted = value_of([&] {
        const py::gil_scoped_release released;
        return deformation::fit_dual_path(poses, fit);
    }());
    py::dict facts;
    facts["parameters"] = array_from(std::move(fitted.parameters), 1).attr("ravel")();
    facts["tip_deviation_mm"] = fitted.tip_deviation_mm;
    facts["orientation_deviation_deg"] = fitted.orientation_deviation_rad / degree;
    facts["distance_error_mm"] = fitted.distance_error_mm;
    return {std::move(fitted.path), facts};
}

py::tuple path_poses(const BoundPath& self, py::handle u) {
    const Array at = numbers_of(u, "u");
    return py::make_tuple(
        at_each(at, {3}, [&](double value, double* out) { put(out, self.path.at(value).tip_in_workpiece_mm); }),
        at_each(at, {3}, [&](double value, double* out) { put(out, self.path.at(value).axis_in_workpiece); }));
}

constexpr const char* dual_path_doc = R"(DualPath(tips, axes, **options)
--

A tool path as two cubic C² splines over the same knots: f of the tip, g of the point at a distance up the axis. What counts
is f and the direction of g - f.

Parameters
----------
tips : array_like, shape (n, 3)
    mm.
axes : array_like, shape (n, 3)
    Unit to 1e-6.
distance_mm : float
    Of the two curves; 50.
distance_tolerance_mm : float
    How far their distance may differ before normalisation; 0.001.
tip_tolerance_mm, orientation_tolerance_deg : float
    Both 0 (default): through all poses; both above 0: within them, by least squares.
parametrisation : {'chord_length', 'centripetal'}
ends : {'not_a_knot', 'natural'}
parameters : array_like, shape (n,), optional
    The u of every pose, rising; None: by `parametrisation`.
weights : array_like, shape (n,), optional
    Of every pose in the least squares, above 0; None: all 1.

Raises
------
Error
    DEFO0101 to DEFO0107; PY0001 to PY0004 by the argument's name.

Source: Affouard et al. 2004; Piegl & Tiller, The NURBS Book, §9.2-9.4.)";

constexpr const char* poses_doc = R"(poses($self, /, u)
--

Tip and unit tool axis.

Parameters
----------
u : array_like
    Any shape.

Returns
-------
tips : ndarray, shape (*u.shape, 3)
    mm.
axes : ndarray, shape (*u.shape, 3))";

void bind_path(py::module_& module) {
    py::class_<BoundPath>(module, "DualPath", dual_path_doc)
        .def(py::init(&fit_path), py::arg("tips"), py::arg("axes"))
        .def_property_readonly(
            "spline", [](const BoundPath& self) { return self.path.spline; }, "DualSpline: f and g.")
        .def_property_readonly(
            "begin", [](const BoundPath& self) { return self.path.begin(); }, "float: where u begins.")
        .def_property_readonly(
            "end", [](const BoundPath& self) { return self.path.end(); }, "float: where u ends.")
        .def_property_readonly(
            "distance_mm", [](const BoundPath& self) { return self.path.distance_mm; }, "float: of f and g.")
        .def_readonly("fit", &BoundPath::facts, R"(dict, or None of a path that was not fitted.

`parameters` (n,) u of every pose; `tip_deviation_mm`, `orientation_deviation_deg` at the poses; `distance_error_mm`.)")
        .def("poses", &path_poses, py::arg("u"), poses_doc);
}

constexpr Word<deformation::FlankKind> flank_kinds[]{{"cylinder", deformation::FlankKind::cylinder},
                                                     {"cone", deformation::FlankKind::cone},
                                                     {"barrel", deformation::FlankKind::barrel}};

FlankTool make_flank_tool(py::handle kind, py::handle radius, const py::kwargs& given) {
    Keywords keywords(given, "FlankTool");
    FlankTool out{.kind = word_of(kind, "kind", flank_kinds), .radius_mm = positive_of(radius, "radius_mm")};
    keywords.number("half_angle_deg", out.half_angle_rad, degree);
    keywords.number("outline_radius_mm", out.outline_radius_mm);
    keywords.number("widest_height_mm", out.widest_height_mm);
    keywords.finish();
    return out;
}

SplineSurface guided_surface(py::handle rows, py::handle side) {
    std::vector<std::vector<Eigen::Vector3d>> curves;
    for (const py::handle row : items_of(rows, "rows_mm", "a sequence of arrays of shape (n, 3)"))
        curves.push_back(points_of(row, "rows_mm"));
    return value_of(deformation::guided_surface(curves, word_of(side, "side", sides)));
}

deformation::FlankRange take_range(Keywords& keywords) {
    deformation::FlankRange out;
    keywords.number("from_height_mm", out.from_height_mm);
    keywords.number("to_height_mm", out.to_height_mm);
    keywords.count("heights", out.heights);
    keywords.count("places_per_interval", out.places_per_interval);
    constexpr int most = 10'000;
    if (out.heights < 2 || out.heights > most || out.places_per_interval < 1 || out.places_per_interval > most)
        refuse({.code = "PY0003", .text = "heights, places_per_interval: out of range", .limit = "2 and 1 … 10000"});
    return out;
}

py::dict map_dict(const deformation::DeviationMap& map) {
    const auto rows = static_cast<py::ssize_t>(map.height_mm.size());
    py::dict out;
    out["u"] = py::array(py::cast(map.u));
    out["height_mm"] = py::array(py::cast(map.height_mm));
    out["deviation_mm"] = array_from(std::vector<double>(map.deviation_mm), rows);
    out["highest_mm"] = map.highest_mm;
    out["deepest_mm"] = map.deepest_mm;
    out["peak_mm"] = map.peak_mm;
    out["mean_square_root_mm"] = map.mean_square_root_mm;
    return out;
}

py::dict deviation_map(const BoundPath& path, const FlankTool& tool, const SplineSurface& surface,
                       const py::kwargs& given) {
    Keywords keywords(given, "deviation_map");
    const auto range = take_range(keywords);
    keywords.finish();
    const auto map = [&] {
        const py::gil_scoped_release released;
        return deformation::deviation_map(path.path, tool, surface, range);
    }();
    return map_dict(value_of(map));
}

py::tuple deform_flank_path(const BoundPath& path, const FlankTool& tool, const SplineSurface& surface,
                            const py::kwargs& given) {
    Keywords keywords(given, "deform_flank_path");
    deformation::FlankDeformation options{.range = take_range(keywords)};
    keywords.number("most_movement_mm", options.most_movement_mm);
    keywords.number("deepest_mm", options.deepest_mm);
    keywords.count("peak_rounds", options.peak_rounds);
    keywords.finish();
    auto deformed = value_of([&] {
        const py::gil_scoped_release released;
        return deformation::deform_flank(path.path, tool, surface, options);
    }());
    py::dict facts;
    facts["before"] = map_dict(deformed.before);
    facts["after"] = map_dict(deformed.after);
    facts["movement_mm"] = deformed.movement_mm;
    facts["distance_error_mm"] = deformed.distance_error_mm;
    facts["iterations"] = deformed.iterations;
    return py::make_tuple(BoundPath{std::move(deformed.path)}, facts);
}

py::tuple two_point_poses(const SplineSurface& surface, const FlankTool& tool, py::handle count, py::handle height) {
    const auto poses = value_of(
        deformation::two_point_poses(surface, tool, count_of(count, "count"), number_of(height, "lower_height_mm")));
    Array tips({static_cast<py::ssize_t>(poses.size()), py::ssize_t{3}}),
        axes({static_cast<py::ssize_t>(poses.size()), py::ssize_t{3}});
    double *tip = tips.mutable_data(), *axis = axes.mutable_data();
    for (const machine::Pose& pose : poses) {
        tip = put(tip, pose.tip_in_workpiece_mm);
        axis = put(axis, pose.axis_in_workpiece);
    }
    return py::make_tuple(tips, axes);
}

py::list singular_cones(const machine::Machine& machine, py::handle turn_rate, py::handle setup) {
    const machine::Setup& placed = setup_of(setup);
    const auto kinematics = value_of(machine::Kinematics::make(machine, placed.workpiece, placed.tool.length_mm));
    py::list out;
    for (const auto& cone :
         deformation::singular_cones(machine, kinematics, positive_of(turn_rate, "turn_rate_deg_s") * degree)) {
        Array direction(3);
        put(direction.mutable_data(), cone.direction);
        py::dict row;
        row["pole"] = cone.pole;
        row["direction"] = direction;
        row["angle_deg"] = cone.angle_rad / degree;
        row["half_angle_deg"] = cone.half_angle_rad / degree;
        row["axis"] = std::string(1, machine.axes[static_cast<std::size_t>(cone.axis)].letter);
        out.append(row);
    }
    return out;
}

constexpr const char* flank_tool_doc = R"(FlankTool(kind, radius_mm, **options)
--

The side of a tool of revolution.

Parameters
----------
kind : {'cylinder', 'cone', 'barrel'}
radius_mm : float
    Above 0; of a cone at the tip, of a barrel where it is widest.
half_angle_deg : float
    Of a cone.
outline_radius_mm, widest_height_mm : float
    Of a barrel.

Raises
------
Error
    PY0001 to PY0004 by the argument's name; DEFO0111 where it is used.)";

constexpr const char* guided_surface_doc = R"(GuidedSurface(rows_mm, side='along')
--

The surface that the side of a tool is to leave, through guide curves.

Parameters
----------
rows_mm : sequence of 2 to 8 array_like, each of shape (n, 3)
    From the tool's tip upwards, as many points in each, mm; two rows are ruled.
side : {'along', 'against'}
    Where the material is not: along S_u × S_v or against it.

Raises
------
Error
    DEFO0112; PY0001 to PY0004 by the argument's name.)";

constexpr const char* deviation_map_doc = R"(deviation_map(path, tool, surface, **options)
--

Signed deviations of what a tool's side leaves from a surface: above 0 material stays. The GIL is released.

Parameters
----------
path : DualPath
tool : FlankTool
surface : GuidedSurface
from_height_mm, to_height_mm : float
    Of the tool; 0 and 20.
heights, places_per_interval : int
    9 and 8.

Returns
-------
dict
    `u` (n,), `height_mm` (m,), `deviation_mm` (n, m), `highest_mm`, `deepest_mm`, `peak_mm`, `mean_square_root_mm`.

Raises
------
Error
    DEFO0111 tool or heights, DEFO0112, DEFO0113 no envelope at a place.

Source: condition n·V = 0 on the tool's side; Lartigue, Duc, Affouard 2003.)";

constexpr const char* deform_flank_path_doc = R"(deform_flank_path(path, tool, surface, **options)
--

Moves the control points of a path so that the tool's side fits a surface. The GIL is released.

Parameters
----------
path : DualPath
tool : FlankTool
surface : GuidedSurface
from_height_mm, to_height_mm, heights, places_per_interval
    As deviation_map().
most_movement_mm : float
    Of a control point; 1.
deepest_mm : float, optional
    The tool cuts no deeper than this.
peak_rounds : int
    Rounds that bring the peak down behind the least squares; 3.

Returns
-------
path : DualPath
facts : dict
    `before`, `after` (as deviation_map()), `movement_mm`, `distance_error_mm`, `iterations`.

Raises
------
Error
    DEFO0105, DEFO0110, DEFO0115 and those of deviation_map().

Source: Affouard et al. 2004; Lartigue, Duc, Affouard 2003.)";

constexpr const char* two_point_poses_doc = R"(two_point_poses(surface, tool, count, lower_height_mm=0.0)
--

Poses at which the tool's side passes both edges of a surface: the usual positioning on a blade.

Parameters
----------
surface : GuidedSurface
tool : FlankTool
count : int
    2 or more.
lower_height_mm : float
    Of the lower contact on the tool.

Returns
-------
tips, axes : ndarray, shape (count, 3)

Raises
------
Error
    DEFO0105, DEFO0111, DEFO0112, DEFO0114.)";

constexpr const char* singular_cones_doc = R"(singular_cones(machine, turn_rate_deg_s, setup=None)
--

Where the rotary axes lose a degree of freedom, and how far around the tool cannot be turned at a rate.

Parameters
----------
machine : Machine
turn_rate_deg_s : float
    Of the tool axis, above 0.
setup : Setup, optional

Returns
-------
list of dict
    `pole` (or a rim), `direction` (3,), `angle_deg`, `half_angle_deg`, `axis`: the one that reaches its limit first.

Raises
------
Error
    codes MACH01…; PY0001 to PY0003 by the argument's name.

Source: docs/theory/singular-cone.md.)";

void bind_flank(py::module_& module) {
    py::class_<FlankTool>(module, "FlankTool", flank_tool_doc)
        .def(py::init(&make_flank_tool), py::arg("kind"), py::arg("radius_mm"));
    py::class_<SplineSurface, std::shared_ptr<SplineSurface>>(module, "GuidedSurface", guided_surface_doc)
        .def(py::init(&guided_surface), py::arg("rows_mm"), py::arg("side") = "along")
        .def_property_readonly("surface", &SplineSurface::surface, "BsplineSurface.");
    module.def("deviation_map", &deviation_map, py::arg("path"), py::arg("tool"), py::arg("surface"),
               deviation_map_doc);
    module.def("deform_flank_path", &deform_flank_path, py::arg("path"), py::arg("tool"), py::arg("surface"),
               deform_flank_path_doc);
    module.def("two_point_poses", &two_point_poses, py::arg("surface"), py::arg("tool"), py::arg("count"),
               py::arg("lower_height_mm") = 0.0, two_point_poses_doc);
    module.def("singular_cones", &singular_cones, py::arg("machine"), py::arg("turn_rate_deg_s"),
               py::arg("setup") = py::none(), singular_cones_doc);
}

}  // namespace

void bind_deformation(py::module_& module) {
    bind_path(module);
    bind_flank(module);
}

}  // namespace trunnion::python
