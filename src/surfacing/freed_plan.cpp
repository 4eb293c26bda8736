#include "trunnion/surfacing/freed_plan.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "trunnion/geometry/great_circle.hpp"

#include "detail/free_links.hpp"
#include "detail/passes.hpp"
#include "detail/surface_program.hpp"
#include "detail/sweep.hpp"

namespace trunnion::surfacing {

using Eigen::Vector3d;

namespace {

/// Of the tolerance, for the guiding surface: what it is off, the tool may cut.
constexpr double guiding_share = 0.1;
constexpr double patch_mm = 5;  ///< of the orientation surface: how fine it can be deformed

/// Passes that one orientation surface serves.
struct Group {
    int face;
    bool along_border;
    int quarter;  ///< turns about the normal from the face's feed to that of the passes
    auto operator<=>(const Group&) const = default;
};

/// Of passes that are led by a lean, seen from the face's feed.
Lean seen_from_feed(const Lean& lean, const Group& group) {
    switch (group.quarter) {
        case 1:
            return {-lean.tilt_rad, lean.lead_rad};
        case 2:  // passes to and fro tilt the same way
            return {-lean.lead_rad, group.along_border ? -lean.tilt_rad : lean.tilt_rad};
        case 3:
            return {lean.tilt_rad, -lean.lead_rad};
        default:
            return lean;
    }
}

OrientationLimits seen_from_feed(const OrientationLimits& limits, const Group& group) {
    OrientationLimits out = limits;
    if (group.quarter == 2) {
        out.least_lead_rad = -limits.most_lead_rad;
        out.most_lead_rad = -limits.least_lead_rad;
    } else if (group.quarter != 0) {
        out.least_lead_rad = -limits.most_tilt_rad;
        out.most_lead_rad = limits.most_tilt_rad;
        out.most_tilt_rad = std::max(std::abs(limits.least_lead_rad), std::abs(limits.most_lead_rad));
    }
    return out;
}

FeedReference feed_of(const Face& face, const SurfaceOptions& options) {
    if (options.strategy == Strategy::along_v) return {.along = FeedReference::Along::v};
    if (options.strategy == Strategy::along_u || options.strategy == Strategy::lin_koren) return {};
    const ParameterBox box = parameter_box(face);
    const Eigen::Vector2d middle = 0.5 * (box.low + box.high);
    const auto shape = shape_at(face.surface, {middle.x(), middle.y()}, face.side);
    if (!shape) return {};
    return {.along = FeedReference::Along::direction, .direction = detail::feed_in_middle(options, *shape)};
}

/// Of the contacts of a pass, which stay among those of the pass as it is laid anew, in their order.
double largest_turn_rad(const Pass& planned, const Pass& laid) {
    double largest = 0;
    auto now = laid.contacts.begin();
    for (const Contact& was : planned.contacts) {
        now = std::find_if(now, laid.contacts.end(),
                           [&](const Contact& at) { return at.place.u == was.place.u && at.place.v == was.place.v; });
        if (now == laid.contacts.end()) break;
        largest = std::max(largest, geometry::angle_between(was.pose.axis, now->pose.axis));
    }
    return largest;
}

/// The cutter with more of its shank: where that is free, the tool can be pulled up its axis.
Cutter longer(const Cutter& cutter, double by_mm) {
    const machine::Tool tool{.kind = cutter.is_ball()         ? machine::ToolKind::ball
                                     : cutter.corner_mm() > 0 ? machine::ToolKind::torus
                                                              : machine::ToolKind::flat,
                             .diameter_mm = 2 * cutter.radius_mm(),
                             .corner_radius_mm = cutter.corner_mm()};
    return *Cutter::make(tool, cutter.reach_mm() + by_mm);
}

class Freeing {
  public:
    Freeing(SurfacePlan plan, std::span<const Face> faces, const Cutter& cutter, const PartBody& part,
            const SurfaceOptions& options, const FreeingOptions& freeing, const Cutter& body)
        : faces_(faces), cutter_(cutter), body_(body), part_(part), options_(options), freeing_(freeing) {
        out_.plan = std::move(plan);
        for (const Face& face : faces) feeds_.push_back(feed_of(face, options));
    }

    Result<FreedPlan> run() {
        std::map<Group, std::vector<std::size_t>> groups;
        for (std::size_t k = 0; k < passes().size(); ++k) groups[group_of(passes()[k])].push_back(k);
        for (const auto& [group, members] : groups)
            if (auto freed = free_group(group, members); !freed) return fail(std::move(freed.error()));
        const auto links = detail::free_links(passes(), cutter_, part_, options_, freeing_);
        if (!links) return fail(links.error());
        for (const detail::Link& link : *links) {
            if (link.height_mm > 0) ++out_.links_raised;
            out_.highest_link_mm = std::max(out_.highest_link_mm, link.height_mm);
        }
        detail::write_program(out_.plan, options_, *links);
        return std::move(out_);
    }

  private:
    std::vector<Pass>& passes() { return out_.plan.passes; }

