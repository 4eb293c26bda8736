#include "detail/way.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/Geometry>

namespace trunnion::surfacing::detail {

namespace {

Eigen::Vector2d as_vector(const geometry::SurfacePlace& place) noexcept {
    return {place.u, place.v};
}

Place on_chart(const Eigen::Vector2d& at, int chart) noexcept {
    return {{at.x(), at.y()}, chart};
}

}  // namespace

Way::Way(const Region& region, const std::vector<Place>& places) : region_(&region) {
    for (const Place& place : places) {
        const Eigen::Vector3d point = region.at(place);
        const bool first = places_.empty(), over = !first && places_.back().chart != place.chart;
        const double step = first || over ? 0 : (point - points_.back()).norm();
        if (!first && !over && !(step > 1e-9)) continue;
        if (first || over) begins_.push_back(places_.size());
        lengths_.push_back(first ? 0 : lengths_.back() + step);
        points_.push_back(point);
        places_.push_back(place);
    }
    gather();
}

void Way::gather() {
    constexpr std::size_t steps = 16;
    for (std::size_t begin = 0; begin + 1 < points_.size(); begin += steps) {
        const std::size_t end = std::min(begin + steps, points_.size() - 1);
        Part part{points_[(begin + end) / 2], 0, begin, end};
        for (std::size_t k = begin; k <= end; ++k)
            part.radius = std::max(part.radius, (points_[k] - part.middle).norm());
        parts_.push_back(part);
    }
}

std::size_t Way::arc_of(std::size_t place) const noexcept {
    if (begins_.size() == 1) return 0;
    return static_cast<std::size_t>(std::ranges::upper_bound(begins_, place) - begins_.begin()) - 1;
}

Eigen::Vector2d Way::slope_at_place(std::size_t i) const noexcept {
    return slope_within(arc_of(i), i);
}

/// Of the parabola through a node and its neighbours.
Eigen::Vector2d Way::slope_within(std::size_t arc, std::size_t i) const noexcept {
    const std::size_t begin = arc_begin(arc), n = arc_end(arc) - begin;
    const auto rise = [&](std::size_t k) -> Eigen::Vector2d {
        return (as_vector(places_[k + 1]) - as_vector(places_[k])) / (lengths_[k + 1] - lengths_[k]);
    };
    if (n < 2) return {0, 0};
    if (n == 2) return rise(begin);
    const std::size_t middle = std::clamp<std::size_t>(i, begin + 1, begin + n - 2);
    const double before = lengths_[middle] - lengths_[middle - 1], after = lengths_[middle + 1] - lengths_[middle];
    const Eigen::Vector2d bend = (rise(middle) - rise(middle - 1)) / (before + after);
    const double at = lengths_[i] - lengths_[middle];
    return rise(middle - 1) + (before + 2 * at) * bend;
}

/// A cubic between two nodes.
struct Way::Piece {
    Eigen::Vector2d from, to, slope_from, slope_to;
    double length, w;
    int chart;

