#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "trunnion/base/result.hpp"
#include "trunnion/geometry/bspline_curve.hpp"
#include "trunnion/geometry/bspline_surface.hpp"
#include "trunnion/surfacing/face.hpp"

namespace trunnion::surfacing::detail {

/// The equations of cubic interpolation at sites that rise with the knots: banded and totally positive, so that
/// elimination needs no pivots. Source: de Boor, A Practical Guide to Splines, ch. XIII.
class Collocation {
  public:
    Collocation(std::span<const double> knots, std::span<const double> sites);
    /// From values at the sites to control points, in place, `stride` apart.
    void solve(Eigen::Vector3d* values, std::size_t stride) const;
    std::size_t size() const noexcept { return rows_.size(); }

  private:
    static constexpr int reach = 3;
    struct Row {
        double entry[2 * reach + 1] = {};  ///< columns row − 3 … row + 3
    };
    std::vector<Row> rows_;  ///< factors below and on and above the diagonal
};

/// Knots of a cubic in one direction: breaks, and of how many knots each inner one is, 1 … 3.
struct FitDirection {
    std::vector<double> breaks;
    std::vector<int> multiplicity;  ///< one a break; those of the ends do not count

    geometry::SurfaceDirection direction() const;
    /// Divides the interval into equal parts, joined as smoothly as cubics are.
    void divide(const std::vector<int>& parts);
};

/// Means of three successive knots: where control points stand, and where cubics are interpolated.
std::vector<double> greville(const geometry::SurfaceDirection& direction);

using SurfaceValue = std::function<std::optional<Eigen::Vector3d>(const geometry::SurfacePlace&)>;

/// The cubic surface through the values at the Greville places. Errors: SURF0303 where there is no value.
Result<geometry::BsplineSurface> interpolate(const FitDirection& u, const FitDirection& v, const SurfaceValue& value);

/// A bound of a fit's error over every rectangle between breaks, row by row; 0 where it does not count.
using FitError = std::function<std::vector<double>(const geometry::BsplineSurface& fit, const FitDirection& u,
                                                   const FitDirection& v)>;
struct Fit {
    geometry::BsplineSurface surface;
    FitDirection u, v;
    double error_mm;
    std::size_t patches;
};
/// Divides where the error is above the tolerance until it is nowhere. Errors: SURF0303, SURF0305 more than `most`
/// patches.
Result<Fit> fit(FitDirection u, FitDirection v, const SurfaceValue& value, const FitError& error, double tolerance_mm,
                std::size_t most);

/// The C² cubic through points at parameters; not-a-knot, of three and fewer points of lower degree raised.
geometry::BsplineCurve curve_through(const std::vector<double>& parameters, std::vector<Eigen::Vector3d> points);

}  // namespace trunnion::surfacing::detail
