#include "trunnion/interpolation/surface_path.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>

#include "surface_samples.hpp"

namespace trunnion::interpolation {
namespace {

using namespace samples;

struct Table {
    machine::Machine machine = trunnion_table();
    machine::Kinematics kinematics = machine::Kinematics::make(machine, {}, 0).value();
};

SurfacePath path_of(const SurfaceCurve& curve, const SurfacePathOptions& options = {}) {
    static const Table table;
    auto made = surface_path(curve, table.kinematics, options);
    if (!made) throw std::runtime_error(to_string(made.error()));
    return *made;
}

/// Largest jump of value and three derivatives between neighbouring pieces.
double largest_jump(const SurfacePath& path) {
    double largest = 0;
    const auto& pieces = path.tool_path.pieces;
    for (std::size_t i = 1; i < pieces.size(); ++i) {
        const auto before = path::evaluate(pieces[i - 1], pieces[i - 1].length_mm),
                   behind = path::evaluate(pieces[i], 0);
        for (int k = 0; k < 6; ++k)
            for (int order = 0; order < 4; ++order)
                largest = std::max(largest, std::abs(before[k].c[order] - behind[k].c[order]));
    }
    return largest;
}

TEST(SurfacePath, follows_a_smooth_surface_to_a_nanometre) {
    const auto surface = hills(60, 12);
    const auto curve = SurfaceCurve::make(surface, geometry::Side::along, bow(), {6, 2, 0.1, 0.05}).value();
    const SurfacePath path = path_of(curve);
    double way = 0;
    for (int k = 0; k < 50; ++k) way += curve.way_mm(k / 50.0, (k + 1) / 50.0);
    EXPECT_NEAR(path.tool_path.length_mm(), way, 1e-9);
    EXPECT_LE(path.fit_tip_mm, 1e-6);
    EXPECT_LE(path.fit_axis_rad, 1e-8);
    EXPECT_EQ(path.bridged_mm, 0);
    EXPECT_EQ(path.pieces.size(), path.tool_path.pieces.size());
    EXPECT_LT(path.pieces.size(), 200u);
    EXPECT_LT(largest_jump(path), 1e-9);
    // At other places than those looked at.
    double off = 0;
    for (std::size_t i = 0; i < path.pieces.size(); ++i) {
        const auto& piece = path.pieces[i];
        for (const double share : {0.06, 0.44, 0.81}) {
            const double w = piece.w_begin + share * (piece.w_end - piece.w_begin);
            const auto pose = curve.pose(curve.contact(w));
            const auto at = path::evaluate(path.tool_path.pieces[i], curve.way_mm(piece.w_begin, w));
            for (int k = 0; k < 3; ++k) off = std::max(off, std::abs(at[k].value() - pose.tip_in_workpiece_mm[k]));
        }
    }
    EXPECT_LT(off, 1.5e-6);
}

/// Where curvature's slope jumps, the upright tool's axis is C¹: bridges of some 0.1 µm make the path C³.
TEST(SurfacePath, bridges_knots_of_the_surface) {
    const auto surface = patched_hills(60, 12);
    const auto curve =
        SurfaceCurve::make(surface, geometry::Side::along, line(0.1, 0.2, 0.9, 0.7), {5, 0, 0, 0}).value();
    const SurfacePath path = path_of(curve);
    EXPECT_GT(path.bridged_mm, 0);
    EXPECT_LT(path.bridged_mm, 5 * 4.1);
    EXPECT_LE(path.tool_path.bound.tip_mm, 2e-4);
    EXPECT_LE(path.tool_path.bound.orientation_rad, 2e-5);
    EXPECT_GT(path.tool_path.bound.orientation_rad, 1e-7);
    EXPECT_LT(largest_jump(path), 1e-9);
    for (const double rough : curve.rough_places()) {
        const auto on =
            std::ranges::find_if(path.pieces, [&](const auto& p) { return p.w_begin < rough && rough < p.w_end; });
        ASSERT_NE(on, path.pieces.end());
        EXPECT_TRUE(on->bridge);
    }
}

/// A cylinder of two rational pieces: its parameter has a kink where the pieces meet, the path has none.
TEST(SurfacePath, does_not_feel_the_parametrisation) {
    const auto surface = belt(20, 30);
    const auto curve =
        SurfaceCurve::make(surface, geometry::Side::along, line(0.1, 0.5, 1.9, 0.5), {5, 0, 0, 0}).value();
    const SurfacePath path = path_of(curve);
    double worst = 0;
    for (const auto& piece : path.tool_path.pieces) {
        const auto at = path::evaluate(piece, 0.4 * piece.length_mm);
        worst = std::max(worst, std::abs(std::hypot(at[0].value(), at[1].value()) - 20));
    }
    EXPECT_LT(worst, 1e-6);
    const auto start = curve.contact(0).point_mm;
    EXPECT_NEAR(path.tool_path.length_mm(), 40 * std::abs(std::atan2(start.y(), start.x())), 1e-6);
}

TEST(SurfacePath, carries_the_feed_of_contact_or_tip) {
    const auto surface = koren_surface();
    const auto curve = SurfaceCurve::make(surface, geometry::Side::along, line(0, 0, 1, 0), flat_tool(5)).value();
    const auto contact = path_of(curve, {.feed_mm_s = 30}),
               tip = path_of(curve, {.feed_mm_s = 30, .feed_point = FeedPoint::tip});
    const auto& block = contact.tool_path.blocks.front();
    EXPECT_EQ(block.feed.rule, path::FeedRule::block_time);
    EXPECT_NEAR(block.time_scale_mm / block.feed.value, 30, 1e-12);
    EXPECT_EQ(tip.tool_path.blocks.front().feed.rule, path::FeedRule::tip_speed);
    EXPECT_EQ(tip.tool_path.blocks.front().feed.value, 30);
}

TEST(SurfacePath, refuses_edges_and_options_without_meaning) {
    const Table table;
    const auto smooth = hills(60, 12);
    const auto on_smooth = SurfaceCurve::make(smooth, geometry::Side::along, bow(), flat_tool(5)).value();
    for (const double feed : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()})
        EXPECT_EQ(surface_path(on_smooth, table.kinematics, {.feed_mm_s = feed}).error().code, "INTP0006");
    EXPECT_EQ(surface_path(on_smooth, table.kinematics, {.fit_tip_mm = 0}).error().code, "INTP0006");
    for (const double pole_rad : {-1e-9, 3e-5, std::numeric_limits<double>::quiet_NaN()})
        EXPECT_EQ(surface_path(on_smooth, table.kinematics, {.pole_rad = pole_rad}).error().code, "INTP0006");
    const SurfaceDirection folded{1, {0, 0, 1, 2, 2}}, straight{1, {0, 0, 1, 1}};
    const auto roof = BsplineSurface::make(folded, straight,
                                           {{0, 0, 0}, {0, 20, 0}, {20, 0, 5}, {20, 20, 5}, {40, 0, 0}, {40, 20, 0}})
                          .value();
    const auto over = SurfaceCurve::make(roof, geometry::Side::along, line(0.1, 0.5, 1.9, 0.5), flat_tool(5)).value();
    EXPECT_EQ(surface_path(over, table.kinematics, {}).error().code, "INTP0007");
}

/// Hills of half a micrometre.
TEST(SurfacePath, refuses_a_curve_that_bends_within_a_micrometre) {
    const Table table;
    const auto tiny = hills(5e-4, 2e-4);
    const auto curve = SurfaceCurve::make(tiny, geometry::Side::along, bow(), flat_tool(5)).value();
    EXPECT_EQ(surface_path(curve, table.kinematics, {}).error().code, "INTP0008");
}

/// A patch of a cylinder of radius 60 about Y, falling along y: the upright axis passes the pole at that slope.
SurfacePath over_hump(double slope, double corner_mm) {
    const auto surface = geometry::polynomial_surface(
        2, 1, {{-12, 0, -1.2}, {0, 6, -6 * slope}, {24, 0, 4.8}, {0, 0, 0}, {0, 0, -4.8}, {0, 0, 0}});
    const auto curve =
        SurfaceCurve::make(*surface, geometry::Side::along, line(0, 0.5, 1, 0.5), {5, corner_mm, 0, 0}).value();
    return path_of(curve);
}

TEST(SurfacePath, has_a_joint_at_a_pole_exactly) {
    for (const double slope : {0.0, 1e-13, 5e-6, 9e-6})
        for (const double corner : {0.0, 5.0}) {
            const SurfacePath path = over_hump(slope, corner);
            const auto at_pole = std::ranges::count_if(path.tool_path.pieces, [](const path::PathPiece& piece) {
                const auto at = path::evaluate(piece, 0);
                return at[3].value() == 0 && at[4].value() == 0;
            });
            EXPECT_EQ(at_pole, 1) << slope;
            EXPECT_LT(largest_jump(path), 1e-9);
            EXPECT_NEAR(path.tool_path.bound.orientation_rad, slope, 1e-9);
            EXPECT_LE(path.tool_path.bound.tip_mm, corner * slope + 1e-9);
            EXPECT_NEAR(path.bridged_mm, 4, 0.01);
        }
    EXPECT_EQ(over_hump(1.1e-5, 5).bridged_mm, 0);
}

}  // namespace
}  // namespace trunnion::interpolation
