#include <memory>

#include <pybind11/stl.h>

#include "trunnion/geometry/surface_shape.hpp"

#include "arguments.hpp"
#include "bindings.hpp"
#include "series.hpp"
#include "words.hpp"

namespace trunnion::python {

using geometry::BsplineSurface;

namespace {

/// A grid of points (n, m, 3) as the rows that a surface takes.
struct Net {
    std::vector<Eigen::Vector3d> points;
    py::ssize_t along_u = 0, along_v = 0;
};

Net net_of(py::handle object, const char* name) {
    const Rows rows = rows_of(object, name, 3);
    if (rows.leading.size() != 2) refuse({.code = "PY0001", .text = std::string(name) + ": shape (n, m, 3) wanted"});
    Net out{.points = {}, .along_u = rows.leading[0], .along_v = rows.leading[1]};
    for (py::ssize_t i = 0; i < rows.count; ++i) out.points.push_back(rows.vector(i));
    return out;
}

void check_direction(const geometry::SurfaceDirection& direction, py::ssize_t points, const char* name) {
    if (direction.degree >= 1 && direction.points() == static_cast<std::size_t>(points)) return;
    refuse({.code = "GEOM0102",
            .text = std::string(name) + ": as many knots as control points in this direction, and degree + 1 more"});
}

BsplineSurface make_surface(py::handle degree_u, py::handle degree_v, py::handle knots_u, py::handle knots_v,
                            py::handle points, py::handle weights) {
    geometry::SurfaceDirection u{count_of(degree_u, "degree_u"), list_of(knots_u, "knots_u")},
        v{count_of(degree_v, "degree_v"), list_of(knots_v, "knots_v")};
    Net net = net_of(points, "control_points_mm");
    check_direction(u, net.along_u, "knots_u");
    check_direction(v, net.along_v, "knots_v");
    std::vector<double> all_weights;
    if (!weights.is_none()) {
        const Array given = numbers_of(weights, "weights");
        if (given.ndim() != 2 || given.shape(0) != net.along_u || given.shape(1) != net.along_v)
            refuse({.code = "PY0001", .text = "weights: one for each control point wanted, shape (n, m)"});
        all_weights.assign(given.data(), given.data() + given.size());
    }
    return value_of(BsplineSurface::make(std::move(u), std::move(v), std::move(net.points), std::move(all_weights)));
}

BsplineSurface polynomial(py::handle coefficients) {
    const Net net = net_of(coefficients, "coefficients_mm");
    return value_of(
        geometry::polynomial_surface(static_cast<int>(net.along_u) - 1, static_cast<int>(net.along_v) - 1, net.points));
}

/// Two arrays of one shape.
struct Places {
    Array u, v;
};

Places places_of(py::handle u, py::handle v) {
    Places out{numbers_of(u, "u"), numbers_of(v, "v")};
    const bool same =
        out.u.ndim() == out.v.ndim() && std::equal(out.u.shape(), out.u.shape() + out.u.ndim(), out.v.shape());
    if (!same) refuse({.code = "PY0001", .text = "v: the shape of u wanted"});
    return out;
}

template <class Fill>
Array at_places(const Places& at, std::initializer_list<py::ssize_t> last, Fill&& fill) {
    const double* v = at.v.data();
    return at_each(at.u, last, [&](double u, double* out) { fill(u, *v++, out); });
}

Array surface_points(const BsplineSurface& surface, py::handle u, py::handle v) {
    return at_places(places_of(u, v), {3},
                     [&](double at_u, double at_v, double* out) { put(out, surface.at(at_u, at_v)); });
}

Array surface_derivatives(const BsplineSurface& surface, py::handle u, py::handle v) {
    return at_places(places_of(u, v), {6, 3}, [&](double at_u, double at_v, double* out) {
        const auto p = surface.evaluate(at_u, at_v);
        for (const auto* row : {&p.at, &p.by_u, &p.by_v, &p.by_uu, &p.by_uv, &p.by_vv}) out = put(out, *row);
    });
}

/// Normal, and both principal curvatures.
py::dict surface_shape(const BsplineSurface& surface, py::handle u, py::handle v, py::handle side) {
    const auto on = word_of(side, "side", sides);
    const Places at = places_of(u, v);
    constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
    Array curvatures = array_of(Shape(at.u.shape(), at.u.shape() + at.u.ndim()), {2});
    double* curvature = curvatures.mutable_data();
    py::dict out;
    out["normal"] = at_places(at, {3}, [&](double at_u, double at_v, double* row) {
        const auto shape = geometry::shape_at(surface, {at_u, at_v}, on);
        put(row, shape ? shape->normal : Eigen::Vector3d::Constant(unknown));
        const auto principal = shape ? geometry::principal_curvatures(shape->shape)
                                     : geometry::PrincipalCurvatures{.larger = unknown, .smaller = unknown};
        *curvature++ = principal.larger;
        *curvature++ = principal.smaller;
    });
    out["curvatures_per_mm"] = curvatures;
    return out;
}

Array closest_places(const BsplineSurface& surface, py::handle points) {
    const Rows rows = rows_of(points, "points_mm", 3);
    Array out = array_of(rows.leading, {2});
    {
        const py::gil_scoped_release released;
        for (py::ssize_t i = 0; i < rows.count; ++i) {
            const auto place = geometry::closest_place(surface, rows.vector(i));
            out.mutable_data()[2 * i] = place.u;
            out.mutable_data()[2 * i + 1] = place.v;
        }
    }
    return out;
}

}  // namespace

constexpr const char* bspline_surface_doc =
    R"(BsplineSurface(degree_u, degree_v, knots_u, knots_v, control_points_mm, weights=None)
--

Tensor-product B-spline surface S(u, v), with weights or without. Immutable.

Parameters
----------
degree_u, degree_v : int
    1 to 7.
knots_u : array_like, shape (n + degree_u + 1,)
    Never falling.
knots_v : array_like, shape (m + degree_v + 1,)
    Never falling.
control_points_mm : array_like, shape (n, m, 3)
    mm; n along u, m along v.
weights : array_like, shape (n, m), optional
    Positive. None: all 1.

Raises
------
Error
    GEOM0101 to GEOM0107 as BsplineCurve; PY0001 and PY0002 by the argument's name.

Source: Piegl & Tiller, The NURBS Book, §3.4 and Eq. 4.20.)";

