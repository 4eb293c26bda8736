#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include "trunnion/base/result.hpp"
#include "trunnion/geometry/surface_shape.hpp"

namespace trunnion::files {

/// A surface that a file gives by its coefficients or control points.
struct DescribedSurface {
    geometry::BsplineSurface surface;
    geometry::Side side = geometry::Side::along;  ///< where the normal leads out of the material
};

/// Reads surfaces (TOML), one table each; docs/surface-files.md has the format at length.
///
///     [[surface]]
///     side = "along" | "against"       where the material is not: along S_u × S_v (default) or against it
///     coefficients_mm = [[[x, y, z], …], …]      S(u, v) = Σ a_ij u^i v^j over 0 … 1, a_ij in row i at place j
///
///     [[surface]]
///     control_points_mm = [[[x, y, z], …], …]    P_ij in row i (along u) at place j (along v)
///     degree = [3, 3]                  of u and v, 1 … 7; default 3, or one below the number of points
///     knots_u = […], knots_v = […]     points + degree + 1, never falling; default: clamped, uniform over 0 … 1
///     weights = [[…], …]               as the control points; default all 1
///
/// Numbers are plain: lengths in mm, as the keys say. A surface has either coefficients or control points.
///
/// Errors, each with its line: FILE0101 file cannot be read, FILE0102 not TOML, FILE0103 key missing, FILE0104 unknown
/// key, FILE0105 value of another kind, rows of unequal length or numbers that are not finite, FILE0113 another side,
/// FILE0119 no surface in the file; GEOM0101 … GEOM0107 a surface that is none: degrees, knots, weights.
Result<std::vector<DescribedSurface>> read_surface_file(const std::filesystem::path& path);

/// The same from text; `file_name` is what diagnostics say.
Result<std::vector<DescribedSurface>> read_surfaces(std::string_view toml_text, std::string_view file_name);

}  // namespace trunnion::files
