#include "trunnion/pipeline/summary.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "trunnion/base/quantity.hpp"

namespace trunnion::pipeline {

using nlohmann::ordered_json;

namespace {

constexpr double allowed_ratio = 1.001;
constexpr double allowed_deviation = 1 + 1e-6;

ordered_json diagnostics_json(const std::vector<Diagnostic>& diagnostics) {
    ordered_json out = ordered_json::array();
    for (const Diagnostic& d : diagnostics)
        out.push_back({{"code", d.code},
                       {"severity", to_string(d.severity)},
                       {"line", d.place.line},
                       {"text", d.text},
                       {"value", d.value},
                       {"limit", d.limit},
                       {"count", d.count},
                       {"hint", d.hint}});
    return out;
}

ordered_json drops_json(const std::vector<FeedDrop>& drops) {
    ordered_json out = ordered_json::array();
    for (const FeedDrop& d : drops)
        out.push_back({{"line", d.line},
                       {"s_from_mm", d.s_from_mm},
                       {"s_to_mm", d.s_to_mm},
                       {"feed_min_mm_min", d.feed_min_mm_s * 60},
                       {"programmed_feed_mm_min", d.programmed_feed_mm_s * 60},
                       {"lost_s", d.lost_s},
                       {"cause", d.cause}});
    return out;
}

ordered_json axes_json(const std::vector<AxisLoad>& axes) {
    ordered_json out = ordered_json::object();
    for (const AxisLoad& a : axes)
        out[std::string(1, a.letter)] = {{"velocity_ratio", a.velocity_ratio},
                                         {"acceleration_ratio", a.acceleration_ratio},
                                         {"jerk_ratio", a.jerk_ratio},
                                         {"limiting_share", a.limiting_share}};
    return out;
}

}  // namespace

bool Summary::usable() const {
    const bool limits = std::all_of(axes.begin(), axes.end(), [](const AxisLoad& a) {
        return std::max({a.velocity_ratio, a.acceleration_ratio, a.jerk_ratio}) <= allowed_ratio;
    });
    const bool orientation = flank_tolerance_mm > 0
                                 ? height_deviation_mm <= flank_tolerance_mm * allowed_deviation
                                 : orientation_deviation_rad <= orientation_tolerance_rad * allowed_deviation;
    return limits && orientation && tip_deviation_mm <= tip_tolerance_mm * allowed_deviation;
}

std::string Summary::report() const {
    std::string out;
    const auto line = [&](std::string_view name, const std::string& value) {
        out += fmt::format("{:<22}{}\n", name, value);
    };
    line("program", fmt::format("{} ({}, {} blocks)", program, dialect, blocks));
    line("machine", machine + (setup.empty() ? "" : fmt::format(", setup {}", setup)));
    line("cycle time",
         fmt::format("{:.3f} s = {:.3f} cutting + {:.3f} rapid + {:.3f} dwell; {:.3f} s without jerk limits",
                     cycle_time_s, cut_time_s, rapid_time_s, dwell_time_s, jerk_free_bound_s));
    line("path",
         fmt::format("{:.1f} mm of the tip in {} setpoints of {:g} ms", path_length_mm, setpoints, period_s * 1e3));
    line("deviation at most",
         fmt::format("tip {:.4f} mm of {:g}; {}", tip_deviation_mm, tip_tolerance_mm,
                     flank_tolerance_mm > 0
                         ? fmt::format("{:g} mm up the flank {:.4f} mm of {:g}", flank_height_mm, height_deviation_mm,
                                       flank_tolerance_mm)
                         : fmt::format("orientation {:.4f} deg of {:g}", orientation_deviation_rad / degree,
                                       orientation_tolerance_rad / degree)));
    const ExactStops& e = exact_stops;
    line("exact stops", fmt::format("{}: {} rapids, {} reversals, {} dwells, {} events, {} stop words, {} corners",
                                    e.total, e.rapids, e.reversals, e.dwells, e.events, e.words, e.corners));
    line("axis", "velocity  acceleration  jerk  (peak / limit)   limits the feed");
    for (const AxisLoad& a : axes)
        line(fmt::format("  {}", a.letter),
             fmt::format("{:8.4f}  {:12.4f}  {:.4f}                  {:5.1f} % of the cut", a.velocity_ratio,
                         a.acceleration_ratio, a.jerk_ratio, 100 * a.limiting_share));
    std::vector<FeedDrop> worst = feed_drops;
    std::stable_sort(worst.begin(), worst.end(),
                     [](const FeedDrop& a, const FeedDrop& b) { return a.lost_s > b.lost_s; });
    worst.resize(std::min<std::size_t>(worst.size(), 3));
    for (const FeedDrop& d : worst)
        line("slow",
             fmt::format("line {}, {:.1f} … {:.1f} mm: down to {:.0f} of {:.0f} mm/min, {:.3f} s lost, {}", d.line,
                         d.s_from_mm, d.s_to_mm, d.feed_min_mm_s * 60, d.programmed_feed_mm_s * 60, d.lost_s, d.cause));
    line("verdict", usable() ? "all limits and tolerances hold" : "NOT USABLE: a limit or a tolerance is broken");
    return out;
}

std::string to_json(const Summary& s) {
    ordered_json out;
    out["program"] = s.program;
    out["dialect"] = s.dialect;
    out["machine"] = s.machine;
    out["setup"] = s.setup;
    out["controller"] = nullptr;
    out["options"] = {{"period_s", s.period_s},
                      {"tip_tolerance_mm", s.tip_tolerance_mm},
                      {"orientation_tolerance_deg", s.orientation_tolerance_rad / degree},
                      {"flank_tolerance_mm", s.flank_tolerance_mm},
                      {"flank_height_mm", s.flank_height_mm}};
    out["usable"] = s.usable();
    out["cycle_time_s"] = s.cycle_time_s;
    out["cut_time_s"] = s.cut_time_s;
    out["rapid_time_s"] = s.rapid_time_s;
    out["dwell_time_s"] = s.dwell_time_s;
    out["path_length_mm"] = s.path_length_mm;
    out["blocks"] = s.blocks;
    out["setpoints"] = s.setpoints;
    out["period_s"] = s.period_s;
    out["jerk_free_bound_s"] = s.jerk_free_bound_s;
    out["tip_deviation_mm"] = s.tip_deviation_mm;
    out["orientation_deviation_deg"] = s.orientation_deviation_rad / degree;
    out["height_deviation_mm"] = s.height_deviation_mm;
    out["tolerance_used"] = s.tolerance_used;
    const ExactStops& e = s.exact_stops;
    out["exact_stops"] = {{"total", e.total},   {"reversals", e.reversals}, {"rapids", e.rapids},  {"dwells", e.dwells},
                          {"events", e.events}, {"words", e.words},         {"corners", e.corners}};
    out["axes"] = axes_json(s.axes);
    out["feed_drops"] = drops_json(s.feed_drops);
    out["intervals"] = s.intervals;
    out["windows"] = s.windows;
    out["fallbacks"] = s.fallbacks;
    out["work"] = {{"read_s", s.work.read_s},
                   {"smooth_s", s.work.smooth_s},
                   {"plan_s", s.work.plan_s},
                   {"sample_s", s.work.sample_s},
                   {"peak_memory_mb", s.work.peak_memory_mb}};
    out["diagnostics"] = diagnostics_json(s.diagnostics);
    return out.dump(1) + "\n";
}

}  // namespace trunnion::pipeline
