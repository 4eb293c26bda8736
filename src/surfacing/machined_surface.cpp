#include "trunnion/surfacing/machined_surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

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

/// Distance of the body in a pose from a point, with its slope by the point's place.
struct Gap {
    double distance_mm, up, out;
    Eigen::Vector3d from_tip, sideways;
    MeridianDistance meridian;
    Eigen::Vector3d slope(const Eigen::Vector3d& axis) const {
        return meridian.by_out * sideways + meridian.by_up * axis;
    }
};

Gap gap_of(const Cutter& cutter, const Eigen::Vector3d& tip, const Eigen::Vector3d& axis,
           const Eigen::Vector3d& point) noexcept {
    Gap gap;
    gap.from_tip = point - tip;
    gap.up = gap.from_tip.dot(axis);
    gap.sideways = gap.from_tip - gap.up * axis;
    gap.out = gap.sideways.norm();
    if (gap.out > 0) gap.sideways /= gap.out;
    gap.meridian = cutter.in_meridian(gap.out, gap.up);
    gap.distance_mm = gap.meridian.value;
    return gap;
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
    constexpr double largest_turn_rad = 0.03;
    const double longest_mm = 0.2 * cutter_.radius_mm();
    const double parts_needed =
        (to.tip_mm - from.tip_mm).norm() / longest_mm + geometry::angle_between(from.axis, to.axis) / largest_turn_rad;
    const int parts = std::max(1, static_cast<int>(std::ceil(parts_needed)));
    CutterPose begin = from;
    for (int k = 1; k <= parts; ++k) {
        const CutterPose end = k == parts ? to : between(from, to, static_cast<double>(k) / parts);
        moves_.push_back({begin, end.tip_mm - begin.tip_mm, end.axis - begin.axis});
        begin = end;
    }
}

MachinedSurface::Group MachinedSurface::group_of(std::int32_t first, std::int32_t count) const {
    const auto moves = std::span(moves_).subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(count));
    Group group{.middle = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()},
                .along_mm = 0,
                .across_mm = 0,
                .cone_rad = 0,
                .first = first,
                .count = count};
    for (const Move& move : moves) {
        group.middle.tip_mm += move.middle_tip() / count;
        group.middle.axis += move.from.axis + 0.5 * move.turn;
    }
    group.middle.axis.normalize();
    const auto hold = [&group](const CutterPose& pose) {
        const Eigen::Vector3d off = pose.tip_mm - group.middle.tip_mm;
        const double along = off.dot(group.middle.axis);
        group.along_mm = std::max(group.along_mm, std::abs(along));
        group.across_mm = std::max(group.across_mm, (off - along * group.middle.axis).norm());
        group.cone_rad = std::max(group.cone_rad, geometry::angle_between(pose.axis, group.middle.axis));
    };
    for (const Move& move : moves) {
        hold(move.from);
        hold(move.end());
    }
    return group;
}

void MachinedSurface::build() {
    if (moves_.empty()) return;
    groups_.push_back(group_of(0, static_cast<std::int32_t>(moves_.size())));
    for (std::size_t at = 0; at < groups_.size(); ++at) {
        const Group group = groups_[at];
        if (group.count <= 1) continue;
        const auto begin = moves_.begin() + group.first, end = begin + group.count;
        Eigen::Vector3d low = begin->middle_tip(), high = low;
        for (auto move = begin; move != end; ++move) {
            low = low.cwiseMin(move->middle_tip());
            high = high.cwiseMax(move->middle_tip());
        }
        int axis = 0;
        (high - low).maxCoeff(&axis);
        const std::int32_t half = group.count / 2;
        std::nth_element(begin, begin + half, end,
                         [axis](const Move& a, const Move& b) { return a.middle_tip()[axis] < b.middle_tip()[axis]; });
        groups_[at].count = 0;
        groups_[at].first = static_cast<std::int32_t>(groups_.size());
        groups_.push_back(group_of(group.first, half));
        groups_.push_back(group_of(group.first + half, group.count - half));
    }
}

/// A bound from below of the body's distance on all moves of a group, by the tangent plane of the distance at its
/// middle: a pose that is shifted and turned against it has the point elsewhere in the body's frame.
double MachinedSurface::least_distance(const Group& group, const Eigen::Vector3d& point) const noexcept {
    const Gap gap = gap_of(cutter_, group.middle.tip_mm, group.middle.axis, point);
    const double turn = group.cone_rad;
    const double up = std::abs(gap.meridian.by_up) + turn, out = std::abs(gap.meridian.by_out) + turn;
    const double arm = std::abs(gap.up * gap.meridian.by_out - gap.out * gap.meridian.by_up);
    return gap.distance_mm - up * group.along_mm - out * group.across_mm - turn * arm -
           0.5 * turn * turn * gap.from_tip.norm();
}

