#include "trunnion/surfacing/read_faces.hpp"

#ifndef TRUNNION_WITH_OPEN_CASCADE

namespace trunnion::surfacing {

Result<FaceList> read_faces(const std::string& file, const ReadFacesOptions&) {
    return fail({.code = "SURF0101",
                 .text = "this Trunnion was built without Open CASCADE and reads no STEP or IGES file",
                 .place = {.file = file},
                 .hint = "install libocct-data-exchange-dev and build it anew"});
}

}  // namespace trunnion::surfacing

#else

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>

#include <BRepBuilderAPI_NurbsConvert.hxx>
#include <BRepTools.hxx>
#include <BRepTools_WireExplorer.hxx>
#include <BRep_Tool.hxx>
#include <Geom2d_Curve.hxx>
#include <GeomConvert.hxx>
#include <GeomConvert_ApproxSurface.hxx>
#include <Geom_BSplineSurface.hxx>
#include <IGESControl_Reader.hxx>
#include <IGESData_GlobalSection.hxx>
#include <IGESData_IGESModel.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <STEPControl_Reader.hxx>
#include <Standard_Failure.hxx>
#include <TColStd_SequenceOfAsciiString.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Wire.hxx>
#include <fmt/format.h>

#include "trunnion/geometry/bspline_curve.hpp"

#include "detail/solid_faces.hpp"

