#include "trunnion/surfacing/leave_out.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "trunnion/geometry/great_circle.hpp"

#include "detail/free_links.hpp"
#include "detail/left_reach.hpp"
#include "detail/surface_program.hpp"

namespace trunnion::surfacing {

namespace {

constexpr double cut_to_mm = 0.01;  ///< ends of what stays, along the pass

/// Divides passes into what stays and what does not.
class PassCutter {
  public:
    PassCutter(std::span<const Face> faces, const Cutter& cutter, const PartBody& part, const LeavingOptions& leaving,
               const detail::LeftReach& reach, ReachedPlan& out)
        : faces_(faces), cutter_(cutter), part_(part), leaving_(leaving), reach_(reach), out_(out) {}

    std::vector<Pass> parts_of(const Pass& pass) {
        parts_.clear();
        current_ = {.contacts = {}, .index = pass.index};
        bool free = is_free(pass.contacts.front().pose);
        if (free) current_.contacts.push_back(pass.contacts.front());
        for (std::size_t k = 1; k < pass.contacts.size(); ++k) free = go(pass.contacts[k - 1], pass.contacts[k], free);
        finish();
        return std::move(parts_);
    }

    /// Notes that the way between two contacts is left out, from one share of it to another.
    void leave(const Contact& from, const Contact& to, int index, double begin = 0, double end = 1) {
        const double way = (to.point_mm - from.point_mm).norm() * (end - begin);
        out_.left_way_mm += way;
        const double look_mm = detail::look_mm(cutter_);
        const int parts = std::max(1, static_cast<int>(std::ceil(way / look_mm)));
        const double reach_mm = reach_.between_mm(from, to, index) + 0.5 * look_mm;
        for (int i = 0; i <= parts; ++i) {
            const double w = begin + (end - begin) * i / parts;
            out_.plan.left.push_back({(1 - w) * from.point_mm + w * to.point_mm, from.face, reach_mm});
        }
    }

  private:
    bool is_free(const CutterPose& pose) {
        if (!part_.is_deeper(cutter_, pose, leaving_.tolerance_mm, leaving_.holder)) return true;
        const double known_mm = std::max(leaving_.tolerance_mm, out_.deepest_mm);
        if (const auto in = part_.deepest(cutter_, pose, known_mm, leaving_.holder)) out_.deepest_mm = in->depth_mm;
        return false;
    }

    static CutterPose between(const Contact& from, const Contact& to, double w) {
        return {(1 - w) * from.pose.tip_mm + w * to.pose.tip_mm, geometry::slerp(from.pose.axis, to.pose.axis, w)};
    }

    /// One move; returns whether its end is free.
    bool go(const Contact& from, const Contact& to, bool begins_free) {
        const int parts = detail::looks_between(from.pose, to.pose, cutter_, leaving_.holder);
        double changed = 0;
        bool free = begins_free;
        for (int i = 1; i <= parts; ++i) {
            const double w = static_cast<double>(i) / parts;
            const bool here = is_free(i == parts ? to.pose : between(from, to, w));
            if (here != free) {
                const double at = border(from, to, w - 1.0 / parts, w, here);
                if (!here) {
                    stay_until(from, to, at);
                } else {
                    leave(from, to, current_.index, changed, at);
                    current_.contacts.push_back(contact_between(from, to, at));
                }
                changed = at;
            }
            free = here;
        }
        if (free)
            current_.contacts.push_back(to);
        else
            leave(from, to, current_.index, changed, 1);
        return free;
    }

    void stay_until(const Contact& from, const Contact& to, double at) {
        current_.contacts.push_back(contact_between(from, to, at));
        finish();
    }

    void finish() {
        // Too short to be worth an approach.
        const double least_mm = 0.02 * cutter_.radius_mm();
        double way = 0;
        for (std::size_t k = 1; k < current_.contacts.size(); ++k)
            way += (current_.contacts[k].point_mm - current_.contacts[k - 1].point_mm).norm();
        if (way >= least_mm)
            parts_.push_back(current_);
        else
            for (std::size_t k = 1; k < current_.contacts.size(); ++k)
                leave(current_.contacts[k - 1], current_.contacts[k], current_.index);
        current_.contacts.clear();
    }

    /// The free side of where a move enters the part, or leaves it.
    double border(const Contact& from, const Contact& to, double low, double high, bool leaves) {
        const double length = std::max((to.point_mm - from.point_mm).norm(), cut_to_mm);
        while ((high - low) * length > cut_to_mm) {
            const double middle = 0.5 * (low + high);
            (is_free(between(from, to, middle)) == leaves ? high : low) = middle;
        }
        return leaves ? high : low;
    }

    Contact contact_between(const Contact& from, const Contact& to, double w) const {
        Contact out = w < 0.5 ? from : to;
        out.pose = between(from, to, w);
        if (from.face != to.face) return out;
        const Face& face = faces_[static_cast<std::size_t>(from.face)];
        out.place = {std::lerp(from.place.u, to.place.u, w), std::lerp(from.place.v, to.place.v, w)};
        if (const auto shape = shape_at(face.surface, out.place, face.side)) {
            out.point_mm = shape->point;
            out.normal = shape->normal;
        }
        return out;
    }

