#include "trunnion/smoothing/corner.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"

#include "runs.hpp"

namespace trunnion::smoothing {
namespace {

using Eigen::Vector3d;
using geometry::BsplineCurve;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Segments of the given lengths that meet at the interior angle, the corner away from the origin.
struct Angle {
    Vector3d before, corner, after;
    explicit Angle(double degrees, double length_before = 100, double length_after = 100) : corner(3, -2, 7) {
        before = corner - length_before * Vector3d::UnitX();
        const double turn = (180 - degrees) * degree;
        after = corner + length_after * Vector3d(std::cos(turn), 0.6 * std::sin(turn), 0.8 * std::sin(turn));
    }
    Result<BsplineCurve> rounded(double tolerance, double ratio = usual_corner_ratio) const {
        return corner_spline(before, corner, after, {tolerance, ratio});
    }
};

double distance_to_segment(const Vector3d& p, const Vector3d& a, const Vector3d& b) {
    const double share = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
    return (p - a - share * (b - a)).norm();
}

double nearest(const BsplineCurve& curve, const Vector3d& point) {
    double least = infinity;
    for (int i = 0; i <= 1000; ++i) least = std::min(least, (curve.evaluate(i / 1000.0)[0] - point).norm());
    return least;
}

TEST(CornerBasis, IsTheBsplineOfItsKnots) {
    for (int row = 0; row < 5; ++row) {
        std::vector<Vector3d> control(5, Vector3d::Zero());
        control[row].x() = 1;
        const auto spline = BsplineCurve::make(3, {0, 0, 0, 0, 0.5, 1, 1, 1, 1}, control);
        for (int i = 0; i <= 100; ++i) {
            const double u = i / 100.0;
            const auto expected = spline->evaluate(u);
            const CornerBasis basis = corner_basis(u, u < 0.5 ? Half::first : Half::second);
            for (int k = 0; k < 4; ++k)
                EXPECT_NEAR(basis(row, k), expected[k].x(), 1e-13) << row << ' ' << u << ' ' << k;
        }
    }
}

TEST(CornerBasis, HalvesMeetWithSecondDerivativesAndNotWithTheThird) {
    const CornerBasis left = corner_basis(0.5, Half::first), right = corner_basis(0.5, Half::second);
    EXPECT_LT((left - right).leftCols<3>().cwiseAbs().maxCoeff(), 1e-14);
    EXPECT_GT((left - right).col(3).cwiseAbs().maxCoeff(), 1);
    EXPECT_EQ(left(0, 0), 0) << "the outer points have no part in the middle";
    EXPECT_EQ(left(4, 0), 0);
}

TEST(CornerSpline, KeepsTheToleranceAndUsesIt) {
    for (const double angle : {1.0, 30.0, 90.0, 150.0, 179.0}) {
        SCOPED_TRACE(angle);
        constexpr double tolerance = 0.02;
        const Angle at(angle);
        const auto curve = at.rounded(tolerance);
        ASSERT_TRUE(curve);
        EXPECT_NEAR((curve->evaluate(0.5)[0] - at.corner).norm(), tolerance, 1e-12);
        EXPECT_NEAR(nearest(*curve, at.corner), tolerance, 1e-12);

        const double inner = (curve->control_points_mm()[1] - at.corner).norm(), cosine = std::cos(angle * degree);
        double to_polyline = 0;
        for (int i = 0; i <= 1000; ++i) {
            const Vector3d p = curve->evaluate(i / 1000.0)[0];
            to_polyline = std::max(to_polyline, std::min(distance_to_segment(p, at.before, at.corner),
                                                         distance_to_segment(p, at.corner, at.after)));
        }
        EXPECT_NEAR(to_polyline, polyline_error_mm(inner, cosine), 1e-9);
        EXPECT_NEAR(to_polyline, tolerance * std::sin(angle * degree / 2), 1e-9);
    }
}

TEST(CornerSpline, LengthAndErrorAreInverse) {
    for (double angle = 0; angle < 180; angle += 7) {
        const double cosine = std::cos(angle * degree);
        EXPECT_NEAR(corner_error_mm(inner_length_mm(0.3, cosine), cosine), 0.3, 1e-13);
    }
    EXPECT_EQ(inner_length_mm(0.3, -1), infinity);
    EXPECT_NEAR(inner_length_mm(0.02, 0), 0.04 * std::numbers::sqrt2, 1e-15);
}

TEST(CornerSpline, LeavesTheSegmentsWithTangentAndCurvature) {
    const Angle at(70);
    const auto curve = at.rounded(0.5);
    const double inner = inner_length_mm(0.5, std::cos(70 * degree));
    const auto begin = curve->evaluate(0), end = curve->evaluate(1);
    EXPECT_LT((begin[0] - at.corner - 1.4 * inner * (at.before - at.corner).normalized()).norm(), 1e-14);
    EXPECT_LT((end[0] - at.corner - 1.4 * inner * (at.after - at.corner).normalized()).norm(), 1e-14);
    for (const auto& [point, along] : {std::pair{begin, at.corner - at.before}, {end, at.after - at.corner}}) {
        EXPECT_GT(point[1].dot(along), 0);
        EXPECT_LT(point[1].cross(along).norm() / along.norm(), 1e-13);
        EXPECT_LT(point[2].cross(along).norm() / along.norm(), 1e-12);
        EXPECT_GT(point[3].cross(along).norm() / along.norm(), 1) << "G², not G³";
    }
}

TEST(CornerSpline, CurvatureBeginsWithTheSlopeOfTheFormula) {
    for (const double ratio : {1.05, 1.4, 2.5}) {
        const Angle at(110);
        const auto curve = at.rounded(0.3, ratio);
        const auto d = curve->evaluate(0);
        const double inner = inner_length_mm(0.3, std::cos(110 * degree));
        const double slope = d[1].cross(d[3]).norm() / std::pow(d[1].norm(), 4);
        EXPECT_NEAR(end_curvature_slope({inner, ratio * inner, std::cos(110 * degree)}) / slope, 1, 1e-10);
    }
}

TEST(CornerSpline, TakesAtMostHalfOfTheShorterSegment) {
    const Angle at(90, 0.05, 100);
    const auto curve = at.rounded(0.02);
    ASSERT_TRUE(curve);
    for (const int end : {0, 4}) EXPECT_NEAR((curve->control_points_mm()[end] - at.corner).norm(), 0.025, 1e-15);
    EXPECT_NEAR((curve->control_points_mm()[1] - at.corner).norm(), 0.025 / 1.4, 1e-15);
    EXPECT_LT((curve->evaluate(0.5)[0] - at.corner).norm(), 0.02);
}

TEST(CornerSpline, OfSegmentsInLineIsTheLine) {
    const Vector3d along(3, -1, 2);
    const auto curve = corner_spline(-along, Vector3d::Zero(), 2 * along, {0.02});
    ASSERT_TRUE(curve);
    EXPECT_LT((curve->evaluate(0)[0] + along / 2).norm(), 1e-14);
    EXPECT_LT((curve->evaluate(1)[0] - along / 2).norm(), 1e-14);
    for (double u = 0; u <= 1; u += 0.1) EXPECT_LT(curve->evaluate(u)[0].cross(along).norm(), 1e-14);
}

template <class T>
std::string code_of(const Result<T>& result) {
    return result ? "accepted" : result.error().code;
}

TEST(CornerSpline, RefusesWhatHasNoRounding) {
    const Angle good(90);
    for (const double tolerance : {0.0, -0.02, nan, infinity}) EXPECT_EQ(code_of(good.rounded(tolerance)), "SMTH0101");
    for (const double ratio : {1.0, 0.5, -2.0, nan, infinity})
        EXPECT_EQ(code_of(good.rounded(0.02, ratio)), "SMTH0104");
    EXPECT_EQ(code_of(corner_spline(good.corner, good.corner, good.after, {0.02})), "SMTH0102");
    EXPECT_EQ(code_of(corner_spline(good.before, good.corner, good.corner, {0.02})), "SMTH0102");
    EXPECT_EQ(code_of(corner_spline(Vector3d(nan, 0, 0), good.corner, good.after, {0.02})), "SMTH0102");
    EXPECT_EQ(code_of(corner_spline(good.before, good.corner, Vector3d(0, infinity, 0), {0.02})), "SMTH0102");
    EXPECT_EQ(code_of(corner_spline(good.before, good.corner, good.before, {0.02})), "SMTH0103");
    EXPECT_EQ(code_of(Angle(0.05).rounded(0.02)), "SMTH0103");
    EXPECT_EQ(code_of(Angle(0.06).rounded(0.02)), "accepted");
}

/// A corner in the plane with the tool tilted along and across it.
struct Tilted {
    RuledPose before{{-60, 0, 0}, {-60, 6, 30}}, corner{{0, 0, 0}, {2, -5, 29}}, after{{0, 50, 0}, {-8, 53, 28}};
    Result<DualCorner> rounded(double tip, double top, double ratio = usual_corner_ratio) const {
        return dual_corner(before, corner, after, {tip, top, ratio});
    }
};

TEST(DualCorner, KeepsBothTolerancesAndUsesThem) {
    const Tilted at;
    const auto dual = at.rounded(0.5, 0.4);
    ASSERT_TRUE(dual);
    EXPECT_NEAR((dual->curves.bottom().evaluate(0.5)[0] - at.corner.bottom_mm).norm(), 0.5, 1e-12);
    EXPECT_NEAR((dual->curves.top().evaluate(0.5)[0] - at.corner.top_mm).norm(), 0.4, 1e-12);
}

TEST(DualCorner, BothCurvesBeginAndEndOnOnePoseOfTheSegments) {
    const Tilted at;
    const auto dual = at.rounded(0.5, 0.4);
    for (const int end : {0, 1}) {
        const RuledPose& far = end == 0 ? at.before : at.after;
        const Vector3d bottom = dual->curves.bottom().evaluate(end)[0], top = dual->curves.top().evaluate(end)[0];
        const double share = (bottom - at.corner.bottom_mm).norm() / (far.bottom_mm - at.corner.bottom_mm).norm();
        EXPECT_LT((at.corner.bottom_mm + share * (far.bottom_mm - at.corner.bottom_mm) - bottom).norm(), 1e-14);
        EXPECT_LT((at.corner.top_mm + share * (far.top_mm - at.corner.top_mm) - top).norm(), 1e-13);
        EXPECT_NEAR(dual->rate[end],
                    (far.top_mm - at.corner.top_mm).norm() / (far.bottom_mm - at.corner.bottom_mm).norm(), 1e-14);
        EXPECT_NEAR(dual->top[end].outer_mm, dual->rate[end] * dual->bottom[end].outer_mm, 1e-14);
    }
}

TEST(DualCorner, TopPolygonNeverFolds) {
    test::Random random(1);
    int limited = 0;
    for (int i = 0; i < 1000; ++i) {
        SCOPED_TRACE(i);
        Tilted at;
        for (RuledPose* pose : {&at.before, &at.corner, &at.after})
            for (int k = 0; k < 3; ++k) pose->top_mm[k] += random.uniform(-5, 5);
        const double top = std::pow(10, random.uniform(-3, 1));
        const auto dual = at.rounded(0.02, top);
        ASSERT_TRUE(dual);
        const double error = corner_error_mm(dual->top[0].inner_mm, dual->top[0].cosine);
        double ratio = infinity;
        for (const CornerSide& side : dual->top) ratio = std::min(ratio, side.outer_mm / side.inner_mm);
        EXPECT_GE(ratio, least_top_ratio - 1e-12);
        EXPECT_LE(error, top * (1 + 1e-12));
        EXPECT_TRUE(ratio < least_top_ratio + 1e-9 || error > top * (1 - 1e-9)) << "one of both decides";
        limited += ratio < least_top_ratio + 1e-9 ? 1 : 0;
    }
    EXPECT_GT(limited, 100);
    EXPECT_LT(limited, 900);
}

TEST(DualCorner, RefusesWhatHasNoRounding) {
    const Tilted good;
    EXPECT_EQ(code_of(good.rounded(0, 0.1)), "SMTH0101");
    EXPECT_EQ(code_of(good.rounded(0.1, 0)), "SMTH0101");
    EXPECT_EQ(code_of(good.rounded(0.1, nan)), "SMTH0101");
    EXPECT_EQ(code_of(good.rounded(0.1, 0.1, 1)), "SMTH0104");
    Tilted still = good;
    still.after.top_mm = still.corner.top_mm;
    EXPECT_EQ(code_of(still.rounded(0.1, 0.1)), "SMTH0102");
    Tilted turn_alone = good;
    turn_alone.after.bottom_mm = turn_alone.corner.bottom_mm;
    EXPECT_EQ(code_of(turn_alone.rounded(0.1, 0.1)), "SMTH0102");
    Tilted swings_back = good;
    swings_back.after.top_mm =
        swings_back.corner.top_mm + 0.3 * (swings_back.before.top_mm - swings_back.corner.top_mm);
    EXPECT_EQ(code_of(swings_back.rounded(0.1, 0.1)), "SMTH0103");
}

}  // namespace
}  // namespace trunnion::smoothing
