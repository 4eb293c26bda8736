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
    /// `agreeing`: targets have room round them and share their leans; else each takes what is nearest for itself.
    GougeRemover(const GuidedTool& tool, int machined, const PartBody& part, const GougeRemovalOptions& options,
                 bool agreeing)
        : tool_(tool), machined_(machined), part_(part), options_(options), agreeing_(agreeing) {}

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
            if (agreeing_) agree();
            auto deformed = tool_.orientation.moved_towards(wanted(), options_.hold);
            if (!deformed) return fail(std::move(deformed.error()));
            orientation = std::move(*deformed);
        }
        return fail(not_free());
    }

  private:
    struct Target {
        OrientationTarget wanted;
        Vector3d along;    ///< the motion there; 0: it is the limits that want it
        double least_rad;  ///< turned from how the tool stood, for itself alone
    };

    std::vector<OrientationTarget> wanted() const {
        std::vector<OrientationTarget> out;
        for (const Target& target : targets_) out.push_back(target.wanted);
        return out;
    }

    Result<void> add_targets(std::span<const Pass> passes, const GougeReport& report,
                             const std::vector<OrientationTarget>& beyond, const GuidedTool& tool) {
        for (const OrientationTarget& place : beyond)
            put({{place.place, tool_.orientation.nearest_allowed(place.place, place.axis, reach_beyond_)},
                 Vector3d::Zero(),
                 0});
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
            put({{gouge.place, *axis}, along, turn_from_start(gouge.place, *axis)});
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
    void put(Target target) {
        target.wanted.place = on_surface(target.wanted.place);
        const auto at = [&](const SurfacePlace& place) { return tool_.face.surface.at(place.u, place.v); };
        const Vector3d here = at(target.wanted.place);
        const double same = 0.1 * spacing();
        std::erase_if(targets_, [&](const Target& other) { return (at(other.wanted.place) - here).norm() < same; });
        targets_.push_back(target);
    }

    double turn_from_start(const SurfacePlace& place, const Vector3d& axis) const {
        return geometry::angle_between(axis, tool_.orientation.axis(on_surface(place)));
    }

    /// What of an axis is the same at other places: how it leans.
    std::optional<Lean> lean_at(const SurfacePlace& place, const Vector3d& axis) const {
        const auto shape = shape_at(tool_.face.surface, place, tool_.face.side);
        const auto feed = shape ? tool_.orientation.limits().feed.at(*shape) : std::nullopt;
        return feed ? lean_of(axis, *shape, *feed) : std::nullopt;
    }
    std::optional<Vector3d> leaning(const SurfacePlace& place, const Lean& lean) const {
        const auto shape = shape_at(tool_.face.surface, place, tool_.face.side);
        const auto feed = shape ? tool_.orientation.limits().feed.at(*shape) : std::nullopt;
        return feed ? std::optional(axis_of(lean, *shape, *feed)) : std::nullopt;
    }

    /// The leans that targets ask for, those apart from each other.
    std::vector<Lean> leans() const {
        constexpr double apart_rad = std::numbers::pi / 180;
        constexpr std::size_t most = 100;
        std::vector<Lean> out;
        for (const Target& target : targets_) {
            const auto lean = lean_at(target.wanted.place, target.wanted.axis);
            const auto near = [&](const Lean& other) {
                return std::hypot(other.lead_rad - lean->lead_rad, other.tilt_rad - lean->tilt_rad) < apart_rad;
            };
            if (lean && out.size() < most && std::ranges::none_of(out, near)) out.push_back(*lean);
        }
        return out;
    }

    /// The axis of a lean at a target, where it is free with room and not much farther than what the target wants.
    std::optional<Vector3d> serving(const Target& target, const Lean& lean) const {
        constexpr double farther = 1.5, slack_rad = std::numbers::pi / 90;
        const auto axis = leaning(target.wanted.place, lean);
        if (!axis || target.along.isZero()) return std::nullopt;
        if (turn_from_start(target.wanted.place, *axis) > farther * target.least_rad + slack_rad) return std::nullopt;
        if (!is_free(target.wanted.place, target.along, *axis)) return std::nullopt;
        if (!is_roomy(target.wanted.place, target.along, *axis, options_.clearance_rad)) return std::nullopt;
        return axis;
    }

    /// Where there are two ways out neighbours may have taken different ones, and between them the surface gouges: as
    /// few leans for all targets as serve them, the one that serves most of them first.
    void agree() {
        const std::vector<Lean> all = leans();
        std::vector<std::vector<std::optional<Vector3d>>> axes;  // by lean and target
        for (const Lean& lean : all) {
            axes.emplace_back();
            for (const Target& target : targets_) axes.back().push_back(serving(target, lean));
        }
        const auto serves = [](const auto& served) { return std::ranges::count_if(served, &has); };
        while (true) {
            const auto most = std::ranges::max_element(axes, {}, serves);
            if (most == axes.end() || serves(*most) < 2) return;
            const auto served = *most;
            for (std::size_t k = 0; k < targets_.size(); ++k) {
                if (!served[k]) continue;
                targets_[k].wanted.axis = *served[k];
                for (auto& other : axes) other[k].reset();
            }
        }
    }
    static bool has(const std::optional<Vector3d>& axis) { return axis.has_value(); }

    /// Whether the tool may stand at a place with an orientation and is in nothing there.
    bool is_free(const SurfacePlace& place, const Vector3d& along, const Vector3d& axis) const {
        if (!tool_.orientation.check(place, axis)) return false;
        const auto shape = shape_at(tool_.face.surface, place, tool_.face.side);
        const Cutter& cutter = tool_.cutter;
        CutterPose pose = cutter.touching(shape->point, shape->normal, axis);
        if (Cutter::upright(shape->normal, axis)) pose.tip_mm -= cutter.flat_radius_mm() * along.normalized();
        return !part_.is_deeper(cutter, pose, options_.gouge.tolerance_mm, options_.gouge.holder);
    }

    /// Whether orientations all round one are free too. A corner between two walls is free at its tip, and no surface
    /// keeps to that.
    bool is_roomy(const SurfacePlace& place, const Vector3d& along, const Vector3d& axis, double room) const {
        constexpr int directions = 6;
        for (int k = 0; k < directions && room > 0; ++k)
            if (!is_free(place, along, turned(axis, 2 * std::numbers::pi * k / directions, room))) return false;
        return true;
    }

    static Vector3d turned(const Vector3d& from, double direction, double angle) {
        const Vector3d e1 = from.unitOrthogonal(), e2 = from.cross(e1);
        return std::cos(angle) * from + std::sin(angle) * (std::cos(direction) * e1 + std::sin(direction) * e2);
    }

    /// The orientation nearest to one that is free, and a little beyond it where that is free too; or, agreeing, with
    /// as much room round it as there is up to what is wanted.
    std::optional<Vector3d> free_axis(const Gouge& gouge, const Vector3d& along, const GuidedTool& tool) const {
        const Vector3d from = tool.orientation.nearest_allowed(gouge.place, gouge.axis);
        if (!agreeing_) {
            const auto nearest = nearest_axis(gouge.place, along, from, 0);
            if (!nearest || *nearest == from) return nearest;
            const Vector3d beyond = farther(from, *nearest, reach_beyond_);
            return is_free(gouge.place, along, beyond) ? beyond : nearest;
        }
        constexpr double least_share = 0.2;
        for (double room = reach_beyond_; room > least_share * options_.clearance_rad; room *= 0.5)
            if (auto axis = nearest_axis(gouge.place, along, from, room)) return axis;
        return nearest_axis(gouge.place, along, from, 0);
    }

    static Vector3d farther(const Vector3d& from, const Vector3d& to, double by) {
        const Vector3d aside = (to - to.dot(from) * from).normalized();
        const double angle = geometry::angle_between(from, to) + by;
        return std::cos(angle) * from + std::sin(angle) * aside;
    }

    std::optional<Vector3d> nearest_axis(const SurfacePlace& place, const Vector3d& along, const Vector3d& from,
                                         double room) const {
        constexpr double ring = std::numbers::pi / 180, farthest = std::numbers::pi / 2;
        constexpr int directions = 24;
        const auto serves = [&](const Vector3d& axis) {
            return is_free(place, along, axis) && is_roomy(place, along, axis, room);
        };
        if (serves(from)) return from;
        for (double angle = ring; angle < farthest; angle += ring) {
            double least = angle;
            std::optional<Vector3d> best;
            for (int k = 0; k < directions; ++k) {
                const double direction = 2 * std::numbers::pi * k / directions;
                if (!serves(turned(from, direction, least))) continue;
                double held = angle - ring, free = least;
                while (free - held > 0.1 * ring) {
                    const double middle = 0.5 * (held + free);
                    (serves(turned(from, direction, middle)) ? free : held) = middle;
                }
                least = free;
                best = turned(from, direction, least);
            }
            if (best) return best;
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
    std::vector<Target> targets_;
    GougeReport last_;
    std::string last_beyond_;
    double reach_beyond_ = 0;
    bool agreeing_;
};

Result<GougeRemoval> remove_gouges(const GuidedTool& tool, int machined, const PartBody& part,
                                   std::span<const Pass> passes, const GougeRemovalOptions& options) {
    auto removed = GougeRemover(tool, machined, part, options, false).run(passes);
    if (removed || removed.error().code != "SURF0311") return removed;
    return GougeRemover(tool, machined, part, options, true).run(passes);
}

}  // namespace trunnion::surfacing
