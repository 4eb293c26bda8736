#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "trunnion/base/result.hpp"
#include "trunnion/surfacing/face.hpp"
#include "trunnion/surfacing/guiding_surface.hpp"

namespace trunnion::surfacing {

/// The direction of feed that lead and tilt are counted from, everywhere on a face: the tangent along u or v, or a
/// direction in space laid into the tangent plane.
struct FeedReference {
    enum class Along : std::uint8_t { u, v, direction } along = Along::u;
    Eigen::Vector3d direction{1, 0, 0};

    /// Unit, in the tangent plane. Nothing where the direction is along the normal.
    std::optional<Eigen::Vector3d> at(const geometry::SurfaceShape& shape) const noexcept;
};

/// How an axis leans from the normal n: axis ∝ n + tan(lead) f + tan(tilt) n × f, f the feed reference.
struct Lean {
    double lead_rad = 0, tilt_rad = 0;
};
Eigen::Vector3d axis_of(const Lean& lean, const geometry::SurfaceShape& shape, const Eigen::Vector3d& feed) noexcept;
/// Nothing where the axis is not above the tangent plane.
std::optional<Lean> lean_of(const Eigen::Vector3d& axis, const geometry::SurfaceShape& shape,
                            const Eigen::Vector3d& feed) noexcept;

/// The orientations that are allowed: lead from S_low's to S_upp's, tilt to both sides of 0.
struct OrientationLimits {
    double least_lead_rad = -1.0, most_lead_rad = 1.0;
    double most_tilt_rad = 1.0;
    FeedReference feed{};
};

struct OrientationOptions {
    double height_mm = 50;       ///< of S₂ over S₁
    double tolerance_mm = 0.01;  ///< at that height: 0.2 mrad of the wanted orientation
    double spacing_mm = 10;      ///< patches are no larger: how fine editing can be
    std::size_t most_patches = 10'000;
};

/// An orientation that is wanted at a place.
struct OrientationTarget {
    geometry::SurfacePlace place;
    Eigen::Vector3d axis;  ///< unit
};

/// The orientation surface S₂: a second point of the tool `height` up along its axis direction from the guiding point,
/// S₂(u, v) = S₁(u, v) + h a(u, v). Every orientation of a plan is then a smooth function of (u, v) that is edited by
/// moving control points. (Affouard's S₂, the locus of C_L, is S₁ + (R − r) v; of a ball it is S₁ and fixes no
/// orientation. C_L follows from K, n and the axis: see surface_tool_path.hpp.)
///
/// A cubic B-spline over the guiding surface's box, C² where the normal is. |S₂ − S₁| = h holds only to some
/// hundredths of a mm; axis() is normalised. Limits hold at 5 × 5 places of every patch within the face.
///
/// Guarded: u ⟂ n, an axis less than 1° above the tangent plane, is refused: K, C_L and n would fix no axis and the end
/// of the tool would not be what cuts. u ∥ n is allowed: see contact_at().
///
/// Every function that edits gives a new surface or refuses: SURF0307, SURF0308 (how far beyond the limits, where),
/// SURF0309 a place outside the surface. Immutable. The face must outlive it.
class OrientationSurface {
  public:
    /// Of constant lead and tilt. Errors: SURF0301 option, SURF0303 a place without normal or feed, SURF0305 tolerance
    /// not reached, SURF0307, SURF0308.
    static Result<OrientationSurface> make(const Face& face, const GuidingSurface& guiding, const Lean& lean,
                                           const OrientationLimits& limits, const OrientationOptions& options = {});
    /// Of any orientation as a function of the place; nothing: SURF0303.
    using AxisField = std::function<std::optional<Eigen::Vector3d>(const geometry::SurfaceShape&)>;
    static Result<OrientationSurface> make(const Face& face, const GuidingSurface& guiding, const AxisField& axis,
                                           const OrientationLimits& limits, const OrientationOptions& options = {});
    /// S_low and S_upp: of least and of most lead, without tilt. Errors as make().
    Result<OrientationSurface> lower_limit() const;
    Result<OrientationSurface> upper_limit() const;

