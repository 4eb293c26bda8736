#include <algorithm>
#include <cmath>
#include <utility>

#include "trunnion/geometry/great_circle.hpp"
#include "trunnion/pipeline/surface.hpp"
#include "trunnion/surfacing/plan_region.hpp"

#include "detail/part_looks.hpp"

namespace trunnion::pipeline {

using surfacing::Cutter;
using surfacing::CutterPose;
using surfacing::Face;
using surfacing::Holder;
using surfacing::PartBody;
using surfacing::Penetration;

namespace {

constexpr double ridge_slack = 1.005;
constexpr double most_left = 0.5;   ///< of the area
constexpr double body_error = 1.1;  ///< of depths, in body tolerances

/// Keeps the deepest place of the tool in a part.
class Depths {
  public:
    Depths(const PartBody& body, const Cutter& cutter, const Holder& holder, double allowed_mm)
        : body_(body),
          cutter_(cutter),
          holder_(holder),
          arm_mm_(std::max(cutter.reach_mm(), holder.to_mm) + std::max(cutter.radius_mm(), holder.radius_mm)),
          allowed_mm_(allowed_mm + body_error * body.tolerance_mm()) {}

    void ask(const CutterPose& pose) {
        const double more_than_mm = deepest_ ? deepest_->depth_mm : allowed_mm_;
        if (auto found = body_.deepest(cutter_, pose, more_than_mm, holder_)) deepest_ = found;
    }

    /// Between the poses, and at the second of them.
    void ask_straight(const CutterPose& from, const CutterPose& to) {
        const geometry::GreatCircle turn(from.axis, to.axis);
        const double way_mm = (to.tip_mm - from.tip_mm).norm() + turn.angle_rad() * arm_mm_;
        const int steps = std::max(1, static_cast<int>(std::ceil(way_mm / check_step_mm(cutter_.radius_mm()))));
        for (int k = 1; k <= steps; ++k) {
            const double w = static_cast<double>(k) / steps;
            ask({(1 - w) * from.tip_mm + w * to.tip_mm, turn.at(w)});
        }
    }

    const std::optional<Penetration>& deepest() const { return deepest_; }

  private:
    const PartBody& body_;
    const Cutter& cutter_;
    const Holder& holder_;
    double arm_mm_, allowed_mm_;
    std::optional<Penetration> deepest_;
};

std::optional<Penetration> deepest_in_part(const PartBody& body, const Cutter& cutter, const Holder& holder,
                                           const SurfaceResult& made, double allowed_mm) {
    Depths depths(body, cutter, holder, allowed_mm);
    const auto& moves = made.plan.program.moves;
    for (std::size_t k = 0; k < moves.size(); ++k) {
        const CutterPose to{moves[k].position_mm, moves[k].axis};
        if (k == 0 || moves[k].curve_part != program::no_curve_part)
            depths.ask(to);
        else
            depths.ask_straight({moves[k - 1].position_mm, moves[k - 1].axis}, to);
    }
    if (made.splines)
        for (const auto& pass : made.plan.passes)
            for (const auto& contact : pass.contacts) depths.ask(contact.pose);
    return depths.deepest();
}

}  // namespace

Result<SurfacePartCheck> check_part(std::span<const Face> part, const Cutter& cutter, const SurfaceResult& made,
                                    double gouge_tolerance_mm, const Holder& holder) {
    const auto body = PartBody::make(part, part_tolerance_mm(gouge_tolerance_mm));
    if (!body) return fail(body.error());
    SurfacePartCheck out{.faces = part.size(),
                         .in_part = deepest_in_part(*body, cutter, holder, made, passing_depth_mm(gouge_tolerance_mm))};
    if (out.in_part) out.in_part_face = part[static_cast<std::size_t>(out.in_part->face)].number;
    return out;
}

Result<SurfaceCheck> check_surface_program(std::span<const Face> faces, std::span<const Face> part,
                                           const Cutter& cutter, const SurfaceResult& made,
                                           const surfacing::SurfaceOptions& allowed, const Holder& holder) {
    auto in_part = check_part(part, cutter, made, allowed.gouge_tolerance_mm, holder);
    if (!in_part) return fail(in_part.error());
    surfacing::SurfaceCheckOptions looking;
    looking.limit_mm = std::max({looking.limit_mm, 2 * allowed.scallop_mm, 2 * allowed.gouge_tolerance_mm});
    looking.grid_mm = std::max(looking.grid_mm, 0.1 * cutter.radius_mm());
    looking.ridge_spacing_mm = std::max(looking.ridge_spacing_mm, 0.2 * cutter.radius_mm());
    looking.left = made.plan.left;
    looking.left_above_mm = ridge_slack * allowed.scallop_mm;
    SurfaceCheck out{*in_part, surfacing::check_region(faces, cutter, made.plan.passes, looking)};
    const auto& verdict = out.verdict;
    const double highest_mm =
        allowed.borders ? std::max(verdict.highest_mm, verdict.largest_ridge_mm) : verdict.largest_ridge_mm;
    out.ridges_hold = highest_mm <= ridge_slack * allowed.scallop_mm;
    out.surface_holds = verdict.deepest_mm <= allowed.gouge_tolerance_mm;
    out.mostly_left = verdict.left_mm2 > most_left * verdict.area_mm2;
    return out;
}

}  // namespace trunnion::pipeline
