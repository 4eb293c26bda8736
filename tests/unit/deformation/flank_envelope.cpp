#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "flank_blades.hpp"

namespace {

using namespace trunnion;
using namespace trunnion::deformation;
using Eigen::Vector3d;

/// Signed distance of a point from the tool's side, prolonged, at one place of the path.
double outside_mm(const Pose& pose, const FlankTool& tool, const Vector3d& point) {
    const Vector3d from_tip = point - pose.tip_in_workpiece_mm;
    const double z = from_tip.dot(pose.axis_in_workpiece);
    const double off = (from_tip - z * pose.axis_in_workpiece).norm();
    if (tool.kind == FlankKind::cone)
        return (off - tool.radius_mm - z * std::tan(tool.half_angle_rad)) * std::cos(tool.half_angle_rad);
    if (tool.kind == FlankKind::barrel)
        return std::hypot(off + tool.outline_radius_mm - tool.radius_mm, z - tool.widest_height_mm) -
               tool.outline_radius_mm;
    return off - tool.radius_mm;
}

/// The depth of a point in the whole swept volume: places one by one, then a search around the nearest.
double swept_distance_mm(const DualPath& path, const FlankTool& tool, const Vector3d& point) {
    const auto at = [&](double u) { return outside_mm(path.at(u), tool, point); };
    constexpr int places = 800;
    double nearest = path.begin(), least = at(nearest);
    for (int i = 1; i <= places; ++i) {
        const double u = std::lerp(path.begin(), path.end(), static_cast<double>(i) / places);
        if (const double d = at(u); d < least) least = d, nearest = u;
    }
    double step = (path.end() - path.begin()) / places;
    for (int i = 0; i < 60; ++i, step *= 0.7)
        for (const double u : {nearest - step, nearest + step})
            if (const double d = at(std::clamp(u, path.begin(), path.end())); d < least)
                least = d, nearest = std::clamp(u, path.begin(), path.end());
    return least;
}

const FlankTool cylinder{.radius_mm = 5};
const FlankTool cone{.kind = FlankKind::cone, .radius_mm = 4, .half_angle_rad = 6 * degree};
const FlankTool barrel{.kind = FlankKind::barrel, .radius_mm = 6, .outline_radius_mm = 300, .widest_height_mm = 17};

TEST(FlankEnvelope, IsTheBoundaryOfTheSweptVolume) {
    const auto surface = blade(20 * degree);
    for (const FlankTool& tool : {cylinder, cone, barrel}) {
        const DualPath path = two_point_path(surface, tool);
        for (double share = 0.1; share < 0.95; share += 0.2)
            for (const double height : {3.0, 10.0, 17.0, 30.0}) {
                const double u = std::lerp(path.begin(), path.end(), share);
                const auto found = envelope_point(path, tool, u, height, Vector3d(0, 1, 0));
                ASSERT_TRUE(found);
                EXPECT_GT(found->normal.y(), 0.5);
                EXPECT_NEAR(outside_mm(path.at(u), tool, found->point_mm), 0, 1e-12);
                EXPECT_NEAR(swept_distance_mm(path, tool, found->point_mm), 0, 1e-7);
                EXPECT_LT(swept_distance_mm(path, tool, found->point_mm - 1e-3 * found->normal), -0.9e-3);
                EXPECT_GT(swept_distance_mm(path, tool, found->point_mm + 1e-3 * found->normal), 0.9e-3);
            }
    }
}

/// A line that turns about a fixed axis makes a hyperboloid of one sheet; a cylinder about it, its parallel surface.
TEST(FlankEnvelope, OfACylinderIsParallelToTheSurfaceOfItsAxis) {
    constexpr double throat = 30, lean = 0.4;
    std::vector<Pose> poses;
    for (int i = 0; i <= 60; ++i) {
        const double turn = i * 2 * degree;
        const Vector3d out(std::cos(turn), std::sin(turn), 0), along(-std::sin(turn), std::cos(turn), 0);
        const Vector3d axis = (std::cos(lean) * Vector3d::UnitZ() + std::sin(lean) * along).eval();
        poses.push_back({throat * out - 15 * axis, axis});
    }
    const DualPath path = taken(fit_dual_path(poses)).path;
    for (double share = 0.2; share < 0.85; share += 0.1)
        for (const double height : {0.0, 7.0, 15.0, 29.0}) {
            const double u = std::lerp(path.begin(), path.end(), share);
            const auto found = envelope_point(path, cylinder, u, height, path.at(u).tip_in_workpiece_mm);
            ASSERT_TRUE(found);
            // Back along the normal by the radius the hyperboloid x² + y² = a² + (z tan λ)² is met, and met squarely.
            const Vector3d on_axis = found->point_mm - 5 * found->normal;
            const double slope = std::tan(lean) * std::tan(lean);
            EXPECT_NEAR(std::hypot(on_axis.x(), on_axis.y()),
                        std::sqrt(throat * throat + slope * on_axis.z() * on_axis.z()), 1e-4);
            const Vector3d square = Vector3d(on_axis.x(), on_axis.y(), -slope * on_axis.z()).normalized();
            EXPECT_NEAR(square.dot(found->normal), 1, 1e-8);
        }
}

TEST(FlankEnvelope, OfAConeOnAStraightWayIsAPlane) {
    const std::vector<Pose> poses{{{0, 0, 0}, Vector3d::UnitZ()},
                                  {{10, 0, 0}, Vector3d::UnitZ()},
                                  {{20, 0, 0}, Vector3d::UnitZ()},
                                  {{30, 0, 0}, Vector3d::UnitZ()}};
    const DualPath path = taken(fit_dual_path(poses)).path;
    for (const double height : {0.0, 20.0}) {
        const auto found = envelope_point(path, cone, 12, height, -Vector3d::UnitY());
        ASSERT_TRUE(found);
        EXPECT_LT((found->point_mm - Vector3d(12, -4 - height * std::tan(6 * degree), height)).norm(), 1e-9);
        EXPECT_NEAR(found->normal.z(), -std::sin(6 * degree), 1e-9);
    }
}

TEST(FlankEnvelope, IsMissingWhereTheToolPlunges) {
    std::vector<Pose> poses;
    for (int i = 0; i < 4; ++i) poses.push_back({Vector3d(0, 0, -10.0 * i), Vector3d::UnitZ()});
    const DualPath path = taken(fit_dual_path(poses)).path;
    EXPECT_FALSE(envelope_point(path, cone, 5, 3, Vector3d::UnitY()));
    const auto map = deviation_map(path, cone, blade(0), blade_range());
    ASSERT_FALSE(map);
    EXPECT_EQ(map.error().code, "DEFO0113");
}

TEST(FlankEnvelope, DeviationsAreSignedAndAgreeWithTheSweptVolume) {
    const auto surface = blade(20 * degree);
    const DualPath path = two_point_path(surface, cylinder);
    FlankRange range = blade_range();
    range.places_per_interval = 1;
    const DeviationMap map = taken(deviation_map(path, cylinder, surface, range));
    ASSERT_EQ(map.deviation_mm.size(), map.u.size() * map.height_mm.size());
    EXPECT_GT(map.peak_mm, 0.005) << "a twist that a cylinder cannot follow";
    for (std::size_t i = 2; i + 2 < map.u.size(); i += 3)
        for (std::size_t j = 0; j < map.height_mm.size(); j += 2) {
            const auto point = envelope_point(path, cylinder, map.u[i], map.height_mm[j], -Vector3d::UnitY());
            const auto foot = surface.foot(point->point_mm);
            // What is left or cut, measured from the surface to the swept volume.
            double low = -1, high = 1;
            for (int k = 0; k < 50; ++k) {
                const double middle = 0.5 * (low + high);
                (swept_distance_mm(path, cylinder, foot->point_mm + middle * foot->normal) < 0 ? high : low) = middle;
            }
            EXPECT_NEAR(map.deviation_mm[i * map.height_mm.size() + j], low, 1e-4);
        }
    EXPECT_EQ(map.highest_mm, std::ranges::max(map.deviation_mm));
    EXPECT_EQ(map.deepest_mm, std::ranges::min(map.deviation_mm));
}

TEST(FlankPositioning, TouchesBothEdgesWithEveryTool) {
    for (const double belly : {0.0, 0.4})
        for (const FlankTool& tool : {cylinder, cone, barrel}) {
            const auto surface = blade(20 * degree, belly);
            const auto poses = taken(two_point_poses(surface, tool, 7, 2));
            for (std::size_t i = 0; i < poses.size(); ++i)
                for (const double v : {0.0, 1.0}) {
                    const auto edge = *surface.shape(surface.place_at(static_cast<double>(i) / 6, v));
                    EXPECT_NEAR(outside_mm(poses[i], tool, edge.point), 0, 1e-9);
                    EXPECT_NEAR(outside_mm(poses[i], tool, edge.point + 0.1 * edge.normal), -0.1, 1e-3)
                        << "nearly square";
                }
        }
}

TEST(FlankPositioning, WithoutTwistTheEnvelopeIsTheSurface) {
    const auto surface = blade(0);
    const DualPath path = two_point_path(surface, cylinder, 61);
    const DeviationMap map = taken(deviation_map(path, cylinder, surface, blade_range()));
    EXPECT_LT(map.peak_mm, 1e-5);
}

TEST(FlankTool, RefusesWhatHasNoSide) {
    const auto refusal = [](const FlankTool& tool, double from = 0, double to = 30) {
        const auto checked = check(tool, from, to);
        return checked ? std::string("accepted") : checked.error().code;
    };
    EXPECT_EQ(refusal(cylinder), "accepted");
    EXPECT_EQ(refusal(cone), "accepted");
    EXPECT_EQ(refusal(barrel), "accepted");
    EXPECT_EQ(refusal(cylinder, 5, 5), "DEFO0111");
    EXPECT_EQ(refusal({.radius_mm = 0}), "DEFO0111");
    EXPECT_EQ(refusal({.radius_mm = NAN}), "DEFO0111");
    EXPECT_EQ(refusal({.kind = FlankKind::cone, .radius_mm = 1, .half_angle_rad = -10 * degree}), "DEFO0111");
    EXPECT_EQ(refusal({.kind = FlankKind::barrel, .radius_mm = 6, .outline_radius_mm = 5}), "DEFO0111");
    EXPECT_EQ(refusal({.kind = FlankKind::barrel, .radius_mm = 6, .outline_radius_mm = 20, .widest_height_mm = 5}),
              "DEFO0111");
}

TEST(DesignedSurface, GoesThroughItsRowsAndRefusesBadOnes) {
    const auto rows = blade_rows(15 * degree, 0.5);
    const auto surface = taken(guided_surface(rows, Side::against));
    for (std::size_t r = 0; r < 3; ++r)
        for (const auto& point : rows[r]) {
            const auto foot = surface.foot(point + 0.3 * Vector3d::UnitY());
            ASSERT_TRUE(foot);
            EXPECT_LT((surface.foot(point)->point_mm - point).norm(), 1e-9);
            EXPECT_GT(foot->normal.y(), 0.5);
        }
    const auto refusal = [&](std::vector<std::vector<Vector3d>> changed) {
        const auto made = guided_surface(changed, Side::along);
        return made ? std::string("accepted") : made.error().code;
    };
    EXPECT_EQ(refusal(rows), "accepted");
    EXPECT_EQ(refusal({rows[0]}), "DEFO0112");
    EXPECT_EQ(refusal({rows[0], {rows[1].begin(), rows[1].end() - 1}}), "DEFO0112");
    EXPECT_EQ(refusal({rows[0], rows[0]}), "DEFO0112");
    auto repeated = rows;
    repeated[1][4] = repeated[1][3];
    EXPECT_EQ(refusal(repeated), "DEFO0112");
    EXPECT_EQ(refusal({{rows[0].begin(), rows[0].begin() + 3}, {rows[1].begin(), rows[1].begin() + 3}}), "DEFO0112");
}

TEST(DesignedSurface, RuledIsStraightFromCurveToCurve) {
    const auto path = two_point_path(blade(10 * degree), cylinder);
    const auto surface = taken(ruled_surface(path.spline.bottom(), path.spline.top(), Side::along));
    const double u = 0.3 * path.end();
    const Vector3d wanted = 0.4 * path.spline.bottom().evaluate(u)[0] + 0.6 * path.spline.top().evaluate(u)[0];
    EXPECT_LT((surface.surface().at(u, 0.6) - wanted).norm(), 1e-11);
    const auto other = two_point_path(blade(10 * degree), cylinder, 30);
    EXPECT_EQ(ruled_surface(path.spline.bottom(), other.spline.top(), Side::along).error().code, "DEFO0112");
}

}  // namespace
