#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "trunnion/base/result.hpp"
#include "trunnion/surfacing/freed_plan.hpp"
#include "trunnion/surfacing/machined_surface.hpp"
#include "trunnion/surfacing/part_body.hpp"
#include "trunnion/surfacing/plan_surface.hpp"

namespace trunnion::pipeline {

/// What freeing may do to passes led by `lead_rad` where nobody says otherwise: lead and tilt up to 60° either way; the
/// lead of a tool that is no ball keeps its sign, from 1° or half of it on.
surfacing::OrientationLimits lean_limits(const surfacing::Cutter& cutter, double lead_rad);

struct SurfaceProgramOptions {
    surfacing::SurfaceOptions passes;     ///< its leave_out: parts of passes that gouge are cut away
    std::vector<surfacing::Face> others;  ///< of the part, beside the faces that are machined: not to be gone into
    surfacing::Holder holder{};
    /// How far the tool may lean out of what it goes into; none: it stays as it is. Not together with leave_out.
    std::optional<surfacing::OrientationLimits> freeing;
    bool splines = false;      ///< every pass one dual spline; else straight moves
    std::string tool_name;     ///< called before the first move; empty: the program names none
    double spindle_rad_s = 0;  ///< 0: the program does not say
};

/// How dual splines lie to the true passes.
struct SplineAccount {
    std::size_t curves = 0, spans = 0;  ///< passes that are one, and their polynomial pieces together
    std::size_t left_straight = 0;      ///< passes of straight moves: fewer than 4 contacts, or no spline near enough
    /// Largest at the contacts, which lie on the true passes: of the tip off where it touches there with the spline's
    /// axis, and of the axis off the one wanted.
    double tip_error_mm = 0, axis_error_rad = 0;
    double touch_error_mm = 0;  ///< how far the tool is off touching, half way between contacts too
};

/// What freeing a plan of gouges came to; see surfacing::FreedPlan.
struct FreedAccount {
    std::array<std::size_t, 4> gouges{};    ///< by surfacing::GougeKind
    std::optional<surfacing::Gouge> worst;  ///< none: nothing gouged
    int worst_face = 0;                     ///< its face by number
    double tolerance_mm = 0;                ///< passes are free of deeper gouges now
    std::size_t passes_turned = 0;
    double largest_turn_rad = 0, largest_step_rad = 0;
    int rounds = 0;
    std::size_t links_raised = 0;
    double highest_link_mm = 0;
};

/// What leaving parts of passes out came to; see surfacing::ReachedPlan.
struct LeftAccount {
    double way_mm = 0, deepest_mm = 0;
    std::size_t passes_lost = 0, ridges_too_high = 0;
};

/// A finished surface program, and how it leads the tool.
struct SurfaceResult {
    /// Its program is the one to write; its passes are what the program does: with splines the poses are theirs, at the
    /// contacts and half way between them.
    surfacing::SurfacePlan plan;
    std::size_t contacts = 0;  ///< of the planner
    std::optional<SplineAccount> splines;
    std::optional<FreedAccount> freed;
    std::optional<LeftAccount> left;
};

/// Plans the finishing of faces as one region (surfacing::plan_region) and makes a program of it.
///
/// Splines: passes are planned with an eighth of the chord tolerance, so that their contacts stand for the true passes.
/// Of each a dual spline is made (deformation::fit_dual_path) whose tip stays within a quarter of the chord tolerance
/// of where the tool touches the contacts, and whose axis within what turns the tool's radius by as much. A ball, and
/// tools that lean, touch wherever their axis points: for them a spline of the axis within 0.01° of the one wanted
/// comes first, and the tips are those that touch with it. So the tool is off its contact by less than the chord
/// tolerance, as with straight moves, and ridges are planned as high as there.
///
/// Freeing: the passes are planned without regard to what the tool cuts away from its contacts, then freed of gouges
/// deeper than the gouge tolerance (surfacing::free_of_gouges) in machined and other faces. Simulate the
/// result: ridges of tools that are no balls change with the lean.
///
/// Leaving: the parts of passes where the tool would be in machined or other faces by more than the gouge tolerance are
/// cut away (surfacing::leave_out_gouges). What of the faces stays as it is, the simulation says.
///
/// Either way, and without both, links keep clear of all faces of the part where there is a way.
///
/// The program is in the workpiece, law vector. Errors: those of surfacing::plan_region, free_of_gouges and
/// leave_out_gouges; PIPE0119 freeing and leaving both. Told in the
/// program's diagnostics: PIPE0114 passes that stay straight moves. Cost: that of plan_region, with splines three times
/// its contacts and some 50 µs for each.
Result<SurfaceResult> make_surface_program(std::span<const surfacing::Face> faces, const surfacing::Cutter& cutter,
                                           const SurfaceProgramOptions& options);

/// Where a program takes the tool into the part.
struct SurfacePartCheck {
    std::size_t faces = 0;  ///< that were looked at
    /// The deepest place of any move, links and rapids too; none: nowhere by more than is allowed.
    std::optional<surfacing::Penetration> in_part;
    int in_part_face = 0;  ///< its face by number
};

/// Asks of every move, at poses between which no point of the tool goes farther than 1 mm or 2 % of its radius, and
/// half its radius at the most, how deep tool and holder are in the part, the tool up to Cutter::reach_mm: PartBody to
/// 2 µm or half of the gouge tolerance, the body that links and what is left out are planned with; depths up to the
/// gouge tolerance, or 4 µm, and these pass. Errors: those of PartBody::make. Cost: 10 µs a pose.
Result<SurfacePartCheck> check_part(std::span<const surfacing::Face> part, const surfacing::Cutter& cutter,
                                    const SurfaceResult& made, double gouge_tolerance_mm,
                                    const surfacing::Holder& holder = {});

/// What the simulation says of a surface program.
struct SurfaceCheck : SurfacePartCheck {
    surfacing::SurfaceVerdict verdict;
    bool ridges_hold = false;    ///< nothing is left higher than the scallop, to 0.5 %
    bool surface_holds = false;  ///< nothing is cut deeper than the gouge tolerance
    bool mostly_left = false;    ///< more than half of the faces' area is left out
    bool usable() const noexcept { return ridges_hold && surface_holds && !in_part && !mostly_left; }
};

/// Simulates the passes on their faces (surfacing::check_region), with what is allowed, and check_part(): in all faces
/// of the part, also those that are not machined. Of plans with places left out the rest of the faces counts, which
/// must be half of their area at the least. Without
/// passes along the borders strips remain beside them: then only ridges between passes count. Errors: those of
/// PartBody::make. Cost: that of check_region and check_part.
Result<SurfaceCheck> check_surface_program(std::span<const surfacing::Face> faces,
                                           std::span<const surfacing::Face> part, const surfacing::Cutter& cutter,
                                           const SurfaceResult& made, const surfacing::SurfaceOptions& allowed,
                                           const surfacing::Holder& holder = {});

}  // namespace trunnion::pipeline
