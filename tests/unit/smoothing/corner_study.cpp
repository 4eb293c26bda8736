#include "trunnion/smoothing/corner_study.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"

#include "runs.hpp"

namespace trunnion::smoothing {
namespace {

using Eigen::Vector3d;

/// Two walls with draft: the tool leans out of the pocket, and its top point goes a longer way than the tip.
struct PocketCorner {
    static RuledPose leaning(double x_mm, double y_mm, double x, double y) {
        const Vector3d tip(x_mm, y_mm, 0);
        return {tip, tip + 25 * Vector3d(x, y, 1).normalized()};
    }
    double lean = std::tan(10 * degree);
    DualCorner corner = *dual_corner(leaning(-70, 0, 0, -lean), leaning(0, 0, lean, -lean), leaning(0, 55, lean, 0),
                                     {.tip_tolerance_mm = 2.5, .top_tolerance_mm = 2.5});
    ParameterLink link = *closed_link(corner);
    machine::Machine table = with_limits();
    machine::Kinematics kinematics = *machine::Kinematics::make(table, {}, 100);

    static machine::Machine with_limits() {
        machine::Machine out = test::trunnion_table();
        for (int k = 0; k < 5; ++k)
            out.axes[k].feed = k < 3 ? machine::AxisLimits{500, 2500, 5000} : machine::AxisLimits{2, 5, 30};
        return out;
    }
    StudiedMachine on() const { return {kinematics, table, {}, 100}; }
    Link closed() const {
        return [l = link](double u) { return l.at(u); };
    }
    static Link linear() {
        return [](double u) { return Taylor3{u, 1, 0, 0}; };
    }
    LinkedPose pose(const Link& with, double share) const {
        return linked_pose(corner.curves.bottom(), corner.curves.top(), share, with(share));
    }
    /// The share of the bottom curve that lies a path length behind another one, to third order.
    double share_after(double share, double way_mm) const {
        const auto d = corner.curves.bottom().evaluate(share);
        const double speed = d[1].norm(), s2 = d[1].dot(d[2]) / speed;
        const double s3 = (d[2].squaredNorm() + d[1].dot(d[3]) - s2 * s2) / speed;
        const double g2 = -s2 / std::pow(speed, 3), g3 = (3 * s2 * s2 / speed - s3) / std::pow(speed, 4);
        return share + way_mm * (1 / speed + way_mm * (g2 / 2 + way_mm * g3 / 6));
    }
    /// Four tool axes a step apart: the last one `last` steps behind the place at the share; before the entry, those of
    /// the segment.
    std::array<Vector3d, 4> tools(const Link& with, double share, double step_mm, int last) const {
        std::array<Vector3d, 4> out;
        for (int k = 0; k < 4; ++k) {
            const double way = step_mm * (last - 3 + k), at = share_after(share, way);
            const LinkedPose p = at < 0 ? segment_pose(corner, 0, -way) : pose(with, at);
            for (int i = 0; i < 3; ++i) out[k][i] = p.tool_axis[i].value();
        }
        return out;
    }
};

TEST(OrientationCriterion, OfDifferencesTendsToTheExactOne) {
    const PocketCorner pocket;
    const double exact = orientation_criterion(pocket.pose(pocket.closed(), 0.3).tool_axis);
    const auto by_differences = [&](double step_mm) {
        return orientation_criterion(pocket.tools(pocket.closed(), 0.3, step_mm, 0), step_mm);
    };
    EXPECT_NEAR(by_differences(0.02) / exact, 1, 0.05);
    EXPECT_NEAR((by_differences(0.04) - exact) / (by_differences(0.02) - exact), 2, 0.1)
        << "of first order in the step";
}

TEST(OrientationCriterion, OfDifferencesMeansNothingWithoutItsStepWhereTheFirstDerivativeJumps) {
    const PocketCorner pocket;
    const auto with = [&](const Link& link, double step) {
        return orientation_criterion(pocket.tools(link, 0, step, 1), step);
    };
    EXPECT_NEAR(with(PocketCorner::linear(), 0.001) / with(PocketCorner::linear(), 0.01), 100, 1);
    const double closed = with(pocket.closed(), 0.01);
    EXPECT_LT(closed, 1e-3 * with(PocketCorner::linear(), 0.01));
    EXPECT_NEAR(with(pocket.closed(), 0.02) / closed, 1, 0.2);
}

TEST(FeedLimit, IsTheLeastOfEquation10) {
    const PocketCorner pocket;
    const auto limit = [&](const Taylor3& x, const Taylor3& a, double programmed) {
        return feed_limit_mm_s(pocket.table, {x, 0, 0, a, 0}, programmed);
    };
    const machine::AxisLimits x = pocket.table.axes[0].feed, a = pocket.table.axes[3].feed;
    EXPECT_EQ(limit({7, 0, 0, 0}, 0, 1234), 1234);
    EXPECT_DOUBLE_EQ(limit({7, -2, 0, 0}, 0, 1e9), x.velocity / 2);
    EXPECT_DOUBLE_EQ(limit({7, 0, 1.5, 0}, 0, 1e9), std::sqrt(x.acceleration / 3));
    EXPECT_DOUBLE_EQ(limit({7, 0, 0, -0.5}, 0, 1e9), std::cbrt(x.jerk / 3));
    EXPECT_DOUBLE_EQ(limit({7, 1e-9, 0, 0}, {0, 0, 0, 1}, 1e9), std::cbrt(a.jerk / 6));
}

TEST(FeedLimit, OverTheRatioOfACornerIsFlatAndFallsToNothingAtOne) {
    const machine::AxisLimits x{500, 2500, 50000}, y{500, 3000, 50000};
    const auto at = [&](double ratio) {
        const auto corner = corner_spline({-100, 0, 0}, {0, 0, 0}, {0, 100, 0}, {0.02, ratio});
        return least_feed_limit_mm_s(*corner, {x, y, y});
    };
    EXPECT_NEAR(at(1.05), 0.711, 0.001);
    EXPECT_NEAR(at(1.4), 3.366, 0.001);
    EXPECT_NEAR(at(1.75), 3.415, 0.001);
    EXPECT_NEAR(at(2.5), 3.303, 0.001);
    EXPECT_LT(at(1.0001), 0.01);
}

TEST(FeedLimit, OfACornerIsThatOfItsMirrorImage) {
    const machine::AxisLimits slow{500, 3000, 5000}, fast{500, 3000, 50000};
    for (const double ratio : {1.1, 1.4, 2.0, 2.5}) {
        const auto corner = corner_spline({-100, 0, 0}, {0, 0, 0}, {0, 100, 0}, {0.02, ratio});
        const double x_slow = least_feed_limit_mm_s(*corner, {slow, fast, fast});
        EXPECT_NEAR(least_feed_limit_mm_s(*corner, {fast, slow, fast}) / x_slow, 1, 1e-9) << ratio;
    }
}

TEST(SegmentPose, LiesOnTheSegmentAndMeetsTheCorner) {
    const PocketCorner pocket;
    for (const int end : {0, 1}) {
        const LinkedPose join = segment_pose(pocket.corner, end, 0), far = segment_pose(pocket.corner, end, 2);
        const auto begin = pocket.corner.curves.bottom().evaluate(end)[0];
        for (int k = 0; k < 3; ++k) {
            EXPECT_NEAR(join.tip_mm[k].value(), begin[k], 1e-14);
            EXPECT_NEAR(join.tool_axis[k].value(), pocket.corner.curves.axis(end)[k].value(), 1e-14);
            EXPECT_NEAR(join.tip_mm[k].value() + (end == 0 ? -2 : 2) * join.tip_mm[k].d1(), far.tip_mm[k].value(),
                        1e-13);
            const double step = end == 0 ? -2 : 2;
            const Taylor3& n = join.tool_axis[k];
            EXPECT_NEAR(n.c[0] + step * (n.c[1] + step * (n.c[2] + step * n.c[3])), far.tool_axis[k].value(), 1e-8);
        }
    }
}

TEST(SampleCorner, GoesAlongTheWholeWay) {
    const PocketCorner pocket;
    constexpr int per_part = 50;
    const auto samples = sample_corner(pocket.corner, pocket.closed(), pocket.on(), 5, 25, per_part);
    ASSERT_EQ(samples.size(), 4 * per_part + 3);
    EXPECT_DOUBLE_EQ(samples.front().length_mm, -5);
    EXPECT_EQ(samples[per_part].length_mm, 0);
    EXPECT_EQ(samples[per_part + 1].length_mm, 0);
    double chords = 0;
    for (int i = 1; i <= 20000; ++i)
        chords += (pocket.corner.curves.bottom().evaluate(i / 20000.0)[0] -
                   pocket.corner.curves.bottom().evaluate((i - 1) / 20000.0)[0])
                      .norm();
    EXPECT_NEAR(samples[3 * per_part + 1].length_mm, chords, 1e-6);
    EXPECT_NEAR(samples.back().length_mm, chords + 5, 1e-6);
    for (std::size_t i = 1; i < samples.size(); ++i) {
        const double way = samples[i].length_mm - samples[i - 1].length_mm;
        for (int axis = 0; axis < 5; ++axis) {
            const Taylor3 &here = samples[i - 1].axes[axis], &next = samples[i].axes[axis];
            EXPECT_NEAR(next.value() - here.value(), way * (here.d1() + next.d1()) / 2, 1e-2 * way) << i << ' ' << axis;
        }
        EXPECT_GE(samples[i].share, samples[i - 1].share);
    }
}

/// Largest relative step of the axes' derivative over both joins.
double step_over_joins(const std::vector<CornerSample>& samples, std::size_t per_part,
                       double (Taylor3::*order)() const) {
    double step = 0, size = 0;
    for (const std::size_t i : {per_part, 3 * per_part + 1})
        for (int axis = 0; axis < 5; ++axis) {
            step = std::max(step, std::abs((samples[i].axes[axis].*order)() - (samples[i + 1].axes[axis].*order)()));
            size = std::max(size, std::abs((samples[i].axes[axis].*order)()));
        }
    return step / size;
}

TEST(SampleCorner, AxesGoOnSmoothlyWithTheClosedLinkAndNotWithTheLinearOne) {
    const PocketCorner pocket;
    const auto closed = sample_corner(pocket.corner, pocket.closed(), pocket.on(), 5, 25, 50);
    const auto linear = sample_corner(pocket.corner, PocketCorner::linear(), pocket.on(), 5, 25, 50);
    EXPECT_LT(step_over_joins(closed, 50, &Taylor3::d1), 1e-12);
    EXPECT_LT(step_over_joins(closed, 50, &Taylor3::d2), 1e-12);
    EXPECT_GT(step_over_joins(closed, 50, &Taylor3::d3), 0.1) << "the third stays";
    EXPECT_GT(step_over_joins(linear, 50, &Taylor3::d1), 1e-3);
}

TEST(SampleCorner, FeedOfThePointAtTheHeightIsThatOfTheTopPoint) {
    const PocketCorner pocket;
    const auto samples = sample_corner(pocket.corner, pocket.closed(), pocket.on(), 5, 25, 50);
    const CornerSample& first = samples.front();
    // On the ruled segment the top point is not quite at the height; 0.1 % here.
    EXPECT_NEAR(first.height_feed_mm_s / first.feed_limit_mm_s, pocket.corner.rate[0], 0.002 * pocket.corner.rate[0]);
    const auto at_tip = sample_corner(pocket.corner, pocket.closed(), pocket.on(), 5, 0, 50);
    for (const CornerSample& sample : at_tip) EXPECT_NEAR(sample.height_feed_mm_s, sample.feed_limit_mm_s, 1e-10);
}

TEST(WalkCorner, AgreesWithTheExactFiguresAwayFromKnots) {
    const PocketCorner pocket;
    constexpr double step = 0.01;
    constexpr int per_part = 400;
    const auto exact = sample_corner(pocket.corner, pocket.closed(), pocket.on(), 5, 25, per_part);
    const auto steps = walk_corner(pocket.corner, pocket.closed(), pocket.on(), 2, step);
    const double middle = exact[2 * per_part + 1].length_mm, end = exact[3 * per_part + 1].length_mm;
    EXPECT_NEAR(steps.front().length_mm, -2, 1e-12);
    EXPECT_NEAR(steps.back().length_mm, end + 2, step);
    int compared = 0;
    for (const CornerStep& at : steps) {
        const double s = at.length_mm;
        // Both curves have their knots within 0.05 mm of the middle.
        if (s < 0.5 || s > end - 0.5 || std::abs(s - middle) < 0.2) continue;
        const auto next = std::ranges::lower_bound(exact, s, {}, &CornerSample::length_mm);
        EXPECT_NEAR(at.criterion_rad_mm3 / next->criterion_rad_mm3, 1, 0.1) << s;
        EXPECT_NEAR(at.feed_limit_mm_s / next->feed_limit_mm_s, 1, 0.05) << s;
        ++compared;
    }
    EXPECT_GT(compared, 1000);
}

TEST(WalkCorner, SeesTheJumpsOfTheLinearLinkAtBothJoinsAlone) {
    const PocketCorner pocket;
    constexpr double step = 0.05;
    const auto linear = walk_corner(pocket.corner, PocketCorner::linear(), pocket.on(), 2, step);
    const auto closed = walk_corner(pocket.corner, pocket.closed(), pocket.on(), 2, step);
    const double end = linear.back().length_mm - 2;
    const auto worst = [&](const std::vector<CornerStep>& steps, double from, double to) {
        double criterion = 0;
        for (const CornerStep& at : steps)
            if (at.length_mm > from && at.length_mm < to) criterion = std::max(criterion, at.criterion_rad_mm3);
        return criterion;
    };
    for (const double join : {0.0, end}) EXPECT_GT(worst(linear, join - 5 * step, join + 5 * step), 1);
    EXPECT_LT(worst(linear, 5 * step, end - 5 * step), 0.01);
    EXPECT_LT(worst(closed, -2, end + 2), 0.01);
    EXPECT_LT(worst(closed, -2, 0), 1e-6) << "the segment turns evenly";
    EXPECT_LT(worst(closed, end + 5 * step, end + 2), 1e-6);
}

TEST(StudiedMachine, FollowsTheRotaryAxesFromWhereTheyStand) {
    const PocketCorner pocket;
    const auto samples = sample_corner(pocket.corner, pocket.closed(), pocket.on(), 5, 25, 20);
    const double from = samples.front().axes[4].value(), to = samples.back().axes[4].value();
    EXPECT_GT(to - from, 0.1);
    // At first this branch is nearer than the other, half a turn of C away; farther on it no longer is.
    StudiedMachine aside = pocket.on();
    aside.near = {0, from + 0.05 - std::numbers::pi / 2};
    const auto samples_aside = sample_corner(pocket.corner, pocket.closed(), aside, 5, 25, 20);
    for (std::size_t i = 0; i < samples.size(); ++i)
        EXPECT_NEAR(samples[i].axes[4].value(), samples_aside[i].axes[4].value(), 1e-12);
    const auto steps = walk_corner(pocket.corner, pocket.closed(), pocket.on(), 5, 0.1);
    const auto steps_aside = walk_corner(pocket.corner, pocket.closed(), aside, 5, 0.1);
    for (std::size_t i = 0; i < steps.size(); ++i)
        EXPECT_NEAR(steps[i].feed_limit_mm_s / steps_aside[i].feed_limit_mm_s, 1, 1e-6);
}

TEST(DiscreteLink, PassesItsPointsAndKeepsTheCriterionSmallThere) {
    const PocketCorner pocket;
    constexpr double step = 0.1;
    const auto link = discrete_link(pocket.corner, step);
    ASSERT_TRUE(link);
    for (std::size_t i = 0; i < 8; ++i) {
        EXPECT_NEAR(link->at(link->bottom[i]).value(), link->top[i], 1e-14);
        EXPECT_NEAR(link->spline.evaluate(link->bottom[i])[0].x(), link->bottom[i], 1e-14);
        EXPECT_TRUE(i == 0 || link->top[i] > link->top[i - 1]);
    }
    // No other first parameter does better.
    const std::vector<double> tops{link->top[1] - 1e-6, link->top[1], link->top[1] + 1e-6};
    const auto tried = first_point_sensitivity(pocket.corner, step, tops, pocket.on());
    EXPECT_LT(tried[1].criterion_rad_mm3, tried[0].criterion_rad_mm3);
    EXPECT_LT(tried[1].criterion_rad_mm3, tried[2].criterion_rad_mm3);
}

TEST(DiscreteLink, TendsToTheExactConnection) {
    const PocketCorner pocket;
    const auto exact =
        connect_end(segment_pose(pocket.corner, 0, 0).tool_axis, point_at_share(pocket.corner.curves.bottom(), 0),
                    point_at_share(pocket.corner.curves.top(), 0));
    ASSERT_TRUE(exact);
    double first = 0, second = 0;
    for (const double step : {0.1, 0.01}) {
        const auto link = discrete_link(pocket.corner, step);
        ASSERT_TRUE(link);
        const Taylor3 at = link->at(0);
        if (step == 0.1) {
            first = std::abs(at.d1() - exact->end.first);
            second = std::abs(at.d2() - exact->end.second);
        } else {
            EXPECT_LT(std::abs(at.d1() - exact->end.first), first / 10);
            EXPECT_LT(std::abs(at.d2() - exact->end.second), second / 5);
        }
    }
    EXPECT_LT(first, 1e-4 * exact->end.first);
}

TEST(DiscreteLink, RefusesStepsThatDoNotFit) {
    const PocketCorner pocket;
    const auto code = [&](double step) {
        const auto link = discrete_link(pocket.corner, step);
        return link ? std::string("accepted") : link.error().code;
    };
    EXPECT_EQ(code(1), "accepted");
    for (const double step : {0.0, -1.0, 3.5, std::nan(""), std::numeric_limits<double>::infinity()})
        EXPECT_EQ(code(step), "SMTH0121") << step;
}

TEST(DiscreteLink, RefusesWhereTheTopCurveTurnsTooSharply) {
    // With little tolerance of its own the top curve turns within a few steps and cannot go on as the points before
    // ask.
    const PocketCorner pocket;
    const auto corner =
        dual_corner(PocketCorner::leaning(-70, 0, 0, -pocket.lean), PocketCorner::leaning(0, 0, 0.3, 0),
                    PocketCorner::leaning(0, 55, pocket.lean, 0), {.tip_tolerance_mm = 0.2, .top_tolerance_mm = 0.1});
    ASSERT_TRUE(corner);
    EXPECT_TRUE(discrete_link(*corner, 0.01));
    const auto link = discrete_link(*corner, 0.2);
    ASSERT_FALSE(link);
    EXPECT_EQ(link.error().code, "SMTH0122");
}

TEST(Sensitivity, ATinyChangeOfTheFirstParameterCostsMostOfTheFeed) {
    const PocketCorner pocket;
    constexpr double step = 0.05;
    const double best = discrete_link(pocket.corner, step)->top[1];
    const double speed = pocket.corner.curves.bottom().evaluate(0)[1].norm(), linear = step / speed;
    const auto tried = first_point_sensitivity(
        pocket.corner, step, std::vector<double>{best, best + 1e-5, best + 2e-5, best - 1e-5, linear}, pocket.on());
    EXPECT_NEAR(tried[1].criterion_rad_mm3 / tried[3].criterion_rad_mm3, 1, 0.05) << "alike on both sides";
    EXPECT_NEAR(tried[2].criterion_rad_mm3 / tried[1].criterion_rad_mm3, 2, 0.05) << "in proportion to the change";
    EXPECT_LT(tried[1].feed_limit_mm_s, 0.7 * tried[0].feed_limit_mm_s);
    EXPECT_LT(tried[4].feed_limit_mm_s, 0.2 * tried[0].feed_limit_mm_s);
}

}  // namespace
}  // namespace trunnion::smoothing
