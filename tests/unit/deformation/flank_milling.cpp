#include "trunnion/deformation/flank_milling.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "flank_blades.hpp"

namespace {

using namespace trunnion;
using namespace trunnion::deformation;
using Eigen::Vector3d;

const FlankTool cylinder{.radius_mm = 5};
const FlankTool cone{.kind = FlankKind::cone, .radius_mm = 4, .half_angle_rad = 4 * degree};
const FlankTool barrel{.kind = FlankKind::barrel, .radius_mm = 6, .outline_radius_mm = 400, .widest_height_mm = 17};

/// What every deformation keeps.
void expect_sound(const DualPath& start, const DeformedFlank& made, const FlankDeformation& options) {
    EXPECT_EQ(made.path.spline.bottom().knots(), start.spline.bottom().knots()) << "C² as before";
    EXPECT_LE(made.after.peak_mm, made.before.peak_mm);
    EXPECT_LE(made.movement_mm, options.most_movement_mm * (1 + 1e-12));
    double moved = 0;
    for (std::size_t i = 0; i < start.spline.top().control_points_mm().size(); ++i)
        moved = std::max(
            moved, (made.path.spline.top().control_points_mm()[i] - start.spline.top().control_points_mm()[i]).norm());
    EXPECT_LE(moved, made.movement_mm);
}

/// Looked at where the deformation did not look.
DeviationMap closely(const DualPath& path, const FlankTool& tool, const DesignedSurface& surface, FlankRange range) {
    range.heights = 31;
    range.places_per_interval = 13;
    return taken(deviation_map(path, tool, surface, range));
}

TEST(FlankMilling, OnATwistedRuledBladeThePeakFallsBelowAThird) {
    const auto surface = blade(30 * degree);
    const DualPath start = two_point_path(surface, cylinder);
    const FlankDeformation options{.range = blade_range()};
    const auto made = taken(deform_flank(start, cylinder, surface, options));
    expect_sound(start, made, options);
    EXPECT_GT(made.before.peak_mm, 0.012);
    EXPECT_LT(made.after.peak_mm, made.before.peak_mm / 3);
    EXPECT_LT(closely(made.path, cylinder, surface, options.range).peak_mm, made.before.peak_mm / 3);
}

TEST(FlankMilling, ConesAndBarrelsToo) {
    const auto surface = blade(30 * degree);
    for (const FlankTool& tool : {cone, barrel}) {
        const DualPath start = two_point_path(surface, tool);
        const FlankDeformation options{.range = blade_range()};
        const auto made = taken(deform_flank(start, tool, surface, options));
        expect_sound(start, made, options);
        EXPECT_LT(made.after.peak_mm, made.before.peak_mm / (tool.kind == FlankKind::cone ? 3 : 1.2));
    }
}

TEST(FlankMilling, ABladeThatIsNotRuled) {
    const auto surface = blade(20 * degree, 0.3);
    for (const FlankTool& tool : {cylinder, cone, barrel}) {
        const DualPath start = two_point_path(surface, tool);
        const FlankDeformation options{.range = blade_range()};
        const auto made = taken(deform_flank(start, tool, surface, options));
        expect_sound(start, made, options);
        EXPECT_LT(made.after.peak_mm, 0.8 * made.before.peak_mm);
    }
}

TEST(FlankMilling, OneSidedCutsNoDeeperThanAllowed) {
    const auto surface = blade(30 * degree);
    const DualPath start = two_point_path(surface, cylinder);
    for (const double allowed : {0.0, 0.001}) {
        const FlankDeformation options{.range = blade_range(), .deepest_mm = allowed};
        const auto made = taken(deform_flank(start, cylinder, surface, options));
        EXPECT_GE(made.after.deepest_mm, -allowed - 1e-9);
        EXPECT_GE(closely(made.path, cylinder, surface, options.range).deepest_mm, -allowed - 1e-4);
        EXPECT_LT(made.after.highest_mm, made.before.peak_mm) << "and not by keeping far off";
    }
}

TEST(FlankMilling, MovementStaysWithinItsBound) {
    const auto surface = blade(30 * degree);
    const DualPath start = two_point_path(surface, cylinder);
    double last = std::numeric_limits<double>::infinity();
    for (const double most : {0.002, 0.01, 1.0}) {
        const FlankDeformation options{.range = blade_range(), .most_movement_mm = most};
        const auto made = taken(deform_flank(start, cylinder, surface, options));
        expect_sound(start, made, options);
        EXPECT_LE(made.after.peak_mm, last * (1 + 1e-9));
        last = made.after.peak_mm;
    }
}

/// The curves of the published path as the guides of a blade.
TEST(FlankMilling, OnThePublishedSurface) {
    const std::filesystem::path file = std::filesystem::path(TRUNNION_SHARED_DIR) / "data/published/flank-2012.json";
    if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not there";
    const auto published = nlohmann::json::parse(std::ifstream(file));
    const auto curve = [&](const char* name) {
        std::vector<Vector3d> points;
        for (const auto& p : published[name]) points.emplace_back(p[0], p[1], p[2]);
        return taken(geometry::BsplineCurve::make(published["degree"], published["knots"], points));
    };
    const FlankRange range{.from_height_mm = 1, .to_height_mm = 16};
    const auto inside = taken(ruled_surface(curve("bottom_mm"), curve("top_mm"), Side::along));
    const auto refused = deform_flank(two_point_path(inside, cylinder, 120, 1), cylinder, inside, {.range = range});
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, "DEFO0110");
    EXPECT_NEAR(std::stod(refused.error().limit), 4.97, 0.01) << "too hollow on this side";

