#include "machine.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <pybind11/stl.h>

#include "trunnion/files/machine_file.hpp"
#include "trunnion/files/setup_file.hpp"
#include "trunnion/files/shipped_machines.hpp"

#include "bindings.hpp"
#include "series.hpp"

namespace trunnion::python {

using machine::Machine;
using machine::Setup;
using machine::Tool;

const Setup& setup_of(py::handle object) {
    static const Setup none;
    return object.is_none() ? none : object_of<Setup>(object, "setup");
}

BoundKinematics kinematics_of(std::shared_ptr<Machine> machine, py::handle setup) {
    const Setup& placed = setup_of(setup);
    auto kinematics = value_of(machine::Kinematics::make(*machine, placed.workpiece, placed.tool.length_mm));
    return {std::move(machine), std::move(kinematics)};
}

namespace {

/// Rows of axis positions, mm and degrees, as the library counts them.
machine::AxisPosition position_of(const double* row, const Machine& machine) {
    machine::AxisPosition out;
    for (int i = 0; i < machine.axis_count; ++i) out[static_cast<std::size_t>(i)] = row[i] * unit_of(machine.axes[i]);
    return out;
}

machine::RotaryPosition rotary_of(py::handle object, const char* name, const Machine& machine) {
    machine::RotaryPosition out{};
    if (object.is_none()) return out;
    const std::vector<double> angles = list_of(object, name);
    if (angles.size() != static_cast<std::size_t>(machine.rotary_count))
        refuse({.code = "PY0001",
                .text = fmt::format("{}: one angle for each rotary axis wanted", name),
                .value = fmt::format("{}", angles.size()),
                .limit = fmt::format("{}", machine.rotary_count)});
    for (std::size_t i = 0; i < angles.size(); ++i) out[i] = angles[i] * degree;
    return out;
}

py::tuple forward(const BoundKinematics& self, py::handle positions) {
    const Machine& machine = *self.machine;
    const Rows rows = rows_of(positions, "positions", machine.axis_count);
    Array tips = array_of(rows.leading, {3}), axes = array_of(rows.leading, {3});
    double *tip = tips.mutable_data(), *axis = axes.mutable_data();
    for (py::ssize_t i = 0; i < rows.count; ++i) {
        const machine::Pose pose = self.kinematics.forward(position_of(rows.row(i), machine));
        tip = put(tip, pose.tip_in_workpiece_mm);
        axis = put(axis, pose.axis_in_workpiece);
    }
    return py::make_tuple(tips, axes);
}

[[noreturn]] void refuse_reach(py::ssize_t row) {
    refuse(
        {.code = "PATH0101", .text = fmt::format("axes: the machine does not reach the orientation of row {}", row)});
}

Array inverse(const BoundKinematics& self, py::handle tips, py::handle axes, py::handle near) {
    const Machine& machine = *self.machine;
    const Rows tip = rows_of(tips, "tips", 3), axis = directions_like(axes, "axes", tip, "tips");
    machine::RotaryPosition rotary = rotary_of(near, "near_deg", machine);
    Array out = array_of(tip.leading, {machine.axis_count});
    double* position = out.mutable_data();
    for (py::ssize_t i = 0; i < tip.count; ++i) {
        const Eigen::Vector3d n = axis.vector(i);
        if (self.kinematics.rotary_for(n).count == 0) refuse_reach(i);
        const auto series = self.kinematics.rotary_series({n.x(), n.y(), n.z()}, rotary);
        for (std::size_t r = 0; r < rotary.size(); ++r) rotary[r] = series[r].value();
        position = std::ranges::copy(self.kinematics.linear_for(tip.vector(i), rotary), position).out;
        for (int r = 0; r < machine.rotary_count; ++r) *position++ = rotary[static_cast<std::size_t>(r)] / degree;
    }
    return out;
}

machine::VectorSeries vector_series(const double* rows) {
    return {series_from(rows, 3), series_from(rows + 1, 3), series_from(rows + 2, 3)};
}

/// (…, 4, 3): value and three derivatives.
Rows series_rows(py::handle object, const char* name) {
    Rows out = rows_of(object, name, 3);
    if (out.leading.empty() || out.leading.back() != 4)
        refuse({.code = "PY0001",
                .text = fmt::format("{}: shape (…, 4, 3) wanted", name),
                .hint = "value and three derivatives, a row each"});
    return out;
}

void check_derivatives(const Rows& tips, const Rows& axes) {
    if (axes.leading != tips.leading) refuse({.code = "PY0001", .text = "axes: the shape of tips wanted"});
    constexpr double shortest = 1e-9;
    for (py::ssize_t i = 0; i < axes.count; i += 4)
        if (axes.vector(i).norm() < shortest)
            refuse({.code = "PY0003", .text = fmt::format("axes: pose {} has an axis without length", i / 4)});
}

Array inverse_derivatives(const BoundKinematics& self, py::handle tips, py::handle axes, py::handle near) {
    const Machine& machine = *self.machine;
    const Rows tip = series_rows(tips, "tips"), axis = series_rows(axes, "axes");
    check_derivatives(tip, axis);
    machine::RotaryPosition rotary = rotary_of(near, "near_deg", machine);
    Array out = array_of(tip.leading, {machine.axis_count});
    for (py::ssize_t i = 0; i < tip.count; i += 4) {
        const machine::VectorSeries n = vector_series(axis.row(i));
        if (self.kinematics.rotary_for(axis.vector(i).normalized()).count == 0) refuse_reach(i / 4);
        const auto turn = self.kinematics.rotary_series(n, rotary);
        for (std::size_t r = 0; r < rotary.size(); ++r) rotary[r] = turn[r].value();
        const auto linear = self.kinematics.linear_for(vector_series(tip.row(i)), turn);
        double* row = out.mutable_data() + i * machine.axis_count;
        for (int order = 0; order < 4; ++order) {
            for (const Taylor3& series : linear) *row++ = derivative(series, order);
            for (int r = 0; r < machine.rotary_count; ++r)
                *row++ = derivative(turn[static_cast<std::size_t>(r)], order) / degree;
        }
    }
    return out;
}

Array branches(const BoundKinematics& self, py::handle axes) {
    const int count = self.machine->rotary_count;
    const Rows given = rows_of(axes, "axes", 3), axis = directions_like(axes, "axes", given, "axes");
    Array out = array_of(axis.leading, {2, count});
    std::fill_n(out.mutable_data(), out.size(), std::numeric_limits<double>::quiet_NaN());
    for (py::ssize_t i = 0; i < axis.count; ++i) {
        const auto solutions = self.kinematics.rotary_for(axis.vector(i));
        for (int k = 0; k < solutions.count; ++k)
            for (int r = 0; r < count; ++r)
                out.mutable_data()[(2 * i + k) * count + r] =
                    solutions.rotary_rad[static_cast<std::size_t>(k)][static_cast<std::size_t>(r)] / degree;
    }
    return out;
}

py::dict limits(const machine::AxisLimits& limits, double unit) {
    py::dict out;
    out["velocity"] = limits.velocity / unit;
    out["acceleration"] = limits.acceleration / unit;
    out["jerk"] = limits.jerk / unit;
    return out;
}

py::list axes(const Machine& machine) {
    py::list out;
    for (int i = 0; i < machine.axis_count; ++i) {
        const machine::Axis& axis = machine.axes[i];
        const double unit = unit_of(axis);
        py::dict row;
        row["letter"] = std::string(1, axis.letter);
        row["rotary"] = axis.rotary;
        row["reversed"] = axis.reversed;
        row["range"] = py::make_tuple(axis.range_min / unit, axis.range_max / unit);
        row["limits"] = limits(axis.feed, unit);
        row["rapid_limits"] = limits(axis.rapid, unit);
        out.append(row);
    }
    return out;
}

std::string chain(const Machine& machine) {
    std::string out;
    for (int i = 0; i < machine.axis_count; ++i)
        out += fmt::format("{}{}", i > 0 ? " " : "", machine.axes[static_cast<std::size_t>(machine.chain[i])].letter);
    return out;
}

constexpr const char* kinematics_doc = R"(Kinematics(machine, setup=None)
--

The geometry of one machine with the tool and the workpiece of one setup: positions are in mm and degrees in the order of
`machine.axes`, poses in the workpiece. Immutable.

Parameters
----------
machine : Machine
setup : Setup, optional
    None: program zero at the machine zero, tool length 0.

Raises
------
Error
    MACH0101 to MACH0103 a chain that cannot set a tool.

Source: closed form by the spherical triangle of both rotary axes; for `C A X Y Z` Lavernhe 2006, Eq. 3.)";

constexpr const char* forward_doc = R"(forward($self, /, positions)
--

Poses of axis positions.

Parameters
----------
positions : array_like, shape (..., axes)
    mm and degrees, in the order of `machine.axes`, in the control's count.

Returns
-------
tips : ndarray, shape (..., 3)
    Tip in the workpiece, mm.
axes : ndarray, shape (..., 3)
    Unit tool axis, tip to spindle.

Raises
------
Error
    PY0001 shape or type, PY0002 not finite.)";

