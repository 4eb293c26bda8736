#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "trunnion/base/diagnostic.hpp"
#include "trunnion/pipeline/surface.hpp"
#include "trunnion/pipeline/surface_faces.hpp"

namespace trunnion::pipeline {

/// What came of planning a surface.
struct SurfaceSummary {
    std::string surface, tool, strategy;  ///< file, tool and strategy as they are called
    int faces_in_file = 0;
    std::vector<FaceFacts> faces;  ///< those that are machined
    surfacing::SurfaceOptions options;
    std::size_t passes = 0, contacts = 0, moves = 0;  ///< moves: of the program, links and rapids too
    double cut_length_mm = 0, least_interval_mm = 0, largest_interval_mm = 0, highest_ridge_mm = 0;  ///< as planned
    std::optional<SplineAccount> splines;
    std::optional<FreedAccount> freed;
    std::optional<LeftAccount> left;
    std::string part_file;                 ///< of faces of the part that are not in the surface's file
    std::optional<SurfacePartCheck> part;  ///< none: not looked at
    std::optional<SurfaceCheck> check;     ///< none: not simulated
    std::string output;                    ///< file and dialect
    std::vector<Diagnostic> diagnostics;

    /// False where the tool goes into the part, or the simulation found more left, or cut, than is allowed.
    bool usable() const noexcept { return !(part && part->in_part) && (!check || check->usable()); }
};

/// For people; a line for each matter.
std::string report(const SurfaceSummary& summary);

/// For programs: `surface, faces_in_file, faces[], tool, strategy, scallop_mm, chord_tolerance_mm, gouge_tolerance_mm,
/// passes, contacts, moves, cut_length_mm, interval_mm, highest_ridge_mm, splines, freed, left, part, check, usable,
/// diagnostics[]`; splines, freed, left, part and check are null where there are none.
std::string to_json(const SurfaceSummary& summary);

/// The faces of a file as a table, a line each.
std::string report(const surfacing::FaceList& list);

}  // namespace trunnion::pipeline