namespace trunnion::surfacing {

namespace {

using geometry::BsplineSurface;
using geometry::Side;

std::unexpected<Diagnostic> refuse(const char* code, const std::string& file, std::string text, std::string hint = {}) {
    Diagnostic refusal{.code = code, .text = std::move(text), .place = {.file = file}, .hint = std::move(hint)};
    return fail(std::move(refusal));
}

/// Open CASCADE writes what it thinks to standard output.
void silence() {
    Message::DefaultMessenger()->ChangePrinters().Clear();
}

struct Import {
    TopoDS_Shape shape;
    std::string unit;
};

Result<Import> import_step(const std::string& file) {
    STEPControl_Reader reader;
    if (reader.ReadFile(file.c_str()) != IFSelect_RetDone) return refuse("SURF0103", file, "not a readable STEP file");
    TColStd_SequenceOfAsciiString lengths, angles, solid_angles;
    reader.FileUnits(lengths, angles, solid_angles);
    reader.TransferRoots();
    return Import{reader.OneShape(), lengths.IsEmpty() ? "" : lengths.First().ToCString()};
}

Result<Import> import_iges(const std::string& file) {
    IGESControl_Reader reader;
    if (reader.ReadFile(file.c_str()) != IFSelect_RetDone) return refuse("SURF0103", file, "not a readable IGES file");
    reader.TransferRoots();
    const auto unit = reader.IGESModel()->GlobalSection().UnitName();
    return Import{reader.OneShape(), unit.IsNull() ? "" : unit->ToCString()};
}

Result<Import> import_file(const std::string& file) {
    std::string suffix = std::filesystem::path(file).extension().string();
    std::ranges::transform(suffix, suffix.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    const bool step = suffix == ".step" || suffix == ".stp", iges = suffix == ".iges" || suffix == ".igs";
    if (!step && !iges)
        return refuse("SURF0102", file, fmt::format("surfaces are not read from a file `{}`", suffix),
                      "STEP (.step .stp) and IGES (.iges .igs) are read");
    return step ? import_step(file) : import_iges(file);
}

geometry::SurfaceDirection direction_of(int degree, const TColStd_Array1OfReal& knots) {
    return {degree, {knots.begin(), knots.end()}};
}

Result<BsplineSurface> surface_of(const Handle(Geom_BSplineSurface) & of) {
    std::vector<Eigen::Vector3d> points;
    std::vector<double> weights;
    const bool rational = of->IsURational() || of->IsVRational();
    for (int i = 1; i <= of->NbUPoles(); ++i)
        for (int j = 1; j <= of->NbVPoles(); ++j) {
            const gp_Pnt pole = of->Pole(i, j);
            points.emplace_back(pole.X(), pole.Y(), pole.Z());
            if (rational) weights.push_back(of->Weight(i, j));
        }
    return BsplineSurface::make(direction_of(of->UDegree(), of->UKnotSequence()),
                                direction_of(of->VDegree(), of->VKnotSequence()), std::move(points),
                                std::move(weights));
}

Handle(Geom_BSplineSurface) within_our_degrees(const Handle(Geom_BSplineSurface) & of, double tolerance_mm) {
    if (std::max(of->UDegree(), of->VDegree()) <= geometry::max_degree) return of;
    constexpr int most_pieces = 400;
    return GeomConvert_ApproxSurface(of, tolerance_mm, GeomAbs_C1, GeomAbs_C1, geometry::max_degree,
                                     geometry::max_degree, most_pieces, 0)
        .Surface();
}

Handle(Geom_BSplineSurface) bspline_of(const TopoDS_Face& face, double tolerance_mm) {
    const Handle(Geom_Surface) any = BRep_Tool::Surface(face);
    Handle(Geom_BSplineSurface) out = Handle(Geom_BSplineSurface)::DownCast(any->Copy());
    if (out.IsNull()) out = GeomConvert::SurfaceToBSplineSurface(any);
    if (out->IsUPeriodic()) out->SetUNotPeriodic();
    if (out->IsVPeriodic()) out->SetVNotPeriodic();
    return within_our_degrees(out, tolerance_mm);
}

/// A border's curve in (u, v), between two of its parameters.
struct BorderCurve {
    Handle(Geom2d_Curve) curve;
    const BsplineSurface* surface;
    double tolerance_mm;

    Eigen::Vector2d at(double t) const {
        const gp_Pnt2d p = curve->Value(t);
        return {p.X(), p.Y()};
    }
    /// Appends the points behind `from` up to `to`, as many as the tolerance asks for.
    void append(double from, double to, Loop& loop, int depth = 0) const {
        const Eigen::Vector2d a = at(from), b = at(to);
        double off = 0;
        for (const double share : {0.25, 0.5, 0.75}) {
            const Eigen::Vector2d straight = a + share * (b - a), curved = at(from + share * (to - from));
            const auto s = surface->at(straight.x(), straight.y()), c = surface->at(curved.x(), curved.y());
            off = std::max(off, (s - c).norm());
        }
        constexpr int deepest = 10;
        if (off <= tolerance_mm || depth == deepest) return loop.push_back(b);
        append(from, 0.5 * (from + to), loop, depth + 1);
        append(0.5 * (from + to), to, loop, depth + 1);
    }
};

struct Borders {
    std::vector<Loop> loops;
    int degenerate_edges = 0;
};

std::optional<Loop> loop_of(const TopoDS_Wire& wire, const TopoDS_Face& face, const BsplineSurface& surface,
                            double tolerance_mm, int& degenerate_edges) {
    Loop loop;
    for (BRepTools_WireExplorer edges(wire, face); edges.More(); edges.Next()) {
        double from = 0, to = 0;
        const BorderCurve border{BRep_Tool::CurveOnSurface(edges.Current(), face, from, to), &surface, tolerance_mm};
        if (border.curve.IsNull()) return std::nullopt;
        if (BRep_Tool::Degenerated(edges.Current())) ++degenerate_edges;
        if (edges.Current().Orientation() == TopAbs_REVERSED) std::swap(from, to);
        // An odd number of pieces first, so that a symmetric border does not pass for a straight one.
        for (int k = 0; k < 3; ++k) border.append(from + (to - from) * k / 3, from + (to - from) * (k + 1) / 3, loop);
    }
    if (loop.size() < 3) return std::nullopt;
    return loop;
}

std::optional<Borders> borders_of(const TopoDS_Face& face, const BsplineSurface& surface, double tolerance_mm) {
    Borders out;
    const TopoDS_Wire outer = BRepTools::OuterWire(face);
    for (TopExp_Explorer wires(face, TopAbs_WIRE); wires.More(); wires.Next()) {
        const TopoDS_Wire wire = TopoDS::Wire(wires.Current());
        auto loop = loop_of(wire, face, surface, tolerance_mm, out.degenerate_edges);
        if (!loop) return std::nullopt;
        const bool first = wire.IsSame(outer);
        out.loops.insert(first ? out.loops.begin() : out.loops.end(), std::move(*loop));
    }
    if (out.loops.empty()) return std::nullopt;
    return out;
}

bool lacks_normals(const Face& face) {
    constexpr int grid = 20;
    const ParameterBox box = parameter_box(face);
    const Eigen::Vector2d step = (box.high - box.low) / grid;
    for (int i = 0; i < grid; ++i)
        for (int j = 0; j < grid; ++j) {
            const geometry::SurfacePlace place{box.low.x() + (i + 0.5) * step.x(), box.low.y() + (j + 0.5) * step.y()};
            if (contains(face, place) && !shape_at(face.surface, place, face.side)) return true;
        }
    return false;
}

/// Collects what is odd, each code once.
class Notes {
  public:
    Notes(std::string file, FaceList& list) : file_(std::move(file)), list_(list) {}
    void add(const char* code, std::string text, int count = 1) {
        if (count == 0) return;
        for (Diagnostic& known : list_.diagnostics)
            if (known.code == code) {
                known.count += count;
                return;
            }
        list_.diagnostics.push_back({.code = code,
                                     .severity = Severity::warning,
                                     .text = std::move(text),
                                     .place = {.file = file_},
                                     .count = count});
    }

  private:
    std::string file_;
    FaceList& list_;
};

void add_face(const TopoDS_Face& original, const detail::SolidFaces& solid, const ReadFacesOptions& options,
              FaceList& list, Notes& notes) {
    ++list.faces_in_file;
    BRepBuilderAPI_NurbsConvert conversion(original, true);
    const TopoDS_Face face = TopoDS::Face(conversion.Shape());
    auto surface = surface_of(bspline_of(face, options.surface_tolerance_mm));
    if (!surface)
        return notes.add("SURF0105", fmt::format("face {} is left out: {}", list.faces_in_file, surface.error().text));
    auto borders = borders_of(face, *surface, options.border_tolerance_mm);
    if (!borders)
        return notes.add("SURF0109", fmt::format("face {} is left out: it has no closed border", list.faces_in_file));
    notes.add("SURF0106", fmt::format("face {} has an edge that is one point", list.faces_in_file),
              borders->degenerate_edges);
    const Side side = face.Orientation() == TopAbs_REVERSED ? Side::against : Side::along;
    list.faces.push_back({std::move(*surface), solid.turned.Contains(original) ? geometry::opposite(side) : side,
                          std::move(borders->loops), list.faces_in_file, solid.faces.Contains(original)});
    if (lacks_normals(list.faces.back()))
        notes.add("SURF0107", fmt::format("face {} has places without a normal", list.faces_in_file));
}

void note(const detail::SolidFaces& solid, FaceList& list, Notes& notes) {
    list.shells = solid.shells;
    list.open_shells = solid.open_shells;
    notes.add("SURF0108", "a shell is open: which side of its faces is material is what the file says of each",
              solid.open_shells);
    notes.add("SURF0110",
              "a face of no closed shell looked into the body that it closes with others, and was turned over",
              solid.turned.Extent());
}

}  // namespace

Result<FaceList> read_faces(const std::string& file, const ReadFacesOptions& options) {
    silence();
    std::error_code status;
    if (!std::filesystem::is_regular_file(file, status)) return refuse("SURF0103", file, "there is no such file");
    FaceList list;
    Notes notes(file, list);
    try {
        auto import = import_file(file);
        if (!import) return fail(std::move(import.error()));
        list.unit = std::move(import->unit);
        if (import->shape.IsNull()) return refuse("SURF0104", file, "no face is in the file");
        const auto solid = detail::solid_faces(import->shape, options.border_tolerance_mm);
        note(solid, list, notes);
        for (TopExp_Explorer faces(import->shape, TopAbs_FACE); faces.More(); faces.Next()) try {
                add_face(TopoDS::Face(faces.Current()), solid, options, list, notes);
            } catch (const Standard_Failure& failure) {
                notes.add("SURF0105",
                          fmt::format("face {} is left out: {}", list.faces_in_file, failure.GetMessageString()));
            }
    } catch (const Standard_Failure& failure) {
        return refuse("SURF0103", file, fmt::format("Open CASCADE gave up: {}", failure.GetMessageString()));
    }
    if (list.faces.empty()) return refuse("SURF0104", file, "no face is in the file that could be used");
    return list;
}

}  // namespace trunnion::surfacing

#endif