constexpr const char* polynomial_doc = R"(polynomial(coefficients_mm)
--

S(u, v) = Σ a_ij u^i v^j over 0 … 1 in both parameters.

Parameters
----------
coefficients_mm : array_like, shape (p + 1, q + 1, 3)
    a_ij in mm; degrees p and q from 1 to 7.

Returns
-------
BsplineSurface

Raises
------
Error
    GEOM0101 a degree.

Source: Lin & Koren, Eq. 3.)";

constexpr const char* call_doc = R"(__call__($self, /, u, v)
--

Points of the surface.

Parameters
----------
u, v : array_like
    Of one shape. Outside the domain the outermost pieces are continued.

Returns
-------
ndarray, shape (*u.shape, 3)
    mm.)";

constexpr const char* derivatives_doc = R"(derivatives($self, /, u, v)
--

S, S_u, S_v, S_uu, S_uv, S_vv, in this order.

Parameters
----------
u, v : array_like
    Of one shape.

Returns
-------
ndarray, shape (*u.shape, 6, 3)
    mm, mm per parameter and its square.)";

constexpr const char* shape_doc = R"(shape($self, /, u, v, side='along')
--

Normals and principal curvatures.

Parameters
----------
u, v : array_like
    Of one shape.
side : {'along', 'against'}
    The normal is S_u × S_v, or against it.

Returns
-------
dict
    `normal`, ndarray (*u.shape, 3), unit; `curvatures_per_mm`, ndarray (*u.shape, 2), the larger first, positive where
    the surface falls away from its tangent plane against the normal. NaN where there is no normal.)";

constexpr const char* closest_doc = R"(closest($self, /, points_mm)
--

The place of the domain that is nearest to each point: from the nearest place of a grid, by Newton's method.

Parameters
----------
points_mm : array_like, shape (..., 3)
    mm.

Returns
-------
ndarray, shape (..., 2)
    u and v.)";

void bind_surfaces(py::module_& module) {
    py::class_<BsplineSurface, std::shared_ptr<BsplineSurface>>(module, "BsplineSurface", bspline_surface_doc)
        .def(py::init(&make_surface), py::arg("degree_u"), py::arg("degree_v"), py::arg("knots_u"), py::arg("knots_v"),
             py::arg("control_points_mm"), py::arg("weights") = py::none())
        .def_static("polynomial", &polynomial, py::arg("coefficients_mm"), polynomial_doc)
        .def_property_readonly(
            "domain",
            [](const BsplineSurface& s) {
                return py::make_tuple(py::make_tuple(s.u().begin(), s.u().end()),
                                      py::make_tuple(s.v().begin(), s.v().end()));
            },
            "tuple: ((u begin, u end), (v begin, v end)).")
        .def_property_readonly(
            "control_points_mm",
            [](py::object self) {
                const auto& surface = self.cast<const BsplineSurface&>();
                constexpr auto number = static_cast<py::ssize_t>(sizeof(double));
                const auto columns = static_cast<py::ssize_t>(surface.v().points());
                return view_of(surface.control_points_mm().data(), py::dtype::of<double>(),
                               {static_cast<py::ssize_t>(surface.u().points()), columns, 3},
                               {columns * 3 * number, 3 * number, number}, self);
            },
            "ndarray, shape (n, m, 3): mm; read-only, no copy.")
        .def("__call__", &surface_points, py::arg("u"), py::arg("v"), call_doc)
        .def("derivatives", &surface_derivatives, py::arg("u"), py::arg("v"), derivatives_doc)
        .def("shape", &surface_shape, py::arg("u"), py::arg("v"), py::arg("side") = "along", shape_doc)
        .def("closest", &closest_places, py::arg("points_mm"), closest_doc);
}

}  // namespace trunnion::python
