#include "stretches.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <pybind11/stl.h>

#include "trunnion/path/rotary_stands.hpp"
#include "trunnion/smoothing/pole_tolerance.hpp"

#include "bindings.hpp"
#include "machine.hpp"
#include "planning.hpp"
#include "series.hpp"

namespace trunnion::python {

using machine::Machine;

path::PathPlace BoundStretch::place_at(double p_mm) const {
    const auto behind = std::ranges::upper_bound(tool_path.pieces, p_mm, {}, &path::PathPiece::begin_mm);
    const auto piece = static_cast<std::size_t>(std::max<std::ptrdiff_t>(behind - tool_path.pieces.begin() - 1, 0));
    const path::PathPiece& at = tool_path.pieces[piece];
    return {piece, std::clamp(p_mm - at.begin_mm, 0.0, at.length_mm)};
}

namespace {

/// Where the rotary axes stand before a stretch: as the last one left them, but at the beginning and at the pole as the
/// moves to come want them.
machine::RotaryPosition standing_before(const path::ToolPath& tool_path, const path::Run& run,
                                        const std::vector<SharedStretch>& before) {
    const auto wanted = run.stands.empty() ? machine::RotaryPosition{} : run.stands[tool_path.blocks.front().run_block];
    if (before.empty()) return wanted;
    const auto begin = path::evaluate(tool_path.pieces.front(), 0);
    const Eigen::Vector3d axis(begin[3].value(), begin[4].value(), begin[5].value());
    if (!run.stands.empty() && tool_path.kinematics->rotary_for(axis.normalized()).degenerate) return wanted;
    const BoundStretch& last = *before.back();
    const auto end = last.axis_path->end_position();
    machine::RotaryPosition out{};
    for (int r = 0; r < last.machine().rotary_count; ++r) out[r] = end[last.machine().linear_count() + r];
    return out;
}

SharedStretch stretch_of(path::ToolPath&& tool_path, const path::Run& run, std::shared_ptr<const StretchOrigin> origin,
                         const std::vector<SharedStretch>& before) {
    auto out = std::make_shared<BoundStretch>(BoundStretch{std::move(origin), std::move(tool_path), {}});
    const auto near = standing_before(out->tool_path, run, before);
    auto made = path::AxisPath::make(out->tool_path, out->machine(), near);
    if (!made && made.error().place.line == 0) made.error().place.line = out->tool_path.blocks.front().line;
    out->axis_path.emplace(value_of(std::move(made)));
    return out;
}

}  // namespace

std::vector<SharedStretch> stretches_of(std::shared_ptr<StretchOrigin> origin,
                                        const smoothing::SmoothingOptions& options) {
    origin->stands = value_of(path::choose_rotary_stands(*origin->program, *origin->machine, origin->setup,
                                                         smoothing::pole_tolerance_rad(options)));
    origin->builder.emplace(
        value_of(path::PathBuilder::make(*origin->program, *origin->machine, origin->setup, origin->stands)));
    std::vector<SharedStretch> out;
    path::Run run;
    while (value_of(origin->builder->next(run))) {
        auto how = options;
        how.controlled_height_mm = run.controlled_height_mm;
        std::vector<path::ToolPath> smoothed;
        smoothing::smooth(run, how, smoothed);
        for (path::ToolPath& tool_path : smoothed) out.push_back(stretch_of(std::move(tool_path), run, origin, out));
    }
    return out;
}

namespace {

std::vector<std::shared_ptr<BoundStretch>> stretches(std::shared_ptr<program::Program> program,
                                                     std::shared_ptr<Machine> machine, py::handle setup,
                                                     const py::kwargs& given) {
    Keywords keywords(given, "stretches");
    smoothing::SmoothingOptions tolerances;
    take_tolerances(keywords, tolerances);
    keywords.finish();
    auto origin = std::make_shared<StretchOrigin>();
    origin->machine = std::move(machine);
    origin->program = std::move(program);
    origin->setup = setup_of(setup);
    const py::gil_scoped_release released;
    std::vector<std::shared_ptr<BoundStretch>> out;
    for (const SharedStretch& one : stretches_of(std::move(origin), tolerances))
        out.push_back(std::const_pointer_cast<BoundStretch>(one));
    return out;
}

/// Places on a stretch, p in mm.
Array places_of(py::handle object, const BoundStretch& stretch) {
    Array out = numbers_of(object, "p_mm");
    const double end = stretch.tool_path.length_mm();
    const auto odd = std::find_if(out.data(), out.data() + out.size(), [&](double p) { return p < 0 || p > end; });
    if (odd == out.data() + out.size()) return out;
    refuse({.code = "PY0003",
            .text = "p_mm: out of range",
            .value = fmt::format("{}", *odd),
            .limit = fmt::format("0 … {}", end)});
}

path::AxisSample sample_at(const BoundStretch& stretch, double p_mm) {
    path::AxisSample out;
    stretch.axis_path->evaluate(stretch.place_at(p_mm), out);
    return out;
}

py::tuple poses(const BoundStretch& self, py::handle p) {
    const Array at = places_of(p, self);
    return py::make_tuple(
        at_each(at, {4, 3}, [&](double place, double* out) { put_derivatives(out, sample_at(self, place).tip); }),
        at_each(at, {4, 3},
                [&](double place, double* out) { put_derivatives(out, sample_at(self, place).tool_axis); }));
}

Array axes(const BoundStretch& self, py::handle p) {
    const Machine& machine = self.machine();
    return at_each(places_of(p, self), {4, machine.axis_count}, [&](double place, double* out) {
        const path::AxisSample sample = sample_at(self, place);
        for (int order = 0; order < 4; ++order)
            for (int a = 0; a < machine.axis_count; ++a)
                *out++ = derivative(sample.axes[static_cast<std::size_t>(a)], order) / unit_of(machine.axes[a]);
    });
}

py::dict blocks(const BoundStretch& self) {
    const auto& spans = self.tool_path.blocks;
    const auto count = static_cast<py::ssize_t>(spans.size());
    py::array_t<std::int32_t> lines(count);
    Array ends({count, py::ssize_t{2}});
    for (py::ssize_t i = 0; i < count; ++i) {
        const path::BlockSpan& span = spans[static_cast<std::size_t>(i)];
        lines.mutable_at(i) = span.line;
        ends.mutable_at(i, 0) = span.begin_mm;
        ends.mutable_at(i, 1) = span.end_mm;
    }
    py::dict out;
    out["line"] = lines;
    out["p_mm"] = ends;
    return out;
}

constexpr const char* stretches_doc = R"(stretches(program, machine, setup=None, **tolerances)
--

The path of a program through a machine, smoothed: its stretches from rest to rest, whose speed `plan_stretch()` plans one
by one. plan() does it all at once; where the tool stands at the pole it also turns a free axis in place between two
stretches, which is not among them. The GIL is released.

Parameters
----------
program : Program
machine : Machine
setup : Setup, optional
tip_tolerance_mm, orientation_tolerance_deg, flank_tolerance_mm, flank_height_mm, rounding, corners, link : optional
    As in plan().

Returns
-------
list of Stretch

Raises
------
Error
    codes PATH… with the line; PY0001 to PY0004 by the argument's name.)";

constexpr const char* poses_doc = R"(poses($self, /, p_mm)
--

Tip and unit tool axis in the workpiece, with three derivatives by p.

Parameters
----------
p_mm : array_like
    0 to `length_mm`, any shape.

Returns
-------
tips : ndarray, shape (*p.shape, 4, 3)
    mm, 1, 1/mm, 1/mm².
axes : ndarray, shape (*p.shape, 4, 3)
    1, 1/mm, 1/mm², 1/mm³.

Raises
------
Error
    PY0001 to PY0003 by the argument's name.)";

constexpr const char* axes_doc = R"(axes($self, /, p_mm)
--

Positions of the machine's axes with three derivatives by p, exact to rounding.

Parameters
----------
p_mm : array_like
    0 to `length_mm`, any shape.

Returns
-------
ndarray, shape (*p.shape, 4, axes)
    mm or degrees per mm^k, in the order of `machine.axes`.

Raises
------
Error
    PY0001 to PY0003 by the argument's name.)";

}  // namespace

void bind_stretches(py::module_& module) {
    py::class_<BoundStretch, std::shared_ptr<BoundStretch>>(
        module, "Stretch",
        R"(A piece of path from rest to rest, C³ over its parameter p in mm; made by `stretches()`. Immutable.

dp² = |dtip|² + (30 mm · turn)²: pure turns have a length too.)")
        .def_property_readonly(
            "length_mm", [](const BoundStretch& s) { return s.tool_path.length_mm(); }, "float: of p.")
        .def_property_readonly(
            "rapid", [](const BoundStretch& s) { return s.tool_path.rapid; }, "bool.")
        .def_property_readonly(
            "deviation",
            [](const BoundStretch& s) {
                py::dict out;
                out["tip_mm"] = s.tool_path.bound.tip_mm;
                out["orientation_deg"] = s.tool_path.bound.orientation_rad / degree;
                return out;
            },
            "dict: `tip_mm`, `orientation_deg`: bounds of how far smoothing has led it off the program.")
        .def_property_readonly("blocks", &blocks,
                               "dict of ndarray: `line` (n,) and `p_mm` (n, 2), where the program's blocks lie.")
        .def("poses", &poses, py::arg("p_mm"), poses_doc)
        .def("axes", &axes, py::arg("p_mm"), axes_doc)
        .def("__repr__", [](const BoundStretch& s) {
            return fmt::format("<trunnion.Stretch: {:.3f} mm>", s.tool_path.length_mm());
        });
    module.def("stretches", &stretches, py::arg("program").none(false), py::arg("machine").none(false),
               py::arg("setup") = py::none(), stretches_doc);
}

}  // namespace trunnion::python