constexpr const char* inverse_doc = R"(inverse($self, /, tips, axes, near_deg=None)
--

Axis positions of poses: each on the branch and winding nearest to the pose before, the first nearest to `near_deg`. Ranges
are not looked at.

Parameters
----------
tips : array_like, shape (..., 3)
    mm.
axes : array_like, shape (..., 3)
    Unit to 1e-6.
near_deg : array_like, shape (rotary axes,), optional
    Degrees; None: 0.

Returns
-------
ndarray, shape (..., axes)
    mm and degrees. Not finite where the linear axes come to lie in a plane.

Raises
------
Error
    PATH0101 an orientation out of reach; PY0001, PY0002, PY0003 by the argument's name.)";

constexpr const char* inverse_derivatives_doc = R"(inverse_derivatives($self, /, tips, axes, near_deg=None)
--

The same with three derivatives by any parameter, exact to rounding.

Parameters
----------
tips : array_like, shape (..., 4, 3)
    Tip and its derivatives, mm.
axes : array_like, shape (..., 4, 3)
    Tool axis and its derivatives; any length above 0.
near_deg : array_like, shape (rotary axes,), optional

Returns
-------
ndarray, shape (..., 4, axes)
    Positions and their derivatives, mm and degrees.

Raises
------
Error
    As inverse().)";

