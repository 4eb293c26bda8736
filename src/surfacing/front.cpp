#include "detail/front.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace trunnion::surfacing::detail {

using geometry::SurfacePlace;
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

double area_mm2(const geometry::BsplineSurface& surface, const ParameterBox& box) {
    constexpr int parts = 24;
    const Eigen::Vector2d cell = (box.high - box.low) / parts;
    double sum = 0;
    for (int i = 0; i < parts; ++i)
        for (int j = 0; j < parts; ++j) {
            const auto at = surface.evaluate(box.low.x() + (i + 0.5) * cell.x(), box.low.y() + (j + 0.5) * cell.y());
            sum += at.by_u.cross(at.by_v).norm() * cell.x() * cell.y();
        }
    return sum;
}

/// Whether the surface has normals all along a line of its parameters.
bool has_normals(const Job& job, const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
    for (const double share : {0.0, 0.3, 0.5, 0.7, 1.0}) {
        const Eigen::Vector2d at = from + share * (to - from);
        if (!job.shape({at.x(), at.y()})) return false;
    }
    return true;
}

/// The next place of a geodesic or plane section.
std::optional<SurfacePlace> step_along(const Job& job, const SurfacePlace& from, const SurfaceShape& shape,
                                       const Eigen::Vector3d& way, const Planes* plane) {
    const Eigen::Vector2d step = shape.parameters_along(way);
    SurfacePlace next{from.u + step.x(), from.v + step.y()};
    if (!plane) {
        // The straight line in the tangent plane, put onto the surface.
        next = geometry::closest_place(job.face.surface, shape.point + way, next, 1);
    } else if (const auto on = onto_plane(job, *plane, next)) {
        next = *on;
    } else {
        return std::nullopt;
    }
    const double gone = (job.face.surface.at(next.u, next.v) - shape.point).norm();
    const bool sound = gone > 0.5 * way.norm() && gone < 1.5 * way.norm();
    return sound ? std::optional(next) : std::nullopt;
}

/// Places onward from one, which is not among them, up to the first one outside of the field.
std::vector<SurfacePlace> onward(const Job& job, const Field& field, SurfacePlace place, Eigen::Vector3d direction,
                                 const Planes* plane) {
    std::vector<SurfacePlace> out;
    const auto most = static_cast<std::size_t>(field.longest_way_mm / field.spacing_mm) + 2;
    while (field.holds(place) && out.size() < most) {
        const auto shape = job.shape(place);
        if (!shape) break;
        const Eigen::Vector3d flat = direction - direction.dot(shape->normal) * shape->normal;
        const auto next = step_along(job, place, *shape, field.spacing_mm * flat.normalized(), plane);
        if (!next) break;
        const Eigen::Vector3d gone = job.face.surface.at(next->u, next->v) - shape->point;
        direction = plane ? gone : Eigen::Vector3d(flat);
        out.push_back(*next);
        place = *next;
    }
    return out;
}

std::vector<SurfacePlace> joined(const std::vector<SurfacePlace>& back, const std::vector<SurfacePlace>& middle,
                                 const std::vector<SurfacePlace>& ahead) {
    std::vector<SurfacePlace> out(back.rbegin(), back.rend());
    out.insert(out.end(), middle.begin(), middle.end());
    out.insert(out.end(), ahead.begin(), ahead.end());
    return out;
}

}  // namespace

