#include "trunnion/surfacing/plan_surface.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <iterator>
#include <limits>
#include <numbers>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "trunnion/surfacing/leave_out.hpp"
#include "trunnion/surfacing/part_body.hpp"
#include "trunnion/surfacing/plan_region.hpp"

#include "detail/border_strip.hpp"
#include "detail/join_passes.hpp"
#include "detail/joints.hpp"
#include "detail/passes.hpp"
#include "detail/plane_sections.hpp"
#include "detail/sweep.hpp"
#include "detail/turned_over.hpp"

namespace trunnion::surfacing {

namespace {

struct Bound {
    const char* name;
    double value, above, below;
};

Result<void> check_options(const SurfaceOptions& options, const Cutter& cutter) {
    constexpr double quarter_turn = std::numbers::pi / 2, infinite = 1e9;
    const Bound bounds[] = {
        {"scallop_mm", options.scallop_mm, 0, 0.5 * cutter.radius_mm()},
        {"chord_tolerance_mm", options.chord_tolerance_mm, 0, 0.5 * options.scallop_mm},
        {"gouge_tolerance_mm", options.gouge_tolerance_mm, 0, infinite},
        {"feed_angle_rad", options.feed_angle_rad, -8 * quarter_turn, 8 * quarter_turn},
        {"lead_rad", options.lead_rad, -quarter_turn, quarter_turn},
        {"tilt_rad", options.tilt_rad, -quarter_turn, quarter_turn},
        {"lift_mm", options.lift_mm, 0, infinite},
        {"retract_mm", options.retract_mm, options.lift_mm, infinite},
        {"longest_step_mm", options.longest_step_mm, 0, infinite},
        {"feed_mm_s", options.feed_mm_s, 0, infinite},
        {"approach_mm_s", options.approach_mm_s, 0, infinite},
    };
    for (const Bound& bound : bounds)
        if (!(bound.value > bound.above && bound.value < bound.below))
            return fail({.code = "SURF0202",
                         .text = fmt::format("{} is out of its range", bound.name),
                         .value = fmt::format("{}", bound.value),
                         .limit = fmt::format("above {:.6g}, below {:.6g}", bound.above, bound.below)});
    return {};
}

double length_mm(const Pass& pass) {
    double sum = 0;
    for (std::size_t i = 1; i < pass.contacts.size(); ++i)
        sum += (pass.contacts[i].point_mm - pass.contacts[i - 1].point_mm).norm();
    return sum;
}

/// Takes passes of a region together.
class RegionPlanner {
  public:
    RegionPlanner(std::span<const Face> faces, const Cutter& cutter, const SurfaceOptions& options)
        : faces_(faces), cutter_(cutter), options_(options) {
        for (std::size_t k = 0; k < faces.size(); ++k) regions_.emplace_back(faces[k], k);
        for (const detail::Region& region : regions_) jobs_.push_back({region, cutter, options});
        plan_.least_interval_mm = std::numeric_limits<double>::infinity();
    }

    Result<SurfacePlan> run() {
        for (std::size_t k = 0; k < faces_.size(); ++k)
            if (auto sided = detail::check_side(faces_[k]); !sided) return refused(k, std::move(sided.error()));
        auto laid = options_.strategy == Strategy::parallel_planes ? by_planes() : by_groups();
        if (!laid) return fail(std::move(laid.error()));
        if (options_.borders)
            if (auto done = along_borders(); !done) return fail(std::move(done.error()));
        if (plan_.passes.empty()) return fail({.code = "SURF0205", .text = "no pass crosses the face"});
        if (faces_.size() > 1 && !options_.leave_out)
            if (auto clear = check_region_body(); !clear) return fail(std::move(clear.error()));
        for (const Pass& pass : plan_.passes) plan_.cut_length_mm += length_mm(pass);
        if (options_.leave_out) return std::move(plan_);  // whose links are laid when parts of passes are cut away
        constexpr double part_tolerance_mm = 0.02;
        const auto part = PartBody::make(faces_, std::max(part_tolerance_mm, 0.5 * options_.gouge_tolerance_mm));
        if (!part) return fail(part.error());
        lead_links_clear(plan_, cutter_, *part, options_, {.tolerance_mm = 2 * part->tolerance_mm()});
        return std::move(plan_);
    }

  private:
    void account(double least_interval, double largest_interval, double highest_ridge) {
        plan_.least_interval_mm = std::min(plan_.least_interval_mm, least_interval);
        plan_.largest_interval_mm = std::max(plan_.largest_interval_mm, largest_interval);
        plan_.highest_ridge_mm = std::max(plan_.highest_ridge_mm, highest_ridge);
    }

