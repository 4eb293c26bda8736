#include "trunnion/smoothing/kernel.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace trunnion::smoothing {
namespace {

template <class Kernel>
struct Kernels : testing::Test {};
using Shipped = testing::Types<CurveKernel, CornerKernel>;
TYPED_TEST_SUITE(Kernels, Shipped);

TYPED_TEST(Kernels, BumpAndDerivativesVanishAtTheEdge) {
    for (const double t : {-1.0, 1.0}) {
        EXPECT_NEAR(TypeParam::bump(t), 0, 1e-15);
        EXPECT_NEAR(TypeParam::slope(t), 0, 1e-15);
        EXPECT_NEAR(TypeParam::density(t), 0, 1e-15);
        EXPECT_NEAR(TypeParam::density_slope(t), 0, 1e-15);
    }
}

TYPED_TEST(Kernels, EachFunctionIsTheDerivativeOfTheOneBefore) {
    constexpr double h = 1e-5;
    for (double t = -0.95; t < 1; t += 0.1) {
        EXPECT_NEAR((TypeParam::bump(t + h) - TypeParam::bump(t - h)) / (2 * h), TypeParam::slope(t), 1e-9);
        EXPECT_NEAR((TypeParam::slope(t + h) - TypeParam::slope(t - h)) / (2 * h), TypeParam::density(t), 1e-8);
        EXPECT_NEAR((TypeParam::density(t + h) - TypeParam::density(t - h)) / (2 * h), TypeParam::density_slope(t),
                    1e-8);
    }
}

TYPED_TEST(Kernels, SlopeStepsByOneAtTheKink) {
    EXPECT_NEAR(TypeParam::slope(-1e-12) - TypeParam::slope(0), 1, 1e-9);
    EXPECT_DOUBLE_EQ(TypeParam::bump(0), TypeParam::peak);
}

double moment(double (*density)(double), int order) {
    constexpr int steps = 2000;
    double sum = 0;
    for (int i = 0; i < steps; ++i) {
        const double t = -1 + 2 * (i + 0.5) / steps;
        sum += density(t) * std::pow(t, order) * 2 / steps;
    }
    return sum;
}

TYPED_TEST(Kernels, DensityHasUnitMass) {
    EXPECT_NEAR(moment(&TypeParam::density, 0), 1, 1e-6);
}

TEST(CurveKernel, LeavesCubicsWhereTheyAre) {
    EXPECT_NEAR(moment(&CurveKernel::density, 2), 0, 1e-6);
    EXPECT_GT(std::abs(moment(&CurveKernel::density, 4)), 0.01);
}

TEST(CornerKernel, IsPositive) {
    for (double t = -1; t <= 1; t += 0.01) EXPECT_GE(CornerKernel::density(t), 0);
    EXPECT_GT(moment(&CornerKernel::density, 2), 0.1);
}

TEST(DetectionKernel, VanishesAtTheEdge) {
    EXPECT_NEAR(DetectionKernel::bump(1), 0, 1e-15);
    EXPECT_NEAR(DetectionKernel::bump(-1), 0, 1e-15);
    EXPECT_DOUBLE_EQ(DetectionKernel::bump(0), DetectionKernel::peak);
}

}  // namespace
}  // namespace trunnion::smoothing
