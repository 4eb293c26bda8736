#include "trunnion/surfacing/machined_surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "trunnion/geometry/great_circle.hpp"

namespace trunnion::surfacing {

namespace {

CutterPose between(const CutterPose& from, const CutterPose& to, double w) {
    return {(1 - w) * from.tip_mm + w * to.tip_mm, geometry::slerp(from.axis, to.axis, w)};
}

std::vector<std::vector<CutterPose>> poses_of(const std::vector<Pass>& passes) {
    std::vector<std::vector<CutterPose>> out;
    for (const Pass& pass : passes) {
        auto& poses = out.emplace_back();
        for (const Contact& contact : pass.contacts) poses.push_back(contact.pose);
    }
    return out;
}

}  // namespace

MachinedSurface::MachinedSurface(const Cutter& cutter, const std::vector<Pass>& passes)
    : MachinedSurface(cutter, poses_of(passes)) {}

MachinedSurface::MachinedSurface(const Cutter& cutter, const std::vector<std::vector<CutterPose>>& polylines)
    : cutter_(cutter) {
    for (const auto& poses : polylines)
        for (std::size_t i = 0; i + 1 < poses.size(); ++i) add(poses[i], poses[i + 1]);
    build();
}

void MachinedSurface::add(const CutterPose& from, const CutterPose& to) {
    const double turn = geometry::angle_between(from.axis, to.axis);
    const double length = (to.tip_mm - from.tip_mm).norm() + turn * cutter_.reach_mm();
    const double longest = 0.1 * cutter_.radius_mm();
    const int parts = std::max(1, static_cast<int>(std::ceil(length / longest)));
    for (int k = 0; k < parts; ++k) {
        Move move{.from = between(from, to, static_cast<double>(k) / parts),
                  .to = between(from, to, static_cast<double>(k + 1) / parts)};
        move.middle = between(move.from, move.to, 0.5);
        // The body's farthest point is within reach and radius of the tip.
        const double arm = cutter_.reach_mm() + cutter_.radius_mm();
        move.sweep_mm = 0.5 * ((move.to.tip_mm - move.from.tip_mm).norm() + turn / parts * arm);
        move.bow_mm = 0.125 * std::pow(turn / parts, 2) * arm;
        moves_.push_back(move);
    }
}

MachinedSurface::Box MachinedSurface::box_of(std::int32_t first, std::int32_t count) const {
    Box box{Eigen::Vector3d::Constant(1e300), Eigen::Vector3d::Constant(-1e300), first, count};
    for (std::int32_t i = first; i < first + count; ++i)
        for (const CutterPose& pose : {moves_[i].from, moves_[i].to}) {
            const Eigen::Vector3d top = pose.tip_mm + cutter_.reach_mm() * pose.axis;
            // A disc of radius R across the axis reaches R √(1 − a²) along a coordinate.
            const Eigen::Vector3d wide = cutter_.radius_mm() * (1 - pose.axis.array().square()).max(0).sqrt().matrix();
            box.low = box.low.cwiseMin(pose.tip_mm - wide).cwiseMin(top - wide);
            box.high = box.high.cwiseMax(pose.tip_mm + wide).cwiseMax(top + wide);
        }
    return box;
}

void MachinedSurface::build() {
    if (moves_.empty()) return;
    constexpr std::int32_t leaf = 4;
    boxes_.push_back(box_of(0, static_cast<std::int32_t>(moves_.size())));
    for (std::size_t at = 0; at < boxes_.size(); ++at) {
        const Box box = boxes_[at];
        if (box.count <= leaf) continue;
        int axis = 0;
        (box.high - box.low).maxCoeff(&axis);
        const auto begin = moves_.begin() + box.first;
        const std::int32_t half = box.count / 2;
        std::nth_element(begin, begin + half, begin + box.count, [axis](const Move& a, const Move& b) {
            return a.middle.tip_mm[axis] < b.middle.tip_mm[axis];
        });
        boxes_[at].count = 0;
        boxes_[at].first = static_cast<std::int32_t>(boxes_.size());
        boxes_.push_back(box_of(box.first, half));
        boxes_.push_back(box_of(box.first + half, box.count - half));
    }
}

/// A bound from below of the body's distance on all of a move. While a convex body is shifted its distance from a point
/// is a convex function of the way: either half of it lies above the line through the two values of the other half.
double MachinedSurface::least_distance(const Move& move, const Eigen::Vector3d& point) const noexcept {
    const double middle = cutter_.distance_mm(move.middle, point);
    if (middle > move.sweep_mm) return middle - move.sweep_mm;
    const double from = cutter_.distance_mm(move.from, point), to = cutter_.distance_mm(move.to, point);
    return std::min({middle, 2 * middle - to, 2 * middle - from}) - move.bow_mm;
}

/// The least height over one move: the parabola through three poses, then a narrower one about its lowest place.
double MachinedSurface::over_move(const Move& move, const Eigen::Vector3d& point, const Eigen::Vector3d& direction,
                                  double limit) const noexcept {
    const auto height = [&](double w) {
        return cutter_.height_mm(between(move.from, move.to, w), point, direction, limit);
    };
    double centre = 0.5, half = 0.5;
    double here = cutter_.height_mm(move.middle, point, direction, limit), least = here;
    for (int round = 0; round < 2; ++round) {
        const double before = height(centre - half), after = height(centre + half);
        least = std::min({least, before, after});
        const double bend = before - 2 * here + after;
        const double move_by = bend > 0 ? 0.5 * (before - after) / bend : (before < after ? -1.0 : 1.0);
        constexpr double narrower = 0.15;
        centre = std::clamp(centre + std::clamp(move_by, -1.0, 1.0) * half, narrower * half, 1 - narrower * half);
        half *= narrower;
        here = height(centre);
        least = std::min(least, here);
    }
    return least;
}

double MachinedSurface::height_mm(const Eigen::Vector3d& point, const Eigen::Vector3d& direction,
                                  double limit) const noexcept {
    if (boxes_.empty()) return limit;
    double least = limit;
    std::array<std::int32_t, 64> stack{0};
    for (int depth = 1; depth > 0;) {
        const Box& box = boxes_[static_cast<std::size_t>(stack[static_cast<std::size_t>(--depth)])];
        // The line's part from −limit to what is known to be cut is what matters.
        const Eigen::Vector3d a = point - limit * direction, b = point + std::max(least, 0.0) * direction;
        if ((a.cwiseMin(b).array() > box.high.array()).any() || (a.cwiseMax(b).array() < box.low.array()).any())
            continue;
        if (box.count == 0) {
            stack[static_cast<std::size_t>(depth++)] = box.first;
            stack[static_cast<std::size_t>(depth++)] = box.first + 1;
            continue;
        }
        for (std::int32_t i = box.first; i < box.first + box.count; ++i) {
            const Move& move = moves_[static_cast<std::size_t>(i)];
            // From where the material is known to be cut, no way of the move leads the body lower.
            const Eigen::Vector3d top = point + least * direction;
            if (least_distance(move, top) > 0) continue;
            least = std::min(least, over_move(move, point, direction, limit));
        }
    }
    return least;
}

}  // namespace trunnion::surfacing
