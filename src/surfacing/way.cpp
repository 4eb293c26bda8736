#include "detail/way.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/Geometry>

namespace trunnion::surfacing::detail {

using geometry::SurfacePlace;

namespace {

Eigen::Vector2d as_vector(const SurfacePlace& place) noexcept {
    return {place.u, place.v};
}

std::optional<Eigen::Vector3d> normal_at(const geometry::BsplineSurface& surface, const SurfacePlace& place) {
    const auto shape = geometry::shape_at(surface, place, geometry::Side::along);
    return shape ? std::optional(shape->normal) : std::nullopt;
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
    gather();
}

void Way::gather() {
    constexpr std::size_t steps = 16;
    for (std::size_t begin = 0; begin + 1 < points_.size(); begin += steps) {
        const std::size_t end = std::min(begin + steps, points_.size() - 1);
        Stretch stretch{points_[(begin + end) / 2], 0, begin, end};
        for (std::size_t k = begin; k <= end; ++k)
            stretch.radius = std::max(stretch.radius, (points_[k] - stretch.middle).norm());
        stretches_.push_back(stretch);
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

/// `accept`: whether a foot counts, asked of those alone that are nearer than all before: step and share of it.
template <class Accept>
Way::Foot Way::foot_of(const Eigen::Vector3d& point, const Accept& accept) const noexcept {
    Foot foot{0, std::numeric_limits<double>::infinity()};
    const auto on = [&](const Stretch& stretch) {
        for (std::size_t k = stretch.begin; k < stretch.end; ++k) {
            const Eigen::Vector3d way = points_[k + 1] - points_[k];
            const double w = std::clamp((point - points_[k]).dot(way) / way.squaredNorm(), 0.0, 1.0);
            const double off = (points_[k] + w * way - point).squaredNorm();
            if (off < foot.squared && accept(k, w, off))
                foot = {lengths_[k] + w * (lengths_[k + 1] - lengths_[k]), off};
        }
    };
    const auto apart = [&](const Stretch& stretch) { return (point - stretch.middle).norm() - stretch.radius; };
    const auto first = std::ranges::min_element(stretches_, {}, apart);
    if (first != stretches_.end()) on(*first);
    for (auto stretch = stretches_.begin(); stretch != stretches_.end(); ++stretch)
        if (const double off = apart(*stretch); stretch != first && (off <= 0 || off * off < foot.squared))
            on(*stretch);
    return foot;
}

std::optional<double> Way::nearest(const SurfacePlace& from, const geometry::SurfaceShape& shape) const noexcept {
    constexpr double farther = 3, slack_mm = 1e-3;  // curved and unevenly drawn surfaces are longer than a chord
    const Foot foot = foot_of(shape.point, [&](std::size_t k, double w, double squared) {
        const Eigen::Vector2d off = (1 - w) * as_vector(places_[k]) + w * as_vector(places_[k + 1]) - as_vector(from);
        const double on_surface = (off.x() * shape.by_u + off.y() * shape.by_v).norm();
        return on_surface <= farther * std::sqrt(squared) + slack_mm;
    });
    return std::isfinite(foot.squared) ? std::optional(foot.s) : std::nullopt;
}

double Way::distance_mm(const Eigen::Vector3d& point) const noexcept {
    return std::sqrt(foot_of(point, [](auto...) { return true; }).squared);
}

Way Way::resampled(const geometry::BsplineSurface& surface, double spacing) const {
    if (places_.size() < 2) return *this;
    const int steps = std::max(2, static_cast<int>(std::ceil(length() / spacing)));
    std::vector<SurfacePlace> out;
    const double step = length() / steps;
    auto before = normal_at(surface, place(0));
    out.push_back(place(0));
    for (int k = 1; k <= steps; ++k) {
        const auto here = normal_at(surface, place(k * step));
        close(surface, {(k - 1) * step, before}, {k * step, here}, 0, out);
        out.push_back(place(k * step));
        before = here;
    }
    return {surface, std::move(out)};
}

/// Places between two ends between which the surface turns too far.
void Way::close(const geometry::BsplineSurface& surface, const End& from, const End& to, int depth,
                std::vector<SurfacePlace>& out) const {
    constexpr double most_turn_rad = 0.2;
    constexpr int deepest = 6;
    if (depth == deepest || !from.normal || !to.normal) return;
    if (from.normal->dot(*to.normal) > std::cos(most_turn_rad)) return;
    const double s = 0.5 * (from.s + to.s);
    const End middle{s, normal_at(surface, place(s))};
    close(surface, from, middle, depth + 1, out);
    out.push_back(place(s));
    close(surface, middle, to, depth + 1, out);
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
