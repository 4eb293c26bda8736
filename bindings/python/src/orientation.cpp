#include <cmath>
#include <memory>

#include <fmt/format.h>
#include <pybind11/stl.h>

#include "trunnion/surfacing/orientation_surface.hpp"
#include "trunnion/surfacing/surface_tool_path.hpp"

#include "bindings.hpp"
#include "series.hpp"
#include "surfacing.hpp"

/// The surfaces that lead a tool over a face: of its guiding point, and of its orientation.
namespace trunnion::python {

using geometry::SurfacePlace;
using surfacing::Face;
using surfacing::GuidingSurface;
using surfacing::OrientationSurface;

namespace {

/// A guiding surface with what it was made from.
struct BoundGuiding {
    std::shared_ptr<const Face> face;
    surfacing::Cutter cutter;
    GuidingSurface surface;
};
using SharedGuiding = std::shared_ptr<const BoundGuiding>;

std::shared_ptr<BoundGuiding> make_guiding(const Face& face, const machine::Tool& tool, py::handle tolerance,
                                           py::handle most_patches) {
    const auto cutter = cutter_of(tool);
    const surfacing::GuidingOptions options{
        .tolerance_mm = number_of(tolerance, "tolerance_mm"),
        .most_patches = static_cast<std::size_t>(std::max(0, count_of(most_patches, "most_patches")))};
    auto kept = std::make_shared<const Face>(face);
    const py::gil_scoped_release released;
    auto surface = value_of(GuidingSurface::make(*kept, cutter, options));
    return std::make_shared<BoundGuiding>(BoundGuiding{std::move(kept), cutter, std::move(surface)});
}

/// An orientation surface with what it refers to.
struct BoundOrientation {
    SharedGuiding guiding;
    OrientationSurface surface;

