#include "trunnion/surfacing/orientation_surface.hpp"

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "trunnion/geometry/great_circle.hpp"

#include "sample_parts.hpp"

namespace {

using namespace trunnion;
using namespace trunnion::surfacing;
using namespace trunnion::surfacing::samples;
using Eigen::Vector3d;
using geometry::angle_between;
using geometry::SurfacePlace;

constexpr double degree = std::numbers::pi / 180;

const Face& form() {
    static const Face face = free_form_face();
    return face;
}
const GuidingSurface& guiding() {
    static const auto made = GuidingSurface::make(form(), Cutter::make(torus_tool(12, 3)).value()).value();
    return made;
}
OrientationLimits wide_limits() {
    return {.least_lead_rad = -30 * degree, .most_lead_rad = 30 * degree, .most_tilt_rad = 30 * degree};
}
OrientationSurface with_lead(double lead_deg, double tilt_deg = 0) {
    return OrientationSurface::make(form(), guiding(), Lean{lead_deg * degree, tilt_deg * degree}, wide_limits())
        .value();
}

template <class Visit>
void each_place(int places, const Visit& visit) {
    for (int i = 0; i <= places; ++i)
        for (int j = 0; j <= places; ++j)
            visit(SurfacePlace{static_cast<double>(i) / places, static_cast<double>(j) / places});
}

TEST(OrientationSurface, HoldsLeadAndTiltWithinItsBound) {
    for (const double tolerance : {0.05, 0.002}) {
        const auto made = OrientationSurface::make(form(), guiding(), Lean{10 * degree, -5 * degree}, wide_limits(),
                                                   {.height_mm = 50, .tolerance_mm = tolerance, .spacing_mm = 50});
        ASSERT_TRUE(made);
        double largest = 0, shortest = 1e9, longest = 0;
        each_place(150, [&](const SurfacePlace& at) {
            const auto shape = shape_at(form().surface, at, form().side).value();
            const Vector3d feed = shape.by_u.normalized();
            const Vector3d wanted =
                (shape.normal + std::tan(10 * degree) * feed - std::tan(5 * degree) * shape.normal.cross(feed))
                    .normalized();
            const Vector3d way = made->surface().at(at.u, at.v) - guiding().at(at);
            largest = std::max(largest, (way - 50 * wanted).norm());
            shortest = std::min(shortest, way.norm());
            longest = std::max(longest, way.norm());
            EXPECT_NEAR(made->axis(at).norm(), 1, 1e-14);
        });
        EXPECT_LE(largest, made->error_bound_mm());
        EXPECT_LE(made->error_bound_mm(), tolerance);
        EXPECT_GT(largest, made->error_bound_mm() / 6);
        const auto [low, high] = made->distance_range_mm();
        EXPECT_LE(low, shortest);
        EXPECT_GE(high, longest);
        EXPECT_GT(low, 50 - 3 * tolerance);  // a bound, and not a wide one
        EXPECT_LT(high, 50 + 3 * tolerance);
    }
}

/// Whatever lead and tilt are counted from, on polynomials and on rational surfaces: the bound holds, and is no wild
/// one.
TEST(OrientationSurface, IsProvedToBeWithinItsTolerance) {
    const std::vector<Face> faces{form(), facing(cylinder(20, 30, 2), {0, 0, 1}), facing(plane(40, 30), {0, 0, -1})};
    const FeedReference feeds[] = {{.along = FeedReference::Along::u},
                                   {.along = FeedReference::Along::v},
                                   {.along = FeedReference::Along::direction, .direction = {1, 0.7, 0.2}}};
    for (const Face& face : faces) {
        const auto below = GuidingSurface::make(face, Cutter::make(torus_tool(12, 3)).value()).value();
        const auto &u = below.surface().u(), &v = below.surface().v();
        for (const FeedReference& feed : feeds)
            for (const Lean& lean : {Lean{-8 * degree, 20 * degree}, Lean{0, 0}, Lean{10 * degree, 0}}) {
                if (feed.along != FeedReference::Along::u && lean.tilt_rad == 0) continue;
                OrientationLimits limits = wide_limits();
                limits.feed = feed;
                const auto made = OrientationSurface::make(face, below, lean, limits, {.spacing_mm = 50});
                ASSERT_TRUE(made) << to_string(made.error());
                double largest = 0;
                each_place(30, [&](const SurfacePlace& share) {
                    const SurfacePlace at{u.begin() + share.u * (u.end() - u.begin()),
                                          v.begin() + share.v * (v.end() - v.begin())};
                    const auto shape = shape_at(face.surface, at, face.side).value();
                    const Vector3d wanted = axis_of(lean, shape, *feed.at(shape));
                    largest = std::max(largest, (made->surface().at(at.u, at.v) - below.at(at) - 50 * wanted).norm());
                });
                EXPECT_LE(largest, made->error_bound_mm() + 1e-9);
                EXPECT_LE(made->error_bound_mm(), 0.01);
                EXPECT_LT(made->error_bound_mm(), 8 * largest + 1e-3);
                EXPECT_LT(made->patches(), 400u);
            }
    }
}

TEST(OrientationSurface, HasLimitsThatAreSurfacesThemselves) {
    const auto made = with_lead(5);
    const auto low = made.lower_limit().value(), upper = made.upper_limit().value();
    each_place(20, [&](const SurfacePlace& at) {
        EXPECT_NEAR(angle_between(low.axis(at), upper.axis(at)), 60 * degree, 0.001);
        EXPECT_NEAR(angle_between(low.axis(at), made.axis(at)), 35 * degree, 0.001);
    });
    EXPECT_TRUE(made.beyond_limits().empty());
}

TEST(OrientationSurface, TurnsARegionAndNothingElse) {
    const auto before = with_lead(5);
    const SurfacePlace middle{0.5, 0.45};
    const Vector3d turn = 8 * degree * shape_at(form().surface, middle, form().side)->by_v.normalized();
    const auto after = before.turned(middle, 30, turn);
    ASSERT_TRUE(after) << to_string(after.error());
    // The surface runs under its control points, so the peak is a little lower: less so in a wider region.
    EXPECT_NEAR(angle_between(before.axis(middle), after->axis(middle)), 0.83 * 8 * degree, 0.2 * degree);
    const auto wide = before.turned(middle, 60, turn).value();
    EXPECT_NEAR(angle_between(before.axis(middle), wide.axis(middle)), 0.95 * 8 * degree, 0.2 * degree);
    const double reach = 30 + 3 * 10;  // a control point is felt over two patches more
    bool changed_beside = false;
    each_place(40, [&](const SurfacePlace& at) {
        const double away = (guiding().at(at) - guiding().at(middle)).norm();
        const double turned = angle_between(before.axis(at), after->axis(at));
        EXPECT_LT(turned, 8.2 * degree);
        EXPECT_TRUE(away < reach || turned < 1e-12);
        changed_beside = changed_beside || (away > 15 && turned > 0.5 * degree);
    });
    EXPECT_TRUE(changed_beside);
    // C²: knots stay simple, so second derivatives do not jump.
    const auto& knots = after->surface().u().knots;
    for (std::size_t k = 4; k + 5 < knots.size(); ++k) EXPECT_LT(knots[k], knots[k + 1]);
}

TEST(OrientationSurface, GoesTowardsTargetsAndFadesAway) {
    const auto before = with_lead(5);
    std::vector<OrientationTarget> targets;  // along a curve
    for (int k = 0; k <= 20; ++k) {
        const SurfacePlace at{0.2, 0.1 + 0.04 * k};
        const auto shape = shape_at(form().surface, at, form().side).value();
        targets.push_back({at, axis_of({20 * degree, 5 * degree}, shape, shape.by_u.normalized())});
    }
    const auto after = before.towards(targets);
    ASSERT_TRUE(after) << to_string(after.error());
    for (const auto& target : targets) EXPECT_LT(angle_between(after->axis(target.place), target.axis), 0.2 * degree);
    const auto held = before.towards(targets, 1).value();
    for (const double v : {0.1, 0.5, 0.9}) {  // some 8 patches away, of 16°
        EXPECT_LT(angle_between(before.axis({0.95, v}), after->axis({0.95, v})), 1.6 * degree);
        EXPECT_LT(angle_between(before.axis({0.95, v}), held.axis({0.95, v})), 0.3 * degree);
    }
}

TEST(OrientationSurface, Blends) {
    const OrientationOptions coarse{.tolerance_mm = 0.2};
    const auto make = [&](double lead) {
        return OrientationSurface::make(form(), guiding(), Lean{lead * degree, 0}, wide_limits(), coarse).value();
    };
    const auto low = make(0), high = make(20);
    const auto blend = low.blended(high, [](const SurfacePlace& at) { return at.u; }).value();
    EXPECT_NEAR(angle_between(blend.axis({0, 0.5}), low.axis({0, 0.5})), 0, 1e-9);
    EXPECT_NEAR(angle_between(blend.axis({1, 0.5}), high.axis({1, 0.5})), 0, 1e-9);
    EXPECT_NEAR(angle_between(blend.axis({0.5, 0.5}), low.axis({0.5, 0.5})), 10 * degree, 0.2 * degree);
    EXPECT_EQ(low.blended(high, [](const SurfacePlace&) { return 1.5; }).error().code, "SURF0301");
    const auto coarser = OrientationSurface::make(form(), guiding(), Lean{}, wide_limits(), {.spacing_mm = 40}).value();
    EXPECT_EQ(low.blended(coarser, [](const SurfacePlace&) { return 0.5; }).error().code, "SURF0301");
}

TEST(OrientationSurfaceRefuses, WhatIsBeyondLimitsAndSaysHowFar) {
    const auto made = with_lead(25);
    const SurfacePlace middle{0.5, 0.5};
    const Vector3d turn = 10 * degree * shape_at(form().surface, middle, form().side)->by_v.normalized();
    const auto one = made.turned(middle, 30, turn), other = made.turned(middle, 30, -turn);
    ASSERT_NE(one.has_value(), other.has_value());  // towards more lead it is refused
    const Diagnostic& refused = one ? other.error() : one.error();
    EXPECT_EQ(refused.code, "SURF0308");
    EXPECT_NE(refused.value.find("beyond"), std::string::npos) << refused.value;
    EXPECT_NE(refused.limit.find("30.000 deg"), std::string::npos) << refused.limit;
    const auto too_much = OrientationSurface::make(form(), guiding(), Lean{31 * degree, 0}, wide_limits());
    ASSERT_FALSE(too_much);
    EXPECT_EQ(too_much.error().code, "SURF0308");
    EXPECT_NE(too_much.error().value.find("1.00"), std::string::npos) << too_much.error().value;
    const std::vector<OrientationTarget> target{
        {middle, shape_at(form().surface, middle, form().side)->by_u.normalized()}};
    EXPECT_EQ(made.towards(target).error().code, "SURF0307");
}

TEST(OrientationSurfaceRefuses, AxesInTheTangentPlaneAndBadOptions) {
    OrientationLimits all = wide_limits();
    all.most_lead_rad = 89.9 * degree;
    const auto code = [&](const Lean& lean, const OrientationLimits& limits, const OrientationOptions& options = {}) {
        const auto made = OrientationSurface::make(form(), guiding(), lean, limits, options);
        return made ? std::string() : made.error().code;
    };
    EXPECT_EQ(code({88.5 * degree, 0}, all), "");
    EXPECT_EQ(code({89.5 * degree, 0}, all), "SURF0307");
    EXPECT_EQ(code({0, 0}, wide_limits(), {.height_mm = 0}), "SURF0301");
    EXPECT_EQ(code({0, 0}, wide_limits(), {.tolerance_mm = -1}), "SURF0301");
    OrientationLimits crossed = wide_limits();
    crossed.least_lead_rad = 0.6;
    EXPECT_EQ(code({0, 0}, crossed), "SURF0301");
    OrientationLimits along_normal = wide_limits();
    along_normal.feed = {.along = FeedReference::Along::direction, .direction = {0, 0, 0}};
    EXPECT_EQ(code({0, 0}, along_normal), "SURF0303");
    EXPECT_EQ(code({0.1, 0}, wide_limits(), {.tolerance_mm = 1e-6, .most_patches = 110}), "SURF0305");
    const auto made = with_lead(5);
    EXPECT_EQ(made.turned({2, 0}, 30, {0, 0.1, 0}).error().code, "SURF0309");
    EXPECT_EQ(made.turned({0.5, 0.5}, 0, {0, 0.1, 0}).error().code, "SURF0301");
}

}  // namespace