Result<Field> field_of(const Job& job) {
    const geometry::BsplineSurface& surface = job.face.surface;
    const ParameterBox& inside = job.box;
    const Eigen::Vector2d middle = 0.5 * (inside.low + inside.high), half = 0.5 * (inside.high - inside.low);
    Field field{.box = inside, .middle = middle, .face_box_mm2 = area_mm2(surface, inside)};
    double longest = 0;
    const auto shape = job.shape({middle.x(), middle.y()});
    if (!shape)
        return fail({.code = "SURF0205", .text = "the surface has no normal in the face's middle, where passes begin"});
    for (int k = 0; k < 2; ++k) {
        const Eigen::Vector2d way = k == 0 ? Eigen::Vector2d(half.x(), 0) : Eigen::Vector2d(0, half.y());
        const double length = line_length_mm(surface, middle - way, middle + way);
        longest = std::max(longest, length);
        for (const double side : {-1.0, 0.0, 1.0}) {
            const Eigen::Vector2d shift = side * Eigen::Vector2d(half.x() - way.x(), half.y() - way.y());
            constexpr double detour = 2;
            field.longest_way_mm += detour * line_length_mm(surface, middle + shift - way, middle + shift + way);
        }
        constexpr double margin_share = 0.05;
        const double margin = margin_share * 2 * half[k];
        const Eigen::Vector2d side(half.x() - way.x(), half.y() - way.y());
        const auto bears = [&](const Eigen::Vector2d& end) { return has_normals(job, end - side, end + side); };
        // Beyond a border that is one point there is nothing; ways end just before it.
        field.box.low[k] -= bears(middle - way) ? margin : -1e-4 * half[k];
        field.box.high[k] += bears(middle + way) ? margin : -1e-4 * half[k];
    }
    field.spacing_mm = std::min(std::max(2.0, spacing_share * job.cutter.radius_mm()), longest / places_across);
    return field;
}

std::optional<SurfacePlace> onto_plane(const Job& job, const Planes& plane, SurfacePlace place) {
    for (int step = 0; step < 8; ++step) {
        const auto shape = job.shape(place);
        if (!shape) return std::nullopt;
        const double off = plane.offset_mm - plane.normal.dot(shape->point);
        if (std::abs(off) < 1e-10) return place;
        const Eigen::Vector3d rise = plane.normal - plane.normal.dot(shape->normal) * shape->normal;
        constexpr double flattest = 0.02;
        if (rise.norm() < flattest) return std::nullopt;
        const Eigen::Vector2d way = shape->parameters_along(off / rise.squaredNorm() * rise);
        place = {place.u + way.x(), place.v + way.y()};
    }
    return place;
}

Way way_through(const Job& job, const Field& field, const SurfacePlace& place, const Eigen::Vector3d& direction,
                const Planes* plane) {
    const auto back = onward(job, field, place, -direction, plane), ahead = onward(job, field, place, direction, plane);
    return Way(job.face.surface, joined(back, {place}, ahead)).resampled(job.face.surface, field.spacing_mm);
}

std::optional<Way> way_of_moved(const Job& job, const Field& field, const Way& before,
                                const std::vector<std::optional<SurfacePlace>>& moved) {
    std::vector<SurfacePlace> kept;
    std::vector<Eigen::Vector3d> points;
    for (std::size_t i = 0; i < moved.size(); ++i) {
        if (!moved[i] || !field.holds(*moved[i])) continue;
        const Eigen::Vector3d point = job.face.surface.at(moved[i]->u, moved[i]->v);
        const auto station = job.station(before, before.lengths()[i], false);
        constexpr double least_progress = 0.05;
        const bool ahead = points.empty() || !station ||
                           (point - points.back()).dot(station->along) > least_progress * field.spacing_mm;
        if (!ahead) continue;
        kept.push_back(*moved[i]);
        points.push_back(point);
    }
    if (kept.size() < 2) return std::nullopt;
    const Way core(job.face.surface, kept);
    if (core.places().size() < 2) return std::nullopt;
    const auto first = job.station(core, 0, false), last = job.station(core, core.length(), false);
    if (!first || !last) return std::nullopt;
    const auto back = onward(job, field, kept.front(), -first->along, nullptr);
    const auto ahead = onward(job, field, kept.back(), last->along, nullptr);
    return Way(job.face.surface, joined(back, kept, ahead)).resampled(job.face.surface, field.spacing_mm);
}

Way parameter_way(const Job& job, const Field& field, bool along_u, double at) {
    const int k = along_u ? 0 : 1;
    constexpr int steps = 200;
    std::vector<SurfacePlace> places;
    for (int i = 0; i <= steps; ++i) {
        const double x = field.box.low[k] + (field.box.high[k] - field.box.low[k]) * i / steps;
        places.push_back(along_u ? SurfacePlace{x, at} : SurfacePlace{at, x});
    }
    return Way(job.face.surface, std::move(places)).resampled(job.face.surface, field.spacing_mm);
}

}  // namespace trunnion::surfacing::detail
