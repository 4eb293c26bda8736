#include "trunnion/interpolation/surface_step.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "trunnion/interpolation/surface_fit.hpp"

#include "surface_samples.hpp"

namespace trunnion::interpolation {
namespace {

using namespace samples;

/// Largest |way / wanted − 1| of steps of one length along the whole curve, the way by quadrature.
double ripple(const SurfaceCurve& curve, double step_mm, StepOrder order) {
    double largest = 0;
    for (SurfaceContact at = curve.contact(curve.begin());;) {
        const SurfaceContact next = step(curve, at, step_mm, order);
        if (next.w > curve.end()) return largest;
        largest = std::max(largest, std::abs(curve.way_mm(at.w, next.w) / step_mm - 1));
        at = next;
    }
}

/// The bars of the specification on the curve of Eq. 8, and the figures of the theory: Δs C′·C″/(2|C′|³) reaches 0.1 %
/// at 0.01 mm, 0.50 % at 0.05 mm.
TEST(SurfaceStep, keeps_the_feed_on_the_curve_of_equation_8) {
    const auto surface = koren_surface();
    const auto curve = SurfaceCurve::make(surface, geometry::Side::along, line(0, 0, 1, 0), flat_tool(5)).value();
    const double slow = ripple(curve, 0.01, StepOrder::first), fast = ripple(curve, 0.05, StepOrder::first);
    EXPECT_LT(slow, 0.00101);
    EXPECT_GT(slow, 0.0009);
    EXPECT_GT(fast, 0.004);
    EXPECT_LT(fast, 0.0055);
    EXPECT_LT(ripple(curve, 0.05, StepOrder::second), 0.00005);
    EXPECT_LT(ripple(curve, 0.05, StepOrder::corrected), 1e-6);
    EXPECT_LT(ripple(curve, 0.01, StepOrder::corrected), 1e-9);
}

/// A pass over the length of its polyline: the parameter is nearly the way already.
TEST(SurfaceStep, keeps_the_feed_on_a_pass) {
    const auto surface = hills(60, 12);
    std::vector<geometry::SurfacePlace> places;
    for (int k = 0; k <= 60; ++k) {
        const double x = k / 60.0;
        places.push_back({0.02 + 0.96 * x, 0.3 + 0.1 * std::sin(3 * x)});
    }
    const auto fitted = fit_places(surface, places, 1e-3).value();
    const auto curve = SurfaceCurve::make(surface, geometry::Side::along, fitted, flat_tool(5)).value();
    EXPECT_LT(ripple(curve, 0.01, StepOrder::first), 0.001);
    EXPECT_LT(ripple(curve, 0.05, StepOrder::second), 0.00005);
    EXPECT_LT(ripple(curve, 0.05, StepOrder::corrected), 1e-6);
}

TEST(SurfaceStep, stands_where_no_way_is_wanted) {
    const auto surface = koren_surface();
    const auto curve = SurfaceCurve::make(surface, geometry::Side::along, line(0, 0, 1, 0), flat_tool(5)).value();
    const auto at = curve.contact(0.3);
    for (const StepOrder order : {StepOrder::first, StepOrder::second, StepOrder::corrected})
        EXPECT_EQ(step(curve, at, 0, order).w, 0.3);
}

}  // namespace
}  // namespace trunnion::interpolation
