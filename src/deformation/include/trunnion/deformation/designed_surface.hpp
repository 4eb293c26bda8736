#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "trunnion/base/result.hpp"
#include "trunnion/geometry/bspline_curve.hpp"
#include "trunnion/geometry/bspline_surface.hpp"
#include "trunnion/geometry/surface_shape.hpp"

namespace trunnion::deformation {

using geometry::Side;
using geometry::SurfacePlace;

/// The place of a surface that is nearest to a point.
struct SurfaceFoot {
    Eigen::Vector3d point_mm;
    Eigen::Vector3d normal;  ///< unit, out of the material
    SurfacePlace place;      ///< from where the next search may begin
};

/// The surface that the part is to have, in the workpiece's frame: all that flank milling asks of it. Own kinds (an
/// analytic one, a mesh) derive from it.
class DesignedSurface {
  public:
    virtual ~DesignedSurface() = default;
    /// Nearest to a point, searched from a guess. A pure function, callable from several threads. None: the surface has
    /// no normal there.
    virtual std::optional<SurfaceFoot> foot(const Eigen::Vector3d& point_mm, SurfacePlace guess) const = 0;
    /// The same without a guess.
    virtual std::optional<SurfaceFoot> foot(const Eigen::Vector3d& point_mm) const = 0;
    /// The surface to second order at a place.
    virtual std::optional<geometry::SurfaceShape> shape(SurfacePlace place) const = 0;
    /// The place at shares of the domain, 0 … 1 each: u along the way of the tool, v from its tip upwards.
    virtual SurfacePlace place_at(double u_share, double v_share) const = 0;
};

/// A B-spline surface. Beyond its edges it is continued by a fifth of its size, so that a tool that runs out over an
/// edge still has a surface to be compared with.
class SplineSurface final : public DesignedSurface {
  public:
    SplineSurface(geometry::BsplineSurface surface, Side material_free)
        : surface_(std::move(surface)), side_(material_free) {}

    const geometry::BsplineSurface& surface() const noexcept { return surface_; }
    std::optional<SurfaceFoot> foot(const Eigen::Vector3d& point_mm, SurfacePlace guess) const override;
    std::optional<SurfaceFoot> foot(const Eigen::Vector3d& point_mm) const override;
    std::optional<geometry::SurfaceShape> shape(SurfacePlace place) const override;
    SurfacePlace place_at(double u_share, double v_share) const override;

  private:
    geometry::BsplineSurface surface_;
    Side side_;
};

/// The ruled surface between two curves over the same knots: S(u, v) = (1 − v) bottom(u) + v top(u).
/// `material_free`: the side that is cut from, `along` S_u × S_v or `against` it. Errors: DEFO0112 the curves differ in
/// degree or knots or have weights, or the surface has no normal somewhere (they meet, or both run along the ruling).
Result<SplineSurface> ruled_surface(const geometry::BsplineCurve& bottom, const geometry::BsplineCurve& top,
                                    Side material_free);

/// A surface through guide curves that are given by points, row by row from the tip's edge upwards; points of all rows
/// at the same place belong together. u: cubic C² spline through every row by mean chord length; v: polynomial through
/// the rows at even distances, two rows ruled, three a parabola. Errors: DEFO0112 fewer than 2 or more than 8 rows,
/// rows of different length or below 4 points, points that are not finite or repeat, or no normal somewhere.
Result<SplineSurface> guided_surface(std::span<const std::vector<Eigen::Vector3d>> rows_mm, Side material_free);

}  // namespace trunnion::deformation