    Eigen::Vector2d value() const noexcept {
        const double a = (1 + 2 * w) * (1 - w) * (1 - w), b = w * w * (3 - 2 * w);
        return a * from + b * to + length * (w * (1 - w) * (1 - w) * slope_from - w * w * (1 - w) * slope_to);
    }
    Eigen::Vector2d slope() const noexcept {
        return 6 * w * (1 - w) / length * (to - from) + (1 - w) * (1 - 3 * w) * slope_from + w * (3 * w - 2) * slope_to;
    }
};

Way::Piece Way::piece(double s, std::size_t k, std::size_t arc) const noexcept {
    const double length = lengths_[k + 1] - lengths_[k];
    return {
        as_vector(places_[k]),      as_vector(places_[k + 1]), slope_within(arc, k), slope_within(arc, k + 1), length,
        (s - lengths_[k]) / length, places_[k].chart};
}

Way::Piece Way::piece_at(double s) const noexcept {
    const auto after = std::upper_bound(lengths_.begin() + 1, lengths_.end() - 1, s);
    const auto k = static_cast<std::size_t>(after - lengths_.begin()) - 1;
    return piece(s, k, arc_of(k));
}

Way::Piece Way::piece_at(double s, std::size_t arc) const noexcept {
    const auto at = [this](std::size_t i) { return lengths_.begin() + static_cast<std::ptrdiff_t>(i); };
    const auto after = std::upper_bound(at(arc_begin(arc) + 1), at(arc_end(arc) - 1), s);
    return piece(s, static_cast<std::size_t>(after - lengths_.begin()) - 1, arc);
}

Place Way::place(double s) const noexcept {
    const Piece at = piece_at(s);
    return on_chart(at.value(), at.chart);
}

Place Way::place(double s, std::size_t arc) const noexcept {
    const Piece at = piece_at(s, arc);
    return on_chart(at.value(), at.chart);
}

Eigen::Vector2d Way::slope(double s) const noexcept {
    return piece_at(s).slope();
}

Eigen::Vector2d Way::slope(double s, std::size_t arc) const noexcept {
    return piece_at(s, arc).slope();
}

/// `accept`: whether a foot counts, asked of those alone that are nearer than all before: step and share of it.
template <class Accept>
Way::Foot Way::foot_of(const Eigen::Vector3d& point, const Accept& accept) const noexcept {
    Foot foot{0, std::numeric_limits<double>::infinity()};
    const auto on = [&](const Part& part) {
        for (std::size_t k = part.begin; k < part.end; ++k) {
            if (leads_over(k)) continue;
            const Eigen::Vector3d way = points_[k + 1] - points_[k];
            const double w = std::clamp((point - points_[k]).dot(way) / way.squaredNorm(), 0.0, 1.0);
            const double off = (points_[k] + w * way - point).squaredNorm();
            if (off < foot.squared && accept(k, w, off))
                foot = {lengths_[k] + w * (lengths_[k + 1] - lengths_[k]), off};
        }
    };
    const auto apart = [&](const Part& part) { return (point - part.middle).norm() - part.radius; };
    const auto first = std::ranges::min_element(parts_, {}, apart);
    if (first != parts_.end()) on(*first);
    for (auto part = parts_.begin(); part != parts_.end(); ++part)
        if (const double off = apart(*part); part != first && (off <= 0 || off * off < foot.squared)) on(*part);
    return foot;
}

std::optional<double> Way::nearest(const Place& from, const geometry::SurfaceShape& shape) const noexcept {
    constexpr double farther = 3, slack_mm = 1e-3;  // curved and unevenly drawn surfaces are longer than a chord
    const auto on_face = [&](std::size_t k, double w, double squared) {
        const Eigen::Vector2d off = (1 - w) * as_vector(places_[k]) + w * as_vector(places_[k + 1]) - as_vector(from);
        const double on_surface = (off.x() * shape.by_u + off.y() * shape.by_v).norm();
        return on_surface <= farther * std::sqrt(squared) + slack_mm;
    };
    // From face to face it leads over joints, which are no farther off then.
    const auto over_joints = [&](std::size_t k, double w, double squared) {
        const double off = std::sqrt(squared), most = farther * off + slack_mm;
        const int chart = places_[k].chart;
        if (region_->to_joint_mm(from.chart, shape.point) > most) return false;
        if (region_->to_joint_mm(chart, points_[k] + w * (points_[k + 1] - points_[k])) > most) return false;
        const Eigen::Vector2d at = (1 - w) * as_vector(places_[k]) + w * as_vector(places_[k + 1]);
        const auto normal = normal_at(on_chart(at, chart));
        return normal && normal->dot(shape.normal) > 0;
    };
    const Foot foot = foot_of(shape.point, [&](std::size_t k, double w, double squared) {
        return places_[k].chart == from.chart ? on_face(k, w, squared) : over_joints(k, w, squared);
    });
    return std::isfinite(foot.squared) ? std::optional(foot.s) : std::nullopt;
}

double Way::distance_mm(const Eigen::Vector3d& point) const noexcept {
    return std::sqrt(foot_of(point, [](auto...) { return true; }).squared);
}

std::optional<Eigen::Vector3d> Way::normal_at(const Place& place) const {
    const auto shape = region_->shape(place);
    return shape ? std::optional(shape->normal) : std::nullopt;
}

Way Way::resampled(double spacing) const {
    if (places_.size() < 2) return *this;
    std::vector<Place> out;
    for (std::size_t arc = 0; arc < arcs(); ++arc) resample(arc, spacing, out);
    return {*region_, out};
}

void Way::resample(std::size_t arc, double spacing, std::vector<Place>& out) const {
    const double from = lengths_[arc_begin(arc)], length = lengths_[arc_end(arc) - 1] - from;
    if (!(length > 0)) return;
    const int least = arcs() > 1 ? 1 : 2, steps = std::max(least, static_cast<int>(std::ceil(length / spacing)));
    const double step = length / steps;
    out.push_back(places_[arc_begin(arc)]);
    auto before = normal_at(out.back());
    for (int k = 1; k <= steps; ++k) {
        const Place at = k == steps ? places_[arc_end(arc) - 1] : place(from + k * step, arc);
        const auto here = normal_at(at);
        close(arc, {from + (k - 1) * step, before}, {from + k * step, here}, 0, out);
        out.push_back(at);
        before = here;
    }
}

/// Places between two ends between which the surface turns too far.
void Way::close(std::size_t arc, const End& from, const End& to, int depth, std::vector<Place>& out) const {
    constexpr double most_turn_rad = 0.2;
    constexpr int deepest = 6;
    if (depth == deepest || !from.normal || !to.normal) return;
    if (from.normal->dot(*to.normal) > std::cos(most_turn_rad)) return;
    const double s = 0.5 * (from.s + to.s);
    const Place at = place(s, arc);
    const End middle{s, normal_at(at)};
    close(arc, from, middle, depth + 1, out);
    out.push_back(at);
    close(arc, middle, to, depth + 1, out);
}

std::optional<Station> Job::station(const Place& place, const Eigen::Vector2d& slope, bool backwards) const noexcept {
    const auto shape = this->shape(place);
    if (!shape) return std::nullopt;
    return standing(place, *shape, (slope.x() * shape->by_u + slope.y() * shape->by_v).normalized(), backwards);
}

Station Job::standing(const Place& place, const geometry::SurfaceShape& shape, const Eigen::Vector3d& along,
                      bool backwards) const noexcept {
    const Eigen::Vector3d across = shape.normal.cross(along);
    const double lead = backwards ? -options.lead_rad : options.lead_rad;
    const Eigen::Vector3d axis =
        (shape.normal + std::tan(lead) * along + std::tan(options.tilt_rad) * across).normalized();
    return {place, shape, along, across, cutter.touching(shape.point, shape.normal, axis)};
}

}  // namespace trunnion::surfacing::detail
