#include "trunnion/pipeline/surface_summary.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "trunnion/base/quantity.hpp"

#include "detail/diagnostics_json.hpp"
#include "detail/freed_json.hpp"
#include "detail/report_lines.hpp"

namespace trunnion::pipeline {

using nlohmann::ordered_json;

namespace {

constexpr double um = 1000;  ///< µm in a mm

std::string radius_text(double radius_mm) {
    return std::isfinite(radius_mm) ? fmt::format("{:.4g}", radius_mm) : "none";
}

std::string faces_text(const SurfaceSummary& s) {
    const FaceFacts& first = s.faces.front();
    double area_mm2 = 0, hollow_mm = HUGE_VAL;
    for (const FaceFacts& face : s.faces) {
        area_mm2 += face.area_mm2;
        hollow_mm = std::min(hollow_mm, face.hollow_radius_mm);
    }
    const std::string which = s.faces.size() == 1 ? fmt::format("face {} of {}", first.number, s.faces_in_file)
                                                  : fmt::format("{} of {} faces", s.faces.size(), s.faces_in_file);
    const std::string hollow =
        std::isfinite(hollow_mm) ? fmt::format("hollow down to a radius of {:.4g} mm", hollow_mm) : "nowhere hollow";
    return fmt::format("{}: {}, {:.0f} mm², {}", s.surface, which, area_mm2, hollow);
}

std::string splines_text(const SplineAccount& splines) {
    return fmt::format("{} in {} pieces; off the true passes: tip {:.3f} um, axis {:.5f} deg; off touching {:.3f} um",
                       splines.curves, splines.spans, um * splines.tip_error_mm, splines.axis_error_rad / degree,
                       um * splines.touch_error_mm);
}

std::string verdict_text(const SurfaceSummary& s) {
    if (s.usable() && s.check) return "ridges, surface and part hold";
    if (s.usable()) return s.part ? "the part holds; ridges are not simulated (--check)" : "not simulated (--check)";
    std::string out;
    if (s.check && !s.check->ridges_hold) out = fmt::format("more is left than {:g} um", um * s.options.scallop_mm);
    if (s.check && !s.check->surface_holds)
        out += fmt::format("{}the surface is cut deeper than {:g} um", out.empty() ? "" : "; ",
                           um * s.options.gouge_tolerance_mm);
    if (s.check && s.check->mostly_left)
        out += fmt::format("{}more than half of the area is left out", out.empty() ? "" : "; ");
    if (s.part && s.part->in_part)
        out += fmt::format("{}the tool goes into the part{}", out.empty() ? "" : "; ",
                           s.freed || s.left ? "" : " (--free-gouges leans it out, --leave-out leaves those places)");
    return "NOT USABLE: " + out;
}

std::string at_text(const Eigen::Vector3d& at) {
    return fmt::format("({:.3f} {:.3f} {:.3f})", at.x(), at.y(), at.z());
}

/// A face of the part by its index and number.
std::string face_text(const SurfaceSummary& s, int index, int number) {
    const bool elsewhere = !s.part_file.empty() && index >= static_cast<int>(s.faces.size());
    return elsewhere ? fmt::format("face {} of {}", number, s.part_file) : fmt::format("face {}", number);
}

void add_freed(ReportLines& lines, const SurfaceSummary& s) {
    const FreedAccount& freed = *s.freed;
    if (!freed.worst) {
        lines.add("gouges", "none before anything was changed");
    } else {
        std::size_t count = 0;
        for (const std::size_t of_kind : freed.gouges) count += of_kind;
        lines.add("gouges before",
                  fmt::format("at {} contacts; deepest {:.4g} mm, {}, in {} at {}", count, freed.worst->depth_mm,
                              kind_text(*freed.worst), face_text(s, freed.worst->face, freed.worst_face),
                              at_text(freed.worst->at_mm)));
        lines.add("gouges after",
                  fmt::format("none above {:g} um; {} passes turned, by {:.2f} deg at most, {:.2f} deg "
                              "between contacts, in {} rounds",
                              um * freed.tolerance_mm, freed.passes_turned, freed.largest_turn_rad / degree,
                              freed.largest_step_rad / degree, freed.rounds));
    }
    if (freed.links_raised > 0)
        lines.add("", fmt::format("{} ways between passes raised, to {:g} mm at most", freed.links_raised,
                                  freed.highest_link_mm));
}

/// Share of the faces' area that is left as it was.
double left_share(const surfacing::SurfaceVerdict& v) {
    return v.area_mm2 > 0 ? v.left_mm2 / v.area_mm2 : 0;
}

void add_left(ReportLines& lines, const SurfaceSummary& s) {
    const LeftAccount& left = *s.left;
    if (left.way_mm == 0 && left.passes_lost == 0 && left.ridges_too_high == 0) return lines.add("left out", "nothing");
    lines.add("left out", fmt::format("{:.1f} mm of passes, {} passes altogether; the tool would go {:.4g} mm into "
                                      "the part",
                                      left.way_mm, left.passes_lost, left.deepest_mm));
    if (left.ridges_too_high > 0)
        lines.add("", fmt::format("at {} places no distance of passes keeps the scallop, or none gets there",
                                  left.ridges_too_high));
    if (s.check) lines.add("", fmt::format("{:.2f} % of the area is left", 100 * left_share(s.check->verdict)));
}

void add_part(ReportLines& lines, const SurfaceSummary& s) {
    const auto& in = s.part->in_part;
    if (!in) return lines.add("part", fmt::format("the tool goes into none of its {} faces", s.part->faces));
    lines.add("part", fmt::format("THE {} GOES {:.4g} mm INTO {} at {}", in->by_holder ? "HOLDER" : "TOOL",
                                  in->depth_mm, face_text(s, in->face, s.part->in_part_face), at_text(in->at_mm)));
}

void add_check(ReportLines& lines, const SurfaceCheck& check) {
    const auto& v = check.verdict;
    const std::string ridges =
        v.ridges > 0 ? fmt::format("ridges {:.2f} least, {:.2f} median, {:.2f} um largest, of {}",
                                   um * v.least_ridge_mm, um * v.median_ridge_mm, um * v.largest_ridge_mm, v.ridges)
                     : "no ridges away from the borders";
    lines.add("simulated", ridges);
    lines.add("", fmt::format("anywhere on the surface: {:.2f} um left at most, {:.2f} um cut into it at most",
                              um * v.highest_mm, um * v.deepest_mm));
}

ordered_json face_json(const FaceFacts& face) {
    return {{"number", face.number},
            {"along_u_mm", face.along_u_mm},
            {"along_v_mm", face.along_v_mm},
            {"area_mm2", face.area_mm2},
            {"hollow_radius_mm", finite_or_null(face.hollow_radius_mm)},
            {"hump_radius_mm", finite_or_null(face.hump_radius_mm)},
            {"trimmed", !face.whole}};
}

ordered_json splines_json(const SplineAccount& splines) {
    return {{"curves", splines.curves},
            {"pieces", splines.spans},
            {"left_straight", splines.left_straight},
            {"tip_error_mm", splines.tip_error_mm},
            {"axis_error_deg", splines.axis_error_rad / degree},
            {"touch_error_mm", splines.touch_error_mm}};
}

ordered_json in_part_json(const SurfacePartCheck& check) {
    if (!check.in_part) return nullptr;
    return {{"depth_mm", check.in_part->depth_mm},
            {"face", check.in_part_face},
            {"at_mm", point_json(check.in_part->at_mm)},
            {"by_holder", check.in_part->by_holder}};
}

ordered_json part_json(const SurfaceSummary& s) {
    return {{"file", s.part_file}, {"faces", s.part->faces}, {"in_part", in_part_json(*s.part)}};
}

ordered_json left_json(const LeftAccount& left) {
    return {{"way_mm", left.way_mm},
            {"deepest_mm", left.deepest_mm},
            {"passes_lost", left.passes_lost},
            {"ridges_too_high", left.ridges_too_high}};
}

ordered_json check_json(const SurfaceCheck& check) {
    const auto& v = check.verdict;
    return {{"ridges", v.ridges},
            {"least_ridge_mm", v.least_ridge_mm},
            {"median_ridge_mm", v.median_ridge_mm},
            {"largest_ridge_mm", v.largest_ridge_mm},
            {"highest_mm", v.highest_mm},
            {"highest_at_mm", point_json(v.highest_at_mm)},
            {"deepest_mm", v.deepest_mm},
            {"deepest_at_mm", point_json(v.deepest_at_mm)},
            {"left_share", left_share(v)},
            {"ridges_hold", check.ridges_hold},
            {"surface_holds", check.surface_holds},
            {"in_part", in_part_json(check)}};
}

}  // namespace

std::string report(const SurfaceSummary& s) {
    ReportLines lines;
    lines.add("surface", faces_text(s));
    lines.add("tool", s.tool);
    lines.add("passes", fmt::format("{}, {}; {:.1f} mm on the surface, {} contacts", s.passes, s.strategy,
                                    s.cut_length_mm, s.contacts));
    lines.add("between passes", fmt::format("{:.4g} … {:.4g} mm, for ridges of {:.2f} um at most", s.least_interval_mm,
                                            s.largest_interval_mm, um * s.highest_ridge_mm));
    if (s.splines) lines.add("splines", splines_text(*s.splines));
    if (s.freed) add_freed(lines, s);
    if (s.left) add_left(lines, s);
    if (s.part) add_part(lines, s);
    if (s.check) add_check(lines, *s.check);
    if (!s.output.empty()) lines.add("program", fmt::format("{}, {} moves", s.output, s.moves));
    lines.add("verdict", verdict_text(s));
    return lines.text();
}

std::string to_json(const SurfaceSummary& s) {
    ordered_json out;
    out["surface"] = s.surface;
    out["faces_in_file"] = s.faces_in_file;
    out["faces"] = ordered_json::array();
    for (const FaceFacts& face : s.faces) out["faces"].push_back(face_json(face));
    out["tool"] = s.tool;
    out["strategy"] = s.strategy;
    out["scallop_mm"] = s.options.scallop_mm;
    out["chord_tolerance_mm"] = s.options.chord_tolerance_mm;
    out["gouge_tolerance_mm"] = s.options.gouge_tolerance_mm;
    out["passes"] = s.passes;
    out["contacts"] = s.contacts;
    out["moves"] = s.moves;
    out["cut_length_mm"] = s.cut_length_mm;
    out["interval_mm"] = {{"least", s.least_interval_mm}, {"largest", s.largest_interval_mm}};
    out["highest_ridge_mm"] = s.highest_ridge_mm;
    out["splines"] = s.splines ? splines_json(*s.splines) : ordered_json(nullptr);
    out["freed"] = s.freed ? freed_json(*s.freed) : ordered_json(nullptr);
    out["left"] = s.left ? left_json(*s.left) : ordered_json(nullptr);
    out["part"] = s.part ? part_json(s) : ordered_json(nullptr);
    out["check"] = s.check ? check_json(*s.check) : ordered_json(nullptr);
    out["usable"] = s.usable();
    out["diagnostics"] = diagnostics_json(s.diagnostics);
    return out.dump(2) + "\n";
}

std::string report(const surfacing::FaceList& list) {
    std::string out =
        fmt::format("{} {}, in {}", list.faces_in_file, list.faces_in_file == 1 ? "face" : "faces", list.unit);
    if (list.shells > 0) out += fmt::format("; shells: {}, open: {}", list.shells, list.open_shells);
    out += "; below in mm\n";
    out += "face   along u   along v      area   hollow     hump  border   box\n";
    for (const auto& face : list.faces) {
        const FaceFacts f = facts_of(face);
        out += fmt::format("{:>4} {:>9.2f} {:>9.2f} {:>9.5g} {:>8} {:>8}  {:<7} ", f.number, f.along_u_mm, f.along_v_mm,
                           f.area_mm2, radius_text(f.hollow_radius_mm), radius_text(f.hump_radius_mm),
                           f.whole ? "whole" : "trimmed");
        out += f.has_normals ? fmt::format(" {:.1f} {:.1f} {:.1f} … {:.1f} {:.1f} {:.1f}\n", f.low_mm.x(), f.low_mm.y(),
                                           f.low_mm.z(), f.high_mm.x(), f.high_mm.y(), f.high_mm.z())
                             : " no normals\n";
    }
    return out;
}

}  // namespace trunnion::pipeline
