#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "trunnion/base/result.hpp"
#include "trunnion/pipeline/surface.hpp"

#include "surface_options.hpp"

namespace trunnion::app {

/// What the command line says about the part that the tool must not go into, as text.
struct SurfacePartText {
    std::string part, holder, least_lead, most_lead = "60deg", most_tilt = "60deg";
    bool leave_out = false, free_gouges = false;

    void add_to(CLI::App& command);
};

/// The part beside the faces that are machined.
struct SurfacePart {
    std::string file;  ///< of `others`; empty: that of the surface
    std::vector<surfacing::Face> others;
    surfacing::Holder holder;
    std::vector<Diagnostic> told;  ///< by what read the file

    /// The faces that are machined first.
    std::vector<surfacing::Face> with(const std::vector<surfacing::Face>& machined) const;
};

/// Default: all faces of the surface's file. Errors: PIPE0110, PIPE0117 a holder that is none, those of
/// pipeline::read_surface_faces.
Result<SurfacePart> read_part(const SurfacePartText& text, const SurfaceText& surface, const SurfaceWork& work);

/// Limits of --free-gouges. Where none is given for the least lead, the lead of a tool that is no ball keeps its sign.
Result<surfacing::OrientationLimits> lean_limits(const SurfacePartText& text, const SurfaceWork& work);

}  // namespace trunnion::app
