#include "trunnion/surfacing/chord_steps.hpp"

#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace {

using namespace trunnion::surfacing;
using Eigen::Vector3d;

/// Lin & Koren, Eq. 8.
Vector3d their_curve(double u) {
    return {10 * u * u * u + 10 * u * u + 10, 10 * u * u + 10 * u, 0};
}
Vector3d their_normal(double u) {
    const Vector3d along = Vector3d(30 * u * u + 20 * u, 20 * u + 10, 0).normalized();
    return {-along.y(), along.x(), 0};
}

std::vector<double> their_steps(double tolerance_mm) {
    return chord_steps([](double from, double to) { return chord_error_mm(their_curve, from, to); }, 0, 1, tolerance_mm,
                       1);
}

TEST(ChordSteps, OfTheirCurveAreFiftyFive) {
    EXPECT_EQ(their_steps(0.001).size() - 1, 55u);
    EXPECT_EQ(their_steps(0.0011).size() - 1, 52u);  // the number in the paper
}

TEST(ChordSteps, KeepTheToleranceAndUseIt) {
    const auto at = their_steps(0.001);
    EXPECT_EQ(at.front(), 0);
    EXPECT_EQ(at.back(), 1);
    double largest = 0;
    for (std::size_t i = 0; i + 1 < at.size(); ++i) {
        double off = 0;
        const Vector3d a = their_curve(at[i]), way = their_curve(at[i + 1]) - a;
        for (int k = 0; k <= 200; ++k) {
            const Vector3d p = their_curve(at[i] + (at[i + 1] - at[i]) * k / 200) - a;
            off = std::max(off, p.cross(way).norm() / way.norm());
        }
        EXPECT_LT(off, 0.0010001) << i;
        if (i + 3 < at.size()) {
            EXPECT_GT(off, 0.00099) << i;
        }
        largest = std::max(largest, off);
    }
    EXPECT_GT(largest, 0.00099);
}

/// Largest angle between the curve's normal and the normals at a step's ends, turned in proportion to `share` of the
/// step.
template <class Share>
double orientation_error_deg(const Share& share) {
    const auto at = their_steps(0.001);
    double largest = 0;
    for (std::size_t i = 0; i + 1 < at.size(); ++i)
        for (int k = 1; k < 50; ++k) {
            const double u = at[i] + (at[i + 1] - at[i]) * k / 50, w = share(at[i], at[i + 1], u);
            const Vector3d n = ((1 - w) * their_normal(at[i]) + w * their_normal(at[i + 1])).normalized();
            largest = std::max(largest, std::asin(n.cross(their_normal(u)).norm()) * 180 / 3.14159265358979);
        }
    return largest;
}

TEST(ChordSteps, LeaveTheirOrientationError) {
    const auto along_chord = [](double from, double to, double u) {
        const Vector3d way = their_curve(to) - their_curve(from);
        return (their_curve(u) - their_curve(from)).dot(way) / way.squaredNorm();
    };
    EXPECT_NEAR(orientation_error_deg(along_chord), 0.0170, 0.0003);
    EXPECT_NEAR(orientation_error_deg([](double from, double to, double u) { return (u - from) / (to - from); }), 0.006,
                0.0005);
}

TEST(ChordSteps, GoStraightInOneStepOrInTheLongest) {
    const auto none = [](double, double) { return 0.0; };
    EXPECT_EQ(chord_steps(none, 2, 9, 0.001, 100).size(), 2u);
    EXPECT_EQ(chord_steps(none, 0, 10, 0.001, 2.5).size(), 5u);
}

}  // namespace
