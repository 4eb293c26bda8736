#include "trunnion/surfacing/part_body.hpp"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "sample_parts.hpp"

namespace {

using namespace trunnion;
using namespace trunnion::surfacing;
using namespace trunnion::surfacing::samples;
using Eigen::Vector3d;

const Vector3d up(0, 0, 1);

PartBody body_of(const std::vector<Face>& faces, double tolerance_mm = 0.001) {
    return PartBody::make(faces, tolerance_mm).value();
}

TEST(PartBody, OfAPlaneIsAsDeepAsTheToolIsUnderIt) {
    Face top = facing(plane(100, 100), up);
    top.solid = true;
    const PartBody part = body_of({top});
    EXPECT_EQ(part.triangles(), 2u);
    for (const auto& tool : {flat_tool(10), ball_tool(10), torus_tool(10, 2)}) {
        const Cutter cutter = Cutter::make(tool, 40).value();
        EXPECT_EQ(part.depth_mm(cutter, {{50, 50, 0.001}, up}), 0);
        EXPECT_NEAR(part.depth_mm(cutter, {{50, 50, -0.3}, up}), 0.3, 1e-4);
        EXPECT_NEAR(part.depth_mm(cutter, {{50, 50, -4}, up}), 4, 1e-4);
        EXPECT_NEAR(part.depth_mm(cutter, {{50, 50, -60}, up}), 60, 1e-3);  // wholly inside
        EXPECT_EQ(part.depth_mm(cutter, {{200, 50, -4}, up}), 0);           // beside it
        // Lying on its side.
        EXPECT_NEAR(part.depth_mm(cutter, {{30, 50, 4.8}, {1, 0, 0}}), 0.2, 1e-4);
        EXPECT_NEAR(part.depth_mm(cutter, {{30, 50, -2}, {1, 0, 0}}), 7, 1e-4);
    }
}

/// What is behind a sheet nobody says: it is found where it is within the tool, whichever side that comes from.
TEST(PartBody, OfASheetIsAsThinAsPaper) {
    for (const Vector3d& out : {up, Vector3d(-up)}) {
        const PartBody part = body_of({facing(plane(100, 100), out)});
        const Cutter ball = Cutter::make(ball_tool(10), 40).value();
        EXPECT_EQ(part.depth_mm(ball, {{50, 50, 0.001}, up}), 0);
        EXPECT_NEAR(part.depth_mm(ball, {{50, 50, -0.3}, up}), 0.3, 1e-4);
        EXPECT_NEAR(part.depth_mm(ball, {{50, 50, -4}, up}), 4, 1e-3);
        EXPECT_NEAR(part.depth_mm(ball, {{50, 50, -20}, up}), 5, 0.01);  // through it, up to its axis
        EXPECT_NEAR(part.depth_mm(ball, {{50, 50, -39.8}, up}), 0.2, 1e-4);
        EXPECT_EQ(part.depth_mm(ball, {{50, 50, -40.001}, up}), 0);  // behind it
        EXPECT_EQ(part.depth_mm(ball, {{50, 50, -80}, up}), 0);
    }
}

/// A sheet before a solid hides nothing of it.
TEST(PartBody, KnowsTheInsideOfASolidBehindASheet) {
    std::vector<Face> faces = block(40, 30, 20);
    for (Face& face : faces) face.solid = true;
    faces.push_back(rectangle({0, 0, 10}, {0, 30, 0}, {40, 0, 0}));  // in the middle of it, down
    const Cutter ball = Cutter::make(ball_tool(2), 3).value();
    EXPECT_NEAR(body_of(faces).depth_mm(ball, {{20, 15, 5}, up}), 1 + 6, 1e-6);
    for (Face& face : faces) face.solid = false;
    EXPECT_EQ(body_of(faces).depth_mm(ball, {{20, 15, 5}, up}), 0);
}

TEST(PartBody, OfASphereIsAsDeepAsCentresTell) {
    const PartBody part = body_of({facing(torus(0, 25, -0.5, 1, 1), {1, 0, 0})}, 0.0005);
    const Cutter ball = Cutter::make(ball_tool(8), 30).value();
    const Vector3d out = Vector3d(1, 0.3, -0.2).normalized(), axis = Vector3d(1, -0.4, 0.5).normalized();
    for (const double depth : {-0.01, 0.002, 0.1, 1.0, 3.0}) {
        const CutterPose pose{(25 + 4 - depth) * out - 4 * axis, axis};
        EXPECT_NEAR(part.depth_mm(ball, pose), std::max(depth, 0.0), 0.0006 + 0.01 * std::abs(depth)) << depth;
    }
}

/// Against the part's faces sampled densely: never less than they show, and at most the tolerance more.
TEST(PartBody, OfAFreeFormIsThatOfDenseSamples) {
    const Face face = free_form_face();
    const PartBody part = body_of({face}, 0.002);
    const Cutter torus_cutter = Cutter::make(torus_tool(12, 3), 40).value();
    const SampledPart samples({face}, 0.25);
    Random random(20261);
    for (int trial = 0; trial < 60; ++trial) {
        const double u = random.between(0.1, 0.9), v = random.between(0.1, 0.9);
        const auto shape = shape_at(face.surface, {u, v}, face.side).value();
        const double a = random.between(-0.6, 0.6), b = random.between(-0.6, 0.6), sunk = random.between(0, 2);
        CutterPose pose =
            torus_cutter.touching(shape.point, shape.normal, (shape.normal + a * shape.e1 + b * shape.e2).normalized());
        pose.tip_mm -= sunk * shape.normal;
        const double sampled = samples.depth_mm(torus_cutter, pose);
        const double depth = part.depth_mm(torus_cutter, pose);
        EXPECT_GT(depth, 0.99 * sampled - 0.0023) << random.seed();
        EXPECT_LT(depth, sampled + 0.02) << random.seed();  // the grid misses the deepest place
    }
}

TEST(PartBody, IsTheFaceWithinItsLoops) {
    Face holed = facing(plane(100, 100), up);
    Loop hole;
    for (int k = 0; k < 90; ++k)
        hole.emplace_back(0.5 + 0.2 * std::cos(4 * k * std::numbers::pi / 180),
                          0.5 + 0.2 * std::sin(4 * k * std::numbers::pi / 180));
    holed.loops.push_back(hole);
    const PartBody part = body_of({holed});
    const Cutter flat = Cutter::make(flat_tool(10), 40).value();
    EXPECT_EQ(part.depth_mm(flat, {{50, 50, -2}, up}), 0);         // through the hole
    EXPECT_EQ(part.depth_mm(flat, {{50 + 14.9, 50, -2}, up}), 0);  // along its border
    EXPECT_NEAR(part.depth_mm(flat, {{50 + 15.5, 50, -2}, up}), 0.5, 0.01);
    EXPECT_NEAR(part.depth_mm(flat, {{80, 50, -2}, up}), 2, 1e-3);
}

/// Trapezoids and curved patches: area and distance of what comes out, by rays of the surface's own points.
TEST(PartBody, KeepsItsToleranceEverywhere) {
    for (const double tolerance : {0.05, 0.002}) {
        Face face = free_form_face();
        face.loops = {{{0.1, 0.15}, {0.8, 0.1}, {0.95, 0.7}, {0.5, 0.6}, {0.2, 0.9}}};
        const PartBody part = body_of({face}, tolerance);
        Random random(77);
        double largest = 0;
        for (int k = 0; k < 3000; ++k) {
            const double u = random.between(0, 1), v = random.between(0, 1);
            const double off = std::abs(part.signed_distance_mm(face.surface.at(u, v)));
            if (contains(face, {u, v})) largest = std::max(largest, off);
        }
        EXPECT_LT(largest, tolerance);
        EXPECT_GT(largest, 0.05 * tolerance);  // not finer than asked for
    }
}

TEST(PartBody, TellsTheFaceThePlaceAndTheHolder) {
    const PartBody part = body_of(pocket_with_wall());
    const Cutter flat = Cutter::make(flat_tool(10), 30).value();
    const auto wall = part.deepest(flat, {{5.5, 30, 0}, Vector3d(-0.1, 0, 1).normalized()}, 0.01);
    ASSERT_TRUE(wall);
    EXPECT_EQ(wall->face, 1);
    EXPECT_NEAR(wall->normal.x(), 1, 1e-12);
    EXPECT_NEAR(wall->at_mm.x(), 0, 1e-9);
    EXPECT_FALSE(wall->by_holder);
    const Holder holder{.radius_mm = 20, .from_mm = 30, .to_mm = 80};
    EXPECT_FALSE(part.deepest(flat, {{15, 30, 0}, up}, 0.01));
    const auto held = part.deepest(flat, {{15, 30, 0}, up}, 0.01, holder);
    ASSERT_TRUE(held);
    EXPECT_TRUE(held->by_holder);
    EXPECT_NEAR(held->depth_mm, 5, 1e-3);
}

TEST(PartBody, KnowsItsInsideAtEdges) {
    const PartBody part = body_of(block(40, 30, 20));
    EXPECT_NEAR(part.signed_distance_mm({20, 15, 10}), -10, 1e-9);
    EXPECT_NEAR(part.signed_distance_mm({43, 34, 10}), 5, 1e-9);
    EXPECT_NEAR(part.signed_distance_mm({39, 29.5, 10}), -0.5, 1e-9);
    EXPECT_NEAR(part.signed_distance_mm({-1, -1, -1}), std::sqrt(3.0), 1e-9);
}

TEST(PartBodyRefuses, WhatIsNoBody) {
    const std::vector<Face> none, one{facing(plane(10, 10), up)}, round{free_form_face()};
    EXPECT_EQ(PartBody::make(none, 0.01).error().code, "SURF0302");
    EXPECT_EQ(PartBody::make(one, 0).error().code, "SURF0301");
    EXPECT_EQ(PartBody::make(one, std::nan("")).error().code, "SURF0301");
    EXPECT_EQ(PartBody::make(round, 1e-9).error().code, "SURF0302");
}

}  // namespace
