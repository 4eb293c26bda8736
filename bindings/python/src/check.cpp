#include "trunnion/verify/check.hpp"

#include <algorithm>
#include <memory>

#include <fmt/format.h>
#include <pybind11/stl.h>

#include "trunnion/files/setpoint_file.hpp"
#include "trunnion/pipeline/check_setpoints.hpp"
#include "trunnion/pipeline/expand_surfaces.hpp"
#include "trunnion/pipeline/programmed.hpp"
#include "trunnion/program/program_parts.hpp"

#include "bindings.hpp"
#include "machine.hpp"
#include "planning.hpp"
#include "series.hpp"

namespace trunnion::python {

namespace {

/// A program as its only part.
class OnePart final : public program::ProgramParts {
  public:
    explicit OnePart(program::Program program) : program_(std::move(program)) {}
    Result<bool> next(program::Program& part) override {
        if (given_) return false;
        part = std::move(program_);
        return given_ = true;
    }

  private:
    program::Program program_;
    bool given_ = false;
};

Result<pipeline::Programmed> programmed(const program::Program& program, const machine::Machine& machine,
                                        const machine::Setup& setup, const smoothing::SmoothingOptions& tolerances) {
    auto expanded = pipeline::expand_surfaces(program, setup);
    if (!expanded) return fail(expanded.error());
    OnePart part(std::move(*expanded));
    return pipeline::programmed_poses(part, machine, setup, tolerances);
}

constexpr Word<verify::PoseKind> pose_kinds[]{
    {"vector", verify::PoseKind::vector}, {"rotary", verify::PoseKind::rotary}, {"rapid", verify::PoseKind::rapid}};

py::dict programmed_poses(const program::Program& program, const machine::Machine& machine, py::handle setup,
                          const py::kwargs& given) {
    Keywords keywords(given, "programmed_poses");
    smoothing::SmoothingOptions tolerances;
    take_tolerances(keywords, tolerances);
    keywords.finish();
    const machine::Setup& placed = setup_of(setup);
    const auto found = [&] {
        const py::gil_scoped_release released;
        return programmed(program, machine, placed, tolerances);
    }();
    const auto poses = value_of(found).poses;
    const auto count = static_cast<py::ssize_t>(poses.size());
    Array tips({count, py::ssize_t{3}}), axes({count, py::ssize_t{3}});
    Array rotary({count, static_cast<py::ssize_t>(machine.rotary_count)});
    py::array_t<std::int32_t> lines(count);
    py::list kinds;
    double *tip = tips.mutable_data(), *axis = axes.mutable_data(), *angle = rotary.mutable_data();
    std::int32_t* line = lines.mutable_data();
    for (const verify::ProgrammedPose& pose : poses) {
        tip = put(tip, pose.tip_mm);
        axis = put(axis, pose.axis);
        for (int r = 0; r < machine.rotary_count; ++r) *angle++ = pose.rotary_rad[static_cast<std::size_t>(r)] / degree;
        *line++ = pose.line;
        kinds.append(name_of(pose.kind, pose_kinds));
    }
    py::dict out;
    out["tips_mm"] = tips;
    out["axes"] = axes;
    out["rotary_deg"] = rotary;
    out["lines"] = lines;
    out["kinds"] = kinds;
    return out;
}

/// Rows of Plan.setpoints as setpoints.
std::vector<motion::Setpoint> setpoints_of(py::handle object, const machine::Machine& machine) {
    const int width = static_cast<int>(files::setpoint_columns(machine).size()), axes = machine.axis_count;
    const Rows rows = rows_of(object, "setpoints", width);
    std::vector<motion::Setpoint> out(static_cast<std::size_t>(rows.count));
    constexpr double most = 2147483647;
    for (std::size_t i = 0; i < out.size(); ++i) {
        const double* row = rows.row(static_cast<py::ssize_t>(i));
        motion::Setpoint& to = out[i];
        to.time_s = row[0];
        for (int a = 0; a < axes; ++a) to.position[static_cast<std::size_t>(a)] = row[1 + a] * unit_of(machine.axes[a]);
        const double line = row[axes + 1];
        if (line < 0 || line > most)
            refuse({.code = "PY0003", .text = fmt::format("setpoints: no line number in row {}", i)});
        to.line = static_cast<std::int32_t>(line);
        to.path_length_mm = row[axes + 2];
        to.feed_mm_s = row[axes + 3] / 60;
    }
    return out;
}

verify::CheckOptions check_options(const smoothing::SmoothingOptions& tolerances) {
    return {.tip_tolerance_mm = tolerances.tip_tolerance_mm,
            .orientation_tolerance_rad = tolerances.orientation_tolerance_rad,
            .flank_tolerance_mm = tolerances.flank_tolerance_mm,
            .flank_height_mm = tolerances.flank_height_mm};
}

py::object check(py::handle setpoints, const program::Program& program, const machine::Machine& machine,
                 py::handle setup, const py::kwargs& given) {
    Keywords keywords(given, "check");
    smoothing::SmoothingOptions tolerances;
    take_tolerances(keywords, tolerances);
    keywords.finish();
    const machine::Setup& placed = setup_of(setup);
    if (py::isinstance<BoundPlan>(setpoints)) setpoints = setpoints.cast<const BoundPlan&>().setpoints;
    auto rows = setpoints_of(setpoints, machine);
    const auto verdict = [&]() -> Result<verify::Verdict> {
        const py::gil_scoped_release released;
        const auto table = verify::setpoint_table(std::move(rows));
        if (!table) return fail(table.error());
        const auto asked = programmed(program, machine, placed, tolerances);
        if (!asked) return fail(asked.error());
        return verify::check(*table, asked->poses, machine, placed, check_options(tolerances));
    }();
    return from_json(pipeline::to_json(value_of(verdict)));
}

}  // namespace

constexpr const char* check_doc = R"(check(setpoints, program, machine, setup=None, **tolerances)
--

Independent verdict on setpoints: limits, tolerances, path covered. The GIL is released.

Parameters
----------
setpoints : Plan or array_like, shape (n, columns)
    Columns as Plan.columns: t_s, the axes in mm and degrees, line, s_mm, feed_mm_min.
program : Program
machine : Machine
setup : Setup, optional
tip_tolerance_mm, orientation_tolerance_deg, flank_tolerance_mm, flank_height_mm, rounding : optional
    As given to plan().

Returns
-------
dict
    `ok`, deviations, ratios by axis, `broken`: what `trunnion check --summary` writes.

Raises
------
Error
    VER0206 rows that are not one period apart, other codes VER…; PY0001 shape, PY0002 not finite.)";

constexpr const char* programmed_poses_doc = R"(programmed_poses(program, machine, setup=None, **tolerances)
--

The poses that a program asks for, with arcs, curves and moves of the machine axes as chords within 0.1 µm.

Parameters
----------
program : Program
machine : Machine
setup : Setup, optional
**tolerances
    As given to plan(): branch and winding are chosen with them.

Returns
-------
dict
    `tips_mm` ndarray (n, 3), `axes` ndarray (n, 3), `rotary_deg` ndarray (n, rotary axes) with NaN where the program does
    not say, `lines` ndarray (n,), `kinds` list of 'vector', 'rotary', 'rapid'.

Raises
------
Error
    codes VER01…, codes PATH… with the line.)";

void bind_check(py::module_& module) {
    module.def("check", &check, py::arg("setpoints"), py::arg("program"), py::arg("machine"),
               py::arg("setup") = py::none(), check_doc);
    module.def("programmed_poses", &programmed_poses, py::arg("program"), py::arg("machine"),
               py::arg("setup") = py::none(), programmed_poses_doc);
}

}  // namespace trunnion::python