    surfacing::GuidedTool tool() const { return {*guiding->face, guiding->cutter, surface}; }
    BoundOrientation with(Result<OrientationSurface> other) const { return {guiding, value_of(std::move(other))}; }
};

/// 'u', 'v', or a direction in space.
surfacing::FeedReference feed_of(py::handle object) {
    using surfacing::FeedReference;
    constexpr Word<FeedReference::Along> words[]{{"u", FeedReference::Along::u}, {"v", FeedReference::Along::v}};
    if (PyUnicode_Check(object.ptr())) return {.along = word_of(object, "feed", words)};
    const Eigen::Vector3d direction = vector_of(object, "feed");
    if (!(direction.norm() > 0)) refuse({.code = "PY0003", .text = "feed: a direction without length"});
    return {.along = FeedReference::Along::direction, .direction = direction.normalized()};
}

surfacing::OrientationLimits take_limits(Keywords& keywords) {
    surfacing::OrientationLimits out;
    keywords.number("least_lead_deg", out.least_lead_rad, degree);
    keywords.number("most_lead_deg", out.most_lead_rad, degree);
    keywords.number("most_tilt_deg", out.most_tilt_rad, degree);
    if (const py::handle feed = keywords.take("feed")) out.feed = feed_of(feed);
    return out;
}

surfacing::OrientationOptions take_orientation_options(Keywords& keywords) {
    surfacing::OrientationOptions out;
    keywords.number("height_mm", out.height_mm);
    keywords.number("tolerance_mm", out.tolerance_mm);
    keywords.number("spacing_mm", out.spacing_mm);
    return out;
}

/// A function (point, normal) → axis of the caller's.
OrientationSurface::AxisField field_of(const py::object& function) {
    if (!PyCallable_Check(function.ptr())) refuse_type("axis", "a function of point and normal", function);
    return [function](const geometry::SurfaceShape& shape) -> std::optional<Eigen::Vector3d> {
        Array point(3), normal(3);
        put(point.mutable_data(), shape.point);
        put(normal.mutable_data(), shape.normal);
        const Eigen::Vector3d axis = vector_of(function(point, normal), "axis");
        if (!(axis.norm() > 0)) return {};
        return axis.normalized();
    };
}

BoundOrientation make_orientation(std::shared_ptr<BoundGuiding> guiding, const py::kwargs& given) {
    Keywords keywords(given, "OrientationSurface");
    surfacing::Lean lean;
    keywords.number("lead_deg", lean.lead_rad, degree);
    keywords.number("tilt_deg", lean.tilt_rad, degree);
    const auto limits = take_limits(keywords);
    const auto options = take_orientation_options(keywords);
    const py::handle axis = keywords.take("axis");
    keywords.finish();
    auto made = axis ? OrientationSurface::make(*guiding->face, guiding->surface,
                                                field_of(py::reinterpret_borrow<py::object>(axis)), limits, options)
                     : OrientationSurface::make(*guiding->face, guiding->surface, lean, limits, options);
    return {std::move(guiding), value_of(std::move(made))};
}

/// Rows (u, v) within the surface.
std::vector<SurfacePlace> places_of(py::handle object, const BoundOrientation& self, Shape* shape = nullptr) {
    const Rows rows = rows_of(object, "places", 2);
    if (shape) *shape = rows.leading;
    const auto &u = self.surface.surface().u(), &v = self.surface.surface().v();
    std::vector<SurfacePlace> out;
    for (py::ssize_t i = 0; i < rows.count; ++i) {
        const double* at = rows.row(i);
        if (at[0] < u.begin() || at[0] > u.end() || at[1] < v.begin() || at[1] > v.end())
            refuse({.code = "SURF0309",
                    .text = fmt::format("places: row {} is outside of the surface", i),
                    .value = fmt::format("({}, {})", at[0], at[1])});
        out.push_back({at[0], at[1]});
    }
    return out;
}

Array axes_at(const BoundOrientation& self, py::handle places) {
    Shape shape;
    const auto at = places_of(places, self, &shape);
    Array out = array_of(shape, {3});
    double* axis = out.mutable_data();
    for (const SurfacePlace& place : at) axis = put(axis, self.surface.axis(place));
    return out;
}

SurfacePlace one_place(py::handle object, const BoundOrientation& self) {
    const auto places = places_of(object, self);
    if (places.size() != 1) refuse({.code = "PY0001", .text = "place: one place (u, v) wanted"});
    return places.front();
}

BoundOrientation turned(const BoundOrientation& self, py::handle place, py::handle radius, py::handle turn) {
    return self.with(self.surface.turned(one_place(place, self), positive_of(radius, "radius_mm"),
                                         degree * vector_of(turn, "turn_deg")));
}

BoundOrientation towards(const BoundOrientation& self, py::handle places, py::handle axes, py::handle hold) {
    const auto at = places_of(places, self);
    const Rows given = rows_of(axes, "axes", 3), axis = directions_like(axes, "axes", given, "axes");
    if (static_cast<std::size_t>(axis.count) != at.size())
        refuse({.code = "PY0001", .text = "axes: as many rows as places wanted"});
    std::vector<surfacing::OrientationTarget> targets;
    for (std::size_t i = 0; i < at.size(); ++i) targets.push_back({at[i], axis.vector(static_cast<py::ssize_t>(i))});
    return self.with(self.surface.towards(targets, positive_of(hold, "hold")));
}

/// A number, or a function (u, v) of the caller's.
BoundOrientation blended(const BoundOrientation& self, const BoundOrientation& other, py::handle weight) {
    const auto given = py::reinterpret_borrow<py::object>(weight);
    if (PyCallable_Check(given.ptr()))
        return self.with(self.surface.blended(
            other.surface, [&](const SurfacePlace& at) { return number_of(given(at.u, at.v), "weight"); }));
    const double share = number_of(weight, "weight");
    return self.with(self.surface.blended(other.surface, [share](const SurfacePlace&) { return share; }));
}

py::tuple beyond_limits(const BoundOrientation& self) {
    const auto found = self.surface.beyond_limits();
    return py::make_tuple(column_of(found, 2, [](const auto& t) { return Eigen::Vector2d(t.place.u, t.place.v); }),
                          column_of(found, 3, [](const auto& t) { return t.axis; }));
}

py::dict limits(const BoundOrientation& self) {
    const surfacing::OrientationLimits& from = self.surface.limits();
    py::dict out;
    out["least_lead_deg"] = from.least_lead_rad / degree;
    out["most_lead_deg"] = from.most_lead_rad / degree;
    out["most_tilt_deg"] = from.most_tilt_rad / degree;
    return out;
}

surfacing::SurfacePathOptions take_path_options(Keywords& keywords) {
    surfacing::SurfacePathOptions out;
    keywords.number("chord_tolerance_mm", out.chord_tolerance_mm);
    keywords.number("longest_step_mm", out.longest_step_mm);
    return out;
}

py::dict pass_over(const BoundOrientation& self, py::handle places, const py::kwargs& given) {
    Keywords keywords(given, "pass_over");
    const auto options = take_path_options(keywords);
    keywords.finish();
    const auto at = places_of(places, self);
    const auto pass = value_of([&] {
        const py::gil_scoped_release released;
        return surfacing::pass_on(self.tool(), at, 0, options);
    }());
    return contact_columns(pass.contacts);
}

py::tuple spline_over(const BoundOrientation& self, py::handle places, const py::kwargs& given) {
    Keywords keywords(given, "spline_over");
    surfacing::PassSplineOptions options;
    keywords.number("tip_tolerance_mm", options.tip_tolerance_mm);
    keywords.number("orientation_tolerance_deg", options.axis_tolerance_rad, degree);
    keywords.number("height_mm", options.height_mm);
    keywords.finish();
    const auto at = places_of(places, self);
    auto made = value_of([&] {
        const py::gil_scoped_release released;
        return surfacing::dual_spline_on(self.tool(), at, options);
    }());
    py::dict facts;
    facts["tip_error_mm"] = made.tip_error_mm;
    facts["orientation_error_deg"] = made.axis_error_rad / degree;
    facts["poses"] = made.poses;
    return py::make_tuple(std::move(made.spline), facts);
}

constexpr const char* guiding_surface_doc = R"(GuidingSurface(face, tool, tolerance_mm=0.0005, most_patches=40000)
--

Where the tool's guiding point runs while the tool touches a face: the face moved by the corner radius along its normal. Of
a ball it is the centre's surface. A bicubic over the parameters of the face. Immutable.

Parameters
----------
face : Face
tool : Tool
    Flat, ball or torus.
tolerance_mm : float
    From the true one, proved; above 0.
most_patches : int

Raises
------
Error
    SURF0201 the tool, SURF0301 an option, SURF0303 no normal, SURF0304 the face is hollower than the tool is round,
    SURF0305 the tolerance is not reached, SURF0306 a crease.

Source: Affouard et al. 2004, Eq. 1.)";

constexpr const char* orientation_surface_doc = R"(OrientationSurface(guiding, **options)
--

A second point of the tool, up its axis from the guiding point, as a surface: every orientation over a face is a smooth
function of (u, v) that is edited by its control points. Immutable; what edits it gives a new one, or refuses.

Parameters
----------
guiding : GuidingSurface
lead_deg, tilt_deg : float
    How the axis leans from the normal along and across `feed`; 0.
axis : callable, optional
    In place of both: axis(point, normal) gives the axis, any length above 0, at a point of the face (arrays (3,), mm).
least_lead_deg, most_lead_deg, most_tilt_deg : float
    Orientations that are allowed; -57.3, 57.3 and 57.3.
feed : {'u', 'v'} or array_like, shape (3,)
    The direction that lead and tilt are counted from; 'u'.
height_mm, tolerance_mm, spacing_mm : float
    Of the second point, of the surface there, and of its patches at the most; 50, 0.01 and 10.

Raises
------
Error
    SURF0301 an option, SURF0303 a place without normal or feed, SURF0305 the tolerance is not reached, SURF0307 an axis
    less than 1° above the tangent plane, SURF0308 beyond the limits; what `axis` raises; PY0001 to PY0004 by the
    argument's name.

Source: Affouard et al. 2004; docs/theory.)";

