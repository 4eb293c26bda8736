#include <memory>

#include <pybind11/stl.h>

#include "trunnion/geometry/dual_spline.hpp"

#include "arguments.hpp"
#include "bindings.hpp"
#include "series.hpp"

namespace trunnion::python {

using geometry::BsplineCurve;
using geometry::DualSpline;

namespace {

BsplineCurve make_curve(py::handle degree, py::handle knots, py::handle points, py::handle weights) {
    return value_of(BsplineCurve::make(count_of(degree, "degree"), list_of(knots, "knots"),
                                       points_of(points, "control_points_mm"),
                                       weights.is_none() ? std::vector<double>{} : list_of(weights, "weights")));
}

Array curve_points(const BsplineCurve& curve, py::handle u) {
    return at_each(numbers_of(u, "u"), {3}, [&](double at, double* out) { put(out, curve.evaluate(at)[0]); });
}

Array curve_derivatives(const BsplineCurve& curve, py::handle u) {
    return at_each(numbers_of(u, "u"), {4, 3}, [&](double at, double* out) {
        for (const Eigen::Vector3d& derivative : curve.evaluate(at)) out = put(out, derivative);
    });
}

constexpr const char* bspline_curve_doc = R"(BsplineCurve(degree, knots, control_points_mm, weights=None)
--

B-spline curve C(u) = Σ N_i(u) P_i, with weights Σ N_i w_i P_i / Σ N_i w_i. Immutable.

Parameters
----------
degree : int
    p, 1 to 7.
knots : array_like, shape (n + p + 1,)
    Never falling, clamped or not.
control_points_mm : array_like, shape (n, 3)
    mm.
weights : array_like, shape (n,), optional
    Positive. None: all 1.

Raises
------
Error
    GEOM0101 degree, GEOM0102 numbers of knots and points do not fit, GEOM0103 and GEOM0104 knots, GEOM0107 weights;
    PY0001 and PY0002 by the argument's name.

Source: Piegl & Tiller, The NURBS Book, §3.2-3.3 and Eq. 4.8.)";

constexpr const char* call_doc = R"(__call__($self, /, u)
--

Points of the curve, mm.

Parameters
----------
u : array_like
    Any shape. Outside [begin, end] the first or last piece is continued.

Returns
-------
ndarray, shape (*u.shape, 3)
    mm.)";

constexpr const char* derivatives_doc = R"(derivatives($self, /, u)
--

The point and its first three derivatives by u; at an inner knot those on the right.

Parameters
----------
u : array_like
    Any shape.

Returns
-------
ndarray, shape (*u.shape, 4, 3)
    mm, mm/u, mm/u², mm/u³.)";

void bind_curve(py::module_& module) {
    py::class_<BsplineCurve, std::shared_ptr<BsplineCurve>>(module, "BsplineCurve", bspline_curve_doc)
        .def(py::init(&make_curve), py::arg("degree"), py::arg("knots"), py::arg("control_points_mm"),
             py::arg("weights") = py::none())
        .def_property_readonly("degree", &BsplineCurve::degree, "int: 1 to 7.")
        .def_property_readonly("begin", &BsplineCurve::begin, "float: where the domain begins.")
        .def_property_readonly("end", &BsplineCurve::end, "float: where the domain ends.")
        .def_property_readonly(
            "knots", [](py::object self) { return view_of_numbers(self.cast<const BsplineCurve&>().knots(), self); },
            "ndarray, shape (n + p + 1,): read-only, no copy.")
        .def_property_readonly(
            "control_points_mm",
            [](py::object self) { return view_of_points(self.cast<const BsplineCurve&>().control_points_mm(), self); },
            "ndarray, shape (n, 3): mm; read-only, no copy.")
        .def_property_readonly(
            "weights",
            [](py::object self) { return view_of_numbers(self.cast<const BsplineCurve&>().weights(), self); },
            "ndarray, shape (n,), or (0,) where all are 1: read-only, no copy.")
        .def("__call__", &curve_points, py::arg("u"), call_doc)
        .def("derivatives", &curve_derivatives, py::arg("u"), derivatives_doc);
}

DualSpline make_dual(const BsplineCurve& bottom, const BsplineCurve& top) {
    return value_of(DualSpline::make(bottom, top));
}

}  // namespace

constexpr const char* dual_spline_doc = R"(DualSpline(bottom, top)
--

Two curves over the same knots: the tool's tip runs on the bottom one, a second point of its axis on the top one.

Parameters
----------
bottom, top : BsplineCurve
    Of one degree and the same knots.

Raises
------
Error
    GEOM0106 they differ in degree or knots.

Source: Beudaert 2013, §2.2; Affouard et al. 2004.)";

constexpr const char* axis_doc = R"(axis($self, /, u)
--

Unit tool axis, from bottom to top, with its first three derivatives by u: exact, the change of the distance included.

Parameters
----------
u : array_like
    Any shape.

Returns
-------
ndarray, shape (*u.shape, 4, 3)
    1, 1/u, 1/u², 1/u³; NaN where the curves meet.)";

void bind_geometry(py::module_& module) {
    bind_curve(module);
    py::class_<DualSpline, std::shared_ptr<DualSpline>>(module, "DualSpline", dual_spline_doc)
        .def(py::init(&make_dual), py::arg("bottom"), py::arg("top"))
        .def_property_readonly("bottom", &DualSpline::bottom, "BsplineCurve: of the tip.")
        .def_property_readonly("top", &DualSpline::top, "BsplineCurve: of the second point.")
        .def_property_readonly("begin", &DualSpline::begin, "float: where the domain begins.")
        .def_property_readonly("end", &DualSpline::end, "float: where the domain ends.")
        .def(
            "axis",
            [](const DualSpline& self, py::handle u) {
                return at_each(numbers_of(u, "u"), {4, 3},
                               [&](double at, double* out) { put_derivatives(out, self.axis(at)); });
            },
            py::arg("u"), axis_doc);
}

}  // namespace trunnion::python
