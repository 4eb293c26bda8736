#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "trunnion/base/result.hpp"
#include "trunnion/surfacing/face.hpp"

namespace trunnion::surfacing::detail {

/// How a rectangle of (u, v) lies to a face.
enum class Overlap : std::uint8_t { none, part, all };
Overlap overlap(const Face& face, const Eigen::Vector2d& low, const Eigen::Vector2d& high);

/// A flat piece of skin, its corners turning left seen from outside the material.
struct Triangle {
    std::array<Eigen::Vector3d, 3> corner;
    std::int32_t face;
};

/// Appends triangles that lie within `tolerance_mm` of the face, and the face of them; over the part within the loops'
/// polylines, cut along them. Between pieces of different fineness the skin may gape by the tolerance.
/// Errors: SURF0302 more than `most` triangles.
Result<void> tessellate(const Face& face, std::int32_t index, double tolerance_mm, std::size_t most,
                        std::vector<Triangle>& out);

}  // namespace trunnion::surfacing::detail
