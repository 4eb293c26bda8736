#include "trunnion/surfacing/orientation_surface.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "detail/bernstein.hpp"
#include "detail/bezier_patch.hpp"
#include "detail/face_box.hpp"
#include "detail/lean_bound.hpp"
#include "detail/tessellation.hpp"

namespace trunnion::surfacing {

using detail::BezierPatch;
using Eigen::Vector3d;
using geometry::SurfacePlace;

namespace {

Result<void> check_options(const OrientationOptions& options, const OrientationLimits& limits) {
    constexpr double right_angle = 1.5707963267948966;
    struct Bound {
        const char* name;
        double value, above, below;
    };
    const Bound bounds[] = {
        {"height_mm", options.height_mm, 0, 1e6},
        {"tolerance_mm", options.tolerance_mm, 0, 0.1 * options.height_mm},
        {"spacing_mm", options.spacing_mm, 0, 1e9},
        {"least_lead_rad", limits.least_lead_rad, -right_angle, right_angle},
        {"most_lead_rad", limits.most_lead_rad, -right_angle, right_angle},
        {"most_lead_rad", limits.most_lead_rad - limits.least_lead_rad, -1e-12, 2 * right_angle},
        {"most_tilt_rad", limits.most_tilt_rad, -1e-12, right_angle},
    };
    for (const Bound& bound : bounds)
        if (!(bound.value > bound.above && bound.value < bound.below))
            return fail({.code = "SURF0301",
                         .text = fmt::format("{} of an orientation surface is out of its range", bound.name),
                         .value = fmt::format("{:.6g}", bound.value),
                         .limit = fmt::format("above {:.6g}, below {:.6g}", bound.above, bound.below)});
    return {};
}

/// Divides a direction so that patches are no longer than `spacing` along it, in the middle of the other one.
void space(detail::FitDirection& direction, const std::function<Vector3d(double)>& at, double spacing) {
    std::vector<int> parts;
    for (std::size_t k = 0; k + 1 < direction.breaks.size(); ++k) {
        const double from = direction.breaks[k], to = direction.breaks[k + 1], middle = 0.5 * (from + to);
        const double length = (at(middle) - at(from)).norm() + (at(to) - at(middle)).norm();
        parts.push_back(std::max(1, static_cast<int>(std::ceil(length / spacing))));
    }
    direction.divide(parts);
}

/// The largest error of a grid of places in one patch, and twice what second differences let it rise by in between.
class SampledError {
  public:
    SampledError(const geometry::BsplineSurface& fit, const detail::SurfaceValue& value) : fit_(fit), value_(value) {}

    double over(double u0, double u1, double v0, double v1) {
        double largest = 0;
        for (int i = 0; i <= parts; ++i)
            for (int j = 0; j <= parts; ++j) {
                const SurfacePlace place{u0 + (u1 - u0) * i / parts, v0 + (v1 - v0) * j / parts};
                const auto wanted = value_(place);
                off_[i][j] = wanted ? Vector3d(fit_.at(place.u, place.v) - *wanted) : Vector3d(Vector3d::Zero());
                largest = std::max(largest, off_[i][j].norm());
            }
        double by_u = 0, by_v = 0;
        for (int i = 0; i <= parts; ++i)
            for (int j = 1; j < parts; ++j) {
                by_u = std::max(by_u, (off_[j - 1][i] - 2 * off_[j][i] + off_[j + 1][i]).norm());
                by_v = std::max(by_v, (off_[i][j - 1] - 2 * off_[i][j] + off_[i][j + 1]).norm());
            }
        return largest + 0.25 * (by_u + by_v);
    }

  private:
    static constexpr int parts = 4;
    const geometry::BsplineSurface& fit_;
    const detail::SurfaceValue& value_;
    Vector3d off_[parts + 1][parts + 1];
};

/// Breaks of both, ascending, each once: those that are apart by rounding are the same.
std::vector<double> together(std::vector<double> a, const std::vector<double>& b) {
    const double same = 1e-12 * (a.back() - a.front());
    a.insert(a.end(), b.begin(), b.end());
    std::ranges::sort(a);
    a.erase(std::unique(a.begin(), a.end(), [&](double x, double y) { return y - x <= same; }), a.end());
    return a;
}

std::vector<double> breaks_of(const geometry::SurfaceDirection& direction) {
    return detail::breaks_of(direction, direction.begin(), direction.end());
}

/// Of the patch of an interval's middle.
std::size_t index_in(const std::vector<double>& breaks, double from, double to) {
    const auto behind = std::ranges::upper_bound(breaks, 0.5 * (from + to));
    return static_cast<std::size_t>(behind - breaks.begin()) - 1;
}

/// What a patch of a fit is off a field of constant lean: proved where it is within the tolerance.
class LeanError {
  public:
    LeanError(const Face& face, const GuidingSurface& guiding, const detail::LeanField& field, double tolerance)
        : face_(face), guiding_(guiding), field_(field), tolerance_(tolerance) {}

