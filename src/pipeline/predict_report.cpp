#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "trunnion/base/quantity.hpp"
#include "trunnion/pipeline/predict.hpp"

#include "detail/diagnostics_json.hpp"
#include "detail/report_lines.hpp"

namespace trunnion::pipeline {

using motion::Prediction;
using nlohmann::ordered_json;

namespace {

constexpr std::size_t lines_compared = 10;

std::string uncertainty_text(const Prediction& p) {
    if (p.uncertainty_s < 0) return "not stated";
    if (p.doubts.empty()) return "none: nothing in it is documented or guessed";
    std::string out = fmt::format("± {:.3f} s ({:.1f} %)", p.uncertainty_s, 100 * p.uncertainty_s / p.cycle_time_s);
    constexpr std::size_t most = 3;
    for (std::size_t i = 0; i < std::min(most, p.doubts.size()); ++i) {
        const double half = 0.5 * (p.doubts[i].time_high_s - p.doubts[i].time_low_s);
        if (std::abs(half) < 1e-3) break;
        out += fmt::format("{} {} {:+.3f} s", i == 0 ? ":" : ",", p.doubts[i].parameter, half);
    }
    return out;
}

ordered_json doubts_json(const Prediction& p) {
    ordered_json out = ordered_json::array();
    for (const motion::Doubt& d : p.doubts)
        out.push_back({{"parameter", d.parameter},
                       {"low", d.low},
                       {"high", d.high},
                       {"time_low_s", d.time_low_s},
                       {"time_high_s", d.time_high_s}});
    return out;
}

ordered_json axes_json(const Prediction& p) {
    ordered_json out = ordered_json::object();
    for (const motion::PredictedLoad& a : p.axes)
        out[std::string(1, a.letter)] = {{"velocity_ratio", a.velocity_ratio},
                                         {"acceleration_ratio", a.acceleration_ratio},
                                         {"jerk_ratio", finite_or_null(a.jerk_ratio)},
                                         {"limiting_share", a.limiting_share}};
    return out;
}

ordered_json drops_json(const Prediction& p, const machine::Machine& machine) {
    ordered_json out = ordered_json::array();
    for (const motion::PredictedDrop& d : p.feed_drops) out.push_back(drop_json(d, to_string(d.cause, machine)));
    return out;
}

ordered_json against_json(const Prediction& p, const Prediction& other) {
    ordered_json lines = ordered_json::array();
    for (const LineDifference& d : differences(p, other, lines_compared))
        lines.push_back({{"line", d.line}, {"time_s", d.time_s}, {"other_s", d.other_s}});
    return {{"program", other.program},
            {"controller", other.controller},
            {"cycle_time_s", other.cycle_time_s},
            {"difference_s", p.cycle_time_s - other.cycle_time_s},
            {"lines", lines}};
}

}  // namespace

std::string report(const Prediction& p, const machine::Machine& machine, const PredictionOptions& options,
                   const Prediction* other) {
    ReportLines lines;
    const auto line = [&](std::string_view name, const std::string& value) { lines.add(name, value); };
    lines.add_job(p);
    line("controller", p.controller);
    line("cycle time", fmt::format("{:.3f} s = {:.3f} cutting + {:.3f} rapid + {:.3f} dwell + {:.3f} tool change + "
                                   "{:.3f} other stops",
                                   p.cycle_time_s, p.cut_time_s, p.rapid_time_s, p.dwell_time_s, p.tool_change_time_s,
                                   p.other_stop_time_s));
    line("uncertainty", uncertainty_text(p));
    line("path", fmt::format("{:.1f} mm of the tip, {} standstills", p.path_length_mm, p.standstills));
    line("contact feed", fmt::format("in the samples: surface across the feed, tool leaning {:g} deg along it",
                                     options.contact_lead_rad / degree));
    line("axis: peak / limit", "velocity  acceleration      jerk   limits the feed");
    for (const motion::PredictedLoad& a : p.axes)
        line(fmt::format("  {}", a.letter),
             fmt::format("{:8.4f}  {:12.4f}  {:>8}   {:5.1f} % of the cut", a.velocity_ratio, a.acceleration_ratio,
                         std::isfinite(a.jerk_ratio) ? fmt::format("{:.4f}", a.jerk_ratio) : "-",
                         100 * a.limiting_share));
    constexpr std::size_t causes = 5;
    for (std::size_t i = 0; i < std::min(causes, p.limits.size()); ++i)
        line(i == 0 ? "what limits the cut" : "",
             fmt::format("{:<22}{:10.3f} s", to_string(p.limits[i].limit, machine), p.limits[i].time_s));
    for (const motion::PredictedDrop& d : worst_of(p.feed_drops))
        line("slow", drop_text(d, to_string(d.cause, machine)));
    if (!other) return lines.text();
    const double more = p.cycle_time_s - other->cycle_time_s;
    const bool same_program = p.program == other->program;
    line(same_program ? "against" : "before",
         fmt::format("{}: {:.3f} s; this one takes {:.3f} s {} ({:+.1f} %)",
                     same_program ? other->controller : other->program, other->cycle_time_s, std::abs(more),
                     more < 0 ? "less" : "more", 100 * (p.cycle_time_s / other->cycle_time_s - 1)));
    for (const LineDifference& d : differences(p, *other, lines_compared / 2))
        line("", fmt::format("line {}: {:.3f} s, there {:.3f} s", d.line, d.time_s, d.other_s));
    return lines.text();
}

std::string to_json(const Prediction& p, const machine::Machine& machine, const PredictionOptions& options,
                    const Prediction* other) {
    ordered_json out;
    set_job(out, p);
    out["controller"] = p.controller;
    out["options"] = {
        {"feed_override", options.plan.feed_override},
        {"feed_mm_min", options.plan.feed_mm_s ? ordered_json(*options.plan.feed_mm_s * 60) : ordered_json(nullptr)},
        {"contact_tilt_deg", options.contact_lead_rad / degree}};
    out["cycle_time_s"] = p.cycle_time_s;
    out["uncertainty_s"] = p.uncertainty_s < 0 ? ordered_json(nullptr) : ordered_json(p.uncertainty_s);
    set_times(out, p);
    out["tool_change_time_s"] = p.tool_change_time_s;
    out["other_stop_time_s"] = p.other_stop_time_s;
    out["path_length_mm"] = p.path_length_mm;
    out["blocks"] = p.blocks;
    out["standstills"] = p.standstills;
    out["axes"] = axes_json(p);
    ordered_json limits = ordered_json::array();
    for (const motion::LimitTime& limit : p.limits)
        limits.push_back({{"cause", to_string(limit.limit, machine)}, {"time_s", limit.time_s}});
    out["limits"] = limits;
    out["feed_drops"] = drops_json(p, machine);
    out["doubts"] = doubts_json(p);
    if (other) out["against"] = against_json(p, *other);
    out["diagnostics"] = diagnostics_json(p.diagnostics);
    return out.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace trunnion::pipeline