    std::span<const Face> faces_;
    const Cutter& cutter_;
    const PartBody& part_;
    const LeavingOptions& leaving_;
    const detail::LeftReach& reach_;
    ReachedPlan& out_;
    std::vector<Pass> parts_;
    Pass current_;
};

/// Puts passes one behind the other with free links; what cannot be got to is left out.
class Chain {
  public:
    Chain(PassCutter& cutting, const detail::LinkSearch& search) : cutting_(cutting), search_(search) {}

    void add(Pass next) {
        while (true) {
            const Pass* before = passes_.empty() ? nullptr : &passes_.back();
            if (auto link = search_.any_link(before, &next)) {
                passes_.push_back(std::move(next));
                links_.push_back(std::move(*link));
                return;
            }
            if (!search_.leaves(next.contacts.front().pose)) {
                if (!trim(next, true)) return;
            } else if (before && !search_.leaves(before->contacts.back().pose)) {
                if (!trim(passes_.back(), false)) drop_last();
            } else {
                return drop(next);
            }
        }
    }

    /// The way up from the last pass.
    void finish() {
        while (!passes_.empty()) {
            if (auto link = search_.any_link(&passes_.back(), nullptr)) return links_.push_back(std::move(*link));
            if (search_.leaves(passes_.back().contacts.back().pose) || !trim(passes_.back(), false)) drop_last();
        }
    }

    std::vector<Pass>& passes() { return passes_; }
    const std::vector<detail::Link>& links() const { return links_; }

  private:
    /// Cuts a pass back to where the tool can be pulled up its axis; false where nothing stays.
    bool trim(Pass& pass, bool front) {
        auto& contacts = pass.contacts;
        if (!front) std::ranges::reverse(contacts);
        const auto first =
            std::ranges::find_if(contacts, [this](const Contact& at) { return search_.leaves(at.pose); });
        for (auto at = contacts.begin(); at != first && at + 1 != contacts.end(); ++at)
            cutting_.leave(*at, *(at + 1), pass.index);
        contacts.erase(contacts.begin(), first);
        if (!front) std::ranges::reverse(contacts);
        return contacts.size() > 1;
    }

    void drop(const Pass& pass) {
        for (std::size_t k = 1; k < pass.contacts.size(); ++k)
            cutting_.leave(pass.contacts[k - 1], pass.contacts[k], pass.index);
    }

    void drop_last() {
        drop(passes_.back());
        passes_.pop_back();
        links_.pop_back();
    }

    PassCutter& cutting_;
    const detail::LinkSearch& search_;
    std::vector<Pass> passes_;
    std::vector<detail::Link> links_;
};

}  // namespace

Result<ReachedPlan> leave_out_gouges(SurfacePlan plan, std::span<const Face> faces, const Cutter& cutter,
                                     const PartBody& part, const SurfaceOptions& options,
                                     const LeavingOptions& leaving) {
    if (!(leaving.tolerance_mm >= 2 * part.tolerance_mm()))
        return fail({.code = "SURF0301",
                     .text = "tolerance_mm of leaving out gouges is out of its range",
                     .value = fmt::format("{} mm", leaving.tolerance_mm),
                     .limit = fmt::format("at least twice the part's {} mm", part.tolerance_mm())});
    ReachedPlan out{.plan = std::move(plan)};
    out.ridges_too_high = out.plan.left.size();
    const std::vector<Pass> planned = std::exchange(out.plan.passes, {});
    const detail::LeftReach reach(planned, faces, cutter, options.scallop_mm);
    PassCutter cutting(faces, cutter, part, leaving, reach, out);
    const detail::LinkSearch search(cutter, part, options, leaving.tolerance_mm, leaving.holder);
    Chain chain(cutting, search);
    for (const Pass& pass : planned) {
        std::vector<Pass> parts = cutting.parts_of(pass);
        if (parts.empty()) ++out.passes_lost;
        for (Pass& piece : parts) chain.add(std::move(piece));
    }
    chain.finish();
    if (chain.passes().empty())
        return fail({.code = "SURF0315",
                     .text = "the tool gets to no place of the face without going into the part",
                     .value = fmt::format("depth {:.4g} mm", out.deepest_mm),
                     .hint = "a smaller or longer tool, another lead or tilt, or --side other"});
    out.plan.passes = std::move(chain.passes());
    out.plan.cut_length_mm -= out.left_way_mm;
    detail::write_program(out.plan, options, chain.links());
    return out;
}

void lead_links_clear(SurfacePlan& plan, const Cutter& cutter, const PartBody& part, const SurfaceOptions& options,
                      const LeavingOptions& leaving) {
    const detail::LinkSearch search(cutter, part, options, leaving.tolerance_mm, leaving.holder);
    detail::write_program(plan, options, detail::links_where_free(plan.passes, search));
}

program::Program link_between(const Pass* before, const Pass* next, const SurfaceOptions& options,
                              const PartBeside* part) {
    detail::Link link;
    if (part) {
        const detail::LinkSearch search(part->cutter, part->body, options, part->leaving.tolerance_mm,
                                        part->leaving.holder);
        link = search.any_link(before, next).value_or(detail::Link{});
    }
    return detail::program_of_link(before, next, options, link);
}

}  // namespace trunnion::surfacing
