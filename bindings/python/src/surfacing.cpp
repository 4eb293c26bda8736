#include "surfacing.hpp"

#include <algorithm>
#include <memory>

#include <fmt/format.h>
#include <pybind11/stl.h>

#include "bindings.hpp"
#include "machine.hpp"

/// Passes over faces.
namespace trunnion::python {

using surfacing::Cutter;

Cutter cutter_of(const machine::Tool& tool, double reach_mm) {
    if (reach_mm < 0) refuse({.code = "PY0003", .text = "reach_mm: out of range", .limit = "0 or above"});
    return value_of(Cutter::make(tool, reach_mm));
}

namespace {

constexpr Word<surfacing::Strategy> strategies[]{{"constant-scallop", surfacing::Strategy::constant_scallop},
                                                 {"along-u", surfacing::Strategy::along_u},
                                                 {"along-v", surfacing::Strategy::along_v},
                                                 {"parallel-planes", surfacing::Strategy::parallel_planes},
                                                 {"lin-koren", surfacing::Strategy::lin_koren}};

}  // namespace

surfacing::SurfaceOptions take_surface_options(Keywords& keywords) {
    surfacing::SurfaceOptions out;
    constexpr double share_of_scallop = 0.05, share_of_gouge = 0.5;  // as on the command line
    std::optional<double> chord;
    keywords.word("strategy", out.strategy, strategies);
    keywords.number("scallop_mm", out.scallop_mm);
    keywords.number("chord_tolerance_mm", chord);
    keywords.number("gouge_tolerance_mm", out.gouge_tolerance_mm);
    out.chord_tolerance_mm =
        chord.value_or(std::min(share_of_scallop * out.scallop_mm, share_of_gouge * out.gouge_tolerance_mm));
    keywords.number("feed_angle_deg", out.feed_angle_rad, degree);
    keywords.number("lead_deg", out.lead_rad, degree);
    keywords.number("tilt_deg", out.tilt_rad, degree);
    keywords.flag("zigzag", out.zigzag);
    keywords.flag("borders", out.borders);
    keywords.number("lift_mm", out.lift_mm);
    keywords.number("retract_mm", out.retract_mm);
    keywords.number("longest_step_mm", out.longest_step_mm);
    keywords.number("feed_mm_min", out.feed_mm_s, 1.0 / 60);
    out.approach_mm_s = out.feed_mm_s;
    keywords.number("approach_feed_mm_min", out.approach_mm_s, 1.0 / 60);
    return out;
}

namespace {

/// What passes are freed of gouges against.
void take_freeing(Keywords& keywords, const Cutter& cutter, pipeline::SurfaceProgramOptions& options) {
    bool free = false;
    surfacing::OrientationLimits limits = pipeline::lean_limits(cutter, options.passes.lead_rad);
    keywords.flag("free_gouges", free);
    const py::handle others = keywords.take("others"), holder = keywords.take("holder_mm");
    if (others) options.others = faces_of(others, "others");
    if (holder) options.holder = holder_of(holder);
    for (const auto& [name, target] :
         {std::pair{"least_lead_deg", &limits.least_lead_rad}, std::pair{"most_lead_deg", &limits.most_lead_rad},
          std::pair{"most_tilt_deg", &limits.most_tilt_rad}}) {
        std::optional<double> given;
        keywords.number(name, given, degree);
        if (given && !free) refuse({.code = "PY0003", .text = fmt::format("{}: only with free_gouges", name)});
        if (given) *target = *given;
    }
    if (free) options.freeing = limits;
    if (!free && (others || holder))
        refuse(
            {.code = "PY0003", .text = "others, holder_mm: only with free_gouges", .hint = "see gouges() and check()"});
}

BoundSurfacePlan plan_surface(py::handle faces, const machine::Tool& tool, const py::kwargs& given) {
    Keywords keywords(given, "plan_surface");
    pipeline::SurfaceProgramOptions options{.passes = take_surface_options(keywords)};
    keywords.flag("splines", options.splines);
    keywords.text("tool_name", options.tool_name);
    double spindle_rpm = 0;
    keywords.number("spindle_rpm", spindle_rpm);
    options.spindle_rad_s = spindle_rpm * 6 * degree;
    double reach_mm = 0;
    keywords.number("reach_mm", reach_mm);
    const Cutter cutter = cutter_of(tool, reach_mm);
    take_freeing(keywords, cutter, options);
    keywords.finish();
    auto planned = faces_of(faces, "faces");
    auto result = value_of([&] {
        const py::gil_scoped_release released;
        return pipeline::make_surface_program(planned, cutter, options);
    }());
    auto program = std::make_shared<program::Program>(result.plan.program);
    return {std::move(planned), cutter, options.passes, std::move(result), std::move(program)};
}

py::dict contacts(const BoundSurfacePlan& plan) {
    std::vector<std::int64_t> first{0}, index;
    std::vector<surfacing::Contact> all;
    for (const surfacing::Pass& pass : plan.result.plan.passes) {
        all.insert(all.end(), pass.contacts.begin(), pass.contacts.end());
        first.push_back(static_cast<std::int64_t>(all.size()));
        index.push_back(pass.index);
    }
    py::dict out = contact_columns(all);
    out["first"] = py::array(py::cast(first));
    out["index"] = py::array(py::cast(index));
    return out;
}

py::dict freed_facts(const pipeline::FreedAccount& freed) {
    py::dict out;
    std::size_t gouges = 0;
    for (const std::size_t kind : freed.gouges) gouges += kind;
    out["gouges"] = gouges;
    out["deepest_mm"] = freed.worst ? freed.worst->depth_mm : 0.0;
    out["passes_turned"] = freed.passes_turned;
    out["largest_turn_deg"] = freed.largest_turn_rad / degree;
    out["largest_step_deg"] = freed.largest_step_rad / degree;
    out["rounds"] = freed.rounds;
    out["links_raised"] = freed.links_raised;
    return out;
}

py::dict facts(const BoundSurfacePlan& plan) {
    py::dict out;
    out["passes"] = plan.result.plan.passes.size();
    out["contacts"] = plan.result.contacts;
    out["cut_length_mm"] = plan.result.plan.cut_length_mm;
    out["least_interval_mm"] = plan.result.plan.least_interval_mm;
    out["largest_interval_mm"] = plan.result.plan.largest_interval_mm;
    out["highest_ridge_mm"] = plan.result.plan.highest_ridge_mm;
    out["freed"] = plan.result.freed ? py::object(freed_facts(*plan.result.freed)) : py::none();
    return out;
}

py::dict check_surface(const BoundSurfacePlan& plan, py::handle part, py::handle holder_mm) {
    const surfacing::Holder holder = holder_of(holder_mm);
    const auto body = part.is_none() ? plan.faces : faces_of(part, "part");
    const auto found = value_of([&] {
        const py::gil_scoped_release released;
        return pipeline::check_surface_program(plan.faces, body, plan.cutter, plan.result, plan.options, holder);
    }());
    const auto& verdict = found.verdict;
    py::dict out;
    out["usable"] = found.usable();
    out["ridges_hold"] = found.ridges_hold;
    out["surface_holds"] = found.surface_holds;
    out["in_part_mm"] = found.in_part ? found.in_part->depth_mm : 0.0;
    out["highest_mm"] = verdict.highest_mm;
    out["deepest_mm"] = verdict.deepest_mm;
    out["least_ridge_mm"] = verdict.least_ridge_mm;
    out["largest_ridge_mm"] = verdict.largest_ridge_mm;
    out["median_ridge_mm"] = verdict.median_ridge_mm;
    out["ridges"] = verdict.ridges;
    out["heights"] = verdict.heights;
    return out;
}

constexpr const char* contacts_doc = R"(dict of ndarray: every contact, pass after pass.

`first` (passes + 1,): where a pass begins; `index` (passes,): -1 along a border; `places` (n, 2): u, v; `points_mm`,
`normals`, `tips_mm`, `axes` (n, 3).)";

constexpr const char* check_doc = R"(check($self, part=None, holder_mm=None)
--

Simulates what the tool leaves of the material. The GIL is released.

Parameters
----------
part : Face, FaceList or sequence of Face, optional
    All faces of the part; None: those that were planned.
holder_mm : array_like, shape (3,), optional
    Its diameter, and from where to where it goes up the axis from the tip.

Returns
-------
dict
    `usable`, `ridges_hold`, `surface_holds`, `in_part_mm`, heights and ridges in mm.

Raises
------
Error
    SURF0301, SURF0302.)";

