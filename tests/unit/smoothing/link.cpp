#include "trunnion/smoothing/link.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "runs.hpp"

namespace trunnion::smoothing {
namespace {

double least_slope(const ParameterLink& link) {
    double least = link.at(0).d1();
    for (int i = 0; i <= 2000; ++i) least = std::min(least, link.at(i / 2000.0).d1());
    return least;
}

LinkEnd random_end(test::Random& random) {
    LinkEnd end;
    end.first = random.uniform(0.01, 3);
    end.second = random.uniform(-5, 5);
    end.third = random.uniform(-30, 30);
    return end;
}

/// The polynomial with these ends whether it increases or not: its conditions, solved.
Eigen::Vector<double, 8> powers_through(const LinkEnd& entry, const LinkEnd& exit) {
    Eigen::Matrix<double, 8, 8> conditions = Eigen::Matrix<double, 8, 8>::Zero();
    for (int order = 0; order < 4; ++order)
        for (int k = order; k < 8; ++k) {
            const double factor = std::tgamma(k + 1) / std::tgamma(k - order + 1);
            if (k == order) conditions(order, k) = factor;
            conditions(4 + order, k) = factor;
        }
    Eigen::Vector<double, 8> values;
    values << 0, entry.first, entry.second, entry.third, 1, exit.first, -exit.second, exit.third;
    return conditions.partialPivLu().solve(values);
}

TEST(ParameterLink, LinearIsTheIdentity) {
    const ParameterLink link = ParameterLink::linear();
    for (int i = 0; i <= 100; ++i) {
        const double u = i / 100.0;
        EXPECT_DOUBLE_EQ(link.at(u).value(), u);
        EXPECT_EQ(link.at(u).d1(), 1);
        EXPECT_EQ(link.at(u).d2(), 0);
        EXPECT_EQ(link.at(u).d3(), 0);
        EXPECT_DOUBLE_EQ(link.inverse(u), u);
    }
}

TEST(ParameterLink, MeetsBothEnds) {
    test::Random random(1);
    int accepted = 0;
    for (int i = 0; i < 1000; ++i) {
        const LinkEnd entry = random_end(random), exit = random_end(random);
        const auto link = ParameterLink::through(entry, exit);
        if (!link) continue;
        ++accepted;
        const Taylor3 begin = link->at(0), end = link->at(1);
        EXPECT_EQ(begin.value(), 0);
        EXPECT_EQ(end.value(), 1);
        EXPECT_NEAR(begin.d1(), entry.first, 1e-14);
        EXPECT_NEAR(begin.d2(), entry.second, 1e-14);
        EXPECT_NEAR(begin.d3(), entry.third, 1e-13);
        EXPECT_NEAR(end.d1(), exit.first, 1e-14);
        EXPECT_NEAR(end.d2(), -exit.second, 1e-14);
        EXPECT_NEAR(end.d3(), exit.third, 1e-13);
    }
    EXPECT_GT(accepted, 100);
}

TEST(ParameterLink, IsOnePolynomial) {
    const auto link = ParameterLink::through({0.8, 1, -3}, {1.3, -2, 4});
    ASSERT_TRUE(link);
    const Taylor3 left = link->at(0.5), right = link->at(std::nextafter(0.5, 1));
    for (int k = 0; k < 4; ++k) EXPECT_NEAR(left.c[k], right.c[k], 1e-12) << k;
    // Each coefficient is the derivative of the one before.
    constexpr double h = 1e-5;
    for (double u = 0.05; u < 1; u += 0.1)
        for (int k = 0; k < 3; ++k)
            EXPECT_NEAR((link->at(u + h).c[k] - link->at(u - h).c[k]) / (2 * h), (k + 1) * link->at(u).c[k + 1], 1e-6);
}

TEST(ParameterLink, AcceptsExactlyWhatIncreases) {
    int accepted = 0, refused = 0;
    for (std::uint64_t seed = 1; seed <= 5000; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        test::Random random(seed);
        const LinkEnd entry = random_end(random), exit = random_end(random);
        const auto power = powers_through(entry, exit);
        const auto slope = [&](double u) {
            double sum = 0;
            for (int k = 7; k >= 1; --k) sum = sum * u + k * power[k];
            return sum;
        };
        double least = slope(0);
        for (int i = 0; i <= 2000; ++i) least = std::min(least, slope(i / 2000.0));
        const auto link = ParameterLink::through(entry, exit);
        (link ? accepted : refused) += 1;
        if (link) {
            EXPECT_GT(least, 0);
        } else {
            EXPECT_LT(least, 1e-4) << "a sampling this dense overlooks no more";
        }
    }
    EXPECT_GT(accepted, 500);
    EXPECT_GT(refused, 500);
}

TEST(ParameterLink, RefusesWhatStandsAtAPoint) {
    // f′ = 12 (u − ½)² … : f = ½ + 4 (u − ½)³ stands in the middle.
    EXPECT_FALSE(ParameterLink::through({3, -12, 24}, {3, -12, 24}));
    // A little of the identity mixed in makes it pass.
    EXPECT_TRUE(ParameterLink::through({2.98, -11.88, 23.76}, {2.98, -11.88, 23.76}));
    EXPECT_FALSE(ParameterLink::through({0, 1, 0}, {1, 0, 0}));
    EXPECT_FALSE(ParameterLink::through({-1, 0, 0}, {1, 0, 0}));
    EXPECT_FALSE(ParameterLink::through({1, 0, 0}, {std::nan(""), 0, 0}));
    EXPECT_FALSE(ParameterLink::through({INFINITY, 0, 0}, {1, 0, 0}));
}

TEST(ParameterLink, InverseGivesTheParameterBack) {
    for (std::uint64_t seed = 1; seed <= 2000; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        test::Random random(seed);
        const LinkEnd entry = random_end(random), exit = random_end(random);
        const auto link = ParameterLink::through(entry, exit);
        if (!link || least_slope(*link) < 0.2) continue;
        EXPECT_EQ(link->inverse(0), 0);
        EXPECT_EQ(link->inverse(1), 1);
        for (int i = 0; i < 10; ++i) {
            const double u = random.uniform(0, 1), back = link->inverse(link->at(u).value());
            ASSERT_NEAR(back, u, 5e-15) << "rounding of f over its slope";
            ASSERT_NEAR(link->at(back).value(), link->at(u).value(), 1e-15);
        }
    }
}

TEST(ParameterLink, InverseHoldsWhereTheLinkNearlyStands) {
    const auto link = ParameterLink::through({2.9998, -11.9988, 23.9976}, {2.9998, -11.9988, 23.9976});
    ASSERT_TRUE(link);
    for (int i = 0; i <= 1000; ++i) {
        const double value = i / 1000.0;
        EXPECT_NEAR(link->at(link->inverse(value)).value(), value, 1e-15);
    }
}

TEST(ClosedLink, OfCurvesInOneRatioIsTheIdentity) {
    const CornerSide bottom{2, 2.8, -0.4}, top{3, 4.2, -0.4};
    const LinkEnd end = closed_link_end(bottom, top, 1.5);
    EXPECT_NEAR(end.first, 1, 1e-15);
    EXPECT_NEAR(end.second, 0, 1e-14);
    EXPECT_NEAR(end.third, 0, 1e-13);
    EXPECT_GT(std::abs(closed_link_end(bottom, {3, 5, -0.4}, 1.5).first - 1), 0.1);
}

/// The ends depend on both ratios and angles alone: the rate on the segment is that of the outer lengths.
std::optional<ParameterLink> link_of(double bottom_ratio, const std::array<double, 2>& top_ratio, double bottom_angle,
                                     double top_angle) {
    const CornerSide bottom{1, bottom_ratio, std::cos(bottom_angle * test::degree)};
    std::array<LinkEnd, 2> ends;
    for (std::size_t end = 0; end < 2; ++end)
        ends[end] = closed_link_end(bottom, {1, top_ratio[end], std::cos(top_angle * test::degree)},
                                    top_ratio[end] / bottom_ratio);
    return ParameterLink::through(ends[0], ends[1]);
}

TEST(ClosedLink, IncreasesForEveryCornerThatDoesNotFold) {
    for (const double bottom_ratio : {1.001, 1.05, 1.4, 1.75, 2.0, 2.4})
        for (const double entry : {1.4, 1.5, 1.8, 2.5, 5.0, 30.0, 1e4})
            for (const double exit : {1.4, 1.5, 1.8, 2.5, 5.0, 30.0, 1e4})
                for (double bottom_angle = 1; bottom_angle < 180; bottom_angle += 20)
                    for (const double top_angle : {1.0, 30.0, 60.0, 90.0, 120.0, 150.0, 180.0})
                        ASSERT_TRUE(link_of(bottom_ratio, {entry, exit}, bottom_angle, top_angle))
                            << bottom_ratio << ' ' << entry << ' ' << exit << ' ' << bottom_angle << ' ' << top_angle;
}

TEST(ClosedLink, IsRefusedWhereTheTopPolygonIsNearlyFolded) {
    EXPECT_TRUE(link_of(1.4, {1.27, 1.27}, 90, 90));
    EXPECT_FALSE(link_of(1.4, {1.17, 1.17}, 90, 90));
    EXPECT_FALSE(link_of(1.4, {0.16, 0.16}, 90, 90));
}

}  // namespace
}  // namespace trunnion::smoothing