    std::vector<double> operator()(const geometry::BsplineSurface& fit, const std::vector<double>& u,
                                   const std::vector<double>& v) const {
        const auto fine_u = together(u, breaks_of(guiding_.surface().u())),
                   fine_v = together(v, breaks_of(guiding_.surface().v()));
        const auto faces = detail::patches_of(face_.surface, fine_u, fine_v),
                   lower = detail::patches_of(guiding_.surface(), fine_u, fine_v),
                   upper = detail::patches_of(fit, fine_u, fine_v);
        std::vector<double> out((u.size() - 1) * (v.size() - 1));
        for (std::size_t k = 0; k < faces.size(); ++k) {
            const Eigen::Vector2d &low = faces[k].low, &high = faces[k].high;
            double& of_patch = out[index_in(u, low.x(), high.x()) * (v.size() - 1) + index_in(v, low.y(), high.y())];
            if (detail::overlap(face_, low, high) == detail::Overlap::none) continue;
            const double seen = largest_seen(fit, low, high);
            of_patch = std::max(of_patch, seen > tolerance_ ? seen : error(faces[k], lower[k], upper[k], 0));
        }
        return out;
    }

  private:
    /// Bounds get tighter with the rectangle.
    double error(const BezierPatch& face, const BezierPatch& lower, const BezierPatch& upper, int level) const {
        if (detail::overlap(face_, face.low, face.high) == detail::Overlap::none) return 0;
        const double bound = detail::lean_error_bound_mm(field_, face, lower, upper);
        constexpr int deepest = 6;
        if (bound <= tolerance_ || level == deepest) return bound;
        double largest = 0;
        const bool across_u = level % 2 == 0;
        const auto a = face.halves(across_u), b = lower.halves(across_u), c = upper.halves(across_u);
        for (int half = 0; half < 2 && largest <= tolerance_; ++half)
            largest = std::max(largest, error(a[half], b[half], c[half], level + 1));
        return largest;
    }

    /// Of 5 × 5 places: nothing is to be proved where it is too much already.
    double largest_seen(const geometry::BsplineSurface& fit, const Eigen::Vector2d& low,
                        const Eigen::Vector2d& high) const {
        constexpr int parts = 4;
        double largest = 0;
        for (int i = 0; i <= parts; ++i)
            for (int j = 0; j <= parts; ++j) {
                const SurfacePlace place{low.x() + (high.x() - low.x()) * i / parts,
                                         low.y() + (high.y() - low.y()) * j / parts};
                const auto shape = shape_at(face_.surface, place, face_.side);
                const auto feed = shape ? field_.feed.at(*shape) : std::nullopt;
                if (!feed) continue;
                const Vector3d way = fit.at(place.u, place.v) - guiding_.at(place);
                largest = std::max(largest, (way - field_.height_mm * axis_of(field_.lean, *shape, *feed)).norm());
            }
        return largest;
    }