constexpr const char* branches_doc = R"(branches($self, /, axes)
--

All rotary positions that give an orientation, each in ]-180, 180] degrees.

Parameters
----------
axes : array_like, shape (..., 3)
    Unit to 1e-6.

Returns
-------
ndarray, shape (..., 2, rotary axes)
    Degrees; rows of NaN where there are fewer than two: out of reach, at a pole (the axis nearest to the workpiece is then
    given as 0) and at a rim.)";

void bind_kinematics(py::module_& module) {
    py::class_<BoundKinematics>(module, "Kinematics", kinematics_doc)
        .def(py::init(&kinematics_of), py::arg("machine").none(false), py::arg("setup") = py::none())
        .def("forward", &forward, py::arg("positions"), forward_doc)
        .def("inverse", &inverse, py::arg("tips"), py::arg("axes"), py::arg("near_deg") = py::none(), inverse_doc)
        .def("inverse_derivatives", &inverse_derivatives, py::arg("tips"), py::arg("axes"),
             py::arg("near_deg") = py::none(), inverse_derivatives_doc)
        .def("branches", &branches, py::arg("axes"), branches_doc);
}

constexpr const char* axes_doc = R"(list of dict: linear axes, then rotary ones, each in alphabetical order.

`letter`, `rotary`, `reversed`, `range` (least, most; mm or degrees, infinite: endless), `limits` and `rapid_limits` with
`velocity`, `acceleration`, `jerk` in mm or degrees, by s, s² and s³.)";

constexpr const char* machine_kinematics_doc = R"(kinematics($self, /, setup=None)
--

Its geometry with a setup: `Kinematics(machine, setup)`.)";

constexpr const char* machine_forward_doc = R"(forward($self, positions, setup=None)
--

Poses of axis positions: `kinematics(setup).forward(positions)`.)";

constexpr const char* machine_inverse_doc = R"(inverse($self, tips, axes, setup=None, near_deg=None)
--

Axis positions of poses: `kinematics(setup).inverse(tips, axes, near_deg)`.)";

void bind_machine_class(py::module_& module) {
    py::class_<Machine, std::shared_ptr<Machine>>(module, "Machine",
                                                  "A machine as its file says; made by `machine()`. Immutable.")
        .def_readonly("name", &Machine::name, "str: as the file says.")
        .def_readonly("file", &Machine::file, "str: where it was read from.")
        .def_property_readonly("chain", &chain, "str: letters from workpiece to tool.")
        .def_property_readonly("axes", &axes, axes_doc)
        .def_property_readonly(
            "columns",
            [](const Machine& machine) {
                std::vector<std::string> out;
                for (int i = 0; i < machine.axis_count; ++i)
                    out.push_back(fmt::format("{}_{}", machine.axes[i].letter, machine.axes[i].rotary ? "deg" : "mm"));
                return out;
            },
            "list of str: the axes as columns of positions, such as `X_mm` and `A_deg`.")
        .def("kinematics", &kinematics_of, py::arg("setup") = py::none(), machine_kinematics_doc)
        .def(
            "forward",
            [](std::shared_ptr<Machine> self, py::handle positions, py::handle setup) {
                return forward(kinematics_of(std::move(self), setup), positions);
            },
            py::arg("positions"), py::arg("setup") = py::none(), machine_forward_doc)
        .def(
            "inverse",
            [](std::shared_ptr<Machine> self, py::handle tips, py::handle axes, py::handle setup, py::handle near) {
                return inverse(kinematics_of(std::move(self), setup), tips, axes, near);
            },
            py::arg("tips"), py::arg("axes"), py::arg("setup") = py::none(), py::arg("near_deg") = py::none(),
            machine_inverse_doc)
        .def("__repr__", [](const Machine& machine) {
            return fmt::format("<trunnion.Machine {}: {}>", machine.name, chain(machine));
        });
}