    const geometry::BsplineSurface& surface() const noexcept { return surface_; }
    const GuidingSurface& guiding() const noexcept { return guiding_; }
    const OrientationLimits& limits() const noexcept { return limits_; }
    Eigen::Vector3d axis(const geometry::SurfacePlace& place) const noexcept;  ///< unit, guiding point → spindle
    /// Axes within this angle of the normal count as upright, and orientations as within limits: twice what the surface
    /// may be off, 2 tolerance/height.
    double slack_rad() const noexcept { return 2 * options_.tolerance_mm / options_.height_mm; }

    /// From the wanted field as it was made, mm at the height: of constant lead and tilt proved for all of the face, by
    /// Bernstein coefficients, to rounding; of a field given as a function the largest error of 5 × 5 places a patch
    /// and twice what second differences between them let it rise in between, which is no proof.
    double error_bound_mm() const noexcept { return error_bound_; }
    std::size_t patches() const noexcept { return patches_; }
    /// |S₂ − S₁| lies between; certain, by Bernstein coefficients.
    std::pair<double, double> distance_range_mm() const;

    /// Turns the axes round a place by a rotation vector (rad, right-handed), less and less out to `radius_mm` from it:
    /// control points by the share (1 − x²)³ of it, x = distance/radius, which is C² at the border too. As the surface
    /// runs under its control points, the axis at the place turns by less: by 0.83 of it where the radius is three
    /// patches, 0.95 where it is six.
    Result<OrientationSurface> turned(const geometry::SurfacePlace& place, double radius_mm,
                                      const Eigen::Vector3d& turn) const;
    /// The smoothest least change that brings axes to targets: minimises 10⁴ Σ |S₂ − wanted|² + Σ |second
    /// differences of the control points' moves|² + `hold` Σ |moves|². `hold`: the larger the sooner the change fades
    /// away from the targets: to a tenth after some 7 patches with 0.05, 5 with 0.2, 3 with 1.
    Result<OrientationSurface> towards(std::span<const OrientationTarget> targets, double hold = 0.05) const;
    /// (1 − w) of this and w of another one over the same knots, w in [0, 1] at the control points' places.
    /// SURF0301 where knots differ or w is out of range.
    Result<OrientationSurface> blended(const OrientationSurface& other,
                                       const std::function<double(const geometry::SurfacePlace&)>& weight) const;

    /// SURF0307 where an axis is less than 1° above the tangent plane.
    static Result<void> check_rise(const geometry::SurfaceShape& shape, const Eigen::Vector3d& axis);
    /// SURF0307, or SURF0308 beyond the limits by more than what two surfaces within their tolerance may differ by;
    /// SURF0303 where the place has no normal.
    Result<void> check(const geometry::SurfacePlace& place, const Eigen::Vector3d& axis) const;
    /// An axis brought within the limits, by lead and tilt, and so far inside them as there is room, at most
    /// `inside_rad`.
    Eigen::Vector3d nearest_allowed(const geometry::SurfacePlace& place, const Eigen::Vector3d& axis,
                                    double inside_rad = 0) const;
    /// Where it is beyond its limits, patch by patch, at most one place each.
    std::vector<OrientationTarget> beyond_limits() const;

  private:
    friend class GougeRemover;  // keeps limits by more targets
    OrientationSurface(const Face& face, const GuidingSurface& guiding, geometry::BsplineSurface surface,
                       OrientationLimits limits, OrientationOptions options, double error_bound, std::size_t patches)
        : face_(&face),
          guiding_(guiding),
          surface_(std::move(surface)),
          limits_(limits),
          options_(options),
          error_bound_(error_bound),
          patches_(patches) {}
    Result<OrientationSurface> with(std::vector<Eigen::Vector3d> control_points) const;
    Result<OrientationSurface> checked() const;
    Result<OrientationSurface> moved_towards(std::span<const OrientationTarget> targets, double hold) const;

    const Face* face_;
    GuidingSurface guiding_;
    geometry::BsplineSurface surface_;
    OrientationLimits limits_;
    OrientationOptions options_;
    double error_bound_;
    std::size_t patches_;
};

}  // namespace trunnion::surfacing