    void tell_rule(const detail::Sweep& sweep) {
        if (sweep.rule_ridge_mm <= told_ridge_mm_) return;
        told_ridge_mm_ = sweep.rule_ridge_mm;
        const Eigen::Vector3d& at = sweep.rule_ridge_at_mm;
        plan_.program.diagnostics = {
            {.code = "SURF0212",
             .severity = Severity::warning,
             .text = fmt::format("passes by Lin and Koren's rule would leave higher ridges than asked for, most near "
                                 "({:.3f} {:.3f} {:.3f}); they are closer there",
                                 at.x(), at.y(), at.z()),
             .value = fmt::format("{:.4g} mm", told_ridge_mm_),
             .limit = fmt::format("{:.4g} mm", options_.scallop_mm)}};
    }

    std::unexpected<Diagnostic> refused(std::size_t face, Diagnostic refusal) const {
        if (faces_.size() > 1) refusal.text = fmt::format("face {}: {}", faces_[face].number, refusal.text);
        return fail(std::move(refusal));
    }

    /// What is laid over one region.
    struct Laid {
        detail::Sweep sweep;
        std::vector<Pass> passes;
        std::vector<LeftPlace> not_reached;
    };

    /// Faces that meet smoothly have passes in common. Where the march does not get all over them, each has its own.
    Result<void> by_groups() {
        const bool goes_on =
            options_.strategy == Strategy::constant_scallop && options_.across_joints && faces_.size() > 1;
        if (goes_on) groups_ = detail::smooth_groups(faces_);
        for (std::size_t k = 0; !goes_on && k < faces_.size(); ++k) groups_.push_back({.faces = {k}, .joints = {}});
        for (detail::SmoothGroup& group : groups_) {
            if (group.faces.size() > 1) {
                const detail::Region region(faces_, group);
                auto laid = lay({region, cutter_, options_});
                if (laid && laid->not_reached.empty()) {
                    take(std::move(*laid));
                    continue;
                }
                group.joints.clear();
            }
            for (const std::size_t k : group.faces) {
                auto laid = lay(jobs_[k]);
                if (!laid) return refused(k, std::move(laid.error()));
                take(std::move(*laid));
            }
        }
        return {};
    }

    Result<Laid> lay(const detail::Job& job) const {
        auto ways = detail::sweep(job);
        if (!ways) return fail(std::move(ways.error()));
        Laid out{.sweep = std::move(*ways), .passes = {}, .not_reached = {}};
        for (int chart = 0; chart < job.region.charts(); ++chart)
            if (auto covered = check_cover(job.region, chart, out); !covered) return fail(std::move(covered.error()));
        for (const auto& [way, index] : out.sweep.ways)
            if (auto done = detail::append_passes(job, way, index, out.passes); !done)
                return fail(std::move(done.error()));
        return out;
    }

    /// Indices follow those of what was laid before with a gap, so that no link joins the two.
    void take(Laid laid) {
        const detail::Sweep& sweep = laid.sweep;
        account(sweep.least_interval_mm, sweep.largest_interval_mm, sweep.highest_ridge_mm);
        tell_rule(sweep);
        plan_.left.insert(plan_.left.end(), sweep.too_high.begin(), sweep.too_high.end());
        std::ranges::move(laid.not_reached, std::back_inserter(plan_.left));
        const int shift = next_index_ - sweep.ways.front().index;
        for (Pass& pass : laid.passes) pass.index += shift;
        std::ranges::move(laid.passes, std::back_inserter(plan_.passes));
        next_index_ += static_cast<int>(sweep.ways.size()) + 1;
    }

    /// Whether the march got everywhere: it ends early where the surface turns away faster than passes can follow, or
    /// where the tool fits nowhere. With leave_out such places are left.
    Result<void> check_cover(const detail::Region& region, int chart, Laid& laid) const {
        const Face& face = region.face(chart);
        const ParameterBox& box = region.box(chart);
        const double farthest = 1.5 * std::max(laid.sweep.largest_interval_mm, 0.1 * cutter_.radius_mm());
        constexpr int grid = 24;
        const Eigen::Vector2d cell = (box.high - box.low) / grid;
        for (int i = 0; i < grid * grid; ++i) {
            const geometry::SurfacePlace place{box.low.x() + (i / grid + 0.5) * cell.x(),
                                               box.low.y() + (i % grid + 0.5) * cell.y()};
            if (!contains(face, place)) continue;
            const Eigen::Vector3d point = face.surface.at(place.u, place.v);
            double nearest = std::numeric_limits<double>::infinity();
            for (const detail::SweepWay& one : laid.sweep.ways) {
                nearest = std::min(nearest, one.way.distance_mm(point));
                if (nearest <= farthest) break;
            }
            if (nearest <= farthest) continue;
            if (!options_.leave_out) return fail(not_reached(point, farthest));
            const Eigen::Vector3d corner = face.surface.at(place.u + 0.5 * cell.x(), place.v + 0.5 * cell.y());
            laid.not_reached.push_back({.at_mm = point,
                                        .face = static_cast<int>(region.number(chart)),
                                        .reach_mm = nearest + (corner - point).norm()});
        }
        return {};
    }