    const Face& face_;
    const GuidingSurface& guiding_;
    const detail::LeanField& field_;
    double tolerance_;
};

/// Breaks of a fit over the face's box, with patches no longer than the options say.
detail::FaceBox spaced_box(const Face& face, const GuidingSurface& guiding, double spacing_mm) {
    detail::FaceBox box = detail::face_box(face);
    const double u_middle = 0.5 * (box.u.breaks.front() + box.u.breaks.back());
    const double v_middle = 0.5 * (box.v.breaks.front() + box.v.breaks.back());
    space(box.u, [&](double u) { return guiding.at({u, v_middle}); }, spacing_mm);
    space(box.v, [&](double v) { return guiding.at({u_middle, v}); }, spacing_mm);
    return box;
}

/// S₂ of an axis field, as a value at a place.
detail::SurfaceValue value_of(const Face& face, const GuidingSurface& guiding,
                              const OrientationSurface::AxisField& axis, double height_mm) {
    return [&face, &guiding, axis, height_mm](const SurfacePlace& place) -> std::optional<Vector3d> {
        const auto shape = shape_at(face.surface, place, face.side);
        const auto wanted = shape ? axis(*shape) : std::nullopt;
        if (!wanted) return std::nullopt;
        return guiding.at(place) + height_mm * *wanted;
    };
}

}  // namespace

Result<OrientationSurface> OrientationSurface::make(const Face& face, const GuidingSurface& guiding,
                                                    const AxisField& axis, const OrientationLimits& limits,
                                                    const OrientationOptions& options) {
    if (auto sound = check_options(options, limits); !sound) return fail(std::move(sound.error()));
    const detail::SurfaceValue value = value_of(face, guiding, axis, options.height_mm);
    const detail::FitError error = [&](const auto& fit, const auto& u, const auto& v) {
        std::vector<double> out;
        SampledError sampled(fit, value);
        for (std::size_t i = 0; i + 1 < u.breaks.size(); ++i)
            for (std::size_t j = 0; j + 1 < v.breaks.size(); ++j) {
                const Eigen::Vector2d low(u.breaks[i], v.breaks[j]), high(u.breaks[i + 1], v.breaks[j + 1]);
                const bool counts = detail::overlap(face, low, high) != detail::Overlap::none;
                out.push_back(counts ? sampled.over(low.x(), high.x(), low.y(), high.y()) : 0);
            }
        return out;
    };
    const detail::FaceBox box = spaced_box(face, guiding, options.spacing_mm);
    auto made = detail::fit(box.u, box.v, value, error, options.tolerance_mm, options.most_patches);
    if (!made) return fail(std::move(made.error()));
    return OrientationSurface(face, guiding, std::move(made->surface), limits, options, made->error_mm, made->patches)
        .checked();
}

Result<OrientationSurface> OrientationSurface::make(const Face& face, const GuidingSurface& guiding, const Lean& lean,
                                                    const OrientationLimits& limits,
                                                    const OrientationOptions& options) {
    if (auto sound = check_options(options, limits); !sound) return fail(std::move(sound.error()));
    const AxisField axis = [&](const geometry::SurfaceShape& shape) -> std::optional<Vector3d> {
        const auto feed = limits.feed.at(shape);
        if (!feed) return std::nullopt;
        return axis_of(lean, shape, *feed);
    };
    const detail::LeanField field{face.side, limits.feed, lean, options.height_mm};
    const LeanError error(face, guiding, field, options.tolerance_mm);
    const detail::FaceBox box = spaced_box(face, guiding, options.spacing_mm);
    auto made = detail::fit(
        box.u, box.v, value_of(face, guiding, axis, options.height_mm),
        [&](const auto& fit, const auto& u, const auto& v) { return error(fit, u.breaks, v.breaks); },
        options.tolerance_mm, options.most_patches);
    if (!made) return fail(std::move(made.error()));
    return OrientationSurface(face, guiding, std::move(made->surface), limits, options, made->error_mm, made->patches)
        .checked();
}

Result<OrientationSurface> OrientationSurface::lower_limit() const {
    return make(*face_, guiding_, Lean{limits_.least_lead_rad, 0}, limits_, options_);
}

Result<OrientationSurface> OrientationSurface::upper_limit() const {
    return make(*face_, guiding_, Lean{limits_.most_lead_rad, 0}, limits_, options_);
}

Vector3d OrientationSurface::axis(const SurfacePlace& place) const noexcept {
    return (surface_.at(place.u, place.v) - guiding_.at(place)).normalized();
}

std::pair<double, double> OrientationSurface::distance_range_mm() const {
    const auto u = together(breaks_of(surface_.u()), breaks_of(guiding_.surface().u())),
               v = together(breaks_of(surface_.v()), breaks_of(guiding_.surface().v()));
    const auto upper = detail::patches_of(surface_, u, v), lower = detail::patches_of(guiding_.surface(), u, v);
    detail::HullRange all;
    for (std::size_t k = 0; k < upper.size(); ++k) {
        if (detail::overlap(*face_, upper[k].low, upper[k].high) == detail::Overlap::none) continue;
        const Vector3d zero = Vector3d::Zero();
        const auto way = detail::bernstein<Vector3d>(3, 3, zero, [&](int i, int j) -> Vector3d {
            return upper[k].at(i, j).head<3>() - lower[k].at(i, j).head<3>();
        });
        const detail::HullRange here = detail::range(detail::dot(way, way));
        all = {std::min(all.low, here.low), std::max(all.high, here.high)};
    }
    return {std::sqrt(std::max(all.low, 0.0)), std::sqrt(all.high)};
}

Result<OrientationSurface> OrientationSurface::checked() const {
    if (const auto beyond = beyond_limits(); !beyond.empty())
        return fail(check(beyond.front().place, beyond.front().axis).error());
    return *this;
}

}  // namespace trunnion::surfacing
