#include "trunnion/deformation/dual_path.hpp"

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/geometry/great_circle.hpp"

namespace {

using namespace trunnion;
using namespace trunnion::deformation;
using Eigen::Vector3d;

constexpr double infinite = std::numeric_limits<double>::infinity();

/// The tip along a straight line of 60 mm, the tool turning by a swing about an axis across it, evenly.
std::vector<Pose> swinging(int count, double swing_rad) {
    std::vector<Pose> out;
    for (int i = 0; i < count; ++i) {
        const double w = static_cast<double>(i) / (count - 1), turn = (w - 0.5) * swing_rad;
        out.push_back({Vector3d(60 * w, 0, 0), Vector3d(std::sin(turn), 0, std::cos(turn))});
    }
    return out;
}

/// A curved way with an axis that leans to and fro.
Pose curved(double w) {
    const double lean = 0.3 * std::sin(3 * w), round = 2 * w;
    return {Vector3d(40 * std::cos(round), 40 * std::sin(round), 8 * std::sin(2.5 * w)),
            Vector3d(std::sin(lean) * std::cos(round), std::sin(lean) * std::sin(round), std::cos(lean))};
}

std::vector<Pose> curved_poses(int count) {
    std::vector<Pose> out;
    for (int i = 0; i < count; ++i) out.push_back(curved(static_cast<double>(i) / (count - 1)));
    return out;
}

FittedDualPath fitted(const std::vector<Pose>& poses, const DualFit& fit = {}) {
    auto made = fit_dual_path(poses, fit);
    if (!made) throw std::runtime_error(to_string(made.error()));
    return std::move(*made);
}

std::string refusal(const std::vector<Pose>& poses, const DualFit& fit = {}) {
    const auto made = fit_dual_path(poses, fit);
    return made ? "accepted" : made.error().code;
}

/// Largest step of value, first and second derivative at the inner knots, relative to their size.
double largest_jump(const geometry::BsplineCurve& curve) {
    double worst = 0;
    for (const double u : curve.knots()) {
        if (u <= curve.begin() || u >= curve.end()) continue;
        const auto [from, to] = curve.interval_at(u);
        const auto before = curve.interval_at(std::nextafter(u, -infinite));
        const auto left = curve.piece(before.first, before.second).evaluate(1);
        const auto right = curve.piece(from, to).evaluate(0);
        double l = 1, r = 1;
        for (int k = 0; k < 3; ++k, l *= before.second - before.first, r *= to - from)
            worst = std::max(worst, (left[k] / l - right[k] / r).norm() / (1 + right[k].norm() / r));
    }
    return worst;
}

double sampled_distance_error(const DualPath& path) {
    double worst = 0;
    for (int i = 0; i <= 5000; ++i) {
        const double u = std::lerp(path.begin(), path.end(), i / 5000.0);
        const double distance = (path.spline.top().evaluate(u)[0] - path.spline.bottom().evaluate(u)[0]).norm();
        worst = std::max(worst, std::abs(distance - path.distance_mm));
    }
    return worst;
}

TEST(DualPath, GoesThroughAllPosesUnderEveryEndConditionAndParameter) {
    const auto poses = curved_poses(23);
    for (const EndCondition ends : {EndCondition::natural, EndCondition::not_a_knot, EndCondition::tangents})
        for (const auto parameter : {Parametrisation::chord_length, Parametrisation::centripetal}) {
            DualFit fit{.parametrisation = parameter, .ends = ends};
            fit.tangent_at_begin.tip = {0, 1, 0};
            fit.tangent_at_end.tip = {-0.9, -0.4, 0};
            const auto made = fitted(poses, fit);
            EXPECT_LT(made.tip_deviation_mm, 1e-10);
            EXPECT_LT(made.orientation_deviation_rad, 1e-12);
            EXPECT_LT(largest_jump(made.path.spline.bottom()), 1e-8);
            EXPECT_LT(largest_jump(made.path.spline.top()), 1e-8);
            EXPECT_LE(made.distance_error_mm, 1e-3);
            for (std::size_t i = 0; i < poses.size(); ++i)
                EXPECT_LT((made.path.at(made.parameters[i]).tip_in_workpiece_mm - poses[i].tip_in_workpiece_mm).norm(),
                          1e-10);
        }
}

TEST(DualPath, EndConditionsHold) {
    const auto poses = curved_poses(12);
    DualFit fit{.ends = EndCondition::natural};
    const auto natural = fitted(poses, fit);
    for (const double u : {natural.path.begin(), natural.path.end()})
        EXPECT_LT(natural.path.spline.bottom().evaluate(u)[2].norm(), 1e-9);
    fit.ends = EndCondition::tangents;
    fit.tangent_at_begin = {{0.2, 0.9, 0.1}, {0.001, 0.002, 0}};
    fit.tangent_at_end = {{-0.8, 0.3, 0}, {0, -0.004, 0}};
    const auto tangent = fitted(poses, fit);
    EXPECT_LT((tangent.path.spline.bottom().evaluate(0)[1] - fit.tangent_at_begin.tip).norm(), 1e-12);
    EXPECT_LT((tangent.path.spline.bottom().evaluate(tangent.path.end())[1] - fit.tangent_at_end.tip).norm(), 1e-12);
    fit.ends = EndCondition::not_a_knot;
    const auto free = fitted(poses, fit);
    const auto third = [&](double u) { return free.path.spline.bottom().evaluate(u)[3]; };
    EXPECT_LT((third(0.5 * free.parameters[1]) - third(0.5 * (free.parameters[1] + free.parameters[2]))).norm(), 1e-9);
}

/// 40° there and back: what the distance of the splines is off before normalisation, and behind it.
TEST(DualPath, TheDistanceIsApproximateBeforeNormalisationAndExactBehindIt) {
    for (const auto& [count, least_mm, most_mm] : {std::tuple{8, 0.065, 0.068}, {30, 0.00040, 0.00042}}) {
        std::vector<Pose> poses;
        DualFit fit{.distance_mm = 50, .distance_tolerance_mm = infinite};
        for (int i = 0; i < count; ++i) {
            const double w = static_cast<double>(i) / (count - 1);
            const double turn = 40 * degree * std::sin(std::numbers::pi * w);
            poses.push_back({Vector3d(60 * w, 0, 0), Vector3d(std::sin(turn), 0, std::cos(turn))});
            fit.parameters.push_back(w);
        }
        const auto made = fitted(poses, fit);
        EXPECT_GT(sampled_distance_error(made.path), least_mm);
        EXPECT_LT(made.distance_error_mm, most_mm);
        for (double u = 0; u <= 1; u += 0.001) {
            const double distance = (made.path.point_mm(u, 50) - made.path.at(u).tip_in_workpiece_mm).norm();
            ASSERT_NEAR(distance, 50, 1e-11);
        }
    }
}

TEST(DualPath, TheDistanceIsHeldByKnotsThatDoNotMoveTheTip) {
    const auto poses = swinging(8, 40 * degree);
    for (const double tolerance : {1e-3, 1e-5}) {
        const auto loose = fitted(poses, {.distance_tolerance_mm = infinite});
        const auto held = fitted(poses, {.distance_tolerance_mm = tolerance});
        EXPECT_LE(held.distance_error_mm, tolerance);
        EXPECT_GT(held.distance_error_mm, tolerance / 100) << "the tolerance is used";
        EXPECT_LE(sampled_distance_error(held.path), held.distance_error_mm * (1 + 1e-9)) << "it is a bound";
        EXPECT_GT(sampled_distance_error(held.path), 0.5 * held.distance_error_mm) << "and a tight one";
        EXPECT_LT(held.orientation_deviation_rad, 1e-12);
        for (double u = 0; u <= held.path.end(); u += 0.1)
            ASSERT_LT((held.path.at(u).tip_in_workpiece_mm - loose.path.at(u).tip_in_workpiece_mm).norm(), 1e-9);
    }
}

TEST(DualPath, LeastSquaresKeepTheTolerancesWithFewKnots) {
    const auto poses = curved_poses(400);
    std::size_t points = poses.size();
    for (const double tolerance : {1e-4, 1e-3, 1e-2}) {
        const auto made = fitted(poses, {.distance_tolerance_mm = infinite,
                                         .tip_tolerance_mm = tolerance,
                                         .orientation_tolerance_rad = tolerance / 20});
        EXPECT_LE(made.tip_deviation_mm, tolerance);
        EXPECT_LE(made.orientation_deviation_rad, tolerance / 20);
        EXPECT_GT(std::max(made.tip_deviation_mm, 20 * made.orientation_deviation_rad), tolerance / 50);
        const std::size_t needed = made.path.spline.bottom().control_points_mm().size();
        EXPECT_LE(needed, points);
        EXPECT_LT(needed, 80u);
        points = needed;
        EXPECT_LT(largest_jump(made.path.spline.top()), 1e-8);
        EXPECT_LT((made.path.at(0).tip_in_workpiece_mm - poses.front().tip_in_workpiece_mm).norm(), 1e-9);
    }
}

TEST(DualPath, AWeightDrawsThePathNear) {
    auto poses = curved_poses(100);
    poses[50].tip_in_workpiece_mm.z() += 0.05;
    DualFit fit{.distance_tolerance_mm = infinite, .tip_tolerance_mm = 0.06, .orientation_tolerance_rad = 0.01};
    const auto off = [&](const FittedDualPath& made) {
        return (made.path.at(made.parameters[50]).tip_in_workpiece_mm - poses[50].tip_in_workpiece_mm).norm();
    };
    const double even = off(fitted(poses, fit));
    fit.weights.assign(100, 1);
    fit.weights[50] = 1000;
    EXPECT_LT(off(fitted(poses, fit)), 0.2 * even);
}

TEST(DualPath, OneSidedStaysOutOfThePart) {
    auto poses = curved_poses(200);
    std::uint32_t state = 7;
    std::vector<Vector3d> normals;
    for (Pose& pose : poses) {
        state = state * 1664525u + 1013904223u;
        const Vector3d out = Vector3d(pose.tip_in_workpiece_mm.x(), pose.tip_in_workpiece_mm.y(), 0).normalized();
        pose.tip_in_workpiece_mm += 0.004 * (state / 4294967296.0 - 0.5) * out;
        normals.push_back(out);
    }
    DualFit fit{.distance_tolerance_mm = infinite, .tip_tolerance_mm = 0.02, .orientation_tolerance_rad = 0.01};
    const auto deepest = [&](const FittedDualPath& made, double height) {
        double worst = -infinite;
        for (std::size_t i = 0; i < poses.size(); ++i) {
            const Vector3d wanted = poses[i].tip_in_workpiece_mm + height * poses[i].axis_in_workpiece;
            worst = std::max(worst, normals[i].dot(wanted - made.path.point_mm(made.parameters[i], height)));
        }
        return worst;
    };
    EXPECT_GT(deepest(fitted(poses, fit), 0), 0.001) << "seed 7: without it the path cuts into the part";
    for (const double height : {0.0, 5.0})
        for (const double allowed : {0.0, 0.0005}) {
            fit.normals = normals;
            fit.deepest_mm = allowed;
            fit.side_height_mm = height;
            const auto made = fitted(poses, fit);
            EXPECT_LE(deepest(made, height), allowed + 1e-8) << "seed 7";
            EXPECT_NEAR(deepest(made, height), made.deepest_mm, 1e-12);
            EXPECT_LE(made.tip_deviation_mm, 0.02);
        }
}

TEST(DualPath, RefusesBadPoses) {
    const auto good = curved_poses(10);
    EXPECT_EQ(refusal({good.begin(), good.begin() + 3}), "DEFO0101");
    EXPECT_EQ(refusal({good.begin(), good.begin() + 3}, {.ends = EndCondition::natural}), "accepted");
    EXPECT_EQ(refusal({good.begin(), good.begin() + 1}, {.ends = EndCondition::natural}), "DEFO0101");
    const auto with = [&](const std::function<void(std::vector<Pose>&)>& change) {
        auto poses = good;
        change(poses);
        return refusal(poses);
    };
    EXPECT_EQ(with([](auto& p) { p[4] = p[3]; }), "DEFO0102");
    EXPECT_EQ(with([](auto& p) { p[4].axis_in_workpiece = -p[3].axis_in_workpiece; }), "DEFO0103");
    EXPECT_EQ(with([](auto& p) { p[4].tip_in_workpiece_mm.x() = NAN; }), "DEFO0104");
    EXPECT_EQ(with([](auto& p) { p[4].axis_in_workpiece *= 1.01; }), "DEFO0104");
    EXPECT_EQ(with([](auto&) {}), "accepted");
}

TEST(DualPath, RefusesOptionsThatContradict) {
    const auto poses = curved_poses(10);
    const auto with = [&](const std::function<void(DualFit&)>& change) {
        DualFit fit;
        change(fit);
        return refusal(poses, fit);
    };
    EXPECT_EQ(with([](auto& f) { f.distance_mm = 0; }), "DEFO0105");
    EXPECT_EQ(with([](auto& f) { f.distance_tolerance_mm = NAN; }), "DEFO0105");
    EXPECT_EQ(with([](auto& f) { f.tip_tolerance_mm = 0.1; }), "DEFO0105");
    EXPECT_EQ(with([](auto& f) { f.weights.assign(10, 1); }), "DEFO0105");
    EXPECT_EQ(with([](auto& f) { f.parameters = {0, 1}; }), "DEFO0105");
    EXPECT_EQ(with([](auto& f) { f.parameters = {0, 1, 2, 3, 3, 5, 6, 7, 8, 9}; }), "DEFO0105");
    EXPECT_EQ(with([](auto& f) { f.parameters = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9}; }), "accepted");
}

TEST(DualPath, AToleranceThatFewControlPointsCannotKeepIsRefusedWithTheOneThatTheyCan) {
    const auto poses = curved_poses(200);
    DualFit fit{.distance_tolerance_mm = infinite,
                .tip_tolerance_mm = 1e-6,
                .orientation_tolerance_rad = 1e-6,
                .most_control_points = 20};
    const auto refused = fit_dual_path(poses, fit);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, "DEFO0106");
    fit.tip_tolerance_mm = std::stod(refused.error().value) * 1.001;
    fit.orientation_tolerance_rad = 0.01;
    EXPECT_EQ(refusal(poses, fit), "accepted") << refused.error().value;
}

TEST(DualPath, ATurnThatLeavesNoDistanceIsRefused) {
    std::vector<Pose> poses;
    for (int i = 0; i < 8; ++i) {
        const double turn = 165 * degree * i;
        poses.push_back({Vector3d(i, 0, 0), Vector3d(std::sin(turn), 0, std::cos(turn))});
    }
    EXPECT_EQ(refusal(poses, {.most_control_points = 50}), "DEFO0107");
}

}  // namespace