    Group group_of(const Pass& pass) const {
        const Contact& first = pass.contacts.front();
        const auto number = static_cast<std::size_t>(first.face);
        const bool along_border = pass.index < 0;
        const auto shape = shape_at(faces_[number].surface, first.place, faces_[number].side);
        const auto feed = shape ? feeds_[number].at(*shape) : std::nullopt;
        if (!feed) return {first.face, along_border, 0};
        const Vector3d way = pass.contacts.back().point_mm - first.point_mm;
        const double ahead = way.dot(*feed), aside = way.dot(shape->normal.cross(*feed));
        if (along_border && std::abs(aside) > std::abs(ahead)) return {first.face, true, aside > 0 ? 1 : 3};
        return {first.face, along_border, ahead < 0 ? 2 : 0};
    }

    GougeOptions gouge_options() const { return {.tolerance_mm = freeing_.tolerance_mm, .holder = freeing_.holder}; }

    Result<void> free_group(const Group& group, const std::vector<std::size_t>& members) {
        std::vector<Pass> planned;
        for (const std::size_t k : members) planned.push_back(passes()[k]);
        const Face& face = faces_[static_cast<std::size_t>(group.face)];
        const auto found = find_gouges(face, group.face, body_, part_, planned, gouge_options());
        if (!found) return fail(found.error());
        out_.poses += found->poses;
        if (found->gouges.empty()) return {};
        account(*found);
        for (const Pass& pass : planned)
            if (std::ranges::any_of(pass.contacts, [&](const Contact& at) { return at.face != group.face; }))
                return fail(over_several_faces(*found->worst()));
        auto removed = deform(group, face, planned);
        if (!removed) return fail(std::move(removed.error()));
        const auto orientation = std::make_shared<const OrientationSurface>(std::move(removed->orientation));
        for (std::size_t k = 0; k < members.size(); ++k) {
            Pass& pass = passes()[members[k]];
            out_.largest_turn_rad = std::max(out_.largest_turn_rad, largest_turn_rad(pass, removed->passes[k]));
            pass = std::move(removed->passes[k]);
            pass.orientation = orientation;
            for (Contact& contact : pass.contacts) contact.face = group.face;
        }
        out_.passes_turned += members.size();
        return {};
    }

    Result<GougeRemoval> deform(const Group& group, const Face& face, const std::vector<Pass>& planned) {
        const auto guiding =
            GuidingSurface::make(face, cutter_, {.tolerance_mm = guiding_share * freeing_.tolerance_mm});
        if (!guiding) return fail(guiding.error());
        OrientationLimits limits = seen_from_feed(freeing_.limits, group);
        limits.feed = feeds_[static_cast<std::size_t>(group.face)];
        const Lean lean = seen_from_feed(Lean{options_.lead_rad, options_.tilt_rad}, group);
        const auto orientation = OrientationSurface::make(face, *guiding, lean, limits, {.spacing_mm = patch_mm});
        if (!orientation) return fail(orientation.error());
        auto removed = remove_gouges(
            {face, body_, *orientation}, group.face, part_, planned,
            {.gouge = gouge_options(),
             .path = {.chord_tolerance_mm = options_.chord_tolerance_mm, .longest_step_mm = options_.longest_step_mm}});
        if (!removed) return removed;
        out_.largest_step_rad = std::max(out_.largest_step_rad, removed->largest_step_rad);
        out_.rounds = std::max(out_.rounds, removed->rounds);
        return removed;
    }

    void account(const GougeReport& found) {
        for (const Gouge& gouge : found.gouges) ++out_.gouges[static_cast<std::size_t>(gouge.kind)];
        if (!out_.worst || found.worst()->depth_mm > out_.worst->depth_mm) out_.worst = *found.worst();
    }

    static Diagnostic over_several_faces(const Gouge& worst) {
        return {.code = "SURF0313",
                .text = fmt::format("passes that gouge at ({:.3f} {:.3f} {:.3f}) go on over several faces",
                                    worst.at_mm.x(), worst.at_mm.y(), worst.at_mm.z()),
                .value = fmt::format("depth {:.4g} mm", worst.depth_mm),
                .hint = "another strategy than parallel-planes, or one face at a time"};
    }

    std::span<const Face> faces_;
    const Cutter& cutter_;
    const Cutter& body_;  ///< that passes are freed of
    const PartBody& part_;
    const SurfaceOptions& options_;
    const FreeingOptions& freeing_;
    std::vector<FeedReference> feeds_;
    FreedPlan out_;
};

}  // namespace

Result<FreedPlan> free_of_gouges(SurfacePlan plan, std::span<const Face> faces, const Cutter& cutter,
                                 const PartBody& part, const SurfaceOptions& options, const FreeingOptions& freeing) {
    auto freed = Freeing(plan, faces, cutter, part, options, freeing, cutter).run();
    if (freed || freed.error().code != "SURF0314") return freed;
    const Cutter pulled_up = longer(cutter, options.retract_mm);
    return Freeing(std::move(plan), faces, cutter, part, options, freeing, pulled_up).run();
}

}  // namespace trunnion::surfacing
