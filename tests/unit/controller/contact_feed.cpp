#include "trunnion/controller/contact_feed.hpp"

#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "trunnion/machine/kinematics.hpp"

#include "made.hpp"

namespace {

using namespace trunnion;
using controller::contact_from_tip_mm;
using Eigen::Vector3d;
using machine::Tool;
using machine::ToolKind;

const Vector3d up = Vector3d::UnitZ(), ahead = Vector3d::UnitX();

TEST(ContactFeed, PointsOfTheTool) {
    const Tool flat{.kind = ToolKind::flat, .diameter_mm = 10};
    EXPECT_LT((contact_from_tip_mm(flat, up, ahead, 5 * degree) - Vector3d(5, 0, 0)).norm(), 1e-12);
    EXPECT_LT((contact_from_tip_mm(flat, up, ahead, -5 * degree) - Vector3d(-5, 0, 0)).norm(), 1e-12);
    EXPECT_LT(contact_from_tip_mm(flat, up, ahead, 0).norm(), 1e-12);
    const Tool ball{.kind = ToolKind::ball, .diameter_mm = 10, .corner_radius_mm = 5};
    const Vector3d on_ball = contact_from_tip_mm(ball, up, ahead, 30 * degree);
    EXPECT_NEAR((on_ball - Vector3d(0, 0, 5)).norm(), 5, 1e-12);
    EXPECT_NEAR(on_ball.x(), 2.5, 1e-12);
    const Tool torus{.kind = ToolKind::torus, .diameter_mm = 10, .corner_radius_mm = 1};
    const Vector3d on_torus = contact_from_tip_mm(torus, up, ahead, 5 * degree);
    EXPECT_NEAR((on_torus - Vector3d(4, 0, 1)).norm(), 1, 1e-12);
    EXPECT_LT(contact_from_tip_mm(torus, up, up, 5 * degree).norm(), 1e-12);
}

/// Nowhere is the tool deeper than where it touches: its points lie above the plane across the normal.
TEST(ContactFeed, NoPointOfTheToolIsDeeper) {
    const Tool torus{.kind = ToolKind::torus, .diameter_mm = 12, .corner_radius_mm = 2};
    for (const double lead : {-20 * degree, 3 * degree, 40 * degree}) {
        const Vector3d normal = std::cos(lead) * up - std::sin(lead) * ahead;
        const double depth = contact_from_tip_mm(torus, up, ahead, lead).dot(normal);
        for (double round = 0; round < 6.28; round += 0.1)
            for (double along = 0; along < 1.6; along += 0.05) {
                const double radius = 4 + 2 * std::sin(along);
                const Vector3d at(radius * std::cos(round), radius * std::sin(round), 2 - 2 * std::cos(along));
                EXPECT_GE(at.dot(normal), depth - 1e-12);
            }
    }
}

/// Ω against differences of the tool axis, with the chain turned about and counted the other way.
TEST(ContactFeed, TurningOfTheTool) {
    auto machine = test::made_machine();
    machine.axes[3].reversed = true;
    const machine::Frame workpiece{{10, 20, 30},
                                   Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized()).toRotationMatrix()};
    const auto kinematics = machine::Kinematics::make(machine, workpiece, 100).value();
    const machine::AxisPosition at{{1, 2, 3, 0.4, -1.1}};
    const machine::AxisVelocity velocity{{0, 0, 0, 0.3, 0.8}};
    const double step = 1e-6;
    const auto axis_at = [&](double time) {
        auto position = at;
        for (std::size_t a = 3; a < 5; ++a) position[a] += time * velocity[a];
        return kinematics.forward(position).axis_in_workpiece;
    };
    const Vector3d rate = (axis_at(step) - axis_at(-step)) / (2 * step);
    const Vector3d turning = controller::tool_turning_rad_s(machine, workpiece, at, velocity);
    EXPECT_LT((turning.cross(axis_at(0)) - rate).norm(), 1e-8);
    // Nothing but A: about X of the machine, in the workpiece, against ISO 841.
    const Vector3d of_a = controller::tool_turning_rad_s(machine, workpiece, {{0, 0, 0, 0.4, 0}}, {{0, 0, 0, 1, 0}});
    EXPECT_LT((workpiece.rotation * of_a - Vector3d(-1, 0, 0)).norm(), 1e-12);
}

TEST(ContactFeed, IsInTheRowsWhereTheToolIsKnown) {
    const auto program = test::moves(30, {{60, 0, 20}, {60, 40, 20, 30, 0}});
    EXPECT_TRUE(std::isnan(test::predicted(program, test::made_control()).rows[3].contact_feed_mm_s));
    machine::Setup setup;
    setup.tool = {.kind = ToolKind::flat, .diameter_mm = 16};
    const auto upright = test::predicted(program, test::made_control(), setup);
    for (const auto& row : upright.rows) EXPECT_NEAR(row.contact_feed_mm_s, row.tip_feed_mm_s, 1e-6);
    controller::PredictOptions leaning;
    leaning.contact_lead_rad = 5 * degree;
    double farthest = 0;
    for (const auto& row : test::predicted(program, test::made_control(), setup, leaning).rows)
        if (row.tip_feed_mm_s > 0) farthest = std::max(farthest, row.contact_feed_mm_s / row.tip_feed_mm_s);
    EXPECT_GT(farthest, 1.001);
}

}  // namespace
