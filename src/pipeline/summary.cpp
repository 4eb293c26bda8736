#include "trunnion/pipeline/summary.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "trunnion/base/quantity.hpp"

#include "detail/diagnostics_json.hpp"
#include "detail/report_lines.hpp"

namespace trunnion::pipeline {

using nlohmann::ordered_json;

namespace {

constexpr double allowed_ratio = 1.001;
constexpr double allowed_deviation = 1 + 1e-6;
constexpr double rounding_deviation = 1e-9;  // mm or rad, of what is followed exactly
constexpr double worth_telling_s = 1e-3;

ordered_json drops_json(const std::vector<FeedDrop>& drops) {
    ordered_json out = ordered_json::array();
    for (const FeedDrop& d : drops) {
        out.push_back(drop_json(d, d.cause));
        out.back()["at_tolerance"] = d.at_tolerance;
    }
    return out;
}

ordered_json axes_json(const std::vector<AxisLoad>& axes) {
    ordered_json out = ordered_json::object();
    for (const AxisLoad& a : axes)
        out[std::string(1, a.letter)] = {{"velocity_ratio", a.velocity_ratio},
                                         {"acceleration_ratio", a.acceleration_ratio},
                                         {"jerk_ratio", a.jerk_ratio},
                                         {"jerk_rms", a.jerk_rms},
                                         {"limiting_share", a.limiting_share}};
    return out;
}

/// null where there is none.
ordered_json number(std::optional<double> value) {
    return finite_or_null(value.value_or(NAN));
}

const char* name_of(smoothing::Rounding rounding) {
    switch (rounding) {
        case smoothing::Rounding::smooth:
            return "smooth";
        case smoothing::Rounding::beudaert:
            return "beudaert";
        case smoothing::Rounding::none:
            return "none";
    }
    return "";
}

const char* name_of(smoothing::Link link) {
    return link == smoothing::Link::linear ? "linear" : "optimised";
}

ordered_json options_json(const PlanOptions& options) {
    const auto& smoothing = options.smoothing;
    const auto& feed = options.feed;
    return {{"period_s", options.period_s},
            {"tip_tolerance_mm", smoothing.tip_tolerance_mm},
            {"orientation_tolerance_deg", smoothing.orientation_tolerance_rad / degree},
            {"flank_tolerance_mm", smoothing.flank_tolerance_mm},
            {"flank_height_mm", smoothing.flank_height_mm},
            {"rounding", name_of(smoothing.rounding)},
            {"corners", smoothing.corners == smoothing::Corners::beudaert ? "beudaert" : "smooth"},
            {"link", name_of(smoothing.link)},
            {"calm", feed.calm},
            {"feed_override", options.feed_override},
            {"feed_mm_min", options.feed_mm_s ? ordered_json(*options.feed_mm_s * 60) : ordered_json(nullptr)},
            {"jerk_margin", feed.jerk_margin},
            {"chord_error_mm", number(feed.chord_error_mm)},
            {"tip_acceleration_mm_s2", number(feed.tip_acceleration_mm_s2)},
            {"tip_jerk_mm_s3", number(feed.tip_jerk_mm_s3)},
            {"tool_turn_deg_s", number(feed.turn_velocity_rad_s / degree)},
            {"threads", options.threads},
            {"worth", options.worth}};
}

ordered_json calm_json(const Summary& s) {
    const bool known = s.calm.price_s && s.cycle_time_s > 0;
    return {{"weight", s.calm.weight},
            {"price_s", number(s.calm.price_s)},
            {"price_share", known ? ordered_json(*s.calm.price_s / s.cycle_time_s) : ordered_json(nullptr)}};
}

ordered_json worth_json(const std::vector<Worth>& worth) {
    ordered_json out = ordered_json::array();
    for (const Worth& w : worth)
        out.push_back({{"what", w.what},
                       {"change", w.change},
                       {"saves_s", number(w.saves_s)},
                       {"gradient_s", number(w.gradient_s)}});
    return out;
}

std::string calm_text(const Summary& s) {
    if (s.calm.weight == 0) return "off";
    const std::string weight = fmt::format("weight {:g}: ", s.calm.weight);
    if (!s.calm.price_s) return weight + "costs less than 0.02 % of the time";
    if (*s.calm.price_s < worth_telling_s) return weight + "costs less than 1 ms";
    return weight +
           fmt::format("costs {:.3f} s, {:.2f} % of the time", *s.calm.price_s, 100 * *s.calm.price_s / s.cycle_time_s);
}

/// The changes that save most, a line each.
std::vector<std::string> worth_lines(const std::vector<Worth>& worth) {
    constexpr std::size_t most = 5;
    std::vector<std::string> out;
    for (const Worth& w : worth) {
        if (out.size() == most || w.saves_s.value_or(0) < worth_telling_s) break;
        const std::string by_multipliers =
            w.gradient_s ? fmt::format("  (by the multipliers {:.3f} s)", *w.gradient_s) : "";
        out.push_back(fmt::format("{:<22}{:<6} saves {:.3f} s{}", w.what, w.change, *w.saves_s, by_multipliers));
    }
    if (out.empty() && !worth.empty()) out.emplace_back("no limit and no tolerance saves as much as 1 ms");
    return out;
}

}  // namespace

bool Summary::usable() const {
    const bool limits = std::all_of(axes.begin(), axes.end(), [](const AxisLoad& a) {
        return std::max({a.velocity_ratio, a.acceleration_ratio, a.jerk_ratio}) <= allowed_ratio;
    });
    const auto& given = options.smoothing;
    const auto held = [](double deviation, double tolerance) {
        return deviation <= tolerance * allowed_deviation + rounding_deviation;
    };
    const bool orientation = given.flank_tolerance_mm > 0
                                 ? held(height_deviation_mm, given.flank_tolerance_mm)
                                 : held(orientation_deviation_rad, given.orientation_tolerance_rad);
    return limits && orientation && held(tip_deviation_mm, given.tip_tolerance_mm);
}

std::string Summary::report() const {
    ReportLines lines;
    const auto line = [&](std::string_view name, const std::string& value) { lines.add(name, value); };
    lines.add_job(*this);
    line("cycle time",
         fmt::format("{:.3f} s = {:.3f} cutting + {:.3f} rapid + {:.3f} dwell; {:.3f} s without jerk limits",
                     cycle_time_s, cut_time_s, rapid_time_s, dwell_time_s, jerk_free_bound_s));
    line("path", fmt::format("{:.1f} mm of the tip in {} setpoints of {:g} ms", path_length_mm, setpoints,
                             options.period_s * 1e3));
    const auto& given = options.smoothing;
    line("deviation at most",
         fmt::format("tip {:.4f} mm of {:g}; {}", tip_deviation_mm, given.tip_tolerance_mm,
                     given.flank_tolerance_mm > 0
                         ? fmt::format("{:g} mm up the flank {:.4f} mm of {:g}", given.flank_height_mm,
                                       height_deviation_mm, given.flank_tolerance_mm)
                         : fmt::format("orientation {:.4f} deg of {:g}", orientation_deviation_rad / degree,
                                       given.orientation_tolerance_rad / degree)));
    const ExactStops& e = exact_stops;
    line("exact stops", fmt::format("{}: {} rapids, {} reversals, {} dwells, {} events, {} stop words, {} corners",
                                    e.total, e.rapids, e.reversals, e.dwells, e.events, e.words, e.corners));
    line("axis: peak / limit", "velocity  acceleration    jerk   jerk RMS   limits the feed");
    for (const AxisLoad& a : axes)
        line(fmt::format("  {}", a.letter),
             fmt::format("{:8.4f}  {:12.4f}  {:.4f}     {:.4f}   {:5.1f} % of the cut", a.velocity_ratio,
                         a.acceleration_ratio, a.jerk_ratio, a.jerk_rms, 100 * a.limiting_share));
    line("calm", calm_text(*this));
    for (const FeedDrop& d : worst_of(feed_drops))
        line("slow", drop_text(d, d.cause) + (d.at_tolerance ? " (tolerance used up)" : ""));
    for (const std::string& text : worth_lines(worth)) line("worth", text);
    line("verdict", usable() ? "all limits and tolerances hold" : "NOT USABLE: a limit or a tolerance is broken");
    return lines.text();
}

std::string to_json(const Summary& s) {
    ordered_json out;
    set_job(out, s);
    out["controller"] = nullptr;
    out["options"] = options_json(s.options);
    out["usable"] = s.usable();
    out["cycle_time_s"] = s.cycle_time_s;
    set_times(out, s);
    out["path_length_mm"] = s.path_length_mm;
    out["blocks"] = s.blocks;
    out["setpoints"] = s.setpoints;
    out["period_s"] = s.options.period_s;
    out["jerk_free_bound_s"] = s.jerk_free_bound_s;
    out["tip_deviation_mm"] = s.tip_deviation_mm;
    out["orientation_deviation_deg"] = s.orientation_deviation_rad / degree;
    out["height_deviation_mm"] = s.height_deviation_mm;
    out["tolerance_used"] = s.tolerance_used;
    const ExactStops& e = s.exact_stops;
    out["exact_stops"] = {{"total", e.total},   {"reversals", e.reversals}, {"rapids", e.rapids},  {"dwells", e.dwells},
                          {"events", e.events}, {"words", e.words},         {"corners", e.corners}};
    out["axes"] = axes_json(s.axes);
    out["calm"] = calm_json(s);
    out["feed_drops"] = drops_json(s.feed_drops);
    out["worth"] = worth_json(s.worth);
    out["intervals"] = s.intervals;
    out["windows"] = s.windows;
    out["fallbacks"] = s.fallbacks;
    out["work"] = {{"read_s", s.work.read_s},
                   {"smooth_s", s.work.smooth_s},
                   {"plan_s", s.work.plan_s},
                   {"sample_s", s.work.sample_s},
                   {"replan_s", s.work.replan_s},
                   {"elapsed_s", s.work.elapsed_s},
                   {"peak_memory_mb", s.work.peak_memory_mb}};
    out["diagnostics"] = diagnostics_json(s.diagnostics);
    return out.dump(1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace trunnion::pipeline
