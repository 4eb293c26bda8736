#include "trunnion/pipeline/check_setpoints.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "trunnion/base/quantity.hpp"
#include "trunnion/files/output_file.hpp"
#include "trunnion/verify/setpoint_table.hpp"

namespace trunnion::pipeline {

using nlohmann::ordered_json;

Result<verify::Verdict> check_setpoints(const std::filesystem::path& setpoints,
                                        const std::vector<verify::ProgrammedPose>& programmed,
                                        const machine::Machine& machine, const machine::Setup& setup,
                                        const smoothing::SmoothingOptions& tolerances) {
    auto text = files::read_whole_file(setpoints);
    if (!text) return fail(text.error());
    auto table = verify::read_setpoint_csv(*text, machine, setpoints.string());
    if (!table) return fail(table.error());
    text->clear();
    text->shrink_to_fit();
    verify::CheckOptions options;
    options.tip_tolerance_mm = tolerances.tip_tolerance_mm;
    options.orientation_tolerance_rad = tolerances.orientation_tolerance_rad;
    options.flank_tolerance_mm = tolerances.flank_tolerance_mm;
    options.flank_height_mm = tolerances.flank_height_mm;
    return verify::check(*table, programmed, machine, setup, options);
}

std::string report(const verify::Verdict& v) {
    std::string out =
        fmt::format("{:<22}{} of {:g} ms, {:.3f} s\n", "setpoints", v.rows, v.period_s * 1e3, v.cycle_time_s);
    out += fmt::format("{:<22}tip {:.4f} mm, orientation {:.4f} deg, at the flank height {:.4f} mm\n",
                       "motion off the path", v.tip_deviation_mm, v.orientation_deviation_deg, v.height_deviation_mm);
    out += fmt::format("{:<22}tip {:.4f} mm, orientation {:.4f} deg, at the flank height {:.4f} mm\n",
                       "poses off the motion", v.tip_to_poses_mm, v.orientation_to_poses_deg, v.height_to_poses_mm);
    out += fmt::format("{:<22}{:.6f} deg at standstills, {:.4f} deg on the way\n", "rotary words missed",
                       v.words_at_stops_deg, v.words_on_the_way_deg);
    out += fmt::format("{:<22}{:.6f} of the programmed path\n", "covered", v.path_covered);
    for (const auto& a : v.axes)
        out += fmt::format("  {:<20}velocity {:.4f}  acceleration {:.4f}  jerk {:.4f} of the limit\n", a.letter,
                           a.velocity_ratio, a.acceleration_ratio, a.jerk_ratio);
    for (const auto& b : v.broken)
        out += fmt::format("BROKEN {:<15} {:.6g}, limit {:.6g}, first at {:.4f} s, line {}\n", b.what, b.value, b.limit,
                           b.time_s, b.line);
    return out + fmt::format("{:<22}{}\n", "verdict", v.ok ? "ok" : "not ok");
}

std::string to_json(const verify::Verdict& v) {
    ordered_json out{{"ok", v.ok},
                     {"rows", v.rows},
                     {"period_s", v.period_s},
                     {"cycle_time_s", v.cycle_time_s},
                     {"tip_deviation_mm", v.tip_deviation_mm},
                     {"orientation_deviation_deg", v.orientation_deviation_deg},
                     {"height_deviation_mm", v.height_deviation_mm},
                     {"tip_to_poses_mm", v.tip_to_poses_mm},
                     {"orientation_to_poses_deg", v.orientation_to_poses_deg},
                     {"height_to_poses_mm", v.height_to_poses_mm},
                     {"words_at_stops_deg", v.words_at_stops_deg},
                     {"words_on_the_way_deg", v.words_on_the_way_deg},
                     {"path_covered", v.path_covered},
                     {"start_error_mm", v.start_error_mm},
                     {"end_error_mm", v.end_error_mm}};
    for (const auto& a : v.axes) {
        ordered_json& axis = out["axes"][std::string(1, a.letter)];
        axis["velocity_ratio"] = a.velocity_ratio;
        axis["acceleration_ratio"] = a.acceleration_ratio;
        axis["jerk_ratio"] = a.jerk_ratio;
        axis[a.rotary ? "range_excess_deg" : "range_excess_mm"] = a.rotary ? a.range_excess / degree : a.range_excess;
    }
    out["broken"] = ordered_json::array();
    for (const auto& b : v.broken)
        out["broken"].push_back(
            {{"what", b.what}, {"t_s", b.time_s}, {"line", b.line}, {"value", b.value}, {"limit", b.limit}});
    return out.dump(1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace trunnion::pipeline
