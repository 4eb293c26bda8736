#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "trunnion/surfacing/orientation_surface.hpp"

#include "detail/bezier_patch.hpp"
#include "detail/tessellation.hpp"

namespace trunnion::surfacing {

using Eigen::Vector3d;
using geometry::SurfacePlace;
using geometry::SurfaceShape;

namespace {

constexpr double degree = std::numbers::pi / 180;
const double least_rise = std::sin(1 * degree);  // of an axis over the tangent plane

Diagnostic at_place(std::string code, std::string text, const Vector3d& at) {
    return {.code = std::move(code), .text = fmt::format("{} at ({:.3f} {:.3f} {:.3f})", text, at.x(), at.y(), at.z())};
}

/// How far a lean is beyond the limits, rad.
struct Excess {
    double lead = 0, tilt = 0;
    double larger() const noexcept { return std::max(lead, tilt); }
};
Excess excess_of(const Lean& lean, const OrientationLimits& limits) {
    return {std::max(limits.least_lead_rad - lean.lead_rad, lean.lead_rad - limits.most_lead_rad),
            std::abs(lean.tilt_rad) - limits.most_tilt_rad};
}

Lean clamped(const Lean& lean, const OrientationLimits& limits, double inside) {
    const double by_lead = std::min(inside, 0.5 * (limits.most_lead_rad - limits.least_lead_rad));
    const double tilt = limits.most_tilt_rad - std::min(inside, limits.most_tilt_rad);
    return {std::clamp(lean.lead_rad, limits.least_lead_rad + by_lead, limits.most_lead_rad - by_lead),
            std::clamp(lean.tilt_rad, -tilt, tilt)};
}

}  // namespace

std::optional<Vector3d> FeedReference::at(const SurfaceShape& shape) const noexcept {
    const Vector3d& towards = along == Along::u ? shape.by_u : along == Along::v ? shape.by_v : direction;
    const Vector3d flat = towards - towards.dot(shape.normal) * shape.normal;
    if (!(flat.norm() > 1e-9 * towards.norm())) return std::nullopt;
    return flat.normalized();
}

Vector3d axis_of(const Lean& lean, const SurfaceShape& shape, const Vector3d& feed) noexcept {
    return (shape.normal + std::tan(lean.lead_rad) * feed + std::tan(lean.tilt_rad) * shape.normal.cross(feed))
        .normalized();
}

std::optional<Lean> lean_of(const Vector3d& axis, const SurfaceShape& shape, const Vector3d& feed) noexcept {
    const double up = axis.dot(shape.normal);
    if (!(up > 0)) return std::nullopt;
    return Lean{std::atan2(axis.dot(feed), up), std::atan2(axis.dot(shape.normal.cross(feed)), up)};
}

Result<void> OrientationSurface::check_rise(const SurfaceShape& shape, const Vector3d& axis) {
    const double rise = axis.dot(shape.normal);
    if (rise >= least_rise) return {};
    auto lies = at_place("SURF0307", "the tool lies in the tangent plane or under it", shape.point);
    lies.value = fmt::format("{:.2f} deg over it", std::asin(std::clamp(rise, -1.0, 1.0)) / degree);
    lies.limit = "1 deg";
    lies.hint = "less lead or tilt";
    return fail(std::move(lies));
}

Result<void> OrientationSurface::check(const SurfacePlace& place, const Vector3d& axis) const {
    const auto shape = shape_at(face_->surface, place, face_->side);
    const auto feed = shape ? limits_.feed.at(*shape) : std::nullopt;
    if (!feed)
        return fail(at_place("SURF0303", "the surface has no normal, or no feed direction,",
                             face_->surface.at(place.u, place.v)));
    if (auto rises = check_rise(*shape, axis); !rises) return rises;
    const auto lean = lean_of(axis, *shape, *feed);
    // The surfaces are within their tolerance of the orientations that they stand for, the limits' ones too.
    const Excess excess = excess_of(*lean, limits_);
    if (excess.larger() <= slack_rad()) return {};
    auto beyond = at_place("SURF0308", "the orientation is beyond its limits", shape->point);
    beyond.value = fmt::format("lead {:.3f} deg, tilt {:.3f} deg: {:.3f} deg beyond", lean->lead_rad / degree,
                               lean->tilt_rad / degree, excess.larger() / degree);
    beyond.limit = fmt::format("lead {:.3f} … {:.3f} deg, tilt ±{:.3f} deg", limits_.least_lead_rad / degree,
                               limits_.most_lead_rad / degree, limits_.most_tilt_rad / degree);
    return fail(std::move(beyond));
}

Vector3d OrientationSurface::nearest_allowed(const SurfacePlace& place, const Vector3d& axis, double inside_rad) const {
    const auto shape = shape_at(face_->surface, place, face_->side);
    const auto feed = shape ? limits_.feed.at(*shape) : std::nullopt;
    if (!feed) return axis;
    const auto lean = lean_of(axis, *shape, *feed);
    return axis_of(clamped(lean.value_or(Lean{}), limits_, inside_rad), *shape, *feed);
}

std::vector<OrientationTarget> OrientationSurface::beyond_limits() const {
    std::vector<OrientationTarget> out;
    const auto u = detail::breaks_of(surface_.u(), surface_.u().begin(), surface_.u().end());
    const auto v = detail::breaks_of(surface_.v(), surface_.v().begin(), surface_.v().end());
    constexpr int places = 4;
    for (std::size_t i = 0; i + 1 < u.size(); ++i)
        for (std::size_t j = 0; j + 1 < v.size(); ++j) {
            if (detail::overlap(*face_, {u[i], v[j]}, {u[i + 1], v[j + 1]}) == detail::Overlap::none) continue;
            std::optional<OrientationTarget> first;
            for (int k = 0; k <= places && !first; ++k)
                for (int l = 0; l <= places && !first; ++l) {
                    const SurfacePlace place{u[i] + (u[i + 1] - u[i]) * k / places,
                                             v[j] + (v[j + 1] - v[j]) * l / places};
                    if (const Vector3d here = axis(place); !check(place, here)) first = {place, here};
                }
            if (first) out.push_back(*first);
        }
    return out;
}

}  // namespace trunnion::surfacing
