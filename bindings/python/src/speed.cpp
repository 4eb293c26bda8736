#include <algorithm>
#include <memory>

#include <fmt/format.h>
#include <pybind11/stl.h>

#include "trunnion/feed/live_planner.hpp"
#include "trunnion/feed/plan_stretch.hpp"

#include "bindings.hpp"
#include "machine.hpp"
#include "planning.hpp"
#include "series.hpp"
#include "stretches.hpp"

/// The speed along one stretch: planned as a whole, or period by period under the operator's commands.
namespace trunnion::python {

using feed::LivePlanner;
using feed::StretchPlan;

namespace {

struct BoundProfile {
    SharedStretch stretch;
    StretchPlan plan;
};

feed::FeedOptions feed_options(const char* function, const py::kwargs& given) {
    Keywords keywords(given, function);
    feed::FeedOptions out;
    take_feed_options(keywords, out);
    keywords.number("period_s", out.period_s);
    keywords.finish();
    return out;
}

BoundProfile plan_stretch(std::shared_ptr<BoundStretch> stretch, const py::kwargs& given) {
    const auto options = feed_options("plan_stretch", given);
    auto plan = value_of([&] {
        const py::gil_scoped_release released;
        return feed::plan_stretch(*stretch->axis_path, options);
    }());
    return {std::move(stretch), std::move(plan)};
}

double p_at(const BoundProfile& self, const motion::ProfilePiece& piece, double delta_mm) {
    return self.stretch->p_of({piece.path_piece, piece.path_offset_mm + delta_mm});
}

void put_state(const BoundProfile& self, double time_s, double* out) {
    const auto& pieces = self.plan.profile.pieces;
    if (!(time_s >= 0 && time_s <= self.plan.profile.duration_s()))
        refuse({.code = "PY0003",
                .text = "time_s: out of range",
                .value = fmt::format("{}", time_s),
                .limit = fmt::format("0 … {}", self.plan.profile.duration_s())});
    const auto behind = std::ranges::upper_bound(pieces, time_s, {}, &motion::ProfilePiece::begin_s);
    const motion::ProfilePiece& piece = *std::prev(behind == pieces.begin() ? std::next(behind) : behind);
    const double delta = motion::distance_at(piece, std::min(time_s - piece.begin_s, piece.duration_s));
    const motion::PathState state = motion::state_at(piece, delta);
    for (const double value : {p_at(self, piece, delta), state.speed_mm_s, state.acceleration_mm_s2, state.jerk_mm_s3})
        *out++ = value;
}

Array states(const BoundProfile& self, py::handle time) {
    return at_each(numbers_of(time, "time_s"), {4}, [&](double at, double* out) { put_state(self, at, out); });
}

py::dict pieces(const BoundProfile& self) {
    const auto& all = self.plan.profile.pieces;
    const auto count = static_cast<py::ssize_t>(all.size());
    Array p(count), length(count), begin(count), duration(count);
    py::list causes;
    for (py::ssize_t i = 0; i < count; ++i) {
        const motion::ProfilePiece& piece = all[static_cast<std::size_t>(i)];
        p.mutable_at(i) = p_at(self, piece, 0);
        length.mutable_at(i) = piece.length_mm;
        begin.mutable_at(i) = piece.begin_s;
        duration.mutable_at(i) = piece.duration_s;
        causes.append(feed::name_of(self.plan.causes[static_cast<std::size_t>(i)], self.stretch->machine()));
    }
    py::dict out;
    out["p_mm"] = p;
    out["length_mm"] = length;
    out["begin_s"] = begin;
    out["duration_s"] = duration;
    out["cause"] = causes;
    return out;
}

py::dict peaks(const BoundProfile& self) {
    py::dict out;
    for (int a = 0; a < self.stretch->machine().axis_count; ++a) {
        const feed::AxisPeaks& peak = self.plan.peaks[static_cast<std::size_t>(a)];
        py::dict row;
        row["velocity"] = peak.velocity;
        row["acceleration"] = peak.acceleration;
        row["jerk"] = peak.jerk;
        out[py::str(std::string(1, self.stretch->machine().axes[a].letter))] = row;
    }
    return out;
}

/// A planner with the stretch that it moves along.
struct BoundLivePlanner {
    SharedStretch stretch;
    LivePlanner planner;
};

BoundLivePlanner live_planner(std::shared_ptr<BoundStretch> stretch, const py::kwargs& given) {
    const auto options = feed_options("LivePlanner", given);
    auto planner = value_of(LivePlanner::make(*stretch->axis_path, options, options.period_s));
    return {std::move(stretch), std::move(planner)};
}

constexpr Word<feed::LiveStatus> statuses[]{{"moving", feed::LiveStatus::moving},
                                            {"holding", feed::LiveStatus::holding},
                                            {"finished", feed::LiveStatus::finished}};

py::dict tick(BoundLivePlanner& self) {
    const feed::LiveState state = value_of(self.planner.tick());
    const machine::AxisPosition position = self.stretch->axis_path->position(state.place);
    const machine::Machine& machine = self.stretch->machine();
    Array axes(machine.axis_count);
    for (int a = 0; a < machine.axis_count; ++a)
        axes.mutable_at(a) = position[static_cast<std::size_t>(a)] / unit_of(machine.axes[a]);
    py::dict out;
    out["status"] = name_of(state.status, statuses);
    out["p_mm"] = self.stretch->p_of(state.place);
    out["speed_mm_s"] = state.speed_mm_s;
    out["acceleration_mm_s2"] = state.acceleration_mm_s2;
    out["jerk_mm_s3"] = state.jerk_mm_s3;
    out["line"] = self.stretch->tool_path.blocks[state.block].line;
    out["axes"] = axes;
    return out;
}

constexpr const char* plan_stretch_doc = R"(plan_stretch(stretch, **options)
--

The speed along one stretch in minimum time from rest to rest: limits of all axes and programmed feed held to 1.0004 over
all of it. The GIL is released.

Parameters
----------
stretch : Stretch
calm, jerk_margin, period_s, chord_error_mm, tip_acceleration_mm_s2, tip_jerk_mm_s3, tool_turn_deg_s : optional
    As in plan(); `period_s` is that of the chord error.

Returns
-------
FeedProfile

Raises
------
Error
    FEED0001 to FEED0009; PY0001, PY0002 by the argument's name.

Source: docs/theory/feed-planning.md.)";

constexpr const char* state_doc = R"(state($self, /, time_s)
--

Place, speed, acceleration and jerk along the path.

Parameters
----------
time_s : array_like
    0 to `duration_s`, any shape.

Returns
-------
ndarray, shape (*time.shape, 4)
    p in mm and its derivatives by time, mm/s, mm/s², mm/s³.

Raises
------
Error
    PY0001 to PY0003 by the argument's name.)";

constexpr const char* live_planner_doc = R"(LivePlanner(stretch, **options)
--

Moves along a stretch period by period under an operator's commands: overrides, hold, single block. It stands at the
beginning; the first tick() begins to move. A plan in hand always ends in standstill within all limits, and a command
changes it from two periods ahead on. For one thread.

Parameters
----------
stretch : Stretch
period_s : float
    Above 0; 0.001.
calm, jerk_margin, chord_error_mm, tip_acceleration_mm_s2, tip_jerk_mm_s3, tool_turn_deg_s : optional
    As in plan().

Raises
------
Error
    FEED0001 to FEED0009, FEED0011 the period; PY0001, PY0002 by the argument's name.

Source: docs/theory/feed-planning.md.)";

