#pragma once

#include <optional>
#include <span>
#include <vector>

#include "trunnion/surfacing/freed_plan.hpp"

#include "detail/surface_program.hpp"

namespace trunnion::surfacing::detail {

/// No point of the tool moves farther between two poses that are looked at: half its radius at the most, so that it
/// gets through no sheet unseen.
double look_mm(const Cutter& cutter);

/// Into how many parts a move is divided for that.
int looks_between(const CutterPose& from, const CutterPose& to, const Cutter& cutter, const Holder& holder);

/// Looks for ways from pass to pass on which the tool is nowhere in the part; the options and the part must outlive it.
class LinkSearch {
  public:
    LinkSearch(const Cutter& cutter, const PartBody& part, const SurfaceOptions& options, double tolerance_mm,
               const Holder& holder)
        : cutter_(cutter), part_(part), options_(options), tolerance_mm_(tolerance_mm), holder_(holder) {}

    /// Over a height up the tool axis: as the options say, the retract height, and that doubled up to 5 times; between
    /// passes the lift height where none of these is free. `before` or `next` may be null. Errors: SURF0314.
    Result<Link> link(const Pass* before, const Pass* next) const;

    /// That, or else round the part. Nothing where neither is free.
    std::optional<Link> any_link(const Pass* before, const Pass* next) const;

    /// Whether the tool can be pulled up its axis, by the retract height.
    bool leaves(const CutterPose& pose) const;

  private:
    bool leave(const Pass* before, const Pass* next) const;
    std::optional<Penetration> in_part(const Pass* before, const Pass* next, double height_mm) const;
    std::optional<Penetration> on_way(std::span<const CutterPose> way) const;
    std::optional<Penetration> on_straight(const CutterPose& from, const CutterPose& to) const;
    CutterPose out_of(const CutterPose& pose, double radius_mm) const;
    Diagnostic none_free(const Penetration& in, double height_mm) const;

    const Cutter& cutter_;
    const PartBody& part_;
    const SurfaceOptions& options_;
    double tolerance_mm_;
    Holder holder_;
};

/// The way to each pass on which the tool is nowhere in the part, and the way up from the last one: one more than
/// passes. Errors: SURF0314.
Result<std::vector<Link>> free_links(std::span<const Pass> passes, const Cutter& cutter, const PartBody& part,
                                     const SurfaceOptions& options, const FreeingOptions& freeing);

/// The same, round the part too; as the options say where none is free.
std::vector<Link> links_where_free(std::span<const Pass> passes, const LinkSearch& search);

}  // namespace trunnion::surfacing::detail
