#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "trunnion/geometry/bezier_piece.hpp"

namespace trunnion::geometry {

/// The basis functions that do not vanish at one u, with two derivatives: of N_{first+j,p}, j = 0 … p, derivative k is
/// derivative[k][j]. The rest is 0.
struct BasisFunctions {
    std::size_t first = 0;
    std::array<std::array<double, max_degree + 1>, 3> derivative{};
};

/// Of the B-splines of a degree p, 1 … 7, over knots t_0 ≤ … ≤ t_{n+p} as in BsplineCurve: for whoever sets up linear
/// equations in control points. Precondition: knots that BsplineCurve::make takes. Outside [t_p, t_n] the first or last
/// piece is continued. No allocation. Cost about 0.1 µs for cubics. Source: Piegl & Tiller, The NURBS Book, eq. 2.5 and
/// 2.7.
BasisFunctions basis_functions(int degree, std::span<const double> knots, double u) noexcept;

}  // namespace trunnion::geometry
