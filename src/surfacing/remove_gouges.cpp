#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "trunnion/geometry/great_circle.hpp"
#include "trunnion/surfacing/gouge.hpp"

namespace trunnion::surfacing {

using Eigen::Vector3d;
using geometry::SurfacePlace;

/// The loop of remove_gouges(): targets of orientations grow until no pose gouges.
class GougeRemover {
  public:
    GougeRemover(const GuidedTool& tool, int machined, const PartBody& part, const GougeRemovalOptions& options)
        : tool_(tool), machined_(machined), part_(part), options_(options) {}

    Result<GougeRemoval> run(std::span<const Pass> passes) {
        OrientationSurface orientation = tool_.orientation;
        std::optional<GougeReport> before;
        for (int round = 0; round <= options_.most_rounds; ++round) {
            const GuidedTool tool{tool_.face, tool_.cutter, orientation};
            auto laid = reoriented(tool, passes, options_.path);
            if (!laid) return fail(std::move(laid.error()));
            auto report = find_gouges(tool_.face, machined_, tool_.cutter, part_, *laid, options_.gouge);
            if (!report) return fail(std::move(report.error()));
            if (!before) before = *report;
            const auto beyond = orientation.beyond_limits();
            if (report->gouges.empty() && beyond.empty())
                return finished(std::move(orientation), std::move(*laid), std::move(*before), std::move(*report),
                                round);
            last_ = *report;
            last_beyond_ =
                beyond.empty() ? "" : orientation.check(beyond.front().place, beyond.front().axis).error().value;
            reach_beyond_ = options_.clearance_rad * (1 + round);  // what was not enough the last time
            if (auto found = add_targets(*laid, *report, beyond, tool); !found) return fail(std::move(found.error()));
            auto deformed = tool_.orientation.moved_towards(targets_, options_.hold);
            if (!deformed) return fail(std::move(deformed.error()));
            orientation = std::move(*deformed);
        }
        return fail(not_free());
    }

  private:
    Result<void> add_targets(std::span<const Pass> passes, const GougeReport& report,
                             const std::vector<OrientationTarget>& beyond, const GuidedTool& tool) {
        for (const OrientationTarget& place : beyond)
            put({place.place, tool_.orientation.nearest_allowed(place.place, place.axis, reach_beyond_)});
        auto deepest_first = report.gouges;
        std::ranges::stable_sort(deepest_first, std::ranges::greater{}, &Gouge::depth_mm);
        std::vector<Vector3d> taken;
        const double apart = 0.25 * spacing();
        constexpr std::size_t most = 400;
        for (const Gouge& gouge : deepest_first) {
            const Vector3d at = tool_.face.surface.at(gouge.place.u, gouge.place.v);
            const bool near = std::ranges::any_of(taken, [&](const Vector3d& p) { return (p - at).norm() < apart; });
            if (near || taken.size() >= most) continue;
            taken.push_back(at);
            const auto& contacts = passes[gouge.pass].contacts;
            const std::size_t next = gouge.contact + 1 < contacts.size() ? gouge.contact + 1 : gouge.contact - 1;
            const double sign = next > gouge.contact ? 1 : -1;
            const Vector3d along = sign * (contacts[next].point_mm - contacts[gouge.contact].point_mm);
            const auto axis = free_axis(gouge, along, tool);
            if (!axis) return fail(none_free(gouge, at));
            put({gouge.place, *axis});
        }
        return {};
    }

    double spacing() const {
        const auto& surface = tool_.orientation.surface();
        const auto size =
            (surface.at(surface.u().end(), surface.v().end()) - surface.at(surface.u().begin(), surface.v().begin()))
                .norm();
        return size / std::sqrt(2.0 * static_cast<double>(surface.control_points_mm().size()));
    }

    /// Contacts on a border may lie off it by rounding.
    SurfacePlace on_surface(const SurfacePlace& place) const {
        const auto& surface = tool_.orientation.surface();
        return {std::clamp(place.u, surface.u().begin(), surface.u().end()),
                std::clamp(place.v, surface.v().begin(), surface.v().end())};
    }

    /// Replaces a target that is at nearly the same place.
    void put(OrientationTarget target) {
        target.place = on_surface(target.place);
        const auto at = [&](const SurfacePlace& place) { return tool_.face.surface.at(place.u, place.v); };
        const Vector3d here = at(target.place);
        const double same = 0.1 * spacing();
        std::erase_if(targets_, [&](const auto& other) { return (at(other.place) - here).norm() < same; });
        targets_.push_back(target);
    }

