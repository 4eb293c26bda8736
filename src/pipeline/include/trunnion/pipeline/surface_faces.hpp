#pragma once

#include <filesystem>
#include <limits>
#include <span>
#include <vector>

#include "trunnion/base/result.hpp"
#include "trunnion/surfacing/face.hpp"

namespace trunnion::pipeline {

/// The faces of a file: STEP (.step .stp) and IGES (.iges .igs) by surfacing::read_faces, our own TOML (.toml) by
/// files::read_surface_file, where each surface is a whole face. Errors and what is told: those of these two.
Result<surfacing::FaceList> read_surface_faces(const std::filesystem::path& file);

/// Faces by their numbers in the file, in the order asked for; none asked for: the only one. Errors: PIPE0110 a
/// number that the file has not, or one that is asked for twice; PIPE0111 several faces and none asked for.
Result<std::vector<surfacing::Face>> choose_faces(const surfacing::FaceList& list, std::span<const int> numbers);

/// What there is to know of a face before a tool is chosen for it. Found on a grid of places within the face, so that
/// sizes and radii are near the true ones and no bounds.
struct FaceFacts {
    int number = 1;
    double along_u_mm = 0, along_v_mm = 0;  ///< way across its middle
    double area_mm2 = 0;
    Eigen::Vector3d low_mm, high_mm;  ///< corners of its box
    /// Smallest radius of curvature where it is hollow, seen from the side that is machined: what a ball or corner
    /// radius must not exceed; infinite where it is hollow nowhere. The same where it is humped.
    double hollow_radius_mm = std::numeric_limits<double>::infinity();
    double hump_radius_mm = std::numeric_limits<double>::infinity();
    bool whole = false;        ///< its border is that of its surface
    bool has_normals = false;  ///< anywhere
};

/// Cost: some ms a face.
FaceFacts facts_of(const surfacing::Face& face);

}  // namespace trunnion::pipeline