constexpr const char* axis_doc = R"(axis($self, /, places)
--

Unit tool axes.

Parameters
----------
places : array_like, shape (..., 2)
    u and v.

Returns
-------
ndarray, shape (..., 3)

Raises
------
Error
    SURF0309 outside of the surface; PY0001, PY0002.)";

constexpr const char* turned_doc = R"(turned($self, /, place, radius_mm, turn_deg)
--

Turns the axes round a place by a rotation vector, less and less out to a radius. The axis at the place itself turns by
0.83 of it where the radius is three patches, 0.95 where it is six.

Parameters
----------
place : array_like, shape (2,)
    u and v.
radius_mm : float
    Above 0.
turn_deg : array_like, shape (3,)
    Right-handed, degrees.

Returns
-------
OrientationSurface

Raises
------
Error
    SURF0307, SURF0308, SURF0309; PY0001 to PY0003 by the argument's name.)";

constexpr const char* towards_doc = R"(towards($self, /, places, axes, hold=0.05)
--

The smoothest least change that brings axes to those wanted.

Parameters
----------
places : array_like, shape (n, 2)
    u and v.
axes : array_like, shape (n, 3)
    Unit to 1e-6.
hold : float
    Above 0; the larger, the sooner the change fades away from the places.

Returns
-------
OrientationSurface

Raises
------
Error
    SURF0307, SURF0308, SURF0309; PY0001 to PY0003 by the argument's name.)";

constexpr const char* blended_doc = R"(blended($self, /, other, weight)
--

(1 - weight) of this and weight of another one over the same knots.