    /// Whether the tool may stand at a place with an orientation and is in nothing there.
    bool is_free(const SurfacePlace& place, const Vector3d& along, const Vector3d& axis) const {
        if (!tool_.orientation.check(place, axis)) return false;
        const auto shape = shape_at(tool_.face.surface, place, tool_.face.side);
        const Cutter& cutter = tool_.cutter;
        CutterPose pose = cutter.touching(shape->point, shape->normal, axis);
        if (Cutter::upright(shape->normal, axis)) pose.tip_mm -= cutter.flat_radius_mm() * along.normalized();
        return !part_.is_deeper(cutter, pose, options_.gouge.tolerance_mm, options_.gouge.holder);
    }

    /// The free orientation nearest to one, and a little beyond it where that is free too.
    std::optional<Vector3d> free_axis(const Gouge& gouge, const Vector3d& along, const GuidedTool& tool) const {
        const Vector3d from = tool.orientation.nearest_allowed(gouge.place, gouge.axis);
        const Vector3d e1 = from.unitOrthogonal(), e2 = from.cross(e1);
        constexpr double ring = std::numbers::pi / 180, farthest = std::numbers::pi / 2;
        constexpr int directions = 24;
        const auto turned = [&](int direction, double angle) -> Vector3d {
            const double phi = 2 * std::numbers::pi * direction / directions;
            return std::cos(angle) * from + std::sin(angle) * (std::cos(phi) * e1 + std::sin(phi) * e2);
        };
        if (is_free(gouge.place, along, from)) return from;
        for (double angle = ring; angle < farthest; angle += ring) {
            double least = angle;
            int best = -1;
            for (int k = 0; k < directions; ++k) {
                if (!is_free(gouge.place, along, turned(k, least))) continue;
                double held = angle - ring, free = least;
                while (free - held > 0.1 * ring) {
                    const double middle = 0.5 * (held + free);
                    (is_free(gouge.place, along, turned(k, middle)) ? free : held) = middle;
                }
                least = free;
                best = k;
            }
            if (best < 0) continue;
            const Vector3d beyond = turned(best, least + reach_beyond_);
            return is_free(gouge.place, along, beyond) ? beyond : turned(best, least);
        }
        return std::nullopt;
    }

    Result<GougeRemoval> finished(OrientationSurface orientation, std::vector<Pass> passes, GougeReport before,
                                  GougeReport after, int rounds) const {
        GougeRemoval out{.orientation = std::move(orientation),
                         .passes = std::move(passes),
                         .before = std::move(before),
                         .after = std::move(after),
                         .rounds = rounds,
                         .targets = targets_.size()};
        for (const Pass& pass : out.passes)
            for (std::size_t k = 0; k < pass.contacts.size(); ++k) {
                const Contact& at = pass.contacts[k];
                const double turn = geometry::angle_between(at.pose.axis, tool_.orientation.axis(at.place));
                out.largest_turn_rad = std::max(out.largest_turn_rad, turn);
                if (k == 0) continue;
                const double step = geometry::angle_between(at.pose.axis, pass.contacts[k - 1].pose.axis);
                out.largest_step_rad = std::max(out.largest_step_rad, step);
            }
        return out;
    }

    static Diagnostic none_free(const Gouge& gouge, const Vector3d& at) {
        return {.code = "SURF0310",
                .text = fmt::format("no orientation within the limits is free of gouges at ({:.3f} {:.3f} {:.3f})",
                                    at.x(), at.y(), at.z()),
                .value = fmt::format("depth {:.4g} mm as it is", gouge.depth_mm),
                .hint = "a smaller or longer tool, or wider limits"};
    }

    Diagnostic not_free() const {
        Diagnostic out{.code = "SURF0311",
                       .text = "the orientation surface was not free of gouges and within its limits after all rounds",
                       .limit = fmt::format("{} rounds", options_.most_rounds),
                       .hint = "finer patches of the orientation surface, or wider limits"};
        out.value = last_beyond_;
        if (const Gouge* worst = last_.worst())
            out.value = fmt::format("depth {:.4g} mm at ({:.3f} {:.3f} {:.3f})", worst->depth_mm, worst->at_mm.x(),
                                    worst->at_mm.y(), worst->at_mm.z());
        return out;
    }

    const GuidedTool& tool_;
    int machined_;
    const PartBody& part_;
    const GougeRemovalOptions& options_;
    std::vector<OrientationTarget> targets_;
    GougeReport last_;
    std::string last_beyond_;
    double reach_beyond_ = 0;
};

Result<GougeRemoval> remove_gouges(const GuidedTool& tool, int machined, const PartBody& part,
                                   std::span<const Pass> passes, const GougeRemovalOptions& options) {
    return GougeRemover(tool, machined, part, options).run(passes);
}

}  // namespace trunnion::surfacing