constexpr Word<machine::ToolKind> tool_kinds[]{{"flat", machine::ToolKind::flat},
                                               {"ball", machine::ToolKind::ball},
                                               {"torus", machine::ToolKind::torus},
                                               {"taper", machine::ToolKind::taper}};

Tool make_tool(py::handle kind, py::handle diameter, py::handle corner_radius, py::handle length) {
    Tool out{.kind = word_of(kind, "kind", tool_kinds), .diameter_mm = positive_of(diameter, "diameter_mm")};
    out.corner_radius_mm = number_of(corner_radius, "corner_radius_mm");
    out.length_mm = number_of(length, "length_mm");
    if (out.kind == machine::ToolKind::ball) out.corner_radius_mm = out.diameter_mm / 2;
    if (out.corner_radius_mm < 0 || out.corner_radius_mm > out.diameter_mm / 2)
        refuse({.code = "PY0003",
                .text = "corner_radius_mm: out of range",
                .value = fmt::format("{}", out.corner_radius_mm),
                .limit = fmt::format("0 … {}", out.diameter_mm / 2)});
    return out;
}

constexpr const char* tool_doc = R"(Tool(kind, diameter_mm, corner_radius_mm=0.0, length_mm=0.0)
--

A cutting tool.

Parameters
----------
kind : {'flat', 'ball', 'torus', 'taper'}
diameter_mm : float
    Above 0.
corner_radius_mm : float
    0 to half the diameter; of a ball it is half the diameter, whatever is given.
length_mm : float
    Gauge line to tip.

Raises
------
Error
    PY0001 to PY0004 by the argument's name.)";

void bind_tool(py::module_& module) {
    py::class_<Tool>(module, "Tool", tool_doc)
        .def(py::init(&make_tool), py::arg("kind"), py::arg("diameter_mm"), py::arg("corner_radius_mm") = 0.0,
             py::arg("length_mm") = 0.0)
        .def_property_readonly(
            "kind", [](const Tool& tool) { return name_of(tool.kind, tool_kinds); }, "str.")
        .def_readonly("diameter_mm", &Tool::diameter_mm, "float.")
        .def_readonly("corner_radius_mm", &Tool::corner_radius_mm, "float.")
        .def_readonly("length_mm", &Tool::length_mm, "float: gauge line to tip.")
        .def_property_readonly("controlled_height_mm", &Tool::controlled_height_mm,
                               "float: the point that tolerances are of, up from the tip.");
}

void bind_setup(py::module_& module) {
    py::class_<Setup, std::shared_ptr<Setup>>(module, "Setup",
                                              "How part and tools sit in the machine; made by `setup()`. Immutable.")
        .def_readonly("file", &Setup::file, "str: where it was read from.")
        .def_readonly("tool", &Setup::tool, "Tool: of a program that names none.")
        .def_readonly("tools", &Setup::tools, "dict of str to Tool: by number or name.")
        .def_property_readonly(
            "origin_mm",
            [](py::object self) {
                const Eigen::Vector3d& origin = self.cast<const Setup&>().workpiece.origin_mm;
                return view_of(origin.data(), py::dtype::of<double>(), {3}, {sizeof(double)}, self);
            },
            "ndarray, shape (3,): program zero in the machine frame, all axes at 0; read-only.")
        .def_property_readonly(
            "rotation",
            [](const Setup& setup) {
                Array out = array_of({}, {3, 3});
                Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(out.mutable_data()) = setup.workpiece.rotation;
                return out;
            },
            "ndarray, shape (3, 3): turns workpiece directions into the machine frame.");
}

}  // namespace

void bind_machine(py::module_& module) {
    bind_tool(module);
    bind_setup(module);
    bind_machine_class(module);
    bind_kinematics(module);
    const auto find = [](py::handle source) {
        return std::make_shared<Machine>(
            value_of(files::find_machine(path_of(source, "source"), data_folders("machines"))));
    };
    module.def("find_machine", find, py::arg("source"));
    module.def(
        "read_machine_text",
        [](const std::string& toml, const std::string& name) {
            return std::make_shared<Machine>(value_of(files::read_machine(toml, name)));
        },
        py::arg("toml"), py::arg("name"));
    module.def("shipped_machines", [] {
        std::vector<std::string> out;
        for (const auto& machine : files::shipped_machines(data_folders("machines"))) out.push_back(machine.name);
        return out;
    });
    module.def(
        "read_setup_file",
        [](py::handle source) {
            return std::make_shared<Setup>(value_of(files::read_setup_file(path_of(source, "source"))));
        },
        py::arg("source"));
    module.def(
        "read_setup_text",
        [](const std::string& toml, const std::string& name) {
            return std::make_shared<Setup>(value_of(files::read_setup(toml, name)));
        },
        py::arg("toml"), py::arg("name"));
}

}  // namespace trunnion::python
