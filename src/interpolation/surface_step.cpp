#include "trunnion/interpolation/surface_step.hpp"

namespace trunnion::interpolation {

double way_between_mm(const SurfaceContact& from, const SurfaceContact& to) noexcept {
    const double dw = to.w - from.w;
    return dw * ((from.rate_mm + to.rate_mm) / 2 + dw * (from.rate_slope_mm - to.rate_slope_mm) / 12);
}

SurfaceContact step(const SurfaceCurve& curve, const SurfaceContact& from, double way_mm, StepOrder order) noexcept {
    double dw = way_mm / from.rate_mm;
    if (order != StepOrder::first) dw -= dw * dw * from.rate_slope_mm / (2 * from.rate_mm);
    const SurfaceContact there = curve.contact(from.w + dw);
    if (order != StepOrder::corrected) return there;
    return curve.contact(there.w + (way_mm - way_between_mm(from, there)) / there.rate_mm);
}

}  // namespace trunnion::interpolation
