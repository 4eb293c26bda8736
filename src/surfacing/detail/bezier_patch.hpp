#pragma once

#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "trunnion/geometry/bspline_surface.hpp"

namespace trunnion::surfacing::detail {

/// A piece of a surface without inner knots, over a rectangle of (u, v): S = Σ Σ B_i B_j w_ij P_ij / Σ Σ B_i B_j w_ij.
struct BezierPatch {
    int degree_u = 1, degree_v = 1;
    std::vector<Eigen::Vector4d> control;  ///< (w P, w), row by row: at i · (degree_v + 1) + j
    Eigen::Vector2d low, high;             ///< corners of its rectangle

    const Eigen::Vector4d& at(int i, int j) const noexcept {
        return control[static_cast<std::size_t>(i) * static_cast<std::size_t>(degree_v + 1) +
                       static_cast<std::size_t>(j)];
    }
    /// Cut in the middle of u or of v, by de Casteljau.
    std::array<BezierPatch, 2> halves(bool across_u) const;
    /// How far it is off being flat.
    struct Bend {
        /// Largest distance of the patch from linear interpolation over any triangle within its rectangle between
        /// points of the patch, mm: ¼ (max(A, C) + B) with A, B, C bounds of |S_uu|, |S_uv|, |S_vv| over it, parameters
        /// counted from 0 to 1; of rational ones by the polynomials that they
        /// are over w³. Holds for sure, and is small of second order.
        double triangle_error_mm;
        bool more_along_u;  ///< which way halves lower that error faster
    };
    Bend bend() const;
};

/// Knots within [from, to] and both ends, ascending, each once.
std::vector<double> breaks_of(const geometry::SurfaceDirection& direction, double from, double to);

/// The patches of all rectangles between breaks, row by row; no knot of the surface may lie between two breaks.
std::vector<BezierPatch> patches_of(const geometry::BsplineSurface& surface, const std::vector<double>& u_breaks,
                                    const std::vector<double>& v_breaks);

}  // namespace trunnion::surfacing::detail
