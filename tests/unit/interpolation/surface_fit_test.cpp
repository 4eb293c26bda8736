#include "trunnion/interpolation/surface_fit.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "trunnion/base/diagnostic.hpp"
#include "trunnion/interpolation/surface_curve.hpp"

#include "surface_samples.hpp"

namespace trunnion::interpolation {
namespace {

using namespace samples;
using geometry::SurfacePlace;

std::vector<SurfacePlace> wave(int count) {
    std::vector<SurfacePlace> out;
    for (int k = 0; k < count; ++k) {
        // Uneven steps, as chords of a tolerance are.
        const double x = static_cast<double>(k) / (count - 1), u = x + 0.03 * std::sin(9 * x);
        out.push_back({0.05 + 0.85 * u, 0.4 + 0.15 * std::sin(5 * u)});
    }
    return out;
}

double farthest_mm(const BsplineSurface& surface, const std::vector<SurfacePlace>& places, const BsplineCurve& curve) {
    double largest = 0;
    for (const SurfacePlace& place : places) {
        double nearest = 1e9;
        for (int k = 0; k <= 5000; ++k) {
            const auto at = curve.evaluate(curve.begin() + (curve.end() - curve.begin()) * k / 5000)[0];
            nearest = std::min(nearest, (surface.at(at.x(), at.y()) - surface.at(place.u, place.v)).norm());
        }
        largest = std::max(largest, nearest);
    }
    return largest;
}

TEST(SurfaceFit, passes_the_places_within_the_tolerance_with_few_knots) {
    const auto surface = hills(60, 12);
    const auto places = wave(120);
    const auto fine = fit_places(surface, places, 1e-4).value(), coarse = fit_places(surface, places, 1e-2).value();
    EXPECT_EQ(fine.degree(), 5);
    EXPECT_LT(coarse.control_points_mm().size(), fine.control_points_mm().size());
    EXPECT_LT(fine.control_points_mm().size(), places.size() / 2);
    // Beside what the 5000 places looked at leave: half of 15 µm along the curve.
    EXPECT_LT(farthest_mm(surface, places, coarse), 1e-2 + 8e-3);
    EXPECT_LT(farthest_mm(surface, places, fine), 1e-4 + 8e-3);
    for (const auto& curve : {fine, coarse}) {
        const auto first = curve.evaluate(curve.begin())[0], last = curve.evaluate(curve.end())[0];
        EXPECT_NEAR(first.x(), places.front().u, 1e-14);
        EXPECT_NEAR(last.y(), places.back().v, 1e-14);
    }
}

/// Noise that no smooth curve explains: interpolated in the end.
TEST(SurfaceFit, interpolates_where_nothing_less_keeps_the_tolerance) {
    const auto surface = hills(60, 12);
    auto places = wave(40);
    for (std::size_t k = 1; k + 1 < places.size(); ++k) places[k].v += (k % 2 ? 1 : -1) * 1e-3;
    const auto curve = fit_places(surface, places, 1e-6).value();
    EXPECT_EQ(curve.control_points_mm().size(), places.size());
    EXPECT_LT(farthest_mm(surface, places, curve), 8e-3);
}

TEST(SurfaceFit, takes_few_places) {
    const auto surface = hills(60, 12);
    for (int count = 2; count < 8; ++count) {
        const auto curve = fit_places(surface, wave(count), 1e-3);
        ASSERT_TRUE(curve) << count;
        EXPECT_EQ(curve->degree(), std::min(5, count - 1));
        EXPECT_LT(farthest_mm(surface, wave(count), *curve), 8e-3) << count;
    }
}

TEST(SurfaceFit, refuses_what_is_no_curve) {
    const auto surface = hills(60, 12);
    EXPECT_EQ(fit_places(surface, {}, 1e-3).error().code, "INTP0005");
    const std::vector<SurfacePlace> same(5, SurfacePlace{0.5, 0.5});
    EXPECT_EQ(fit_places(surface, same, 1e-3).error().code, "INTP0005");
}

}  // namespace
}  // namespace trunnion::interpolation
