#include "detail/turned_over.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "trunnion/geometry/great_circle.hpp"

#include "detail/bernstein.hpp"
#include "detail/bezier_patch.hpp"
#include "detail/patch_polynomials.hpp"
#include "detail/tessellation.hpp"

namespace trunnion::surfacing::detail {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// A positive multiple of S_u × S_v of a patch, as a polynomial; taken about the patch's own middle, as far from the
/// origin digits are lost.
VectorBernstein normal_of(BezierPatch patch) {
    const Vector3d middle = patch.control.front().head<3>() / patch.control.front()[3];
    for (Eigen::Vector4d& c : patch.control) c.head<3>() -= c[3] * middle;
    const PatchPolynomials about_middle(patch);
    return cross(about_middle.along_u, about_middle.along_v);
}

/// Whether all normals of a patch are on one side of some plane, or some in it, as at an edge that is one point.
enum class Sides : std::uint8_t { one, one_or_none, both };

Sides sides_of(const VectorBernstein& normal) {
    constexpr double rounding = 1e-12;
    Vector3d mean = Vector3d::Zero();
    double largest = 0, least = std::numeric_limits<double>::infinity();
    normal.each([&](const Vector3d& c) { mean += c, largest = std::max(largest, c.norm()); });
    normal.each([&](const Vector3d& c) { least = std::min(least, c.dot(mean)); });
    const double slack = rounding * largest * mean.norm();
    if (mean.norm() <= rounding * largest) return largest > 0 ? Sides::both : Sides::one_or_none;
    return least > slack ? Sides::one : least >= -slack ? Sides::one_or_none : Sides::both;
}

double extent_mm(const BezierPatch& patch) {
    Vector3d low = patch.control.front().head<3>() / patch.control.front()[3], high = low;
    for (const Eigen::Vector4d& c : patch.control) {
        low = low.cwiseMin(c.head<3>() / c[3]);
        high = high.cwiseMax(c.head<3>() / c[3]);
    }
    return (high - low).norm();
}

class SideCheck {
  public:
    explicit SideCheck(const Face& face) : face_(face) {}

    /// Where normals are opposite; nothing where they are not.
    std::optional<Vector2d> look(const BezierPatch& patch, int depth = 0) {
        constexpr double smallest_mm = 0.002;
        constexpr int deepest = 48;
        const Sides sides = sides_of(normal_of(patch));
        if (sides == Sides::one || overlap(face_, patch.low, patch.high) == Overlap::none) return std::nullopt;
        if (sides == Sides::one_or_none) return over_edges(patch.low, patch.high);
        if (depth == deepest || extent_mm(patch) < smallest_mm) return judged(patch.low, patch.high);
        constexpr int most_halved = 20'000;
        if (++halved_ > most_halved) return std::nullopt;
        for (const BezierPatch& half : patch.halves(is_longer_along_u(patch)))
            if (auto found = look(half, depth + 1)) return found;
        return std::nullopt;
    }

    /// On both sides of a line on which a parameter is a knot.
    std::optional<Vector2d> across(const Vector2d& from, const Vector2d& to, const Vector2d& aside) const {
        for (const double share : {0.17, 0.5, 0.83}) {
            const Vector2d at = from + share * (to - from);
            if (is_opposite(at - aside, at + aside)) return at;
        }
        return std::nullopt;
    }

  private:
    /// Where normals vanish along an edge of a patch they may be opposite beyond it.
    std::optional<Vector2d> over_edges(const Vector2d& low, const Vector2d& high) const {
        constexpr double aside = 1e-6;
        const Vector2d u(high.x() - low.x(), 0), v(0, high.y() - low.y());
        const std::pair<Vector2d, bool> edges[] = {{low, true}, {low + v, true}, {low, false}, {low + u, false}};
        for (const auto& [from, along_u] : edges)
            if (auto found = across(from, from + (along_u ? u : v), aside * (along_u ? v : u))) return found;
        return std::nullopt;
    }

    static bool is_longer_along_u(const BezierPatch& patch) {
        double u = 0, v = 0;
        const auto point = [&](int i, int j) -> Vector3d { return patch.at(i, j).head<3>() / patch.at(i, j)[3]; };
        for (int i = 0; i <= patch.degree_u; ++i)
            for (int j = 0; j <= patch.degree_v; ++j) {
                if (i > 0) u = std::max(u, patch.degree_u * (point(i, j) - point(i - 1, j)).norm());
                if (j > 0) v = std::max(v, patch.degree_v * (point(i, j) - point(i, j - 1)).norm());
            }
        return u >= v;
    }

