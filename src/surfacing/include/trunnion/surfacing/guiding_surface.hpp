#pragma once

#include <cstddef>

#include <Eigen/Core>

#include "trunnion/base/result.hpp"
#include "trunnion/surfacing/cutter.hpp"
#include "trunnion/surfacing/face.hpp"

namespace trunnion::surfacing {

struct GuidingOptions {
    double tolerance_mm = 0.0005;  ///< of the guiding surface from the true one
    std::size_t most_patches = 40'000;
};

/// The guiding surface S₁: where the tool's guiding point K runs while the tool touches the face, the face's surface
/// moved by the corner radius r along its normal, S₁(u, v) = S(u, v) + r n(u, v): of a ball its centre, of a torus the
/// middle of the round edge's section at the contact, of a flat the contact itself. K stays where it is while the tool
/// turns about its contact, so that S₁ knows nothing of orientations. Same (u, v) as the face.
///
/// A cubic B-spline over the box of (u, v) around the face's loops, C² but where the face's surface is less than C³;
/// its patches are the rectangles between knots. They are divided until |S₁ − (S + r n)| at equal (u, v) is proved to
/// be within the tolerance over every patch that has to do with the face: D = S₁ − S has to be along N = S_u × S_v and
/// r long, and what D × N and D² − r² are at most is read off their Bernstein coefficients, D and N being polynomials.
/// So the bound is certain to rounding (1e-12 of the coordinates), for rational surfaces as well; it is some 1 to 3
/// times the true error.
///
/// Source: Affouard 2004, Eq. 1. Immutable.
class GuidingSurface {
  public:
    /// Errors: SURF0301 an option out of range; SURF0303 a place in the box has no normal; SURF0304 S₁ folds over: the
    /// face is hollower there than r (the value is its radius), or S₁ cannot be shown not to; SURF0305 the tolerance is
    /// not reached with `most_patches`; SURF0306 the face has a crease, where S₁ would tear.
    /// Cost: some 30 µs a patch, of rational surfaces 0.2-1 ms.
    static Result<GuidingSurface> make(const Face& face, const Cutter& cutter, const GuidingOptions& options = {});

    const geometry::BsplineSurface& surface() const noexcept { return surface_; }
    Eigen::Vector3d at(const geometry::SurfacePlace& place) const noexcept { return surface_.at(place.u, place.v); }
    double error_bound_mm() const noexcept { return error_bound_; }
    std::size_t patches() const noexcept { return patches_; }

  private:
    GuidingSurface(geometry::BsplineSurface surface, double error_bound, std::size_t patches)
        : surface_(std::move(surface)), error_bound_(error_bound), patches_(patches) {}
    geometry::BsplineSurface surface_;
    double error_bound_;
    std::size_t patches_;
};

}  // namespace trunnion::surfacing
