#include "trunnion/geometry/surface_shape.hpp"

#include <cmath>
#include <limits>

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace trunnion::geometry {

Eigen::Vector2d SurfaceShape::parameters_along(const Eigen::Vector3d& tangent) const noexcept {
    const Eigen::Vector2d along(tangent.dot(by_u), tangent.dot(by_v));
    return {(first(1, 1) * along[0] - first(0, 1) * along[1]) / first.determinant(),
            (first(0, 0) * along[1] - first(0, 1) * along[0]) / first.determinant()};
}

PrincipalCurvatures principal_curvatures(const Eigen::Matrix2d& shape) noexcept {
    const double mean = 0.5 * (shape(0, 0) + shape(1, 1)), half = 0.5 * (shape(0, 0) - shape(1, 1));
    const double spread = std::hypot(half, shape(0, 1));
    PrincipalCurvatures out{.larger = mean + spread, .smaller = mean - spread};
    if (spread > 0) {
        const double angle = 0.5 * std::atan2(shape(0, 1), half);
        out.direction = {std::cos(angle), std::sin(angle)};
    }
    return out;
}

double conjugate_radius(const Eigen::Matrix2d& shape, const Eigen::Vector2d& across) noexcept {
    const Eigen::Vector2d feed(-across[1], across[0]);
    const double along = feed.dot(shape * feed), mixed = across.dot(shape * feed), over = across.dot(shape * across);
    // Along the rulings of a developable surface nothing bends along the feed, and the mixed share is rounding.
    const double curvature = std::abs(along) <= 1e-12 * over ? over : over - mixed * mixed / along;
    return curvature > 0 ? 1 / curvature : std::numeric_limits<double>::infinity();
}

std::optional<SurfaceShape> shape_at(const BsplineSurface& surface, SurfacePlace place, Side side) noexcept {
    const SurfacePoint s = surface.evaluate(place.u, place.v);
    const Eigen::Vector3d across = s.by_u.cross(s.by_v);
    const double length = across.norm(), u_length = s.by_u.norm(), v_length = s.by_v.norm();
    constexpr double point_mm = 1e-9;
    if (!(length > 1e-12 * u_length * v_length) || u_length * (surface.u().end() - surface.u().begin()) < point_mm ||
        v_length * (surface.v().end() - surface.v().begin()) < point_mm)
        return std::nullopt;
    SurfaceShape out;
    out.point = s.at;
    out.normal = (side == Side::along ? 1 : -1) / length * across;
    out.by_u = s.by_u;
    out.by_v = s.by_v;
    out.e1 = s.by_u / u_length;
    out.e2 = out.normal.cross(out.e1);
    out.first << s.by_u.dot(s.by_u), s.by_u.dot(s.by_v), s.by_u.dot(s.by_v), s.by_v.dot(s.by_v);
    out.second << s.by_uu.dot(out.normal), s.by_uv.dot(out.normal), s.by_uv.dot(out.normal), s.by_vv.dot(out.normal);
    out.second = -out.second;
    // S_u = a e1, S_v = b e1 + c e2: II in (du, dv) is Jᵀ W J with J of these columns.
    Eigen::Matrix2d inverse;
    const double a = u_length, b = s.by_v.dot(out.e1), c = s.by_v.dot(out.e2);
    inverse << 1 / a, -b / (a * c), 0, 1 / c;
    out.shape = inverse.transpose() * out.second * inverse;
    return out;
}

}  // namespace trunnion::geometry
