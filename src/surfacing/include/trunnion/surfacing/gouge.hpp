#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "trunnion/base/result.hpp"
#include "trunnion/surfacing/part_body.hpp"
#include "trunnion/surfacing/surface_tool_path.hpp"

namespace trunnion::surfacing {

/// What of the tool is where it must not be. `local`: the surface is hollower at the contact than the tool is round
/// (parting() has a negative principal value). `rear`: the tool's end, away from its contact, in the face that is
/// machined. `global`: another face, or the shank. `holder`: the holder.
enum class GougeKind : std::uint8_t { local, rear, global, holder };

struct Gouge {
    GougeKind kind = GougeKind::global;
    double depth_mm = 0;
    Eigen::Vector3d at_mm;  ///< where the part is deepest in the tool
    int face = 0;           ///< of the part
    std::size_t pass = 0, contact = 0;
    double share = 0;              ///< of the way from this contact to the next one, in [0, 1[
    geometry::SurfacePlace place;  ///< of the tool's contact
    Eigen::Vector3d axis;
};

struct GougeOptions {
    double tolerance_mm = 0.01;  ///< depths up to it are none; at least twice the part's tolerance
    /// No point of the tool moves farther between two poses that are looked at. What begins and ends between two of
    /// them stays unseen; it is shallower than half of it, and on skin of radius ρ than step²/8ρ.
    double step_mm = 0.5;
    Holder holder{};
};

struct GougeReport {
    std::vector<Gouge> gouges;  ///< one for each contact from which a move gouges: its deepest pose, in order
    double deepest_mm = 0;
    std::size_t poses = 0;  ///< looked at
    const Gouge* worst() const noexcept;
};

/// Walks the tool along passes, tip linear and axis in one plane between contacts, and asks the part how deep it is.
/// `machined`: index of the passes' face among the part's faces. Errors: SURF0301 an option out of range. Cost: 5-20 µs
/// a pose.
Result<GougeReport> find_gouges(const Face& face, int machined, const Cutter& cutter, const PartBody& part,
                                std::span<const Pass> passes, const GougeOptions& options = {});

struct GougeRemovalOptions {
    GougeOptions gouge{};
    SurfacePathOptions path{};
    double clearance_rad = 0.01;  ///< turned farther than needed, each round once more, so that neighbours are free too
    double hold = 0.5;            ///< as of OrientationSurface::towards()
    int most_rounds = 12;
};

struct GougeRemoval {
    OrientationSurface orientation;  ///< deformed
    std::vector<Pass> passes;        ///< on it
    GougeReport before, after;
    double largest_turn_rad = 0;  ///< of a contact's axis against the first orientation surface
    double largest_step_rad = 0;  ///< between neighbouring contacts of a pass
    int rounds = 0;
    std::size_t targets = 0;  ///< places whose orientation was asked to change
};

/// Makes passes free of gouges by deforming the orientation surface: contacts stay where they are. Where a pose gouges,
/// the orientation nearest to its own one is looked for that is free and within the limits, in rings 1° apart of 24
/// directions, refined to 0.1°; the surface is brought towards all of them (OrientationSurface::towards()), the passes
/// are laid on it anew and looked at again, with more targets where they still gouge or where limits are exceeded,
/// until none is left. Where that ends after all rounds it is begun anew: orientations are then free all round by the
/// clearance where there is that room, and targets share their leans, as with two ways out neighbours may have taken
/// different ones. Between targets the change is as smooth as the net of S₂ lets it be.
///
/// Errors: SURF0310 no orientation within the limits is free at a place: place and depth are told; SURF0311 not free
/// after `most_rounds`; those of reoriented(), find_gouges(). Cost: two checks of all poses a round, and some 1-5 ms a
/// place that gouges, of which at most 400 a round are taken, the deepest first.
Result<GougeRemoval> remove_gouges(const GuidedTool& tool, int machined, const PartBody& part,
                                   std::span<const Pass> passes, const GougeRemovalOptions& options = {});

}  // namespace trunnion::surfacing
