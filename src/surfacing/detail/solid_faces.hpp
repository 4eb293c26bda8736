#pragma once

#include <TopTools_MapOfShape.hxx>
#include <TopoDS_Shape.hxx>

namespace trunnion::surfacing::detail {

/// Which faces of a file enclose bodies. Needs Open CASCADE.
struct SolidFaces {
    TopTools_MapOfShape faces;        ///< of closed shells, as they are in the shape
    TopTools_MapOfShape turned;       ///< of them those that look into the body
    int shells = 0, open_shells = 0;  ///< as the file has them
};

/// Faces of no closed shell, as IGES has them, are joined where their borders are within the tolerance, or 1e-5 of the
/// whole shape's size: those that close a body then look out of it, whichever way round the file has them.
SolidFaces solid_faces(const TopoDS_Shape& shape, double tolerance_mm);

}  // namespace trunnion::surfacing::detail
