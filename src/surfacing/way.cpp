#include "detail/way.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace trunnion::surfacing::detail {

using geometry::SurfacePlace;

namespace {

Eigen::Vector2d as_vector(const SurfacePlace& place) noexcept {
    return {place.u, place.v};
}

}  // namespace

Way::Way(const geometry::BsplineSurface& surface, std::vector<SurfacePlace> places) {
    for (const SurfacePlace& place : places) {
        const Eigen::Vector3d point = surface.at(place.u, place.v);
        const double step = points_.empty() ? 0 : (point - points_.back()).norm();
        if (!points_.empty() && !(step > 1e-9)) continue;
        lengths_.push_back(lengths_.empty() ? 0 : lengths_.back() + step);
        points_.push_back(point);
        places_.push_back(place);
    }
}

/// Of the parabola through a node and its neighbours.
Eigen::Vector2d Way::slope_at_node(std::size_t i) const noexcept {
    const std::size_t n = places_.size();
    const auto rise = [&](std::size_t k) -> Eigen::Vector2d {
        return (as_vector(places_[k + 1]) - as_vector(places_[k])) / (lengths_[k + 1] - lengths_[k]);
    };
    if (n == 2) return rise(0);
    const std::size_t middle = std::clamp<std::size_t>(i, 1, n - 2);
    const double before = lengths_[middle] - lengths_[middle - 1], after = lengths_[middle + 1] - lengths_[middle];
    const Eigen::Vector2d bend = (rise(middle) - rise(middle - 1)) / (before + after);
    const double at = lengths_[i] - lengths_[middle];
    return rise(middle - 1) + (before + 2 * at) * bend;
}

/// A cubic between two nodes.
struct Way::Piece {
    Eigen::Vector2d from, to, slope_from, slope_to;
    double length, w;

    Eigen::Vector2d value() const noexcept {
        const double a = (1 + 2 * w) * (1 - w) * (1 - w), b = w * w * (3 - 2 * w);
        return a * from + b * to + length * (w * (1 - w) * (1 - w) * slope_from - w * w * (1 - w) * slope_to);
    }
    Eigen::Vector2d slope() const noexcept {
        return 6 * w * (1 - w) / length * (to - from) + (1 - w) * (1 - 3 * w) * slope_from + w * (3 * w - 2) * slope_to;
    }
};

Way::Piece Way::piece_at(double s) const noexcept {
    const auto after = std::upper_bound(lengths_.begin() + 1, lengths_.end() - 1, s);
    const auto k = static_cast<std::size_t>(after - lengths_.begin()) - 1;
    const double length = lengths_[k + 1] - lengths_[k];
    return {as_vector(places_[k]),     as_vector(places_[k + 1]), slope_at_node(k), slope_at_node(k + 1), length,
            (s - lengths_[k]) / length};
}

SurfacePlace Way::place(double s) const noexcept {
    const Eigen::Vector2d at = piece_at(s).value();
    return {at.x(), at.y()};
}

Eigen::Vector2d Way::slope(double s) const noexcept {
    return piece_at(s).slope();
}

Way::Foot Way::foot_of(const Eigen::Vector3d& point) const noexcept {
    Foot foot{0, (points_.front() - point).squaredNorm()};
    for (std::size_t k = 0; k + 1 < points_.size(); ++k) {
        const Eigen::Vector3d way = points_[k + 1] - points_[k];
        const double w = std::clamp((point - points_[k]).dot(way) / way.squaredNorm(), 0.0, 1.0);
        const double off = (points_[k] + w * way - point).squaredNorm();
        if (off < foot.squared) foot = {lengths_[k] + w * (lengths_[k + 1] - lengths_[k]), off};
    }
    return foot;
}

double Way::nearest(const Eigen::Vector3d& point) const noexcept {
    return foot_of(point).s;
}

double Way::distance_mm(const Eigen::Vector3d& point) const noexcept {
    return std::sqrt(foot_of(point).squared);
}

Way Way::resampled(const geometry::BsplineSurface& surface, double spacing) const {
    const int steps = std::max(2, static_cast<int>(std::ceil(length() / spacing)));
    std::vector<SurfacePlace> out;
    for (int k = 0; k <= steps; ++k) out.push_back(place(length() * k / steps));
    return {surface, std::move(out)};
}

std::optional<Station> Job::station(const Way& way, double s, bool backwards) const noexcept {
    const SurfacePlace place = way.place(s);
    const auto shape = this->shape(place);
    if (!shape) return std::nullopt;
    const Eigen::Vector2d slope = way.slope(s);
    const Eigen::Vector3d along = (slope.x() * shape->by_u + slope.y() * shape->by_v).normalized();
    const Eigen::Vector3d across = shape->normal.cross(along);
    const double lead = backwards ? -options.lead_rad : options.lead_rad;
    const Eigen::Vector3d axis =
        (shape->normal + std::tan(lead) * along + std::tan(options.tilt_rad) * across).normalized();
    return Station{place, *shape, along, across, cutter.touching(shape->point, shape->normal, axis)};
}

}  // namespace trunnion::surfacing::detail
