#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "trunnion/geometry/great_circle.hpp"
#include "trunnion/interpolation/surface_path.hpp"

#include "surface_samples.hpp"

namespace trunnion::interpolation {
namespace {

using namespace samples;
using Eigen::Vector3d;
using geometry::Side;

/// Ball, torus and flat: the axis points to S₂, and the tool touches the surface at the contact.
TEST(OrientedCurve, puts_the_tool_onto_the_contact_with_the_axis_of_the_surface) {
    const auto surface = hills(60, 4), second = leaning(true);
    for (const auto& [radius, corner] : {std::pair{5.0, 5.0}, {6.0, 2.0}, {5.0, 0.0}}) {
        const auto curve = SurfaceCurve::make(surface, Side::along, bow(), on(second, radius, corner)).value();
        for (const double w : {0.0, 0.4, 1.0}) {
            const auto at = curve.contact(w);
            const auto pose = curve.pose(at);
            const Vector3d &a = pose.axis_in_workpiece, centre = at.point_mm + corner * at.normal;
            const auto place = curve.place(w);
            EXPECT_NEAR(a.norm(), 1, 1e-14);
            EXPECT_LT(a.cross(second.at(place.u, place.v) - centre).norm(), 1e-12);
            // From the middle of the torus to that of its section at the contact it is R − r, away from the lean.
            const Vector3d off = centre - (pose.tip_in_workpiece_mm + corner * a);
            EXPECT_NEAR(off.dot(a), 0, 1e-12);
            EXPECT_NEAR(off.norm(), radius - corner, 1e-12);
            EXPECT_NEAR(off.dot(at.normal.cross(a)), 0, 1e-11);
            EXPECT_LE(off.dot(at.normal), 1e-12);
        }
    }
}

TEST(OrientedCurve, has_series_that_agree_with_poses) {
    const auto surface = hills(60, 4), second = leaning(true);
    for (const double corner : {6.0, 2.0}) {
        const auto curve = SurfaceCurve::make(surface, Side::along, bow(), on(second, 6, corner)).value();
        for (const double w : {0.2, 0.7}) {
            const SurfaceSeries at = curve.by_parameter(w);
            for (const double h : {0.0, 1e-2, 5e-3}) {
                const auto there = curve.pose(curve.contact(w + h));
                for (int i = 0; i < 3; ++i) {
                    const auto &c = at.tip[i].c, &a = at.axis[i].c;
                    EXPECT_NEAR(c[0] + h * (c[1] + h * (c[2] + h * c[3])), there.tip_in_workpiece_mm[i],
                                1e-12 + 2e4 * std::pow(h, 4));
                    EXPECT_NEAR(a[0] + h * (a[1] + h * (a[2] + h * a[3])), there.axis_in_workpiece[i],
                                1e-14 + 2e3 * std::pow(h, 4));
                }
            }
        }
    }
}

/// A cubic orientation surface is C² at its knots, a path over them C³ all the same.
TEST(OrientedCurve, bridges_knots_of_the_orientation_surface) {
    const auto surface = hills(60, 4), smooth = leaning(false), knotted = leaning(true);
    const machine::Machine machine = trunnion_table();
    const auto kinematics = machine::Kinematics::make(machine, {}, 0).value();
    const auto diagonal = line(0.1, 0.2, 0.9, 0.7);
    for (const auto* second : {&smooth, &knotted}) {
        const auto curve = SurfaceCurve::make(surface, Side::along, diagonal, on(*second, 6, 2)).value();
        EXPECT_EQ(curve.rough_places().size(), second == &knotted ? 5u : 0u);
        const auto path = surface_path(curve, kinematics, {});
        ASSERT_TRUE(path) << to_string(path.error());
        EXPECT_EQ(path->bridged_mm > 0, second == &knotted);
        EXPECT_LE(path->tool_path.bound.tip_mm, 2e-4);
        const auto& pieces = path->tool_path.pieces;
        for (std::size_t i = 1; i < pieces.size(); ++i) {
            const auto before = path::evaluate(pieces[i - 1], pieces[i - 1].length_mm);
            const auto behind = path::evaluate(pieces[i], 0);
            for (int k = 0; k < 6; ++k)
                for (int order = 0; order < 4; ++order) EXPECT_NEAR(before[k].c[order], behind[k].c[order], 1e-9);
        }
    }
}

/// Second points straight over the surface, and far aside of it.
TEST(OrientedCurve, refuses_axes_that_leave_no_side_to_touch_with) {
    const SurfaceDirection straight{1, {0, 0, 1, 1}};
    const auto shifted = [&](double x, double z) {
        return BsplineSurface::make(straight, straight, {{x, 0, z}, {x, 60, z}, {60 + x, 0, z}, {60 + x, 60, z}})
            .value();
    };
    const auto plane = shifted(0, 0), upright = shifted(0, 50), aside = shifted(50, 0.5), leans = shifted(5, 50);
    const auto code = [&](const BsplineSurface& second, double corner_mm) {
        const auto made = SurfaceCurve::make(plane, Side::along, line(0.1, 0.2, 0.9, 0.7), on(second, 5, corner_mm));
        return made ? "" : made.error().code;
    };
    EXPECT_EQ(code(upright, 2), "INTP0009");
    EXPECT_EQ(code(upright, 5), "");  // a ball touches whichever way it stands
    EXPECT_EQ(code(aside, 0), "INTP0009");
    EXPECT_EQ(code(leans, 2), "");
    const auto half =
        BsplineSurface::make(straight, {1, {0, 0, 0.5, 0.5}}, {{5, 0, 50}, {5, 30, 50}, {65, 0, 50}, {65, 30, 50}})
            .value();
    EXPECT_EQ(code(half, 2), "INTP0002");
}

}  // namespace
}  // namespace trunnion::interpolation
