#include "detail/join_passes.hpp"

#include <algorithm>
#include <iterator>
#include <numbers>
#include <optional>

#include "trunnion/geometry/great_circle.hpp"

namespace trunnion::surfacing::detail {

namespace {

constexpr double gap_mm = 0.05, same_mm = 1e-4;
constexpr double corner_rad = std::numbers::pi / 12;

bool goes_on(const Pass& before, const Pass& after) {
    const Contact &end = before.contacts.back(), &begin = after.contacts.front();
    return (begin.point_mm - end.point_mm).norm() < gap_mm &&
           geometry::angle_between(begin.normal, end.normal) < corner_rad;
}

/// The place of a face's border that is nearest to a point, if within the gap.
std::optional<geometry::SurfaceShape> border_near(const Face& face, const Eigen::Vector3d& point) {
    double least = gap_mm;
    geometry::SurfacePlace best;
    for (const Loop& loop : face.loops)
        for (std::size_t i = 0, before = loop.size() - 1; i < loop.size(); before = i++) {
            const Eigen::Vector3d a = face.surface.at(loop[before].x(), loop[before].y());
            const Eigen::Vector3d way = face.surface.at(loop[i].x(), loop[i].y()) - a;
            const double length = std::max(way.squaredNorm(), 1e-300);
            const double w = std::clamp((point - a).dot(way) / length, 0.0, 1.0);
            const Eigen::Vector2d at = loop[before] + w * (loop[i] - loop[before]);
            const double off = (face.surface.at(at.x(), at.y()) - point).norm();
            if (off < least) least = off, best = {at.x(), at.y()};
        }
    if (least >= gap_mm) return std::nullopt;
    return geometry::shape_at(face.surface, best, face.side);
}

}  // namespace

void append(Pass& to, Pass&& from) {
    if (from.contacts.empty()) return;
    const auto are_same = [](const Contact& a, const Contact& b) {
        constexpr double same_rad = 1e-4;
        return (a.point_mm - b.point_mm).norm() < same_mm && geometry::angle_between(a.normal, b.normal) < same_rad &&
               geometry::angle_between(a.pose.axis, b.pose.axis) < same_rad;
    };
    const bool same = !to.contacts.empty() && are_same(to.contacts.back(), from.contacts.front());
    std::move(from.contacts.begin() + (same ? 1 : 0), from.contacts.end(), std::back_inserter(to.contacts));
}

void join_passes(std::vector<Pass>& passes) {
    for (std::size_t i = 0; i < passes.size();) {
        const auto next = std::ranges::find_if(
            passes, [&](const Pass& other) { return &other != &passes[i] && goes_on(passes[i], other); });
        if (next == passes.end()) {
            ++i;
            continue;
        }
        Pass taken = std::move(*next);
        const bool earlier = next - passes.begin() < static_cast<std::ptrdiff_t>(i);
        append(passes[i], std::move(taken));
        passes.erase(next);
        if (earlier) --i;
    }
    if (passes.size() < 2) return;
    const auto chord = [](const Pass& pass) -> Eigen::Vector3d {
        return pass.contacts.back().point_mm - pass.contacts.front().point_mm;
    };
    const Eigen::Vector3d along =
        chord(*std::ranges::max_element(passes, {}, [&](const Pass& pass) { return chord(pass).squaredNorm(); }));
    std::ranges::stable_sort(passes, {}, [&](const Pass& pass) { return pass.contacts.front().point_mm.dot(along); });
}

bool is_shared(const Way& way, std::span<const Face> others, const Face& face) {
    const auto is_on = [&](const Face& other, double share) {
        const geometry::SurfacePlace at = way.place(share * way.length());
        const auto here = geometry::shape_at(face.surface, at, face.side);
        if (!here) return false;
        const auto there = border_near(other, here->point);
        return there && geometry::angle_between(there->normal, here->normal) < corner_rad;
    };
    return std::ranges::any_of(others, [&](const Face& other) {
        return &other != &face && is_on(other, 0.1) && is_on(other, 0.5) && is_on(other, 0.9);
    });
}

}  // namespace trunnion::surfacing::detail
