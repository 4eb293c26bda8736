#include "trunnion/numeric/taylor3.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace {

using namespace trunnion;

void expect_series(const Taylor3& series, double d0, double d1, double d2, double d3, double error = 1e-14) {
    EXPECT_NEAR(series.value(), d0, error * (1 + std::abs(d0)));
    EXPECT_NEAR(series.d1(), d1, error * (1 + std::abs(d1)));
    EXPECT_NEAR(series.d2(), d2, error * (1 + std::abs(d2)));
    EXPECT_NEAR(series.d3(), d3, error * (1 + std::abs(d3)));
}

const Taylor3 at_two{2, 1, 0, 0};  // the variable itself, at 2

TEST(Taylor3, OfPolynomialsIsExact) {
    const Taylor3 x = at_two;
    expect_series(x * x * x - 2.0 * x + Taylor3(5), 9, 10, 12, 6);
    expect_series(-(x * x), -4, -4, -2, 0);
}

TEST(Taylor3, OfAQuotientUndoesTheProduct) {
    const Taylor3 a{1, -2, 0.5, 3}, b{-0.7, 1, 2, -1};
    const Taylor3 back = a * b / b;
    for (int k = 0; k < 4; ++k) EXPECT_NEAR(back.c[k], a.c[k], 1e-13);
    expect_series(1.0 / at_two, 0.5, -0.25, 0.25, -0.375);
}

TEST(Taylor3, OfRootAndAnglesAreTheirDerivatives) {
    expect_series(sqrt(at_two), std::sqrt(2.0), 0.5 / std::sqrt(2.0), -0.25 / std::pow(2, 1.5),
                  0.375 / std::pow(2, 2.5));
    expect_series(sin(at_two), std::sin(2), std::cos(2), -std::sin(2), -std::cos(2));
    expect_series(cos(at_two), std::cos(2), -std::sin(2), -std::cos(2), std::sin(2));
    expect_series(atan2(at_two, Taylor3(1)), std::atan(2.0), 0.2, -0.16, 0.176);
}

TEST(Taylor3, Atan2UndoesSineAndCosineInEveryQuadrant) {
    for (const double angle : {-3.0, -2.0, -0.5, 0.0, 0.5, 1.5708, 3.0}) {
        const Taylor3 phi{angle, 0.3, -0.2, 0.7}, length{2, -1, 0.5, 0.25};
        const auto [s, c] = sin_cos(phi);
        const Taylor3 back = atan2(length * s, length * c);
        for (int k = 0; k < 4; ++k) EXPECT_NEAR(back.c[k], phi.c[k], 1e-14);
    }
}

TEST(Taylor3, SquareOfSinePlusSquareOfCosineIsOne) {
    const auto [s, c] = sin_cos(Taylor3(0.8, 1.5, -0.5, 2));
    expect_series(s * s + c * c, 1, 0, 0, 0);
}

}  // namespace