/// The least distance over one move: where its slope, which grows, changes its sign.
MachinedSurface::Nearest MachinedSurface::nearest(const Move& move, const Eigen::Vector3d& point) const noexcept {
    struct Place {
        double w, rate;
        Nearest nearest;
    };
    const auto at = [&](double w) -> Place {
        const Eigen::Vector3d axis = (move.from.axis + w * move.turn).normalized();
        const Gap gap = gap_of(cutter_, move.from.tip_mm + w * move.shift, axis, point);
        const double up_rate = gap.from_tip.dot(move.turn) - move.shift.dot(axis);
        const double out_rate = -gap.sideways.dot(move.shift) - gap.up * gap.sideways.dot(move.turn);
        return {w, gap.meridian.by_out * out_rate + gap.meridian.by_up * up_rate, {gap.distance_mm, gap.slope(axis)}};
    };
    Place low = at(0), high = at(1);
    if (low.rate >= 0) return low.nearest;
    if (high.rate <= 0) return high.nearest;
    double low_rate = low.rate, high_rate = high.rate;
    constexpr double negligible_mm = 1e-9;
    for (int step = 0; step < 20 && (high.w - low.w) * std::min(-low.rate, high.rate) > negligible_mm; ++step) {
        const Place place = at(low.w - low_rate * (high.w - low.w) / (high_rate - low_rate));
        // The end that stays counts half, so that both move (the Illinois rule).
        if (place.rate < 0) {
            low = place, low_rate = place.rate, high_rate *= 0.5;
        } else {
            high = place, high_rate = place.rate, low_rate *= 0.5;
        }
    }
    return low.nearest.distance_mm < high.nearest.distance_mm ? low.nearest : high.nearest;
}

/// Where the line enters the body over one move, if below the height that is known to be cut: by Newton's method, which
/// halves the part of the line that is left where it runs along a wall.
double MachinedSurface::over_move(const Move& move, const Eigen::Vector3d& point, const Eigen::Vector3d& direction,
                                  double known, double limit) const noexcept {
    constexpr double exact_mm = 1e-9, steep = -0.3;
    double height = known, inside = known, outside = -limit;
    for (int step = 0; step < 60; ++step) {
        const Nearest there = nearest(move, point + height * direction);
        if (step == 0 && there.distance_mm >= 0) return known;
        if (std::abs(there.distance_mm) < exact_mm) break;
        (there.distance_mm < 0 ? inside : outside) = height;
        if (inside - outside < exact_mm) break;
        const double slope = there.slope.dot(direction), newton = height - there.distance_mm / slope;
        const bool sound = slope < steep && newton > outside && newton < inside;
        height = sound ? newton : 0.5 * (inside + outside);
    }
    return std::min(height, known);
}

double MachinedSurface::height_mm(const Eigen::Vector3d& point, const Eigen::Vector3d& direction,
                                  double limit) const noexcept {
    if (groups_.empty()) return limit;
    double least = limit;
    Eigen::Vector3d top = point + limit * direction;
    std::array<std::int32_t, 64> stack{0};
    for (int depth = 1; depth > 0;) {
        const Group& group = groups_[static_cast<std::size_t>(stack[static_cast<std::size_t>(--depth)])];
        // Where the material is known to be cut, what does not reach so low leads it no lower.
        if (least_distance(group, top) > 0) continue;
        if (group.count > 0) {
            for (std::int32_t i = group.first; i < group.first + group.count; ++i)
                least = over_move(moves_[static_cast<std::size_t>(i)], point, direction, least, limit);
            top = point + least * direction;
            continue;
        }
        const auto off = [&](std::int32_t child) {
            return (groups_[static_cast<std::size_t>(child)].middle.tip_mm - top).squaredNorm();
        };
        const bool first_is_nearer = off(group.first) < off(group.first + 1);
        stack[static_cast<std::size_t>(depth++)] = group.first + (first_is_nearer ? 1 : 0);
        stack[static_cast<std::size_t>(depth++)] = group.first + (first_is_nearer ? 0 : 1);
    }
    return least;
}

double MachinedSurface::depth_mm(const Eigen::Vector3d& point) const noexcept {
    if (groups_.empty()) return 0;
    double least = 0;
    std::array<std::int32_t, 64> stack{0};
    for (std::size_t depth = 1; depth > 0;) {
        const Group& group = groups_[static_cast<std::size_t>(stack[--depth])];
        if (least_distance(group, point) >= least) continue;
        if (group.count == 0) {
            stack[depth++] = group.first;
            stack[depth++] = group.first + 1;
        }
        for (std::int32_t i = group.first; i < group.first + group.count; ++i)
            least = std::min(least, nearest(moves_[static_cast<std::size_t>(i)], point).distance_mm);
    }
    return -least;
}

}  // namespace trunnion::surfacing