    bool is_opposite(const Vector2d& a, const Vector2d& b) const {
        constexpr double half_a_degree = std::numbers::pi / 360;
        if (!contains(face_, {a.x(), a.y()}) || !contains(face_, {b.x(), b.y()})) return false;
        const auto one = shape_at(face_.surface, {a.x(), a.y()}, face_.side);
        const auto other = shape_at(face_.surface, {b.x(), b.y()}, face_.side);
        return one && other && geometry::angle_between(one->normal, other->normal) > std::numbers::pi - half_a_degree &&
               goes_on(a, a - b, one->normal) && goes_on(b, b - a, other->normal);
    }

    /// Whether the face goes on with that normal: borders of real files turn back by less than a micron.
    bool goes_on(const Vector2d& from, Vector2d step, const Vector3d& normal) const {
        constexpr double wide_mm = 0.02;
        constexpr int most_doublings = 60;
        const Vector3d start = face_.surface.at(from.x(), from.y());
        for (int k = 0; k < most_doublings; ++k, step *= 2) {
            const Vector2d at = from + step;
            if (!contains(face_, {at.x(), at.y()})) return false;
            const auto shape = shape_at(face_.surface, {at.x(), at.y()}, face_.side);
            if (shape && (shape->point - start).norm() > wide_mm) return shape->normal.dot(normal) > 0;
        }
        return false;
    }

    std::optional<Vector2d> judged(const Vector2d& low, const Vector2d& high) const {
        const Vector2d corners[] = {low, {high.x(), low.y()}, high, {low.x(), high.y()}};
        for (const Vector2d& a : corners)
            for (const Vector2d& b : corners)
                if (is_opposite(a, b)) return a;
        return std::nullopt;
    }

    const Face& face_;
    int halved_ = 0;
};

/// Knots that a surface may have a crease at.
std::vector<double> creases(const geometry::SurfaceDirection& direction, double from, double to) {
    std::vector<double> out;
    for (const double knot : breaks_of(direction, from, to))
        if (knot > from && knot < to && std::ranges::count(direction.knots, knot) >= direction.degree)
            out.push_back(knot);
    return out;
}

std::optional<Vector2d> place_turned_over(const Face& face) {
    const ParameterBox box = parameter_box(face);
    const geometry::BsplineSurface& surface = face.surface;
    const Vector2d low = box.low.cwiseMax(Vector2d(surface.u().begin(), surface.v().begin()));
    const Vector2d high = box.high.cwiseMin(Vector2d(surface.u().end(), surface.v().end()));
    const auto u = breaks_of(surface.u(), low.x(), high.x()), v = breaks_of(surface.v(), low.y(), high.y());
    SideCheck check(face);
    for (const BezierPatch& patch : patches_of(surface, u, v))
        if (auto found = check.look(patch)) return found;
    constexpr double aside = 1e-9;
    const Vector2d size = aside * (high - low);
    for (const double at : creases(surface.u(), low.x(), high.x()))
        for (std::size_t k = 0; k + 1 < v.size(); ++k)
            if (auto found = check.across({at, v[k]}, {at, v[k + 1]}, {size.x(), 0})) return found;
    for (const double at : creases(surface.v(), low.y(), high.y()))
        for (std::size_t k = 0; k + 1 < u.size(); ++k)
            if (auto found = check.across({u[k], at}, {u[k + 1], at}, {0, size.y()})) return found;
    return std::nullopt;
}

}  // namespace

Result<void> check_side(const Face& face) {
    const auto place = place_turned_over(face);
    if (!place) return {};
    const Vector3d at = face.surface.at(place->x(), place->y());
    return fail(
        {.code = "SURF0211",
         .text = fmt::format("the face turns over at ({:.3f} {:.3f} {:.3f}): which side of it is to be machined "
                             "cannot be told",
                             at.x(), at.y(), at.z()),
         .value = fmt::format("normals opposite to each other at u = {:.6g}, v = {:.6g}", place->x(), place->y()),
         .hint = "a face that does not fold, or the part of it on one side of that place"});
}

}  // namespace trunnion::surfacing::detail