constexpr const char* set_feed_override_doc = R"(set_feed_override($self, /, factor)
--

Factor of the programmed feeds, 0 to 2; 0 holds until it is raised.

Raises
------
Error
    FEED0010 outside its range; PY0001, PY0002.)";

constexpr const char* set_rapid_override_doc = R"(set_rapid_override($self, /, factor)
--

Factor of the velocity limits of a rapid, 0 to 1; other stretches do not follow it. 0 holds until it is raised.

Raises
------
Error
    FEED0010 outside its range; PY0001, PY0002.)";

constexpr const char* set_largest_speed_doc = R"(set_largest_speed($self, /, mm_s)
--

Largest speed of the tip, mm/s, whatever is programmed and whatever the override; none at first. Moves that only turn do
not follow it. 0 holds until it is raised.

Raises
------
Error
    FEED0010 below 0; PY0001, PY0002.)";

constexpr const char* set_single_block_doc = R"(set_single_block($self, /, on)
--

While on, every block's end is a stop: the machine stands there until resume().

Raises
------
Error
    PY0001.)";

constexpr const char* tick_doc = R"(tick($self, /)
--

One period on.

Returns
-------
dict
    `status` 'moving', 'holding' or 'finished'; `p_mm`, `speed_mm_s`, `acceleration_mm_s2`, `jerk_mm_s3` along the path;
    `line`; `axes` ndarray (axes,), mm and degrees.

