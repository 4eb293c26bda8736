#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "trunnion/base/result.hpp"
#include "trunnion/program/program.hpp"
#include "trunnion/surfacing/cutter.hpp"
#include "trunnion/surfacing/face.hpp"

namespace trunnion::surfacing {

enum class Strategy : std::uint8_t {
    constant_scallop,  ///< each pass from the one before by the interval of every place: all ridges as high as allowed
    along_u,           ///< v constant in each pass, passes as far apart in v as the highest ridge allows
    along_v,           ///< the same with u constant
    parallel_planes,   ///< all sections with planes that have the surface's normal in the middle in them
    lin_koren  ///< from the border of least v on, passes offset by the least interval that Eq. 2 gives along the
               ///< one before, with normal radii: their rule, for comparison; it bounds ridges where radii of
               ///< normal sections are below the conjugate ones, and does not use the scallop elsewhere
};

struct SurfaceOptions {
    Strategy strategy = Strategy::constant_scallop;
    double scallop_mm = 0.01;            ///< highest ridge between passes
    double chord_tolerance_mm = 0.0005;  ///< how far straight moves may lead the tool off its contact
    double gouge_tolerance_mm = 0.001;   ///< how deep the tool's body may cut into the surface round its contact
    /// constant_scallop and parallel_planes: direction of the feed in the face's middle, from S_u towards S_v.
    double feed_angle_rad = 0;
    double lead_rad = 0;  ///< axis leaning from the normal towards the feed
    double tilt_rad = 0;  ///< axis leaning across the feed, the same way in passes to and fro
    bool zigzag = true;   ///< every second pass backwards; else all in one direction
    /// Places that the tool does not fit into, or where it would cut too deep, do not refuse the plan but are told:
    /// such a plan gouges, until leave_out_gouges() has cut those parts of passes away.
    bool leave_out = false;
    /// constant_scallop of several faces: passes run on over borders at which they meet with normals within 1°.
    bool across_joints = true;
    /// A pass along every border as well, so that no strip is left beside it; where a tool that is no ball leans along
    /// and across its feed as many as that takes.
    bool borders = true;
    double lift_mm = 1;          ///< up the tool axis between neighbouring passes to and fro
    double retract_mm = 20;      ///< up the tool axis for rapids
    double longest_step_mm = 5;  ///< of a straight move
    double feed_mm_s = 50;
    double approach_mm_s = 10;  ///< from lift height down to the surface
};

/// One pose of a pass.
struct Contact {
    geometry::SurfacePlace place;
    Eigen::Vector3d point_mm, normal;  ///< cutter contact, workpiece
    CutterPose pose;                   ///< tip and axis, workpiece
    int face = 0;                      ///< of the faces planned together, which one `place` is on, from 0
};

class OrientationSurface;

struct Pass {
    std::vector<Contact> contacts;  ///< two or more, in the order of motion
    int index = 0;                  ///< passes of neighbouring indices run beside each other; −1: along a border
    /// That its poses stand on, with the face of its contacts; none: lead and tilt of the options.
    std::shared_ptr<const OrientationSurface> orientation{};
};

/// A place of a face that a plan leaves as it is.
struct LeftPlace {
    Eigen::Vector3d at_mm;
    int face = 0;         ///< of the faces planned together, from 0
    double reach_mm = 0;  ///< how far round it the material may be left: as far as the next pass, or the tool's cut
};

struct SurfacePlan {
    std::vector<Pass> passes;
    double cut_length_mm = 0;                               ///< of the contacts' polylines
    double least_interval_mm = 0, largest_interval_mm = 0;  ///< between passes, within the face
    double highest_ridge_mm = 0;                            ///< between passes as planned, within the face
    std::vector<LeftPlace> left;                            ///< with leave_out: where ridges stay too high
    program::Program program;                               ///< all passes with their links: law vector, one tool
};

/// Plans the finishing of a face: passes over it such that ridges between them stay below `scallop_mm`.
///
/// Intervals come from the conjugate radius of surface and tool (path_interval_mm) and are then corrected by the ridges
/// that the tool as a body leaves between two passes; the part of the scallop that chords may add is kept free, so that
/// ridges of constant_scallop lie between scallop − 2 · chord tolerance and the scallop, away from borders. Passes
/// start in the face's middle (along_u, along_v, lin_koren: at a border) and go on until they leave it.
///
/// Straight moves: the tool, carried with tip linear and axis in one plane, stays within the chord tolerance of
/// touching the surface. Passes end on the face's border. Links: to and fro over `lift_mm`, else a rapid over
/// `retract_mm`; where that goes through one of the faces over the retract height, doubled up to 5 times.
///
/// Errors: SURF0202 an option out of range (it is named), SURF0203 the surface is hollower than the tool is round: the
/// value is its radius there, which a ball or corner radius must not exceed; SURF0204 the tool's body, away from its
/// contact, cuts deeper than `gouge_tolerance_mm`; SURF0205 the face has no normal where passes begin or no pass
/// crosses it; SURF0206 more than 20 000 passes, or ridges to be measured at more than
/// 600 000 places, as far as those passed tell that cover less of the face than is in proportion; SURF0208 passes wind
/// up instead of crossing the face; SURF0209 a ridge stays above the scallop however close the passes are; SURF0210
/// passes do not get to a place of the face; SURF0211 the face turns over: normals are opposite on both sides of a
/// place. Told in the program's diagnostics: SURF0212 by the rule of lin_koren alone a ridge would be above the
/// scallop, and passes are closer there; ridges are measured up to four times of it. Cost: some 10 µs a contact and 200
/// µs for each place of a pass, which are up to 2 mm apart.
Result<SurfacePlan> plan_surface(const Face& face, const Cutter& cutter, const SurfaceOptions& options);

}  // namespace trunnion::surfacing