constexpr const char* plan_surface_doc = R"(plan_surface(faces, tool, **options)
--

Passes over faces so that the ridges between them are as high as allowed and no higher. The GIL is released.

Parameters
----------
faces : Face, FaceList or sequence of Face
    Planned as one region.
tool : Tool
    Flat, ball or torus.
strategy : {'constant-scallop', 'along-u', 'along-v', 'parallel-planes', 'lin-koren'}
scallop_mm : float
    Highest ridge; 0.01.
chord_tolerance_mm : float, optional
    How far straight moves may lead the tool off its contact; a twentieth of the scallop, at most half of the
    gouge tolerance.
gouge_tolerance_mm : float
    0.001.
feed_angle_deg, lead_deg, tilt_deg : float
    Direction of the passes in the middle; the tool's lean towards and across the feed; 0.
zigzag, borders : bool
    To and fro; a pass along every border as well; True.
lift_mm, retract_mm, longest_step_mm : float
    1, 20 and 5.
feed_mm_min, approach_feed_mm_min : float
    3000; the approach as the feed.
splines : bool
    Every pass one dual spline.
reach_mm : float
    How far up from the tip the tool counts as its body; 0: its diameter.
free_gouges : bool
    Whether to lean the tool out of what it goes into: in the faces, in `others`, and with its holder. Ridges of tools that
    are no balls change with the lean: check().
