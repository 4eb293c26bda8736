#pragma once

#include <cstdint>

#include "trunnion/interpolation/surface_curve.hpp"

namespace trunnion::interpolation {

/// How the parameter of a curve follows from the way wanted in one period.
enum class StepOrder : std::uint8_t {
    first,     ///< Δw = Δs/|C′| (Lin & Koren, Eq. 5): off by Δs² C′·C″/(2|C′|³)
    second,    ///< the next term of Taylor's series, − Δs² C′·C″/(2|C′|⁴), too
    corrected  ///< that, and one step of Newton's method on the way that it made
};

/// The contact that is `way_mm` farther along the curve, to the accuracy of the order. One evaluation of the contact,
/// corrected two; noexcept, no allocation. Way is counted along the contact, not along the tip.
SurfaceContact step(const SurfaceCurve& curve, const SurfaceContact& from, double way_mm, StepOrder order) noexcept;

/// Way between two contacts that are near each other, from |C′| and its slope at both: Δw (σ₀ + σ₁)/2 + Δw² (σ₀′ −
/// σ₁′)/12, off by Δw⁵ σ⁗/720.
double way_between_mm(const SurfaceContact& from, const SurfaceContact& to) noexcept;

}  // namespace trunnion::interpolation
