#pragma once

#include <memory>
#include <vector>

#include "trunnion/pipeline/surface.hpp"
#include "trunnion/surfacing/cutter.hpp"
#include "trunnion/surfacing/face.hpp"
#include "trunnion/surfacing/part_body.hpp"

#include "arguments.hpp"

/// Faces, tools and passes over them, as Python sees them.
namespace trunnion::python {

/// What was planned, with what it was planned on.
struct BoundSurfacePlan {
    std::vector<surfacing::Face> faces;
    surfacing::Cutter cutter;
    surfacing::SurfaceOptions options;
    pipeline::SurfaceResult result;
    std::shared_ptr<program::Program> program;
};

/// `reach_mm`: how far up from the tip the tool counts as its body; 0: its diameter.
surfacing::Cutter cutter_of(const machine::Tool& tool, double reach_mm = 0);
/// A Face, a FaceList or a sequence of faces.
std::vector<surfacing::Face> faces_of(py::handle object, const char* name);
/// (diameter, from, to) in mm, up the axis from the tip; None: no holder.
surfacing::Holder holder_of(py::handle object);
/// How passes lie.
surfacing::SurfaceOptions take_surface_options(Keywords& keywords);

/// The part as a body, and what of a plan's passes goes into it.
void bind_gouges(py::module_& module, py::class_<BoundSurfacePlan>& plan);

/// One column of contacts, an array of shape (n, width); `take` gives a vector of one.
template <class Contacts, class Take>
Array column_of(const Contacts& contacts, py::ssize_t width, Take&& take) {
    std::vector<double> out;
    for (const auto& contact : contacts) {
        const auto row = take(contact);
        out.insert(out.end(), row.data(), row.data() + width);
    }
    return array_from(std::move(out), width);
}

/// places, points_mm, normals, tips_mm, axes.
template <class Contacts>
py::dict contact_columns(const Contacts& contacts) {
    py::dict out;
    out["places"] = column_of(contacts, 2, [](const auto& c) { return Eigen::Vector2d(c.place.u, c.place.v); });
    out["points_mm"] = column_of(contacts, 3, [](const auto& c) { return c.point_mm; });
    out["normals"] = column_of(contacts, 3, [](const auto& c) { return c.normal; });
    out["tips_mm"] = column_of(contacts, 3, [](const auto& c) { return c.pose.tip_mm; });
    out["axes"] = column_of(contacts, 3, [](const auto& c) { return c.pose.axis; });
    return out;
}

}  // namespace trunnion::python
