#pragma once

#include <span>

#include "trunnion/base/result.hpp"
#include "trunnion/surfacing/machined_surface.hpp"
#include "trunnion/surfacing/plan_surface.hpp"

namespace trunnion::surfacing {

/// Plans the finishing of several faces as one region; of one face it is plan_surface(). Contact::face says on which
/// face of the span a contact lies.
///
/// - parallel_planes: all faces are cut by the same planes, which have the normal and the feed in the first face's
///   middle in them, and are as far apart as the highest ridge on any face allows. Where the part of a pass on one face
///   ends within 0.05 mm of that on the next one, normals within 15°, the pass goes on over their border.
/// - constant_scallop: faces that share borders, with normals within 1° all along, are machined as one, from the middle
///   of the first of them: passes run on over these borders, which have none of their own. Where the march does not get
///   all over them, or the plan would be refused, each face has passes of its own, as below. A ring of faces is cut
///   open at one of its borders.
/// - the other strategies: face by face, each from its own middle or border, passes not joined; a border that two faces
///   share smoothly has its pass once.
///
/// The tool on any face is checked against all of them as PartBody: refused is what cuts deeper than the gouge
/// tolerance and 10 µm; what is less deep, check_region() finds.
///
/// Errors: as plan_surface(), the text with the face's number; SURF0204 also where the tool on one face cuts another
/// one; SURF0207 no face; SURF0302 more triangles than PartBody takes.
Result<SurfacePlan> plan_region(std::span<const Face> faces, const Cutter& cutter, const SurfaceOptions& options);

/// check_surface() of all faces of a region: what any pass cuts counts on every face.
SurfaceVerdict check_region(std::span<const Face> faces, const Cutter& cutter, const std::vector<Pass>& passes,
                            const SurfaceCheckOptions& options = {});

}  // namespace trunnion::surfacing
