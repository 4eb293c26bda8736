#include "trunnion/smoothing/connection.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "runs.hpp"

namespace trunnion::smoothing {
namespace {

using Eigen::Vector3d;
using geometry::BsplineCurve;
using geometry::CurvePoint;
using geometry::DualSpline;
using machine::VectorSeries;

Vector3d random_vector(test::Random& random, double size) {
    Vector3d out;
    for (int k = 0; k < 3; ++k) out[k] = random.uniform(-size, size);
    return out;
}

/// Derivative k of the tool axis.
Vector3d derivative(const VectorSeries& series, int k) {
    const double factorial = k == 3 ? 6 : k == 2 ? 2 : 1;
    return factorial * Vector3d(series[0].c[k], series[1].c[k], series[2].c[k]);
}

double jump(const VectorSeries& a, const VectorSeries& b, int k) {
    return (derivative(a, k) - derivative(b, k)).norm();
}

double size(const VectorSeries& series, int k) {
    return derivative(series, k).norm();
}

/// Two segments of 20 to 200 mm whose tool is tilted any way, 30 mm tall.
struct RandomCorner {
    RuledPose before, corner, after;
    DualCornerShape shape;

    explicit RandomCorner(std::uint64_t seed) {
        test::Random random(seed);
        corner.bottom_mm = random_vector(random, 1);
        before.bottom_mm = corner.bottom_mm + random.uniform(20, 200) * random_vector(random, 1).normalized();
        after.bottom_mm = corner.bottom_mm + random.uniform(20, 200) * random_vector(random, 1).normalized();
        const Vector3d tool = Vector3d(0, 0, 30) + random_vector(random, 10);
        for (RuledPose* pose : {&before, &corner, &after})
            pose->top_mm = pose->bottom_mm + 30 * (tool + random_vector(random, 8)).normalized();
        shape.tip_tolerance_mm = std::pow(10, random.uniform(-2, 0.5));
        shape.top_tolerance_mm = shape.tip_tolerance_mm * random.uniform(0.3, 3);
    }
    Result<DualCorner> rounded() const { return dual_corner(before, corner, after, shape); }
};

/// The tool axis of the segment at an end of a corner, on the way to it from outside.
VectorSeries segment_axis(const DualCorner& corner, int end) {
    const auto& bottom = corner.curves.bottom().control_points_mm();
    const auto& top = corner.curves.top().control_points_mm();
    const int outer = end == 0 ? 0 : 4, inner = end == 0 ? 1 : 3;
    const Vector3d zero = Vector3d::Zero();
    const CurvePoint tip{bottom[outer], (bottom[inner] - bottom[outer]).normalized(), zero, zero};
    const CurvePoint up{top[outer], corner.rate[end] * (top[inner] - top[outer]).normalized(), zero, zero};
    return linked_pose(tip, up, {0, 1, 0, 0}).tool_axis;
}

CurvePoint at_end(const BsplineCurve& curve, int end) {
    return end == 0 ? point_at_share(curve, 0) : backwards(point_at_share(curve, 1));
}

VectorSeries axis_at_end(const DualCorner& corner, int end, const LinkEnd& link) {
    return linked_pose(at_end(corner.curves.bottom(), end), at_end(corner.curves.top(), end),
                       {0, link.first, link.second / 2, link.third / 6})
        .tool_axis;
}

/// What the step of the third derivative along the top's motion allows to take away from the closed form's f‴.
double third_that_leaves_least(const DualCorner& corner, int end, const LinkEnd& closed) {
    const CurvePoint bottom = at_end(corner.curves.bottom(), end), top = at_end(corner.curves.top(), end);
    const Vector3d d = top[0] - bottom[0], tool = d.normalized();
    const double rate = corner.rate[end];
    const auto normal_part = [](const CurvePoint& p, double curvature_slope) {
        const Vector3d along = p[1].normalized();
        return Vector3d(curvature_slope * (p[3] - p[3].dot(along) * along).normalized());
    };
    const Vector3d lateral = std::pow(rate, 3) * normal_part(top, end_curvature_slope(corner.top[end])) -
                             normal_part(bottom, end_curvature_slope(corner.bottom[end]));
    const Vector3d across = top[1] - top[1].dot(tool) * tool;
    return closed.third - std::pow(bottom[1].norm(), 3) * lateral.dot(across) / across.squaredNorm();
}

constexpr std::uint64_t corners = 2000;

TEST(ClosedLinkEnd, MakesFirstAndSecondDerivativeContinuous) {
    for (std::uint64_t seed = 1; seed <= corners; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        const auto corner = RandomCorner(seed).rounded();
        ASSERT_TRUE(corner);
        for (const int end : {0, 1}) {
            const LinkEnd link = closed_link_end(corner->bottom[end], corner->top[end], corner->rate[end]);
            const VectorSeries outside = segment_axis(*corner, end), inside = axis_at_end(*corner, end, link);
            // Measured by the turn of a tool whose top point stands still, and its change over the inner length.
            constexpr double turn = 1.0 / 30;
            EXPECT_LT(jump(outside, inside, 0), 1e-14);
            EXPECT_LT(jump(outside, inside, 1), 1e-12 * turn);
            EXPECT_LT(jump(outside, inside, 2), 1e-12 * turn / corner->bottom[end].inner_mm);
        }
    }
}

TEST(ClosedLinkEnd, LinearLinkJumpsAlreadyInTheFirst) {
    int different_ratios = 0;
    for (std::uint64_t seed = 1; seed <= 100; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        const auto corner = RandomCorner(seed).rounded();
        if (corner->top[0].outer_mm < 1.5 * corner->top[0].inner_mm) continue;
        ++different_ratios;
        const VectorSeries outside = segment_axis(*corner, 0), inside = axis_at_end(*corner, 0, {1, 0, 0});
        EXPECT_GT(jump(outside, inside, 1), 0.05 * size(outside, 1));
    }
    EXPECT_GT(different_ratios, 30);
}

TEST(ConnectEnd, AgreesWithTheClosedFormOnCorners) {
    for (std::uint64_t seed = 1; seed <= corners; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        const auto corner = RandomCorner(seed).rounded();
        for (const int end : {0, 1}) {
            const LinkEnd closed = closed_link_end(corner->bottom[end], corner->top[end], corner->rate[end]);
            const auto found = connect_end(segment_axis(*corner, end), at_end(corner->curves.bottom(), end),
                                           at_end(corner->curves.top(), end));
            ASSERT_TRUE(found) << to_string(found.error());
            const double second = 1 + std::abs(closed.second), third = 1 + std::abs(closed.third);
            EXPECT_NEAR(found->end.first, closed.first, 1e-12 * closed.first);
            EXPECT_NEAR(found->end.second, closed.second, 1e-11 * second);
            EXPECT_NEAR(found->end.third, third_that_leaves_least(*corner, end, closed), 1e-10 * third);
        }
    }
}

TEST(ConnectEnd, LeavesLessOfTheThirdThanTheClosedForm) {
    double sum = 0;
    for (std::uint64_t seed = 1; seed <= corners; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        const auto corner = RandomCorner(seed).rounded();
        const VectorSeries outside = segment_axis(*corner, 0);
        const auto found = connect_end(outside, at_end(corner->curves.bottom(), 0), at_end(corner->curves.top(), 0));
        const LinkEnd closed = closed_link_end(corner->bottom[0], corner->top[0], corner->rate[0]);
        const double left = jump(outside, axis_at_end(*corner, 0, closed), 3);
        EXPECT_LE(found->jump[3], left * (1 + 1e-9));
        EXPECT_GT(found->jump[3], 0);
        sum += found->jump[3] / left;
        for (const double change : {-1e-3, 1e-3}) {
            LinkEnd moved = found->end;
            moved.third += change * (1 + std::abs(moved.third));
            EXPECT_GE(jump(outside, axis_at_end(*corner, 0, moved), 3), found->jump[3] * (1 - 1e-12));
        }
    }
    RecordProperty("mean_share", std::to_string(sum / corners));
    EXPECT_LT(sum / corners, 0.99);
}

TEST(ConnectEnd, IsTheClosedFormWhereTheToolStandsAcrossTheMotion) {
    // Tip and top in parallel horizontal planes and legs in line above each other, the tool upright at the join.
    const auto corner =
        dual_corner({{-50, 0, 0}, {-50, 0, 30}}, {{0, 0, 0}, {0, 0, 30}}, {{0, 40, 0}, {9, 43, 30}}, {0.5, 0.9});
    ASSERT_TRUE(corner);
    const LinkEnd closed = closed_link_end(corner->bottom[0], corner->top[0], corner->rate[0]);
    const auto found =
        connect_end(segment_axis(*corner, 0), at_end(corner->curves.bottom(), 0), at_end(corner->curves.top(), 0));
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->end.third, closed.third, 1e-12 * std::abs(closed.third));
}

/// A curve of degree 5 in one piece that continues another one's end with its tangent and curvature but a speed of its
/// own, and leads likewise to a third one's beginning.
BsplineCurve continuing(const CurvePoint& from, const CurvePoint& to, test::Random& random, double speed) {
    const auto leave = [&](const CurvePoint& p, double sign) {
        const double a = speed * random.uniform(0.9, 1.1) / p[1].norm(), b = random.uniform(-0.1, 0.1) * a;
        return std::pair<Vector3d, Vector3d>(sign * a * p[1], a * a * p[2] + b * p[1]);
    };
    const auto [d0, e0] = leave(from, 1);
    const auto [d1, e1] = leave(to, -1);  // seen backwards, e1 as well
    const std::vector<Vector3d> control{
        from[0], from[0] + d0 / 5, from[0] + 2 * d0 / 5 + e0 / 20, to[0] + 2 * d1 / 5 + e1 / 20, to[0] + d1 / 5, to[0]};
    return *BsplineCurve::make(5, {2, 2, 2, 2, 2, 2, 3.5, 3.5, 3.5, 3.5, 3.5, 3.5}, control);
}

/// A path along x from `begin` to `begin` + 100 mm, its points off the line and its tool tilted at random.
DualSpline random_dual_spline(test::Random& random, double begin) {
    std::vector<Vector3d> bottom, top;
    for (int i = 0; i < 6; ++i) {
        bottom.push_back(Vector3d(begin + 20 * i, 0, 0) + random_vector(random, 2));
        const Vector3d tilt = random_vector(random, 6);
        top.push_back(bottom.back() + Vector3d(tilt.x(), tilt.y(), 40));
    }
    const std::vector<double> knots{0, 0, 0, 0, 1, 2.5, 3, 3, 3, 3};
    return *DualSpline::make(*BsplineCurve::make(3, knots, bottom), *BsplineCurve::make(3, knots, top));
}

TEST(Connect, RandomDualSplinesGoOnSmoothly) {
    int linked = 0;
    for (std::uint64_t seed = 1; seed <= 500; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        test::Random random(seed);
        const DualSpline before = random_dual_spline(random, 0), after = random_dual_spline(random, 160);
        const BsplineCurve bottom =
            continuing(before.bottom().evaluate(before.end()), after.bottom().evaluate(after.begin()), random, 60);
        const BsplineCurve top =
            continuing(before.top().evaluate(before.end()), after.top().evaluate(after.begin()), random, 60);
        const auto link = connect(before, bottom, top, after);
        if (!link) {
            EXPECT_EQ(link.error().code, "SMTH0115") << to_string(link.error());
            continue;
        }
        ++linked;
        const VectorSeries ends[2][2] = {
            {tool_axis_by_length(before, before.end()), linked_pose(bottom, top, 0, link->at(0)).tool_axis},
            {tool_axis_by_length(after, after.begin()), linked_pose(bottom, top, 1, link->at(1)).tool_axis}};
        for (const auto& [outside, inside] : ends) {
            EXPECT_LT(jump(outside, inside, 0), 1e-13);
            EXPECT_LT(jump(outside, inside, 1), 1e-11 * size(outside, 1));
            EXPECT_LT(jump(outside, inside, 2), 1e-11 * (size(outside, 2) + 0.05 * size(outside, 1)));
            const VectorSeries unlinked =
                linked_pose(bottom, top, &outside == &ends[0][0] ? 0 : 1, {0, 1, 0, 0}).tool_axis;
            EXPECT_GT(jump(outside, unlinked, 1), 1e-9) << "without the link it is no easy case";
        }
    }
    EXPECT_GT(linked, 450);
}

TEST(Connect, SaysWhichCurvesHaveNoIncreasingLink) {
    test::Random random(3);
    const DualSpline before = random_dual_spline(random, 0), after = random_dual_spline(random, 160);
    const BsplineCurve bottom =
        continuing(before.bottom().evaluate(before.end()), after.bottom().evaluate(after.begin()), random, 60);
    // A top curve so slow at both ends that the link has to hurry there beyond the end of the curve.
    const BsplineCurve top =
        continuing(before.top().evaluate(before.end()), after.top().evaluate(after.begin()), random, 4);
    const auto link = connect(before, bottom, top, after);
    ASSERT_FALSE(link);
    EXPECT_EQ(link.error().code, "SMTH0115");
}

struct Join {
    VectorSeries path{Taylor3{0, 0.001, 0, 0}, Taylor3{0, 0, 0, 0}, Taylor3{1, 0, -0.5e-6, 0}};
    CurvePoint bottom{Vector3d(0, 0, 0), Vector3d(10, 0, 0), Vector3d(0, 0, 0), Vector3d(0, 1, 0)};
    CurvePoint top{Vector3d(0, 0, 30), Vector3d(12, 0, 0), Vector3d(0, 0, 0), Vector3d(0, 2, 0)};
    std::string code(double tolerance = 1e-6) const {
        const auto found = connect_end(path, bottom, top, tolerance);
        return found ? "accepted" : found.error().code;
    }
};

TEST(ConnectEnd, RefusesWhatCannotBeJoined) {
    EXPECT_EQ(Join().code(), "accepted");
    Join j;
    j.top[0] = j.bottom[0];
    EXPECT_EQ(j.code(), "SMTH0111");
    j = {};
    j.bottom[1].setZero();
    EXPECT_EQ(j.code(), "SMTH0111");
    j = {};
    j.top[1] = Vector3d(0, 0, 5);
    EXPECT_EQ(j.code(), "SMTH0111");
    j = {};
    j.top[0].x() = 1e-3;
    EXPECT_EQ(j.code(), "SMTH0112");
    j = {};
    j.top[1].y() = 1e-3;
    EXPECT_EQ(j.code(), "SMTH0113");
    EXPECT_EQ(j.code(1e-3), "accepted");
    j = {};
    j.top[1].x() = -12;
    EXPECT_EQ(j.code(), "SMTH0114");
    j = {};
    j.path[0].c[1] = -1.0 / 30;  // the top point of the path stands still
    EXPECT_EQ(j.code(), "SMTH0114");
    j = {};
    j.path[0].c[0] = std::nan("");
    EXPECT_EQ(j.code(), "SMTH0112");
    j = {};
    j.top[1].x() = std::nan("");
    EXPECT_NE(j.code(), "accepted");
}

TEST(ConnectEnd, SaysWhatIsLeftWhereCurvaturesDiffer) {
    Join bent;
    bent.top[2] = Vector3d(0, 3, 0);
    const auto found = connect_end(bent.path, bent.bottom, bent.top);
    ASSERT_TRUE(found);
    EXPECT_LT(found->jump[1], 1e-15);
    const double share = 1.03 / 12;  // du_top per mm of the bottom
    EXPECT_NEAR(found->jump[2], 3 * share * share / 30, 1e-12);
}

TEST(LinkedPose, SeriesAreTheDerivativesByPathLength) {
    const auto corner = RandomCorner(7).rounded();
    const auto link = closed_link(*corner);
    ASSERT_TRUE(link);
    constexpr double u = 0.3, h = 1e-4;
    const auto pose = [&](double at) {
        return linked_pose(corner->curves.bottom(), corner->curves.top(), at, link->at(at));
    };
    const LinkedPose here = pose(u), there = pose(u + h), back = pose(u - h);
    EXPECT_NEAR(size(here.tip_mm, 1), 1, 1e-14);
    const double speed = corner->curves.bottom().evaluate(u)[1].norm();
    for (int k = 0; k < 3; ++k)
        for (const auto series : {&LinkedPose::tip_mm, &LinkedPose::tool_axis}) {
            const Vector3d slope = (derivative(there.*series, k) - derivative(back.*series, k)) / (2 * h * speed);
            EXPECT_LT((slope - derivative(here.*series, k + 1)).norm(), 1e-5 * (1e-3 + slope.norm())) << k;
        }
}

}  // namespace
}  // namespace trunnion::smoothing
