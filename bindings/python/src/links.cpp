#include <algorithm>
#include <cmath>
#include <memory>

#include <fmt/format.h>
#include <pybind11/stl.h>

#include "trunnion/smoothing/connection.hpp"
#include "trunnion/smoothing/link.hpp"

#include "bindings.hpp"
#include "series.hpp"

/// Links between the parameters of the curves of tip and tool axis.
namespace trunnion::python {

using geometry::BsplineCurve;
using geometry::DualSpline;
using smoothing::ParameterLink;

namespace {

/// Numbers from 0 to 1, of any shape.
Array shares_of(py::handle object, const char* name) {
    Array out = numbers_of(object, name);
    const auto odd = std::find_if(out.data(), out.data() + out.size(), [](double u) { return u < 0 || u > 1; });
    if (odd == out.data() + out.size()) return out;
    refuse({.code = "PY0003",
            .text = fmt::format("{}: out of range", name),
            .value = fmt::format("{}", *odd),
            .limit = "0 … 1"});
}

}  // namespace

Array link_values(const ParameterLink& link, py::handle u) {
    return at_each(shares_of(u, "u"), {4}, [&](double at, double* out) {
        const Taylor3 f = link.at(at);
        for (int order = 0; order < 4; ++order) out[order] = derivative(f, order);
    });
}

py::tuple linked_poses(const BsplineCurve& bottom, const BsplineCurve& top, const ParameterLink& link, py::handle u) {
    const Array at = shares_of(u, "u");
    const auto pose = [&](double share) { return smoothing::linked_pose(bottom, top, share, link.at(share)); };
    return py::make_tuple(
        at_each(at, {4, 3}, [&](double share, double* out) { put_derivatives(out, pose(share).tip_mm); }),
        at_each(at, {4, 3}, [&](double share, double* out) { put_derivatives(out, pose(share).tool_axis); }));
}

namespace {

Array inverse(const ParameterLink& self, py::handle value) {
    return at_each(shares_of(value, "value"), {}, [&](double at, double* out) { *out = self.inverse(at); });
}

py::tuple poses(const ParameterLink& self, const BsplineCurve& bottom, const BsplineCurve& top, py::handle u) {
    return linked_poses(bottom, top, self, u);
}

ParameterLink connect(const DualSpline& before, const BsplineCurve& bottom, const BsplineCurve& top,
                      const DualSpline& after, py::handle tangent_tolerance) {
    const double tolerance = positive_of(tangent_tolerance, "tangent_tolerance_deg") * degree;
    return value_of(smoothing::connect(before, bottom, top, after, tolerance));
}

constexpr const char* parameter_link_doc = R"(Link u_top = f(u_bottom) of the parameters of two curves, each over its
domain as 0 to 1: increasing, one polynomial of degree 7; made by `connect()`. Immutable.)";

constexpr const char* link_call_doc = R"(__call__($self, /, u)
--

f(u) and its first three derivatives.

Parameters
----------
u : array_like
    0 to 1, any shape.

Returns
-------
ndarray, shape (*u.shape, 4)

Raises
------
Error
    PY0001 to PY0003.)";

constexpr const char* link_inverse_doc = R"(inverse($self, /, value)
--

The u with f(u) = value.

Parameters
----------
value : array_like
    0 to 1, any shape.

Returns
-------
ndarray, the shape of value

Raises
------
Error
    PY0001 to PY0003.)";

constexpr const char* link_poses_doc = R"(poses($self, /, bottom, top, u)
--

Tip and unit tool axis of two curves joined by this link, with three derivatives by the tip's path length, exact.

Parameters
----------
bottom, top : BsplineCurve
    Any degrees and knots.
u : array_like
    Of the bottom curve as 0 to 1, any shape.

Returns
-------
tips : ndarray, shape (*u.shape, 4, 3)
    mm, 1, 1/mm, 1/mm².
axes : ndarray, shape (*u.shape, 4, 3)
    1, 1/mm, 1/mm², 1/mm³; not finite where the curves meet.

Source: Beudaert 2013, Eq. B.1 to B.5, with the change of the distance.)";

constexpr const char* connect_doc = R"(connect(before, bottom, top, after, tangent_tolerance_deg=5.7e-05)
--

The link of a pair of curves that leads from the end of one path to the beginning of another so that the orientation goes
on smoothly at both joins: C² where the curves meet the paths in position, tangent and curvature.

Parameters
----------
before, after : DualSpline
bottom, top : BsplineCurve
    Of the tip and the second point, between both; any degrees and knots.
tangent_tolerance_deg : float
    How far the top curve may leave another way than the path does, seen along the tool; above 0.

Returns
-------
ParameterLink

Raises
------
Error
    SMTH0111 to SMTH0114 at either end, SMTH0115 no polynomial through both ends increases; PY0001 to PY0003.

Source: Beudaert 2013, §2.6.)";

}  // namespace

void bind_links(py::module_& module) {
    py::class_<ParameterLink>(module, "ParameterLink", parameter_link_doc)
        .def("__call__", &link_values, py::arg("u"), link_call_doc)
        .def("inverse", &inverse, py::arg("value"), link_inverse_doc)
        .def("poses", &poses, py::arg("bottom"), py::arg("top"), py::arg("u"), link_poses_doc);
    module.def("connect", &connect, py::arg("before"), py::arg("bottom"), py::arg("top"), py::arg("after"),
               py::arg("tangent_tolerance_deg") = 5.7e-5, connect_doc);
}

}  // namespace trunnion::python
