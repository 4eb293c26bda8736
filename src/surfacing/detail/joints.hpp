#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "trunnion/geometry/surface_shape.hpp"
#include "trunnion/surfacing/face.hpp"

namespace trunnion::surfacing::detail {

/// A point of a face's border.
struct BorderPoint {
    Eigen::Vector2d place;
    Eigen::Vector3d at;
    double along;  ///< number of its point in the loop, with the share of the way to the next one
};

/// A piece of a loop. Closed: all of it; the first point is not repeated.
struct Stretch {
    std::size_t loop = 0;
    std::vector<BorderPoint> points;                 ///< in the order of the loop; `along` grows, beyond its end too
    std::vector<geometry::SurfacePlace> opposite{};  ///< on the other face, at these points
    bool closed = false;

    /// Whether it holds a number of points in its loop of `size`.
    bool holds(double along, std::size_t size) const noexcept;
};

/// Where two faces meet and their normals agree, seen from either of them.
struct SmoothJoint {
    std::size_t first, second;  ///< of the faces, in a group of its faces
    Stretch on_first, on_second;
};

/// Faces that are joined smoothly, in the order given; of one face no joints.
struct SmoothGroup {
    std::vector<std::size_t> faces;
    std::vector<SmoothJoint> joints;
};

/// Borders that two faces share, within 0.03 mm and 0.01 mm off their surfaces, with normals within 1° all along. Cost:
/// some µs for each point of the borders of faces that are near each other.
std::vector<SmoothJoint> smooth_joints(std::span<const Face> faces);

/// Groups of faces by their smooth joints. A joint that would close a ring of faces is left out, unless they lie round
/// a point: what is joined can be spread out like one face.
std::vector<SmoothGroup> smooth_groups(std::span<const Face> faces);

/// Points all along a loop, close enough to stand for it.
std::vector<BorderPoint> border_points(const Face& face, std::size_t loop);

}  // namespace trunnion::surfacing::detail
