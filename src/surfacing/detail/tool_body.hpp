#pragma once

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

#include "trunnion/surfacing/cutter.hpp"
#include "trunnion/surfacing/part_body.hpp"

namespace trunnion::surfacing::detail {

/// A distance and the direction in which it grows: for a convex body all others are at least distance + gradient · way.
struct Gap {
    double distance;
    Eigen::Vector3d gradient;
};

/// A convex piece of a tool at a pose: the cylinder of a Cutter, or a holder, as a rectangle in the meridian plane
/// [0, flat] × [low, high] grown by `corner`.
struct ToolBody {
    Eigen::Vector3d tip, axis;
    double flat, low, high, corner;

    static ToolBody of(const Cutter& cutter, const CutterPose& pose) noexcept {
        return {pose.tip_mm,
                pose.axis,
                cutter.flat_radius_mm(),
                cutter.corner_mm(),
                cutter.reach_mm() - cutter.corner_mm(),
                cutter.corner_mm()};
    }
    static ToolBody of(const Holder& holder, const CutterPose& pose) noexcept {
        return {pose.tip_mm, pose.axis, holder.radius_mm, holder.from_mm, holder.to_mm, 0};
    }

    /// Distance from the surface as Cutter::distance_mm(), negative inside, convex. Cost about 15 ns.
    Gap gap(const Eigen::Vector3d& point) const noexcept {
        const Eigen::Vector3d from_tip = point - tip;
        const double up = from_tip.dot(axis);
        const Eigen::Vector3d across = from_tip - up * axis;
        const double out = across.norm();
        const Eigen::Vector3d outward =
            out > 0 ? Eigen::Vector3d(across / out) : Eigen::Vector3d(Eigen::Vector3d::Zero());
        const double sideways = out - flat, along = std::max(low - up, up - high);
        const double sign = low - up > up - high ? -1 : 1;
        const double x = std::max(sideways, 0.0), y = std::max(along, 0.0);
        if (const double outside = std::hypot(x, y); outside > 0)
            return {outside - corner, (x * outward + y * sign * axis) / outside};
        if (sideways > along) return {sideways - corner, outward};
        return {along - corner, sign * axis};
    }

    /// A place within it: the nearest one of its core to a point outside that, else one on its axis. `there`: at the
    /// point.
    Eigen::Vector3d within(const Eigen::Vector3d& point, const Gap& there) const noexcept {
        const double from_core = there.distance + corner;
        return from_core > 0 ? Eigen::Vector3d(point - from_core * there.gradient) : ball_beside(point);
    }
    double radius() const noexcept { return flat + corner; }
    /// The middle of the largest ball within the body that is nearest to a point's height.
    Eigen::Vector3d ball_beside(const Eigen::Vector3d& point) const noexcept {
        const double bottom = low - corner + ball_radius(), top = high + corner - ball_radius();
        return tip + std::clamp((point - tip).dot(axis), bottom, top) * axis;
    }
    double ball_radius() const noexcept { return std::min(radius(), 0.5 * (high - low) + corner); }
};

}  // namespace trunnion::surfacing::detail
