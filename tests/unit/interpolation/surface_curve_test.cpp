#include "trunnion/interpolation/surface_curve.hpp"

#include <cmath>
#include <limits>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "surface_samples.hpp"

namespace trunnion::interpolation {
namespace {

using namespace samples;
using Eigen::Vector3d;
using geometry::Side;

SurfaceCurve curve_on(const BsplineSurface& surface, const BsplineCurve& places, const SurfaceTool& tool) {
    return SurfaceCurve::make(surface, Side::along, places, tool).value();
}

Vector3d value_of(const machine::VectorSeries& s) {
    return {s[0].value(), s[1].value(), s[2].value()};
}

TEST(SurfaceCurve, has_the_derivatives_of_its_points) {
    const auto surface = hills(60, 12);
    const auto curve = curve_on(surface, bow(), flat_tool(5));
    constexpr double h = 1e-4;
    for (const double w : {0.1, 0.37, 0.5, 0.92}) {
        const auto at = curve.contact(w), before = curve.contact(w - h), behind = curve.contact(w + h);
        EXPECT_LT((at.by_w - (behind.point_mm - before.point_mm) / (2 * h)).norm(), 2e-5 * at.rate_mm);
        EXPECT_LT((at.by_ww - (behind.by_w - before.by_w) / (2 * h)).norm(), 2e-5 * at.by_ww.norm());
        EXPECT_NEAR(at.rate_slope_mm, (behind.rate_mm - before.rate_mm) / (2 * h), 1e-4 * at.rate_mm);
        EXPECT_NEAR(at.normal.dot(at.by_w), 0, 1e-12);
    }
}

/// Ball, flat and torus, upright and leaning: the tool touches the surface at the contact, its axis leans as wanted.
TEST(SurfaceCurve, puts_the_tool_onto_the_contact) {
    const auto surface = hills(60, 12);
    for (const SurfaceTool& tool : {SurfaceTool{5, 0, 0, 0}, SurfaceTool{5, 5, 0.2, -0.1}, SurfaceTool{5, 0, 0.1, 0},
                                    SurfaceTool{6, 2, -0.1, 0.3}}) {
        const auto curve = curve_on(surface, bow(), tool);
        for (const double w : {0.0, 0.4, 1.0}) {
            const auto at = curve.contact(w);
            const auto pose = curve.pose(at);
            const Vector3d &a = pose.axis_in_workpiece, t = at.by_w.normalized();
            EXPECT_NEAR(a.norm(), 1, 1e-14);
            EXPECT_NEAR(a.dot(t) / a.dot(at.normal), std::tan(tool.lead_rad), 1e-12);
            EXPECT_NEAR(a.dot(at.normal.cross(t)) / a.dot(at.normal), std::tan(tool.tilt_rad), 1e-12);
            // From the circle of the corner's centres to the contact it is r, along the normal.
            const Vector3d centre = at.point_mm + tool.corner_mm * at.normal;
            const Vector3d off = centre - (pose.tip_in_workpiece_mm + tool.corner_mm * a);
            EXPECT_NEAR(off.dot(a), 0, 1e-12);
            const bool leans = tool.lead_rad != 0 || tool.tilt_rad != 0;
            EXPECT_NEAR(off.norm(), leans ? tool.radius_mm - tool.corner_mm : 0, 1e-12);
        }
    }
}

TEST(SurfaceCurve, has_series_that_agree_with_poses_and_with_each_other) {
    const auto surface = hills(60, 12);
    const auto round = belt(20, 30);
    const auto across =
        BsplineCurve::make(2, {0, 0, 0, 1, 1, 1}, {{0.1, 0.1, 0}, {0.5, 0.9, 0}, {0.9, 0.4, 0}}).value();
    for (const auto& curve : {curve_on(surface, bow(), {6, 2, -0.1, 0.3}), curve_on(round, across, {5, 0, 0.1, 0})})
        for (const double w : {0.2, 0.7}) {
            const SurfaceSeries at = curve.by_parameter(w);
            const auto pose = curve.pose(curve.contact(w));
            EXPECT_LT((value_of(at.tip) - pose.tip_in_workpiece_mm).norm(), 1e-12);
            EXPECT_LT((value_of(at.axis) - pose.axis_in_workpiece).norm(), 1e-14);
            // What the series foretell, against poses beside: off by the fourth derivative alone.
            for (const double h : {1e-2, 5e-3})
                for (int i = 0; i < 3; ++i) {
                    const auto there = curve.pose(curve.contact(w + h));
                    const auto& c = at.tip[i].c;
                    EXPECT_NEAR(c[0] + h * (c[1] + h * (c[2] + h * c[3])), there.tip_in_workpiece_mm[i],
                                6e3 * std::pow(h, 4));
                    const auto& a = at.axis[i].c;
                    EXPECT_NEAR(a[0] + h * (a[1] + h * (a[2] + h * a[3])), there.axis_in_workpiece[i],
                                6e2 * std::pow(h, 4));
                }
            const SurfaceSeries by_way = curve.by_way(w);
            const Vector3d slope(by_way.contact[0].d1(), by_way.contact[1].d1(), by_way.contact[2].d1());
            const Vector3d bend(by_way.contact[0].d2(), by_way.contact[1].d2(), by_way.contact[2].d2());
            EXPECT_NEAR(slope.norm(), 1, 1e-13);
            EXPECT_NEAR(slope.dot(bend), 0, 1e-12);
        }
}

/// Eq. 8: 29.128 mm.
TEST(SurfaceCurve, measures_its_way) {
    const auto surface = koren_surface();
    const auto curve = curve_on(surface, line(0, 0, 1, 0), flat_tool(5));
    double sum = 0;
    for (int k = 0; k < 20; ++k) sum += curve.way_mm(k / 20.0, (k + 1) / 20.0);
    EXPECT_NEAR(sum, 29.128, 5e-4);
    EXPECT_NEAR(sum, curve.way_mm(0, 0.5) + curve.way_mm(0.5, 1), 1e-8);
}

TEST(SurfaceCurve, tells_where_its_surface_is_rough) {
    const auto smooth = hills(60, 12), patched = patched_hills(60, 12);
    EXPECT_TRUE(curve_on(smooth, bow(), flat_tool(5)).rough_places().empty());
    const auto curve = curve_on(patched, line(0.1, 0.2, 0.9, 0.7), flat_tool(5));
    const auto rough = curve.rough_places();
    ASSERT_EQ(rough.size(), 5u);  // u = 0.3, 0.55, 0.8; v = 0.3, 0.55
    EXPECT_NEAR(curve.place(rough[0]).v, 0.3, 1e-12);
    EXPECT_NEAR(curve.place(rough[1]).u, 0.3, 1e-12);
    // Along a knot is not across it.
    EXPECT_EQ(curve_on(patched, line(0.1, 0.3, 0.9, 0.3), flat_tool(5)).rough_places().size(), 3u);
}

std::string refusal(const BsplineSurface& surface, const BsplineCurve& places, const SurfaceTool& tool) {
    const auto made = SurfaceCurve::make(surface, Side::along, places, tool);
    return made ? "" : made.error().code;
}

TEST(SurfaceCurve, refuses_what_has_no_meaning) {
    const auto surface = hills(60, 12);
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    for (const SurfaceTool& tool : {SurfaceTool{0, 0, 0, 0}, SurfaceTool{nan, 0, 0, 0}, SurfaceTool{5, 6, 0, 0},
                                    SurfaceTool{5, -1, 0, 0}, SurfaceTool{5, 0, 1.6, 0}, SurfaceTool{5, 0, 0, nan}})
        EXPECT_EQ(refusal(surface, bow(), tool), "INTP0001");
    EXPECT_EQ(refusal(surface, line(0.1, 0.1, 1.1, 0.1), flat_tool(5)), "INTP0002");
    EXPECT_EQ(refusal(surface, line(0.5, 0.5, 0.5, 0.5), flat_tool(5)), "INTP0003");
    const SurfaceDirection straight{1, {0, 0, 1, 1}};
    const auto cone = BsplineSurface::make(straight, straight, {{0, 0, 0}, {0, 0, 0}, {10, 0, 0}, {0, 10, 0}}).value();
    EXPECT_EQ(refusal(cone, line(0, 0.5, 1, 0.5), flat_tool(5)), "INTP0003");
    EXPECT_EQ(refusal(cone, line(0.1, 0.5, 1, 0.5), flat_tool(5)), "");
    const auto weighted = BsplineCurve::make(1, {0, 0, 1, 1}, {{0, 0, 0}, {1, 1, 0}}, {1, 2}).value();
    EXPECT_EQ(refusal(surface, weighted, flat_tool(5)), "INTP0004");
}

}  // namespace
}  // namespace trunnion::interpolation