    const auto surface = taken(ruled_surface(curve("bottom_mm"), curve("top_mm"), Side::against));
    const DualPath start = two_point_path(surface, cylinder, 120, 1);
    const FlankDeformation options{.range = range};
    const auto made = taken(deform_flank(start, cylinder, surface, options));
    expect_sound(start, made, options);
    EXPECT_GT(made.before.peak_mm, 0.02);
    EXPECT_LT(made.after.peak_mm, made.before.peak_mm / 3);
    EXPECT_LT(closely(made.path, cylinder, surface, range).peak_mm, made.before.peak_mm / 3);
}

TEST(FlankMilling, OnRandomBladesNothingGetsWorse) {
    std::uint32_t state = 20261122;
    const auto drawn = [&](double from, double to) {
        state = state * 1664525u + 1013904223u;
        return std::lerp(from, to, state / 4294967296.0);
    };
    for (int trial = 0; trial < 6; ++trial) {
        SCOPED_TRACE("seed 20261122, trial " + std::to_string(trial));
        const double twist = drawn(5, 35) * degree, belly = trial % 2 == 0 ? 0 : drawn(0.02, 0.3);
        const FlankTool tool{.kind = trial % 3 == 0 ? FlankKind::cone : FlankKind::cylinder,
                             .radius_mm = drawn(3, 8),
                             .half_angle_rad = drawn(0, 5) * degree};
        const auto surface = blade(twist, belly);
        const DualPath start = two_point_path(surface, tool, 13);
        const FlankDeformation options{.range = blade_range(), .most_movement_mm = drawn(0.05, 1)};
        const auto made = taken(deform_flank(start, tool, surface, options));
        expect_sound(start, made, options);
        EXPECT_LT(made.after.peak_mm, 0.9 * made.before.peak_mm);
    }
}

TEST(FlankMilling, AToolTooLargeForAHollowIsRefusedWithTheRadiusThatFits) {
    std::vector<std::vector<Vector3d>> rows(2);
    for (int i = 0; i <= 24; ++i) {
        const double turn = std::numbers::pi * i / 24;
        for (const int r : {0, 1})
            rows[static_cast<std::size_t>(r)].emplace_back(8 * std::cos(turn), 8 * std::sin(turn), 30 * r);
    }
    const auto surface = taken(guided_surface(rows, Side::against));
    const FlankTool thin{.radius_mm = 5};
    const DualPath start = two_point_path(surface, thin);
    const auto fits = check_hollows(start, thin, surface, blade_range());
    EXPECT_TRUE(fits) << (fits ? "" : to_string(fits.error()));
    const FlankTool large{.radius_mm = 8.5};
    const auto refused = deform_flank(start, large, surface, {.range = blade_range()});
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, "DEFO0110");
    EXPECT_NEAR(std::stod(refused.error().limit), 8, 0.1);
}

TEST(FlankMilling, RefusesOptionsOutOfRange) {
    const auto surface = blade(10 * degree);
    const DualPath start = two_point_path(surface, cylinder);
    const auto refusal = [&](const FlankDeformation& options) {
        const auto made = deform_flank(start, cylinder, surface, options);
        return made ? std::string("accepted") : made.error().code;
    };
    EXPECT_EQ(refusal({.range = blade_range(), .most_movement_mm = 0}), "DEFO0105");
    EXPECT_EQ(refusal({.range = blade_range(), .deepest_mm = -1}), "DEFO0105");
    EXPECT_EQ(refusal({.range = blade_range(), .peak_rounds = -1}), "DEFO0105");
    EXPECT_EQ(refusal({.range = {.from_height_mm = 2, .to_height_mm = 32, .heights = 1}}), "DEFO0105");
    EXPECT_EQ(refusal({.range = {.from_height_mm = 3, .to_height_mm = 2}}), "DEFO0111");
    EXPECT_EQ(refusal({.range = blade_range(), .most_movement_mm = 1e-5, .deepest_mm = 0}), "DEFO0115");
}

}  // namespace
