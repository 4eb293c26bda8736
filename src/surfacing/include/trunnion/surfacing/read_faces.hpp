#pragma once

#include <string>

#include "trunnion/base/result.hpp"
#include "trunnion/surfacing/face.hpp"

namespace trunnion::surfacing {

struct ReadFacesOptions {
    /// Largest distance on the surface between a border and the straight pieces in (u, v) that stand for it.
    double border_tolerance_mm = 0.01;
    /// Largest error where a surface has to be approximated: offset surfaces and the like, or degrees above 7.
    double surface_tolerance_mm = 0.001;
};

/// All faces of a STEP (.step .stp) or IGES (.iges .igs) file, in mm whatever the file counts in, with their borders.
/// Planes, cylinders and so on become B-splines exactly; what is no B-spline in nature is approximated.
///
/// Errors: SURF0101 built without Open CASCADE, SURF0102 another kind of file, SURF0103 not readable or broken,
/// SURF0104 no face in it. Told in FaceList::diagnostics: SURF0105 faces left out that could not be made B-splines,
/// SURF0106 degenerate edges (one point, as at the pole of a sphere), SURF0107 faces with places that have no normal
/// inside, SURF0108 open shells, SURF0109 faces left out without a closed border, SURF0110 faces turned over. Faces of
/// closed shells are solid (Face::solid), and so are faces of no closed shell whose borders meet within the border
/// tolerance, or 1e-5 of the size of it all, so that they close a body: those look out of it then, whatever the file
/// says. Cost: seconds for some MB, all of it Open CASCADE's. It keeps state of its own: not from two threads at once.
Result<FaceList> read_faces(const std::string& file, const ReadFacesOptions& options = {});

}  // namespace trunnion::surfacing
