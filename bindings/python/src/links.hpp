#pragma once

#include "trunnion/geometry/bspline_curve.hpp"
#include "trunnion/smoothing/link.hpp"

#include "arguments.hpp"

/// Links between the parameters of the curves of tip and tool axis, at shares u of the tip's curve.
namespace trunnion::python {

/// f(u) with three derivatives: (…, 4).
Array link_values(const smoothing::ParameterLink& link, py::handle u);
/// Tips and tool axes with three derivatives by the tip's path length: (…, 4, 3) each.
py::tuple linked_poses(const geometry::BsplineCurve& bottom, const geometry::BsplineCurve& top,
                       const smoothing::ParameterLink& link, py::handle u);

}  // namespace trunnion::python