others : Face, FaceList or sequence of Face, optional
    Faces of the part that are not machined; only with `free_gouges`, as all that follows.
holder_mm : array_like, shape (3,), optional
    Its diameter, and from where to where it goes up the axis from the tip.
least_lead_deg, most_lead_deg, most_tilt_deg : float
    How far it may lean; -60 (the lead of a tool that is no ball keeps its sign), 60 and 60.
tool_name : str, optional
spindle_rpm : float, optional

Returns
-------
SurfacePlan

Raises
------
Error
    SURF0201 to SURF0210; SURF0310, SURF0311, SURF0313, SURF0314 not to be freed; PY0001 to PY0004 by the argument's name.

Source: Lin & Koren; docs/theory.)";

}  // namespace

void bind_surfacing(py::module_& module) {
    py::class_<BoundSurfacePlan> plan(module, "SurfacePlan", "Passes over faces; made by `plan_surface()`.");
    plan.def_readonly("program", &BoundSurfacePlan::program, "Program: all passes with their links, law vector.")
        .def_property_readonly("facts", &facts,
                               "dict: passes, contacts, cut_length_mm, least_interval_mm, largest_interval_mm, "
                               "highest_ridge_mm, as planned; `freed`: None, or what freeing it of gouges came to.")
        .def_property_readonly("contacts", &contacts, contacts_doc)
        .def("check", &check_surface, py::arg("part") = py::none(), py::arg("holder_mm") = py::none(), check_doc)
        .def("__repr__", [](const BoundSurfacePlan& self) {
            return fmt::format("<trunnion.SurfacePlan: {} passes>", self.result.plan.passes.size());
        });
    bind_gouges(module, plan);
    module.def("plan_surface", &plan_surface, py::arg("faces"), py::arg("tool"), plan_surface_doc);
}

}  // namespace trunnion::python
