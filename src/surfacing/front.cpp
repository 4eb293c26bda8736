#include "detail/front.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "detail/node.hpp"

namespace trunnion::surfacing::detail {

using geometry::SurfaceShape;

namespace {

constexpr double places_across = 100;
constexpr double spacing_share = 0.2;  ///< of the tool's radius

double line_length_mm(const geometry::BsplineSurface& surface, const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
    constexpr int parts = 32;
    double sum = 0;
    for (int k = 0; k < parts; ++k) {
        const Eigen::Vector2d a = from + (to - from) * k / parts, b = from + (to - from) * (k + 1) / parts;
        sum += (surface.at(b.x(), b.y()) - surface.at(a.x(), a.y())).norm();
    }
    return sum;
}

double area_mm2(const Region& region, int chart) {
    constexpr int parts = 24;
    const ParameterBox& box = region.box(chart);
    const Eigen::Vector2d cell = (box.high - box.low) / parts;
    double sum = 0;
    for (int i = 0; i < parts; ++i)
        for (int j = 0; j < parts; ++j) {
            const Place place{{box.low.x() + (i + 0.5) * cell.x(), box.low.y() + (j + 0.5) * cell.y()}, chart};
            if (!region.is_before_joints(place)) continue;
            const auto at = region.face(chart).surface.evaluate(place.u, place.v);
            sum += at.by_u.cross(at.by_v).norm() * cell.x() * cell.y();
        }
    return sum;
}

/// Whether the surface has normals all along a line of its parameters.
bool has_normals(const Job& job, int chart, const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
    for (const double share : {0.0, 0.3, 0.5, 0.7, 1.0}) {
        const Eigen::Vector2d at = from + share * (to - from);
        if (!job.shape({{at.x(), at.y()}, chart})) return false;
    }
    return true;
}

/// The next place of a geodesic or plane section.
std::optional<Place> step_along(const Job& job, const Place& from, const SurfaceShape& shape,
                                const Eigen::Vector3d& way, const Planes* plane) {
    const Eigen::Vector2d step = shape.parameters_along(way);
    Place next{{from.u + step.x(), from.v + step.y()}, from.chart};
    if (!plane) {
        // The straight line in the tangent plane, put onto the surface.
        next = job.region.closest(shape.point + way, next);
    } else if (const auto on = onto_plane(job, *plane, next)) {
        next = *on;
    } else {
        return std::nullopt;
    }
    const double gone = (job.region.at(next) - shape.point).norm();
    const bool sound = gone > 0.5 * way.norm() && gone < 1.5 * way.norm();
    return sound ? std::optional(next) : std::nullopt;
}

/// How fast the front of passes with a feed runs along a joint: the interval over the share of it that is across it.
double pace_mm(const Job& job, const SurfaceShape& at, const Eigen::Vector3d& feed, const Eigen::Vector3d& joint) {
    const Station station = job.standing({}, at, feed, false);
    return interval_mm(job, station, station.pose.axis, station.across, job.ridge_mm()) / station.across.dot(joint);
}

/// The feed behind a joint. Passes have to meet there again and again, so both fronts run along it as fast: like light,
/// passes are bent towards the face on which they are closer. Where they hardly cross the joint they go on straight.
Eigen::Vector3d refracted(const Job& job, const Place& before, const Place& behind, const Eigen::Vector3d& feed) {
    const auto from = job.shape(before), to = job.shape(behind);
    const auto joint = from ? job.region.joint_along(before.chart, behind.chart, from->point) : std::nullopt;
    if (!to || !joint) return feed;
    const Eigen::Vector3d ahead = (feed - feed.dot(to->normal) * to->normal).normalized();
    const Eigen::Vector3d across = to->normal.cross(ahead);
    constexpr double most_rad = 0.5, along_it = 0.2;
    if (std::abs(across.dot(*joint)) < along_it) return feed;
    const double wanted = pace_mm(job, *from, feed.normalized(), *joint);
    const auto turned = [&](double angle) -> Eigen::Vector3d {
        return std::cos(angle) * ahead + std::sin(angle) * across;
    };
    const auto off = [&](double angle) { return 1 / pace_mm(job, *to, turned(angle), *joint) - 1 / wanted; };
    double low = -most_rad, high = most_rad;
    const bool rises = off(high) > 0;
    if ((off(low) > 0) == rises) return feed;
    for (int halving = 0; halving < 40; ++halving) {
        const double middle = 0.5 * (low + high);
        ((off(middle) > 0) == rises ? high : low) = middle;
    }
    return turned(low);
}

/// Places onward from one, which is not among them, up to the first one outside of the field.
std::vector<Place> onward(const Job& job, const Field& field, Place place, Eigen::Vector3d direction,
                          const Planes* plane) {
    std::vector<Place> out;
    const auto most = static_cast<std::size_t>(field.longest_way_mm / field.spacing_mm) + 2;
    while (field.holds(place) && out.size() < most) {
        const auto shape = job.shape(place);
        if (!shape) break;
        const Eigen::Vector3d flat = direction - direction.dot(shape->normal) * shape->normal;
        const auto next = step_along(job, place, *shape, field.spacing_mm * flat.normalized(), plane);
        if (!next) break;
        const Eigen::Vector3d gone = job.region.at(*next) - shape->point;
        direction = plane ? gone : Eigen::Vector3d(flat);
        if (next->chart != place.chart) direction = refracted(job, place, *next, direction);
        out.push_back(*next);
        place = *next;
    }
    return out;
}

Way way_of(const Job& job, const Field& field, const std::vector<Place>& back, const std::vector<Place>& middle,
           const std::vector<Place>& ahead) {
    std::vector<Place> all(back.rbegin(), back.rend());
    all.insert(all.end(), middle.begin(), middle.end());
    all.insert(all.end(), ahead.begin(), ahead.end());
    return Way(job.region, job.region.jointed(std::move(all), field.spacing_mm)).resampled(field.spacing_mm);
}

/// Widens the field by a face; returns the longer of its middle lines, mm.
double take_in(const Job& job, int chart, Field& field) {
    const geometry::BsplineSurface& surface = job.region.face(chart).surface;
    const ParameterBox& inside = job.region.box(chart);
    const Eigen::Vector2d middle = 0.5 * (inside.low + inside.high), half = 0.5 * (inside.high - inside.low);
    ParameterBox box = inside;
    double longest = 0;
    for (int k = 0; k < 2; ++k) {
        const Eigen::Vector2d way = k == 0 ? Eigen::Vector2d(half.x(), 0) : Eigen::Vector2d(0, half.y());
        longest = std::max(longest, line_length_mm(surface, middle - way, middle + way));
        for (const double side : {-1.0, 0.0, 1.0}) {
            const Eigen::Vector2d shift = side * Eigen::Vector2d(half.x() - way.x(), half.y() - way.y());
            constexpr double detour = 2;
            field.longest_way_mm += detour * line_length_mm(surface, middle + shift - way, middle + shift + way);
        }
        constexpr double margin_share = 0.05;
        const double margin = margin_share * 2 * half[k];
        const Eigen::Vector2d side(half.x() - way.x(), half.y() - way.y());
        const auto bears = [&](const Eigen::Vector2d& end) { return has_normals(job, chart, end - side, end + side); };
        // Beyond a border that is one point there is nothing; ways end just before it.
        box.low[k] -= bears(middle - way) ? margin : -1e-4 * half[k];
        box.high[k] += bears(middle + way) ? margin : -1e-4 * half[k];
    }
    field.boxes.push_back(box);
    field.face_box_mm2 += area_mm2(job.region, chart);
    return longest;
}

/// Ridges change beside a joint within about half an interval: places much farther apart than an interval miss that,
/// and closer ones follow noise.
double close_enough_for_joints(const Job& job, double spacing, double longest) {
    double least = std::numeric_limits<double>::infinity();
    for (int chart = 0; chart < job.region.charts(); ++chart) {
        const Eigen::Vector2d middle = 0.5 * (job.region.box(chart).low + job.region.box(chart).high);
        const Place place{{middle.x(), middle.y()}, chart};
        const auto shape = job.shape(place);
        for (int k = 0; shape && k < 2; ++k) {
            const Station at = job.standing(place, *shape, k == 0 ? shape->e1 : shape->e2, false);
            least = std::min(least, interval_mm(job, at, at.pose.axis, at.across, job.ridge_mm()));
        }
    }
    constexpr double finer = 4, coarser = 2.5;
    return std::clamp(least, std::min(spacing, longest / (finer * places_across)),
                      std::max(spacing, coarser * longest / places_across));
}

}  // namespace

Result<Field> field_of(const Job& job) {
    const ParameterBox& first = job.region.box(0);
    const Eigen::Vector2d middle = 0.5 * (first.low + first.high);
    Field field{.boxes = {}, .middle = {{middle.x(), middle.y()}, 0}};
    if (!job.region.is_before_joints(field.middle))
        field.middle = job.region.closest(job.region.at(field.middle), field.middle);
    if (!job.shape(field.middle))
        return fail({.code = "SURF0205", .text = "the surface has no normal in the face's middle, where passes begin"});
    double longest = 0;
    for (int chart = 0; chart < job.region.charts(); ++chart) longest = std::max(longest, take_in(job, chart, field));
    field.spacing_mm = std::min(std::max(2.0, spacing_share * job.cutter.radius_mm()), longest / places_across);
    if (job.region.charts() > 1) field.spacing_mm = close_enough_for_joints(job, field.spacing_mm, longest);
    return field;
}

std::optional<Place> onto_plane(const Job& job, const Planes& plane, Place place) {
    for (int step = 0; step < 8; ++step) {
        const auto shape = job.shape(place);
        if (!shape) return std::nullopt;
        const double off = plane.offset_mm - plane.normal.dot(shape->point);
        if (std::abs(off) < 1e-10) return place;
        const Eigen::Vector3d rise = plane.normal - plane.normal.dot(shape->normal) * shape->normal;
        constexpr double flattest = 0.02;
        if (rise.norm() < flattest) return std::nullopt;
        const Eigen::Vector2d way = shape->parameters_along(off / rise.squaredNorm() * rise);
        place = {{place.u + way.x(), place.v + way.y()}, place.chart};
    }
    return place;
}

Way way_through(const Job& job, const Field& field, const Place& place, const Eigen::Vector3d& direction,
                const Planes* plane) {
    const auto back = onward(job, field, place, -direction, plane), ahead = onward(job, field, place, direction, plane);
    return way_of(job, field, back, {place}, ahead);
}

std::optional<Way> way_of_moved(const Job& job, const Field& field, const Way& before,
                                const std::vector<std::optional<Place>>& moved) {
    std::vector<Place> kept;
    std::vector<Eigen::Vector3d> points;
    for (std::size_t i = 0; i < moved.size(); ++i) {
        if (!moved[i] || !field.holds(*moved[i])) continue;
        const Eigen::Vector3d point = job.region.at(*moved[i]);
        const auto station = job.station_at_place(before, i, false);
        constexpr double least_progress = 0.05;
        const bool ahead = points.empty() || !station ||
                           (point - points.back()).dot(station->along) > least_progress * field.spacing_mm;
        if (!ahead) continue;
        kept.push_back(*moved[i]);
        points.push_back(point);
    }
    if (kept.size() < 2) return std::nullopt;
    const Way core(job.region, job.region.jointed(kept, field.spacing_mm));
    if (core.places().size() < 2) return std::nullopt;
    const auto first = job.station_at_place(core, 0, false),
               last = job.station_at_place(core, core.places().size() - 1, false);
    if (!first || !last) return std::nullopt;
    const auto back = onward(job, field, kept.front(), -first->along, nullptr);
    const auto ahead = onward(job, field, kept.back(), last->along, nullptr);
    return way_of(job, field, back, kept, ahead);
}

Way parameter_way(const Job& job, const Field& field, bool along_u, double at) {
    const int k = along_u ? 0 : 1;
    constexpr int steps = 200;
    const ParameterBox& box = field.boxes.front();
    std::vector<Place> places;
    for (int i = 0; i <= steps; ++i) {
        const double x = box.low[k] + (box.high[k] - box.low[k]) * i / steps;
        places.push_back(along_u ? Place{{x, at}} : Place{{at, x}});
    }
    return Way(job.region, places).resampled(field.spacing_mm);
}

}  // namespace trunnion::surfacing::detail
