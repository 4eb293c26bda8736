#include "detail/border_strip.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/Geometry>

#include "trunnion/surfacing/path_interval.hpp"

#include "detail/node.hpp"
#include "detail/passes.hpp"

namespace trunnion::surfacing::detail {

using Eigen::Vector3d;

namespace {

constexpr double on_border_mm = 0.01;
/// Of an interval, from pass to pass of a strip: where two strips cross, both kinds of passes end.
constexpr double strip_share = 0.6;

/// Strips along one border.
class Strip {
  public:
    Strip(const Job& job, int face, const Way& border)
        : job_(job), face_(face), way_(border.resampled(0.1 * job.cutter.radius_mm())) {
        for (const double s : way_.lengths()) {
            stations_.push_back(job.station(way_, s, false));
            if (const auto& at = stations_.back(); at && check_fit(job, *at))
                interval_mm_ = std::min(interval_mm_, interval_mm(at->shape, at->pose.axis, at->across));
        }
    }

    /// Between the border and the last place of a ridge that passes cut which end here.
    double width_mm(std::span<const Pass> passes) const {
        double widest = 0;
        for (const Pass& pass : passes) {
            const auto& at = pass.contacts;
            if (pass.index < 0) continue;
            widest = std::max({widest, width_mm(at.front(), at[1]), width_mm(at.back(), at[at.size() - 2])});
        }
        return widest;
    }

    Result<void> append(double width_mm, std::vector<Pass>& passes) const {
        // Half an interval beside it the pass along the border cuts itself.
        if (!(width_mm > 0.5 * interval_mm_)) return {};
        const double step = strip_share * interval_mm_, count = std::ceil(width_mm / step);
        if (!(count <= most_ways)) return too_many_ways();
        const int side = inner_side(step);
        for (int k = 1; k <= static_cast<int>(count); ++k) {
            constexpr int forwards = -2;
            const std::size_t first = passes.size();
            const Way way = beside(side * k * step);
            if (way.places().size() < 2) return {};
            if (auto done = append_passes(job_, way, forwards, passes); !done) return done;
            for (std::size_t i = first; i < passes.size(); ++i) passes[i].index = -1;
        }
        return {};
    }

  private:
    double interval_mm(const geometry::SurfaceShape& at, const Vector3d& axis, const Vector3d& across) const {
        return path_interval_mm(job_.cutter, at, axis, at.components(across), job_.ridge_mm());
    }

    /// Of one end of a pass: half its interval in the direction d = n + t f conjugate to the feed f, away from here; no
    /// farther than the tool's end reaches.
    double width_mm(const Contact& end, const Contact& next) const {
        if (end.face != face_) return 0;
        const auto shape = job_.shape({end.place});
        if (!shape) return 0;
        const auto s = way_.nearest({end.place}, *shape);
        if (!s || (job_.region.at(way_.place(*s)) - end.point_mm).norm() > on_border_mm) return 0;
        const Vector3d back = next.point_mm - end.point_mm;
        const Vector3d feed = (back - back.dot(shape->normal) * shape->normal).normalized();
        const Vector3d across = shape->normal.cross(feed);
        const Eigen::Matrix2d parted = parting(job_.cutter, *shape, end.pose.axis);
        const Eigen::Vector2d f = shape->components(feed), n = shape->components(across);
        if (!(geometry::principal_curvatures(parted).smaller > 0)) return 0;  // it does not fit, and leaves no ridges
        const Vector3d conjugate = across - n.dot(parted * f) / f.dot(parted * f) * feed;
        const Eigen::Vector2d slope = way_.slope(*s);
        const Vector3d tangent = (slope.x() * shape->by_u + slope.y() * shape->by_v).normalized();
        const double half_mm = 0.5 * interval_mm(*shape, end.pose.axis, across);
        return std::min(half_mm * std::abs(conjugate.dot(shape->normal.cross(tangent))), 2 * job_.cutter.radius_mm());
    }

    /// To which side of the border the face lies: +1 where its stations' across direction leads.
    int inner_side(double step) const {
        const auto within = [&](int side) {
            return std::ranges::count_if(beside(side * step).places(),
                                         [&](const Place& place) { return job_.region.contains(place); });
        };
        return within(1) >= within(-1) ? 1 : -1;
    }

    /// The way moved across by a distance: on the circle of the surface's curvature, then onto the surface.
    Way beside(double distance_mm) const {
        std::vector<Place> places;
        for (const std::optional<Station>& at : stations_) {
            if (!at) continue;
            const double bend = at->shape.normal_curvature(at->shape.components(at->across));
            const double sine = std::clamp(0.5 * distance_mm * bend, -0.9, 0.9);
            const Vector3d way = distance_mm * std::sqrt(1 - sine * sine) * at->across;
            const Eigen::Vector2d guess = at->shape.parameters_along(way);
            places.push_back(job_.region.closest(at->shape.point + way - distance_mm * sine * at->shape.normal,
                                                 {{at->place.u + guess.x(), at->place.v + guess.y()}}));
        }
        return {job_.region, places};
    }

    const Job& job_;
    int face_;
    Way way_;
    std::vector<std::optional<Station>> stations_;
    double interval_mm_ = std::numeric_limits<double>::infinity();
};

}  // namespace

Result<void> append_strip_passes(const Job& job, int face, std::span<const Way> borders, std::vector<Pass>& passes) {
    if (job.cutter.is_ball() || job.options.lead_rad == 0 || job.options.tilt_rad == 0) return {};
    const std::size_t planned = passes.size();
    for (const Way& border : borders) {
        const Strip strip(job, face, border);
        if (auto done = strip.append(strip.width_mm({passes.data(), planned}), passes); !done) return done;
    }
    return {};
}

}  // namespace trunnion::surfacing::detail
