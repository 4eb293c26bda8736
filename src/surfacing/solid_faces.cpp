#ifdef TRUNNION_WITH_OPEN_CASCADE

#include "detail/solid_faces.hpp"

#include <algorithm>
#include <cmath>

#include <BRepBndLib.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepLib.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_DataMapOfShapeInteger.hxx>
#include <TopTools_ListOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Shell.hxx>
#include <TopoDS_Solid.hxx>

namespace trunnion::surfacing::detail {

namespace {

/// The faces of a closed shell with their orientations out of the body.
void add_outward(const TopoDS_Shell& shell, TopTools_DataMapOfShapeInteger& out) {
    TopoDS_Solid solid;
    BRep_Builder builder;
    builder.MakeSolid(solid);
    builder.Add(solid, shell);
    if (!BRepLib::OrientClosedSolid(solid)) return;
    for (TopExp_Explorer faces(solid, TopAbs_FACE); faces.More(); faces.Next())
        out.Bind(faces.Current(), static_cast<int>(faces.Current().Orientation()));
}

/// Those of no closed shell.
TopTools_ListOfShape loose_faces(const TopoDS_Shape& shape, const SolidFaces& known) {
    TopTools_ListOfShape out;
    for (TopExp_Explorer faces(shape, TopAbs_FACE); faces.More(); faces.Next())
        if (!known.faces.Contains(faces.Current())) out.Append(faces.Current());
    return out;
}

/// Files are as exact as their numbers are long: large bodies gape wider.
double gape_mm(const TopoDS_Shape& shape, double tolerance_mm) {
    constexpr double share = 1e-5;
    Bnd_Box box;
    BRepBndLib::Add(shape, box);
    return box.IsVoid() ? tolerance_mm : std::max(tolerance_mm, share * std::sqrt(box.SquareExtent()));
}

void join_loose(const TopoDS_Shape& shape, double tolerance_mm, SolidFaces& out) {
    const TopTools_ListOfShape loose = loose_faces(shape, out);
    if (loose.IsEmpty()) return;
    BRepBuilderAPI_Sewing sewing(gape_mm(shape, tolerance_mm));
    for (const TopoDS_Shape& face : loose) sewing.Add(face);
    sewing.Perform();
    TopTools_DataMapOfShapeInteger outward;
    for (TopExp_Explorer shells(sewing.SewedShape(), TopAbs_SHELL); shells.More(); shells.Next())
        if (BRep_Tool::IsClosed(shells.Current())) add_outward(TopoDS::Shell(shells.Current()), outward);
    for (const TopoDS_Shape& face : loose) {
        const TopoDS_Shape& joined = sewing.Modified(face);
        if (!outward.IsBound(joined)) continue;
        out.faces.Add(face);
        if (outward.Find(joined) != static_cast<int>(face.Orientation())) out.turned.Add(face);
    }
}

}  // namespace

SolidFaces solid_faces(const TopoDS_Shape& shape, double tolerance_mm) {
    SolidFaces out;
    for (TopExp_Explorer shells(shape, TopAbs_SHELL); shells.More(); shells.Next()) {
        ++out.shells;
        if (!BRep_Tool::IsClosed(shells.Current())) {
            ++out.open_shells;
            continue;
        }
        for (TopExp_Explorer faces(shells.Current(), TopAbs_FACE); faces.More(); faces.Next())
            out.faces.Add(faces.Current());
    }
    join_loose(shape, tolerance_mm, out);
    return out;
}

}  // namespace trunnion::surfacing::detail

#endif
