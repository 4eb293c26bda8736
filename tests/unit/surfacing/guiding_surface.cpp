#include "trunnion/surfacing/guiding_surface.hpp"

#include <cmath>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "sample_parts.hpp"

namespace {

using namespace trunnion;
using namespace trunnion::surfacing;
using namespace trunnion::surfacing::samples;
using Eigen::Vector3d;

struct Case {
    std::string name;
    Face face;
};

std::vector<Case> cases() {
    Face trimmed = free_form_face();
    trimmed.loops = {{{0.1, 0.15}, {0.8, 0.1}, {0.95, 0.7}, {0.5, 0.6}, {0.2, 0.9}}};
    return {{"plane", facing(plane(60, 40), {0, 0, 1})},
            {"cylinder", facing(cylinder(20, 50, 2), {0, 0, 1})},
            {"hollow cylinder", facing(cylinder(20, 50, 2), {0, 0, -1})},
            {"sphere", facing(torus(0, 25, -0.6, 1.2, 1.2), {1, 0, 0})},
            {"torus", facing(torus(60, 20, -0.8, 1.6, 1), {1, 0, 0})},
            {"free form", free_form_face()},
            {"trimmed", trimmed}};
}

/// Dense truth: the largest |S₁ − (S + r n)| of a grid within the face.
double sampled_error(const Face& face, const GuidingSurface& guiding, double radius) {
    double largest = 0;
    constexpr int places = 240;
    const ParameterBox box = parameter_box(face);
    for (int i = 0; i <= places; ++i)
        for (int j = 0; j <= places; ++j) {
            const geometry::SurfacePlace at{box.low.x() + (box.high - box.low).x() * i / places,
                                            box.low.y() + (box.high - box.low).y() * j / places};
            const auto shape = shape_at(face.surface, at, face.side);
            if (!shape || !contains(face, at)) continue;
            largest = std::max(largest, (guiding.at(at) - shape->point - radius * shape->normal).norm());
        }
    return largest;
}

TEST(GuidingSurface, KeepsItsBoundAndUsesIt) {
    const Cutter cutter = Cutter::make(torus_tool(16, 5)).value();
    for (const auto& [name, face] : cases())
        for (const double tolerance : {0.01, 0.0005}) {
            const auto guiding = GuidingSurface::make(face, cutter, {.tolerance_mm = tolerance});
            ASSERT_TRUE(guiding) << name << ": " << to_string(guiding.error());
            const double sampled = sampled_error(face, *guiding, 5), bound = guiding->error_bound_mm();
            EXPECT_LE(bound, tolerance) << name;
            EXPECT_LE(sampled, bound + 1e-12) << name;
            if (name == "plane") {
                EXPECT_LT(bound, 1e-10);
                EXPECT_EQ(guiding->patches(), 1u);
                continue;
            }
            EXPECT_GT(sampled, bound / 6) << name;      // the bound is no wild guess
            EXPECT_GT(bound, tolerance / 300) << name;  // patches are not wasted
            RecordProperty(name + " " + std::to_string(tolerance), std::to_string(sampled) +
                                                                       " <= " + std::to_string(bound) + ", patches " +
                                                                       std::to_string(guiding->patches()));
        }
}

TEST(GuidingSurface, OfAFlatIsTheSurface) {
    const Face face = free_form_face();
    const auto guiding = GuidingSurface::make(face, Cutter::make(flat_tool(10)).value()).value();
    EXPECT_LT(sampled_error(face, guiding, 0), 1e-10);
    EXPECT_EQ(guiding.patches(), 1u);
}

/// Arcs that are joined at double knots, as CAD systems write cylinders: smooth, though their knots do not say so.
TEST(GuidingSurface, CrossesJointsThatAreSmooth) {
    std::vector<Vector3d> points;
    std::vector<double> weights;
    const auto first = arc(20, 0.5, 1), second = arc(20, 1.5, 1);
    for (const double y : {0.0, 50.0}) {
        for (const ArcPoint& p : first) points.emplace_back(p.x, y, p.y), weights.push_back(p.weight);
        for (std::size_t k = 1; k < 3; ++k)
            points.emplace_back(second[k].x, y, second[k].y), weights.push_back(second[k].weight);
    }
    const geometry::SurfaceDirection two{2, {0, 0, 0, 1, 1, 2, 2, 2}};
    const Face face = facing(geometry::BsplineSurface::make(line(), two, points, weights).value(), {0, 0, 1});
    const auto guiding = GuidingSurface::make(face, Cutter::make(ball_tool(10)).value());
    ASSERT_TRUE(guiding) << to_string(guiding.error());
    EXPECT_LE(sampled_error(face, *guiding, 5), guiding->error_bound_mm());
}

std::string code_of(const Result<GuidingSurface>& made) {
    return made ? "" : made.error().code;
}

TEST(GuidingSurfaceRefuses, ToolsThatAreRounderThanTheHollow) {
    // A ball in a hollow sphere, and in a hollow cylinder of 20 mm: it fits as long as it is smaller.
    const Face bowl = facing(torus(0, 6, -0.6, 1.2, 1.2), {-1, 0, 0}), trough = facing(cylinder(20, 50, 2), {0, 0, -1});
    const auto with_ball = [&](const Face& face, double diameter) {
        return GuidingSurface::make(face, Cutter::make(ball_tool(diameter)).value());
    };
    EXPECT_EQ(code_of(with_ball(bowl, 11)), "");
    EXPECT_EQ(code_of(with_ball(trough, 39)), "");
    EXPECT_EQ(code_of(with_ball(trough, 41)), "SURF0304");
    const auto refused = with_ball(bowl, 16);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, "SURF0304");
    EXPECT_NE(refused.error().value.find("radius of the hollow 6 mm"), std::string::npos) << refused.error().value;
}

TEST(GuidingSurfaceRefuses, CreasesPolesAndBadOptions) {
    const Cutter ball = Cutter::make(ball_tool(4)).value();
    const geometry::SurfaceDirection bent{1, {0, 0, 1, 2, 2}};
    const auto roof = [&](double height) {
        return facing(
            geometry::BsplineSurface::make(
                bent, line(), {{0, 0, 0}, {0, 20, 0}, {10, 0, height}, {10, 20, height}, {20, 0, 0}, {20, 20, 0}})
                .value(),
            {0, 0, 1});
    };
    EXPECT_EQ(code_of(GuidingSurface::make(roof(2), ball)), "SURF0306");
    EXPECT_EQ(code_of(GuidingSurface::make(roof(0), ball)), "");
    const Face to_the_pole = facing(torus(0, 25, 0.4, std::acos(-1.0) / 2 - 0.4, 1), {1, 0, 0});
    EXPECT_EQ(code_of(GuidingSurface::make(to_the_pole, ball)), "SURF0303");
    EXPECT_EQ(code_of(GuidingSurface::make(free_form_face(), ball, {.tolerance_mm = 0})), "SURF0301");
    EXPECT_EQ(code_of(GuidingSurface::make(free_form_face(), ball, {.tolerance_mm = 1e-6, .most_patches = 50})),
              "SURF0305");
}

}  // namespace
