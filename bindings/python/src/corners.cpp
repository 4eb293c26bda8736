#include <memory>
#include <optional>

#include <pybind11/stl.h>

#include "trunnion/smoothing/corner_study.hpp"

#include "bindings.hpp"
#include "links.hpp"
#include "machine.hpp"
#include "series.hpp"

namespace trunnion::python {

using smoothing::DualCorner;
using smoothing::ParameterLink;

namespace {

geometry::BsplineCurve corner_curve(py::handle before, py::handle corner, py::handle after, py::handle tolerance,
                                    py::handle ratio) {
    return value_of(smoothing::corner_spline(vector_of(before, "before_mm"), vector_of(corner, "corner_mm"),
                                             vector_of(after, "after_mm"),
                                             {number_of(tolerance, "tolerance_mm"), number_of(ratio, "ratio")}));
}

/// A corner and the link that is used with it.
struct BoundCorner {
    DualCorner corner;
    ParameterLink link;
};

smoothing::RuledPose pose_of(py::handle object, const char* name) {
    const auto points = points_of(object, name);
    if (points.size() != 2)
        refuse({.code = "PY0001",
                .text = std::string(name) + ": shape (2, 3) wanted",
                .hint = "the tip and the point above it"});
    return {points[0], points[1]};
}

BoundCorner dual_corner(py::handle before, py::handle corner, py::handle after, const py::kwargs& given) {
    Keywords keywords(given, "DualCorner");
    smoothing::DualCornerShape shape{.tip_tolerance_mm = 0.02, .top_tolerance_mm = 0.02};
    keywords.number("tip_tolerance_mm", shape.tip_tolerance_mm);
    keywords.number("top_tolerance_mm", shape.top_tolerance_mm);
    keywords.number("ratio", shape.ratio);
    bool optimised = true;
    constexpr Word<bool> links[]{{"optimised", true}, {"linear", false}};
    keywords.word("link", optimised, links);
    keywords.finish();
    DualCorner made = value_of(smoothing::dual_corner(pose_of(before, "before_mm"), pose_of(corner, "corner_mm"),
                                                      pose_of(after, "after_mm"), shape));
    if (!optimised) return {std::move(made), ParameterLink::linear()};
    const auto link = smoothing::closed_link(made);
    if (!link) refuse({.code = "SMTH0115", .text = "ratio: no polynomial link through both ends increases"});
    return {std::move(made), *link};
}

Array corner_link(const BoundCorner& self, py::handle u) {
    return link_values(self.link, u);
}

py::tuple poses(const BoundCorner& self, py::handle u) {
    return linked_poses(self.corner.curves.bottom(), self.corner.curves.top(), self.link, u);
}

py::dict discrete_link(const BoundCorner& self, py::handle step) {
    auto found = value_of(smoothing::discrete_link(self.corner, number_of(step, "step_mm")));
    py::dict out;
    out["bottom"] = py::array(static_cast<py::ssize_t>(found.bottom.size()), found.bottom.data());
    out["top"] = py::array(static_cast<py::ssize_t>(found.top.size()), found.top.data());
    out["spline"] = std::move(found.spline);
    return out;
}

py::dict sample(const BoundCorner& self, const machine::Machine& machine, py::handle setup, py::handle margin,
                py::handle height, py::handle per_part, py::handle feed) {
    const machine::Setup& placed = setup_of(setup);
    const auto kinematics = value_of(machine::Kinematics::make(machine, placed.workpiece, placed.tool.length_mm));
    const smoothing::StudiedMachine on{
        .kinematics = kinematics, .machine = machine, .programmed_mm_s = positive_of(feed, "feed_mm_min") / 60};
    const int steps = count_of(per_part, "per_part");
    constexpr int most = 1'000'000;
    if (steps < 1 || steps > most) refuse({.code = "PY0003", .text = "per_part: out of range", .limit = "1 … 1000000"});
    const auto samples = smoothing::sample_corner(
        self.corner, [&](double u) { return self.link.at(u); }, on, positive_of(margin, "margin_mm"),
        positive_of(height, "height_mm"), steps);
    const auto count = static_cast<py::ssize_t>(samples.size());
    Array length(count), criterion(count), limit(count), axes({count, py::ssize_t{4}, py::ssize_t{machine.axis_count}});
    for (py::ssize_t i = 0; i < count; ++i) {
        const auto& from = samples[static_cast<std::size_t>(i)];
        length.mutable_at(i) = from.length_mm;
        criterion.mutable_at(i) = from.criterion_rad_mm3;
        limit.mutable_at(i) = from.feed_limit_mm_s * 60;
        for (int order = 0; order < 4; ++order)
            for (int a = 0; a < machine.axis_count; ++a)
                axes.mutable_at(i, order, a) =
                    derivative(from.axes[static_cast<std::size_t>(a)], order) / unit_of(machine.axes[a]);
    }
    py::dict out;
    out["length_mm"] = length;
    out["criterion_rad_mm3"] = criterion;
    out["feed_limit_mm_min"] = limit;
    out["axes"] = axes;
    return out;
}

}  // namespace

constexpr const char* corner_curve_doc = R"(corner_curve(before_mm, corner_mm, after_mm, tolerance_mm, ratio=1.4)
--

The rounded corner of two segments: a cubic B-spline of five points over at most half of the shorter one.

Parameters
----------
before_mm, corner_mm, after_mm : array_like, shape (3,)
    mm.
tolerance_mm : float
    From the corner to the curve, above 0.
ratio : float
    Outer length over inner length, above 1.

Returns
-------
BsplineCurve

Raises
------
Error
    SMTH0101 tolerance, SMTH0102 a segment without length, SMTH0103 the way back is the way there, SMTH0104 ratio.

Source: Beudaert 2013, §2.2 and appendix A.)";

