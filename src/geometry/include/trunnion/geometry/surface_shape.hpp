#pragma once

#include <cstdint>
#include <optional>

#include <Eigen/Core>

#include "trunnion/geometry/bspline_surface.hpp"

namespace trunnion::geometry {

/// On which side of a surface the material is not: the normal is S_u × S_v, or against it.
enum class Side : std::uint8_t { along, against };

inline Side opposite(Side side) noexcept {
    return side == Side::along ? Side::against : Side::along;
}

/// A surface near one of its points, to second order. Curvatures count as positive where the surface falls away from
/// its tangent plane against the normal: a ball seen from outside has 1/r in all directions.
///
/// Directions in the tangent plane are given in space (unit, ⟂ normal) or by their components (a, b) along the
/// orthonormal e₁ = S_u/|S_u|, e₂ = n × e₁. In them the shape operator W is symmetric: dn = W·dx.
struct SurfaceShape {
    Eigen::Vector3d point, normal;  ///< mm; unit
    Eigen::Vector3d by_u, by_v;     ///< S_u, S_v, mm per unit of u and v
    Eigen::Vector3d e1, e2;
    Eigen::Matrix2d shape;  ///< W, 1/mm

    /// The fundamental forms in (du, dv): I = (S_i·S_j), mm²; II = −(S_ij·n), mm, so that κ = II/I with the sign above.
    Eigen::Matrix2d first, second;

    Eigen::Vector2d components(const Eigen::Vector3d& direction) const noexcept {
        return {direction.dot(e1), direction.dot(e2)};
    }
    Eigen::Vector3d in_space(const Eigen::Vector2d& direction) const noexcept {
        return direction[0] * e1 + direction[1] * e2;
    }
    /// The change of (u, v) that goes along a tangent vector, to first order.
    Eigen::Vector2d parameters_along(const Eigen::Vector3d& tangent) const noexcept;

    /// κ(t) = tᵀ W t of a unit direction, 1/mm.
    double normal_curvature(const Eigen::Vector2d& direction) const noexcept {
        return direction.dot(shape * direction);
    }
};

/// Principal curvatures, 1/mm, the larger first, and the unit direction of the larger one; of an umbilic any direction.
struct PrincipalCurvatures {
    double larger = 0, smaller = 0;
    Eigen::Vector2d direction{1, 0};
};
PrincipalCurvatures principal_curvatures(const Eigen::Matrix2d& shape) noexcept;

/// Conjugate radius R = nᵀ W⁻¹ n of the unit direction `across`, mm: of all ways along which the tangent plane rolls
/// off the surface while a line in the direction of the feed stays in it. 1/R = W_nn − W_nf²/W_ff with f ⟂ n: that of
/// the surface's outline seen along f. Infinite for a plane; the normal radius where `across` is principal.
/// Precondition: W is positive semidefinite (convex).
double conjugate_radius(const Eigen::Matrix2d& shape, const Eigen::Vector2d& across) noexcept;

/// The surface at (u, v). Nothing where S_u × S_v is 0 (within 1e-12 of |S_u||S_v|, or either is shorter than 1e-9 mm
/// per share of the domain): poles, and edges that are one point. No allocation. Cost about 0.1 µs above evaluate().
std::optional<SurfaceShape> shape_at(const BsplineSurface& surface, SurfacePlace place, Side side) noexcept;

}  // namespace trunnion::geometry
