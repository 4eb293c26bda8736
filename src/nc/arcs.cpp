#include "detail/arcs.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <fmt/format.h>

namespace trunnion::nc {

using Eigen::Vector3d;
using program::Arc;

namespace {

constexpr double whole_turn = 2 * std::numbers::pi;
constexpr double same_place_mm = 1e-6;  ///< ends that are nearer than this across the normal are one place
constexpr double smallest_radius_mm = 1e-3;
constexpr double largest_radius_mm = 1e7;  ///< rounding stays below 1e-8 mm
constexpr double most_turns = 1000;
constexpr double smallest_sine = 1e-9;  ///< three points that are nearer to a line have no circle

Result<Arc> refused(std::string_view code, std::string text, std::string value = {}, std::string limit = {},
                    std::string hint = {}) {
    return fail(Diagnostic{.code = std::string(code),
                           .text = std::move(text),
                           .value = std::move(value),
                           .limit = std::move(limit),
                           .hint = std::move(hint)});
}

Vector3d across(const Vector3d& way, const Vector3d& normal) {
    return way - way.dot(normal) * normal;
}

/// From one arm to another about the normal, in the sense wanted, more than nothing and about a whole turn at most.
double swept(const Vector3d& from, const Vector3d& to, const Vector3d& normal, bool clockwise) {
    const double sense = clockwise ? -1 : 1;
    const double angle = std::atan2(sense * normal.dot(from.cross(to)), from.dot(to));
    const bool whole = angle * from.norm() < same_place_mm;
    return sense * (whole ? angle + whole_turn : angle);
}

bool are_turns(double turns) {
    return turns >= 0 && turns <= most_turns && turns == std::floor(turns);
}

Result<Arc> too_large(double radius_mm) {
    return refused("NC0213", "a circle so large is not distinguished from a straight line",
                   fmt::format("{:.6g} mm", radius_mm), fmt::format("{:g} mm", largest_radius_mm),
                   "give a straight move");
}

Result<Arc> bad_turns(double turns) {
    return refused("NC0212", "the turns of a helix are a whole number", fmt::format("{}", turns),
                   fmt::format("0 … {}", most_turns));
}

}  // namespace

Result<Arc> arc_by_centre(const Vector3d& start, const Vector3d& end, const Vector3d& centre, const Vector3d& normal,
                          bool clockwise, double further_turns, const ArcTolerance& tolerance) {
    if (!are_turns(further_turns)) return bad_turns(further_turns);
    const Vector3d from = across(start - centre, normal), to = across(end - centre, normal);
    const double first = from.norm(), last = to.norm();
    if (!(std::min(first, last) >= smallest_radius_mm))
        return refused("NC0209", "a circle without radius: an end of it lies on the centre",
                       fmt::format("{:.6g} mm and {:.6g} mm from the centre", first, last),
                       fmt::format("{} mm", smallest_radius_mm), "check the centre");
    if (!(std::max(first, last) <= largest_radius_mm)) return too_large(std::max(first, last));
    const double allowed =
        std::min(tolerance.most_mm, std::max(tolerance.least_mm, tolerance.share * std::max(first, last)));
    if (!(std::abs(first - last) <= allowed))
        return refused("NC0207", "a circle whose radius does not fit its ends",
                       fmt::format("{:.6g} mm at the start, {:.6g} mm at the end", first, last),
                       fmt::format("{:.4g} mm of difference", allowed),
                       "check the centre: is it counted from the start or from zero?");
    const double angle = swept(from, to, normal, clockwise);
    return Arc{centre, normal, angle + std::copysign(whole_turn * further_turns, angle)};
}

Result<Arc> arc_by_radius(const Vector3d& start, const Vector3d& end, double radius_mm, const Vector3d& normal,
                          bool clockwise, double further_turns, const ArcTolerance& tolerance) {
    if (!are_turns(further_turns)) return bad_turns(further_turns);
    const double radius = std::abs(radius_mm);
    if (!(radius >= smallest_radius_mm))
        return refused("NC0209", "a circle without radius", fmt::format("{:.6g} mm", radius_mm),
                       fmt::format("{} mm", smallest_radius_mm));
    if (!(radius <= largest_radius_mm)) return too_large(radius);
    const Vector3d half = 0.5 * across(end - start, normal);
    const double half_chord = half.norm();
    if (!(2 * half_chord > same_place_mm))
        return refused("NC0210", "by its radius alone a circle from a point to the same point is not determined", {},
                       {}, "give the centre");
    if (!(half_chord - radius <= tolerance.short_mm))
        return refused("NC0208", "the radius is too small for the ends of the circle", fmt::format("{:.6g} mm", radius),
                       fmt::format("{:.6g} mm", half_chord));
    const double rise = half_chord < radius ? std::sqrt((radius - half_chord) * (radius + half_chord)) : 0;
    const bool long_way = radius_mm < 0;
    // Left of the chord, seen against the normal, lies the centre of the shorter way counter-clockwise.
    const Vector3d left = normal.cross(half / half_chord);
    const Vector3d centre = start + half + (clockwise == long_way ? rise : -rise) * left;
    const double half_angle = rise > 0 ? std::atan2(half_chord, rise) : std::numbers::pi / 2;
    const double angle = (long_way ? whole_turn - 2 * half_angle : 2 * half_angle) + whole_turn * further_turns;
    return Arc{centre, normal, clockwise ? -angle : angle};
}

Result<Arc> arc_through(const Vector3d& start, const Vector3d& via, const Vector3d& end) {
    const Vector3d a = via - start, b = end - start;
    const Vector3d area = a.cross(b);
    const double twice = area.norm();
    if (!(twice > smallest_sine * a.norm() * b.norm()) || !((end - via).norm() > smallest_sine * b.norm()))
        return refused("NC0211", "no circle goes through these three points: they lie on a line or coincide", {}, {},
                       "give a line, or the centre");
    const Vector3d centre =
        start + (a.squaredNorm() * b.cross(area) + b.squaredNorm() * area.cross(a)) / (2 * twice * twice);
    const Vector3d normal = area / twice;
    if (!((start - centre).norm() <= largest_radius_mm)) return too_large((start - centre).norm());
    return Arc{centre, normal, swept(start - centre, end - centre, normal, false)};
}

double square_of_way(const Arc& arc, const Vector3d& from, const Vector3d& step) {
    const Vector3d arm = from - arc.centre_mm;
    const double radius = (arm - arc.normal * arc.normal.dot(arm)).norm();
    return std::pow(radius * arc.angle_rad, 2) + std::pow(arc.normal.dot(step), 2);
}

}  // namespace trunnion::nc
