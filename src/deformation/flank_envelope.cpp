#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "trunnion/deformation/flank_milling.hpp"

#include "detail/envelope.hpp"
#include "detail/flank_walk.hpp"
#include "detail/spline_equations.hpp"

namespace trunnion::deformation {

using Eigen::Vector3d;

namespace {

ToolMotion<double> motion_at(const DualPath& path, double u) {
    const auto bottom = path.spline.bottom().evaluate(u), top = path.spline.top().evaluate(u);
    return tool_motion<double>(bottom[0], bottom[1], top[0] - bottom[0], top[1] - bottom[1]);
}

Diagnostic no_normal(double u, double height_mm) {
    return {.code = "DEFO0112",
            .text = fmt::format("the surface has no normal beside the tool at u = {:.6g}, {:.4g} mm up", u, height_mm)};
}

void summarise(DeviationMap& map) {
    double squares = 0;
    for (const double d : map.deviation_mm) squares += d * d;
    const auto [deepest, highest] = std::ranges::minmax(map.deviation_mm);
    map.deepest_mm = deepest;
    map.highest_mm = highest;
    map.peak_mm = std::max(-deepest, highest);
    map.mean_square_root_mm = std::sqrt(squares / static_cast<double>(map.deviation_mm.size()));
}

}  // namespace

std::optional<EnvelopePoint> envelope_point(const DualPath& path, const FlankTool& tool, double u, double height_mm,
                                            const Vector3d& towards) noexcept {
    const auto motion = motion_at(path, u);
    const auto outline = tool.at(height_mm);
    const auto found = characteristic_point(motion, height_mm, outline, towards);
    if (!found.exists) return {};
    return EnvelopePoint{found.point, (found.radial - outline.slope * motion.axis).normalized()};
}

std::vector<double> places_along(const DualPath& path, const FlankRange& range) {
    const std::vector<double> at = stations_of(path.spline.bottom().knots());
    std::vector<double> out;
    for (std::size_t k = 0; k + 1 < at.size(); ++k)
        for (int i = 0; i < range.places_per_interval; ++i)
            out.push_back(std::lerp(at[k], at[k + 1], static_cast<double>(i) / range.places_per_interval));
    out.push_back(at.back());
    return out;
}

std::vector<double> heights_of(const FlankRange& range) {
    std::vector<double> out;
    for (int i = 0; i < range.heights; ++i)
        out.push_back(
            std::lerp(range.from_height_mm, range.to_height_mm, static_cast<double>(i) / (range.heights - 1)));
    return out;
}

Diagnostic no_envelope(const FlankSample& sample) {
    return {.code = "DEFO0113",
            .text = fmt::format("the tool leaves no envelope at u = {:.6g}, {:.4g} mm up", sample.u, sample.height_mm),
            .hint = "it stands still or plunges there"};
}

Result<std::vector<FlankSample>> walk_flank(const DualPath& path, const FlankTool& tool, const DesignedSurface& surface,
                                            const FlankRange& range) {
    if (auto sound = check(tool, range.from_height_mm, range.to_height_mm); !sound) return fail(sound.error());
    if (range.heights < 2 || range.places_per_interval < 1)
        return fail({.code = "DEFO0105", .text = "a range takes 2 heights and 1 place in an interval, or more"});
    const std::vector<double> along = places_along(path, range), heights = heights_of(range);
    std::vector<FlankSample> out;
    out.reserve(along.size() * heights.size());
    std::optional<SurfaceFoot> lowest;
    for (std::size_t i = 0; i < along.size(); ++i) {
        std::optional<SurfaceFoot> facing = lowest;
        for (std::size_t j = 0; j < heights.size(); ++j) {
            const Vector3d point = path.point_mm(along[i], heights[j]);
            facing = facing ? surface.foot(point, facing->place) : surface.foot(point);
            if (!facing) return fail(no_normal(along[i], heights[j]));
            if (j == 0) lowest = facing;
            out.push_back({i, j, along[i], heights[j], *facing});
        }
    }
    return out;
}

Result<DeviationMap> deviation_map(const DualPath& path, const FlankTool& tool, const DesignedSurface& surface,
                                   const FlankRange& range) {
    const auto samples = walk_flank(path, tool, surface, range);
    if (!samples) return fail(samples.error());
    DeviationMap out{places_along(path, range), heights_of(range)};
    for (const FlankSample& sample : *samples) {
        const auto found = envelope_point(path, tool, sample.u, sample.height_mm, -sample.facing.normal);
        if (!found) return fail(no_envelope(sample));
        const auto foot = surface.foot(found->point_mm, sample.facing.place);
        if (!foot) return fail(no_normal(sample.u, sample.height_mm));
        out.deviation_mm.push_back((found->point_mm - foot->point_mm).dot(foot->normal));
    }
    summarise(out);
    return out;
}

}  // namespace trunnion::deformation
