#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "trunnion/base/diagnostic.hpp"
#include "trunnion/geometry/surface_shape.hpp"

namespace trunnion::surfacing {

/// A closed polyline in (u, v), without its first point repeated at the end.
using Loop = std::vector<Eigen::Vector2d>;

/// A piece of surface that is to be machined. Its inside is what lies within an odd number of the loops.
struct Face {
    geometry::BsplineSurface surface;
    geometry::Side side = geometry::Side::along;  ///< where the normal leads out of the material
    std::vector<Loop> loops;                      ///< at least one; the outer border first
    int number = 1;                               ///< in its file, from 1
    /// Of a closed shell: all behind it is material. Else it is a sheet, and what is behind it nobody says.
    bool solid = false;
};

/// A face that is all of a surface: one loop, the border of the domain.
Face whole_face(geometry::BsplineSurface surface, geometry::Side side = geometry::Side::along);

/// Whether a place lies within the face. Cost: one pass over the loops' points; no allocation.
bool contains(const Face& face, const geometry::SurfacePlace& place) noexcept;

/// Corners of the box of (u, v) around the loops.
struct ParameterBox {
    Eigen::Vector2d low, high;
};
ParameterBox parameter_box(const Face& face);

/// The faces of a file, mm.
struct FaceList {
    std::vector<Face> faces;              ///< in the order of the file
    std::string unit;                     ///< the length that the file counts in, as it says: "mm", "INCH"
    int faces_in_file = 0;                ///< those left out included
    int shells = 0, open_shells = 0;      ///< groups of faces that are joined at edges, and those with a free edge
    std::vector<Diagnostic> diagnostics;  ///< what was left out or is odd, each code once with its count
};

}  // namespace trunnion::surfacing