    static Diagnostic not_reached(const Eigen::Vector3d& point, double farthest) {
        return {.code = "SURF0210",
                .text = fmt::format("passes do not get to ({:.3f} {:.3f} {:.3f})", point.x(), point.y(), point.z()),
                .limit = fmt::format("a pass within {:.4g} mm", farthest),
                .hint = "another strategy, or another direction of feed"};
    }

    /// Passes of one plane are joined where one ends and the next one begins.
    Result<void> by_planes() {
        auto sections = detail::plane_sections(jobs_);
        if (!sections) return fail(std::move(sections.error()));
        account(sections->least_interval_mm, sections->largest_interval_mm, sections->highest_ridge_mm);
        plan_.left = std::move(sections->too_high);
        if (sections->ways.empty()) return {};
        const int first = sections->ways.front().index;
        for (std::size_t begin = 0, end = 0; begin < sections->ways.size(); begin = end) {
            std::vector<Pass> row;
            for (; end < sections->ways.size() && sections->ways[end].index == sections->ways[begin].index; ++end) {
                const detail::SectionWay& one = sections->ways[end];
                if (auto done = detail::append_passes(jobs_[one.face], one.way, one.index, row); !done)
                    return refused(one.face, std::move(done.error()));
            }
            detail::join_passes(row);
            for (Pass& pass : row) pass.index -= first;
            std::ranges::move(row, std::back_inserter(plan_.passes));
        }
        return {};
    }

    Result<void> along_borders() {
        for (std::size_t k = 0; k < faces_.size(); ++k) {
            const bool goes_on = options_.strategy == Strategy::parallel_planes;
            std::vector<detail::Way> ends;  // borders where passes of this face end
            // A border that two faces share has its pass once, or none where passes go on over it.
            const auto wanted = [&](const detail::Way& way) {
                const bool shared = detail::is_shared(way, faces_.subspan(0, goes_on ? faces_.size() : k), faces_[k]);
                if (!(shared && goes_on)) ends.push_back(way);
                return !shared;
            };
            if (auto done = detail::append_border_passes(jobs_[k], joints_of(k), wanted, plan_.passes); !done)
                return refused(k, std::move(done.error()));
            if (auto done = detail::append_strip_passes(jobs_[k], static_cast<int>(k), ends, plan_.passes); !done)
                return refused(k, std::move(done.error()));
        }
        return {};
    }

    /// Where passes go on from a face to others.
    std::vector<const detail::Stretch*> joints_of(std::size_t face) const {
        std::vector<const detail::Stretch*> out;
        for (const detail::SmoothGroup& group : groups_)
            for (const detail::SmoothJoint& joint : group.joints) {
                if (group.faces[joint.first] == face) out.push_back(&joint.on_first);
                if (group.faces[joint.second] == face) out.push_back(&joint.on_second);
            }
        return out;
    }

    /// The tool on one face against all the others.
    Result<void> check_region_body() const {
        const double tolerance = std::max(0.5 * options_.gouge_tolerance_mm, 0.005);
        const auto body = PartBody::make(faces_, tolerance);
        if (!body) return fail(body.error());
        const double allowed = options_.gouge_tolerance_mm + 2 * tolerance;
        for (const Pass& pass : plan_.passes)
            for (const Contact& contact : pass.contacts)
                if (const auto in = body->deepest(cutter_, contact.pose, allowed)) {
                    const Eigen::Vector3d &at = contact.point_mm, &there = in->at_mm;
                    return refused(
                        static_cast<std::size_t>(contact.face),
                        {.code = "SURF0204",
                         .text = fmt::format("touching the surface at ({:.3f} {:.3f} {:.3f}) the tool cuts "
                                             "into face {} at ({:.3f} {:.3f} {:.3f})",
                                             at.x(), at.y(), at.z(), faces_[static_cast<std::size_t>(in->face)].number,
                                             there.x(), there.y(), there.z()),
                         .value = fmt::format("depth {:.4g} mm", in->depth_mm),
                         .limit = fmt::format("{:.4g} mm", allowed),
                         .hint = "a smaller tool, or one face less"});
                }
        return {};
    }

    std::span<const Face> faces_;
    const Cutter& cutter_;
    const SurfaceOptions& options_;
    std::deque<detail::Region> regions_;  ///< one a face
    std::vector<detail::Job> jobs_;       ///< one a face
    std::vector<detail::SmoothGroup> groups_;
    int next_index_ = 0;
    double told_ridge_mm_ = 0;
    SurfacePlan plan_;
};

}  // namespace

Result<SurfacePlan> plan_surface(const Face& face, const Cutter& cutter, const SurfaceOptions& options) {
    return plan_region({&face, 1}, cutter, options);
}

Result<SurfacePlan> plan_region(std::span<const Face> faces, const Cutter& cutter, const SurfaceOptions& options) {
    if (faces.empty()) return fail({.code = "SURF0207", .text = "a region without faces"});
    if (auto sound = check_options(options, cutter); !sound) return fail(std::move(sound.error()));
    return RegionPlanner(faces, cutter, options).run();
}

}  // namespace trunnion::surfacing