Raises
------
Error
    FEED0002, FEED0004: the machine then stands.)";

void bind_profile(py::module_& module) {
    py::class_<BoundProfile>(module, "FeedProfile",
                             "Speed along a stretch from rest to rest; made by `plan_stretch()`.")
        .def_property_readonly(
            "duration_s", [](const BoundProfile& p) { return p.plan.profile.duration_s(); }, "float: s.")
        .def_property_readonly(
            "jerk_free_bound_s", [](const BoundProfile& p) { return p.plan.jerk_free_bound_s; },
            "float: the same path with velocity, acceleration and feed limits only, s.")
        .def_property_readonly("peaks", &peaks,
                               "dict by letter: `velocity`, `acceleration`, `jerk`: peak / limit, bounds.")
        .def_property_readonly(
            "pieces", &pieces,
            "dict: `p_mm`, `length_mm`, `begin_s`, `duration_s` ndarray (n,), `cause` list of str: what "
            "holds the speed down on each piece.")
        .def("state", &states, py::arg("time_s"), state_doc)
        .def("__repr__", [](const BoundProfile& p) {
            return fmt::format("<trunnion.FeedProfile: {:.3f} s>", p.plan.profile.duration_s());
        });
    module.def("plan_stretch", &plan_stretch, py::arg("stretch").none(false), plan_stretch_doc);
}

void bind_live_planner(py::module_& module) {
    py::class_<BoundLivePlanner>(module, "LivePlanner", live_planner_doc)
        .def(py::init(&live_planner), py::arg("stretch").none(false))
        .def(
            "set_feed_override",
            [](BoundLivePlanner& self, py::handle factor) {
                value_of(self.planner.set_feed_override(number_of(factor, "factor")));
            },
            py::arg("factor"), set_feed_override_doc)
        .def(
            "set_rapid_override",
            [](BoundLivePlanner& self, py::handle factor) {
                value_of(self.planner.set_rapid_override(number_of(factor, "factor")));
            },
            py::arg("factor"), set_rapid_override_doc)
        .def(
            "set_largest_speed",
            [](BoundLivePlanner& self, py::handle mm_s) {
                value_of(self.planner.set_largest_speed(number_of(mm_s, "mm_s")));
            },
            py::arg("mm_s"), set_largest_speed_doc)
        .def(
            "hold", [](BoundLivePlanner& self) { self.planner.hold(); },
            "hold($self, /)\n--\n\nStops as soon as the limits allow, and stands until resume().")
        .def(
            "resume", [](BoundLivePlanner& self) { self.planner.resume(); },
            "resume($self, /)\n--\n\nEnds a hold, and goes on behind a single block.")
        .def(
            "set_single_block",
            [](BoundLivePlanner& self, py::handle on) { self.planner.set_single_block(flag_of(on, "on")); },
            py::arg("on"), set_single_block_doc)
        .def("tick", &tick, tick_doc);
}

}  // namespace

void bind_speed(py::module_& module) {
    bind_profile(module);
    bind_live_planner(module);
}

}  // namespace trunnion::python
