#include "detail/free_links.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "trunnion/geometry/great_circle.hpp"

namespace trunnion::surfacing::detail {

namespace {

constexpr int most_doublings = 5;

/// The turn from one direction to another; between opposite ones over some third one.
Eigen::Vector3d turned(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double w) {
    constexpr double opposite = -0.9999;
    if (from.dot(to) > opposite) return geometry::slerp(from, to, w);
    const Eigen::Vector3d third = from.unitOrthogonal();
    return w < 0.5 ? geometry::slerp(from, third, 2 * w) : geometry::slerp(third, to, 2 * w - 1);
}

double arm_mm(const Cutter& cutter, const Holder& holder) {
    return std::max(cutter.reach_mm(), holder.to_mm) + std::max(cutter.radius_mm(), holder.radius_mm);
}

}  // namespace

double look_mm(const Cutter& cutter) {
    return std::min(std::max(0.5, 0.02 * cutter.radius_mm()), 0.5 * cutter.radius_mm());
}

int looks_between(const CutterPose& from, const CutterPose& to, const Cutter& cutter, const Holder& holder) {
    const double turn = geometry::angle_between(from.axis, to.axis);
    const double way_mm = (to.tip_mm - from.tip_mm).norm() + turn * arm_mm(cutter, holder);
    return std::max(1, static_cast<int>(std::ceil(way_mm / look_mm(cutter))));
}

Result<Link> LinkSearch::link(const Pass* before, const Pass* next) const {
    const bool beside = before && next && is_beside(*before, *next, options_);
    if (!in_part(before, next, beside ? options_.lift_mm : options_.retract_mm)) return Link{};
    double height_mm = options_.retract_mm;
    for (int k = 0;; ++k, height_mm *= 2) {
        const auto in = in_part(before, next, height_mm);
        if (!in) return Link{.height_mm = height_mm};
        // What cannot be pulled up so far cannot be pulled up farther.
        if (k < most_doublings && leave(before, next)) continue;
        // In a channel, say, there is room beside the surface alone.
        if (before && next && !in_part(before, next, options_.lift_mm)) return Link{.height_mm = options_.lift_mm};
        return fail(none_free(*in, height_mm));
    }
}

bool LinkSearch::leave(const Pass* before, const Pass* next) const {
    return (!before || leaves(before->contacts.back().pose)) && (!next || leaves(next->contacts.front().pose));
}

std::optional<Link> LinkSearch::any_link(const Pass* before, const Pass* next) const {
    if (auto over = link(before, next)) return std::move(*over);
    if (!before || !next || !leave(before, next)) return std::nullopt;
    const Eigen::Vector3d middle = part_.middle_mm();
    const double outside_mm = 1.02 * (part_.radius_mm() + options_.retract_mm + arm_mm(cutter_, holder_));
    const CutterPose &end = before->contacts.back().pose, &begin = next->contacts.front().pose;
    const CutterPose from = out_of(end, outside_mm), to = out_of(begin, outside_mm);
    const Eigen::Vector3d out_from = (from.tip_mm - middle).normalized(), out_to = (to.tip_mm - middle).normalized();
    const double angle =
        std::max(geometry::angle_between(out_from, out_to), geometry::angle_between(from.axis, to.axis));
    constexpr double step_rad = std::numbers::pi / 12;
    const int steps = 2 * std::max(1, static_cast<int>(std::ceil(angle / step_rad)));
    Link out;
    for (int k = 0; k <= steps; ++k) {
        const double w = static_cast<double>(k) / steps;
        out.round.push_back({middle + outside_mm * turned(out_from, out_to, w), turned(from.axis, to.axis, w)});
    }
    std::vector<CutterPose> way{end};
    way.insert(way.end(), out.round.begin(), out.round.end());
    way.push_back(begin);
    if (on_way(way)) return std::nullopt;
    return out;
}

bool LinkSearch::leaves(const CutterPose& pose) const {
    return !on_straight(pose, raised(pose, options_.retract_mm));
}

/// Up its axis to some distance from the part's middle.
CutterPose LinkSearch::out_of(const CutterPose& pose, double radius_mm) const {
    const Eigen::Vector3d from = pose.tip_mm - part_.middle_mm();
    const double along = from.dot(pose.axis);
    return raised(pose, std::sqrt(along * along + radius_mm * radius_mm - from.squaredNorm()) - along);
}

/// The first place where the tool is in the part on its way over a height.
std::optional<Penetration> LinkSearch::in_part(const Pass* before, const Pass* next, double height_mm) const {
    std::vector<CutterPose> way;
    if (before) {
        const CutterPose& from = before->contacts.back().pose;
        way.push_back(from);
        way.push_back(raised(from, height_mm));
    }
    if (next) {
        const CutterPose& to = next->contacts.front().pose;
        way.push_back(raised(to, height_mm));
        way.push_back(to);
    }
    return on_way(way);
}

std::optional<Penetration> LinkSearch::on_way(std::span<const CutterPose> way) const {
    for (std::size_t k = 1; k < way.size(); ++k)
        if (auto in = on_straight(way[k - 1], way[k])) return in;
    return std::nullopt;
}

std::optional<Penetration> LinkSearch::on_straight(const CutterPose& from, const CutterPose& to) const {
    const geometry::GreatCircle turn(from.axis, to.axis);
    const int parts = looks_between(from, to, cutter_, holder_);
    for (int k = 0; k <= parts; ++k) {
        const double w = static_cast<double>(k) / parts;
        const CutterPose pose{(1 - w) * from.tip_mm + w * to.tip_mm, turn.at(w)};
        if (part_.is_deeper(cutter_, pose, tolerance_mm_, holder_))
            return part_.deepest(cutter_, pose, tolerance_mm_, holder_);
    }
    return std::nullopt;
}

Diagnostic LinkSearch::none_free(const Penetration& in, double height_mm) const {
    return {.code = "SURF0314",
            .text = fmt::format("no way between two passes is free of the part; over the highest one that was "
                                "tried the {} goes into it at ({:.3f} {:.3f} {:.3f})",
                                in.by_holder ? "holder" : "tool", in.at_mm.x(), in.at_mm.y(), in.at_mm.z()),
            .value = fmt::format("depth {:.4g} mm", in.depth_mm),
            .limit = fmt::format("{:.4g} mm up the tool axis", height_mm),
            .hint = "another retract height, or another direction of the passes"};
}

namespace {

const Pass* before(std::span<const Pass> passes, std::size_t k) {
    return k > 0 ? &passes[k - 1] : nullptr;
}
const Pass* next(std::span<const Pass> passes, std::size_t k) {
    return k < passes.size() ? &passes[k] : nullptr;
}

}  // namespace

Result<std::vector<Link>> free_links(std::span<const Pass> passes, const Cutter& cutter, const PartBody& part,
                                     const SurfaceOptions& options, const FreeingOptions& freeing) {
    const LinkSearch search(cutter, part, options, freeing.tolerance_mm, freeing.holder);
    std::vector<Link> out;
    for (std::size_t k = 0; k <= passes.size(); ++k) {
        auto link = search.link(before(passes, k), next(passes, k));
        if (!link) return fail(link.error());
        out.push_back(std::move(*link));
    }
    return out;
}

std::vector<Link> links_where_free(std::span<const Pass> passes, const LinkSearch& search) {
    std::vector<Link> out;
    for (std::size_t k = 0; k <= passes.size(); ++k)
        out.push_back(search.any_link(before(passes, k), next(passes, k)).value_or(Link{}));
    return out;
}

}  // namespace trunnion::surfacing::detail