constexpr const char* dual_corner_doc = R"(DualCorner(before_mm, corner_mm, after_mm, **options)
--

A rounded five-axis corner: curves of the tip and of a point above it, and the link u_top = f(u) of their parameters.

Parameters
----------
before_mm, corner_mm, after_mm : array_like, shape (2, 3)
    The tip and the point above it, mm, at the ends of two ruled segments and where they meet.
tip_tolerance_mm, top_tolerance_mm : float
    From each corner to its curve, above 0; 0.02.
ratio : float
    Outer over inner length of the tip's curve, above 1; 1.4.
link : {'optimised', 'linear'}
    So that the tool turns C² (default), or u_top = u for comparison.

Raises
------
Error
    SMTH0101 to SMTH0104 as corner_curve(); SMTH0115 no link increases.

Source: Beudaert 2013, §2.2 to §2.6; docs/theory/corner-rounding.md.)";

constexpr const char* link_doc = R"(link($self, /, u)
--

u_top = f(u) and its first three derivatives.

Parameters
----------
u : array_like
    0 to 1, any shape.

Returns
-------
ndarray, shape (*u.shape, 4))";

constexpr const char* poses_doc = R"(poses($self, /, u)
--

Tip and unit tool axis with three derivatives by the tip's path length, exact.

Parameters
----------
u : array_like
    Of the tip's curve, 0 to 1, any shape.

Returns
-------
tips : ndarray, shape (*u.shape, 4, 3)
    mm, 1, 1/mm, 1/mm².
axes : ndarray, shape (*u.shape, 4, 3)
    1, 1/mm, 1/mm², 1/mm³.

Source: Beudaert 2013, Eq. B.1 to B.5, with the change of the distance.)";

constexpr const char* discrete_link_doc = R"(discrete_link($self, /, step_mm)
--

The parametrization spline as it was published: top parameters at three places a step apart after the entry and before the
exit, each found so that Eq. 11 by backward Euler is least, interpolated by a cubic. For comparison; `link()` is what is
used.

Parameters
----------
step_mm : float
    Above 0; six of them are no longer than the corner.

Returns
-------
dict
    `bottom`, `top` ndarray (8,), 0 and 1 at the ends; `spline` BsplineCurve (u_bottom, u_top, 0) over u_bottom.

Raises
------
Error
    SMTH0121 the step, SMTH0122 no parameter found; PY0001, PY0002.

Source: Beudaert 2013, §2.5.)";

constexpr const char* sample_doc =
    R"(sample($self, machine, setup=None, margin_mm=1.0, height_mm=30.0, per_part=50, feed_mm_min=6000.0)
--

What a machine makes of the corner, from the segment before to the segment behind it.

Parameters
----------
machine : Machine
setup : Setup, optional
margin_mm : float
    Of both segments, above 0.
height_mm : float
    Of the point above the tip.
per_part : int
    Steps on each segment and on each half of the corner.
feed_mm_min : float
    Programmed, above 0.

Returns
-------
dict
    `length_mm` (n,) along the tip's path, 0 at the entry; `criterion_rad_mm3` (n,), Eq. 11; `feed_limit_mm_min` (n,),
    Eq. 10; `axes` (n, 4, axes) positions and derivatives by length, mm and degrees. At joins two samples stand at one
    place.

Source: Beudaert 2013, Eq. 10 and 11.)";

void bind_corners(py::module_& module) {
    module.def("corner_curve", &corner_curve, py::arg("before_mm"), py::arg("corner_mm"), py::arg("after_mm"),
               py::arg("tolerance_mm"), py::arg("ratio") = smoothing::usual_corner_ratio, corner_curve_doc);

    py::class_<BoundCorner>(module, "DualCorner", dual_corner_doc)
        .def(py::init(&dual_corner), py::arg("before_mm"), py::arg("corner_mm"), py::arg("after_mm"))
        .def_property_readonly(
            "curves", [](const BoundCorner& self) { return self.corner.curves; },
            "DualSpline: both curves over the knots 0 0 0 0 ½ 1 1 1 1.")
        .def("link", &corner_link, py::arg("u"), link_doc)
        .def("poses", &poses, py::arg("u"), poses_doc)
        .def("discrete_link", &discrete_link, py::arg("step_mm"), discrete_link_doc)
        .def("sample", &sample, py::arg("machine"), py::arg("setup") = py::none(), py::arg("margin_mm") = 1.0,
             py::arg("height_mm") = 30.0, py::arg("per_part") = 50, py::arg("feed_mm_min") = 6000.0, sample_doc);
}

}  // namespace trunnion::python
