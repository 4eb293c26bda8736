#include "trunnion/deformation/flank_tool.hpp"

#include <cmath>
#include <numbers>

namespace trunnion::deformation {

FlankTool::Outline FlankTool::at(double height_mm) const noexcept {
    switch (kind) {
        case FlankKind::cone: {
            const double slope = std::tan(half_angle_rad);
            return {radius_mm + height_mm * slope, slope};
        }
        case FlankKind::barrel: {
            const double above = height_mm - widest_height_mm;
            const double out = std::sqrt(outline_radius_mm * outline_radius_mm - above * above);
            return {radius_mm - outline_radius_mm + out, -above / out};
        }
        case FlankKind::cylinder:
            break;
    }
    return {radius_mm, 0};
}

Result<void> check(const FlankTool& tool, double from_height_mm, double to_height_mm) {
    const auto refuse = [](const char* text) { return fail({.code = "DEFO0111", .text = text}); };
    if (!(from_height_mm < to_height_mm) || !std::isfinite(from_height_mm) || !std::isfinite(to_height_mm))
        return refuse("the heights between which the tool is to cut do not rise");
    if (!(tool.radius_mm > 0) || !std::isfinite(tool.radius_mm)) return refuse("the tool's radius is not above 0");
    if (tool.kind == FlankKind::cone && !(std::abs(tool.half_angle_rad) < std::numbers::pi / 2))
        return refuse("the half angle of a cone does not lie below 90 degrees");
    if (tool.kind == FlankKind::barrel &&
        (!(tool.outline_radius_mm >= tool.radius_mm) || !std::isfinite(tool.outline_radius_mm)))
        return refuse("the outline radius of a barrel is below its radius");
    for (const double height : {from_height_mm, to_height_mm})
        if (!(tool.at(height).radius_mm > 0)) return refuse("the tool has no side at all heights asked for");
    return {};
}

}  // namespace trunnion::deformation
