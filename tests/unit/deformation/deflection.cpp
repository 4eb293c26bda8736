#include "trunnion/deformation/deflection.hpp"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "flank_blades.hpp"

namespace {

using namespace trunnion;
using namespace trunnion::deformation;
using Eigen::Vector3d;

DualPath wanted_path() {
    return two_point_path(blade(20 * degree), FlankTool{.radius_mm = 5});
}

/// A force that swells towards the middle, away from the part.
Vector3d bend(double s_mm) {
    return Vector3d(0.002, 0.04, 0.005) * std::sin(s_mm / 33) + Vector3d(0, 0.01, 0);
}

TEST(Deflection, TheBentTipRunsOnThePathWanted) {
    const DualPath wanted = wanted_path();
    for (const double tolerance : {1e-3, 1e-5}) {
        const auto made =
            taken(compensate_deflection(wanted, [](double s, const Pose&) { return bend(s); }, tolerance));
        EXPECT_LE(made.residual_mm, tolerance);
        double worst = 0, turn = 0, way = 0;
        Vector3d last = wanted.at(0).tip_in_workpiece_mm;
        for (int i = 0; i <= 4000; ++i) {
            const double u = wanted.end() * i / 4000;
            const Pose is = made.path.at(u), was = wanted.at(u);
            way += (was.tip_in_workpiece_mm - last).norm();
            last = was.tip_in_workpiece_mm;
            worst = std::max(worst, (is.tip_in_workpiece_mm + bend(way) - last).norm());
            turn = std::max(turn, (is.axis_in_workpiece - was.axis_in_workpiece).norm());
        }
        EXPECT_LE(worst, 1.1 * tolerance + 1e-6);
        EXPECT_LE(turn, tolerance / wanted.distance_mm * 1.1);
        EXPECT_NEAR(made.largest_deflection_mm, 0.05, 0.002) << "without it the tip were off by as much";
        EXPECT_NEAR(way, tip_length_mm(wanted), 1e-4);
    }
}

TEST(Deflection, NoForceNoChange) {
    const DualPath wanted = wanted_path();
    const auto made =
        taken(compensate_deflection(wanted, [](double, const Pose&) -> Vector3d { return Vector3d::Zero(); }, 1e-6));
    for (double u = 0; u < wanted.end(); u += 0.37)
        EXPECT_LT((made.path.at(u).tip_in_workpiece_mm - wanted.at(u).tip_in_workpiece_mm).norm(), 1e-6);
}

TEST(Deflection, MayDependOnThePose) {
    const DualPath wanted = wanted_path();
    const auto along_axis = [](double, const Pose& pose) -> Vector3d { return 0.03 * pose.axis_in_workpiece; };
    const auto made = taken(compensate_deflection(wanted, along_axis, 1e-5));
    for (double u = 0; u < wanted.end(); u += 0.9)
        EXPECT_LT((made.path.at(u).tip_in_workpiece_mm - wanted.point_mm(u, -0.03)).norm(), 2e-5);
}

TEST(Deflection, GoesThroughItsSamples) {
    std::vector<DeflectionSample> samples;
    for (int i = 0; i <= 12; ++i) samples.push_back({10.0 * i, bend(10.0 * i)});
    const auto field = taken(deflection_through(samples));
    for (const auto& sample : samples) EXPECT_LT((field(sample.s_mm, {}) - sample.deflection_mm).norm(), 1e-14);
    EXPECT_LT((field(55, {}) - bend(55)).norm(), 1e-4);
}

TEST(Deflection, RefusesBadFieldsAndTolerances) {
    const auto samples = [](const std::vector<DeflectionSample>& given) {
        const auto made = deflection_through(given);
        return made ? std::string("accepted") : made.error().code;
    };
    const Vector3d off(0, 0.01, 0);
    EXPECT_EQ(samples({{0, off}, {100, off}}), "accepted");
    EXPECT_EQ(samples({{0, off}}), "DEFO0116");
    EXPECT_EQ(samples({{0, off}, {0, off}}), "DEFO0116");
    EXPECT_EQ(samples({{0, off}, {10, Vector3d(0, NAN, 0)}}), "DEFO0116");
    const DualPath wanted = wanted_path();
    const auto refusal = [&](const Deflection& field, double tolerance, std::optional<double> covered = {}) {
        const auto made = compensate_deflection(wanted, field, tolerance, covered);
        return made ? std::string("accepted") : made.error().code;
    };
    const auto smooth = [](double s, const Pose&) { return bend(s); };
    EXPECT_EQ(refusal(smooth, 0), "DEFO0105");
    EXPECT_EQ(refusal(smooth, 1e-3, 50), "DEFO0117");
    EXPECT_EQ(refusal(smooth, 1e-3, 500), "accepted");
    EXPECT_EQ(refusal([](double, const Pose&) -> Vector3d { return {NAN, 0, 0}; }, 1e-3), "DEFO0116");
    const auto torn = [](double s, const Pose&) -> Vector3d { return {0, s < 50 ? 0.0 : 0.1, 0}; };
    EXPECT_EQ(refusal(torn, 1e-3), "DEFO0106");
}

}  // namespace
