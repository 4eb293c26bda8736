#pragma once

#include <cstdint>

#include "trunnion/base/result.hpp"

namespace trunnion::deformation {

enum class FlankKind : std::uint8_t {
    cylinder,
    cone,   ///< radius in proportion to the height
    barrel  ///< outline of one arc, widest at a height
};

/// The side of a tool of revolution: its radius r(z) at every height z above the tip, along the axis. All lengths mm.
///     cylinder  r = R
///     cone      r = R + z tan β
///     barrel    r = R − ρ + √(ρ² − (z − z₀)²)
struct FlankTool {
    FlankKind kind = FlankKind::cylinder;
    double radius_mm = 5;          ///< R > 0: cylinder; cone: at the tip; barrel: where it is widest
    double half_angle_rad = 0;     ///< β of a cone, in ]−π/2, π/2[; above 0 it widens towards the spindle
    double outline_radius_mm = 0;  ///< ρ ≥ R of a barrel
    double widest_height_mm = 0;   ///< z₀ of a barrel

    /// The outline at a height: r and dr/dz. Precondition: a height at which the tool has a side.
    struct Outline {
        double radius_mm = 0, slope = 0;
    };
    Outline at(double height_mm) const noexcept;
};

/// Refuses what has no side between two heights. Errors: DEFO0111 a dimension is not finite or out of its range, the
/// heights do not rise, or the radius is not above 0 at one of them.
Result<void> check(const FlankTool& tool, double from_height_mm, double to_height_mm);

}  // namespace trunnion::deformation