Parameters
----------
other : OrientationSurface
weight : float or callable
    0 to 1, or weight(u, v).

Returns
-------
OrientationSurface

Raises
------
Error
    SURF0301 other knots or a weight out of range, SURF0307, SURF0308; what `weight` raises.)";

constexpr const char* pass_over_doc = R"(pass_over($self, /, places, **options)
--

Contacts and poses of a tool that goes over a polyline in (u, v): at its corners, and so many between them that straight
moves touch the face within the chord tolerance. The GIL is released.

Parameters
----------
places : array_like, shape (n, 2)
    Two or more.
chord_tolerance_mm, longest_step_mm : float
    0.0005 and 5.

Returns
-------
dict of ndarray
    `places` (n, 2), `points_mm`, `normals`, `tips_mm`, `axes` (n, 3).

Raises
------
Error
    SURF0301, SURF0303, SURF0307, SURF0309, SURF0312.

Source: Affouard et al. 2004, Eq. 1.)";

constexpr const char* spline_over_doc = R"(spline_over($self, /, places, **options)
--

A smooth pass through places as two C² splines: of the tip, and of a point up its axis. The GIL is released.

Parameters
----------
places : array_like, shape (n, 2)
    u and v.
tip_tolerance_mm, orientation_tolerance_deg, height_mm : float
    0.001, 0.0115 and 50.

Returns
-------
spline : DualSpline
    Over the length of the contacts' polyline, mm.
facts : dict
    `tip_error_mm`, `orientation_error_deg`, `poses`.

Raises
------
Error
    As pass_over(); SURF0305 the tolerance is not reached.)";

void bind_guiding(py::module_& module) {
    py::class_<BoundGuiding, std::shared_ptr<BoundGuiding>>(module, "GuidingSurface", guiding_surface_doc)
        .def(py::init(&make_guiding), py::arg("face"), py::arg("tool"), py::arg("tolerance_mm") = 0.0005,
             py::arg("most_patches") = 40'000)
        .def_property_readonly(
            "surface", [](const BoundGuiding& g) { return g.surface.surface(); }, "BsplineSurface.")
        .def_property_readonly(
            "error_bound_mm", [](const BoundGuiding& g) { return g.surface.error_bound_mm(); }, "float: proved.")
        .def_property_readonly("patches", [](const BoundGuiding& g) { return g.surface.patches(); }, "int.");
}

void bind_orientation_surface(py::module_& module) {
    py::class_<BoundOrientation>(module, "OrientationSurface", orientation_surface_doc)
        .def(py::init(&make_orientation), py::arg("guiding").none(false))
        .def_property_readonly(
            "surface", [](const BoundOrientation& o) { return o.surface.surface(); },
            "BsplineSurface: of the second point.")
        .def_property_readonly("limits", &limits, "dict: `least_lead_deg`, `most_lead_deg`, `most_tilt_deg`.")
        .def_property_readonly(
            "error_bound_mm", [](const BoundOrientation& o) { return o.surface.error_bound_mm(); },
            "float: at the height, from the field that it was made from; not proved.")
        .def_property_readonly(
            "distance_range_mm", [](const BoundOrientation& o) { return o.surface.distance_range_mm(); },
            "tuple: the distance of the two points lies between these; proved.")
        .def_property_readonly(
            "lower_limit", [](const BoundOrientation& o) { return o.with(o.surface.lower_limit()); },
            "OrientationSurface: of least lead, without tilt.")
        .def_property_readonly(
            "upper_limit", [](const BoundOrientation& o) { return o.with(o.surface.upper_limit()); },
            "OrientationSurface: of most lead, without tilt.")
        .def_property_readonly(
            "beyond_limits", &beyond_limits,
            "tuple of ndarray: places (n, 2) and axes (n, 3) beyond the limits, at most one a patch.")
        .def("axis", &axes_at, py::arg("places"), axis_doc)
        .def("turned", &turned, py::arg("place"), py::arg("radius_mm"), py::arg("turn_deg"), turned_doc)
        .def("towards", &towards, py::arg("places"), py::arg("axes"), py::arg("hold") = 0.05, towards_doc)
        .def("blended", &blended, py::arg("other"), py::arg("weight"), blended_doc)
        .def("pass_over", &pass_over, py::arg("places"), pass_over_doc)
        .def("spline_over", &spline_over, py::arg("places"), spline_over_doc);
}

}  // namespace

void bind_orientation(py::module_& module) {
    bind_guiding(module);
    bind_orientation_surface(module);
}

}  // namespace trunnion::python
