#include "trunnion/geometry/bspline_basis.hpp"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "trunnion/geometry/bspline_curve.hpp"

namespace {

using namespace trunnion::geometry;
using Eigen::Vector3d;

/// Uneven knots, clamped, one of them double.
std::vector<double> knots_of(int degree) {
    std::vector<double> out(static_cast<std::size_t>(degree) + 1, -1.0);
    for (const double inside : {0.2, 0.5, 0.5, 1.7}) out.push_back(inside);
    if (degree == 1) out.erase(out.end() - 2);
    out.insert(out.end(), static_cast<std::size_t>(degree) + 1, 2.5);
    return out;
}

TEST(BsplineBasis, GivesTheCurveAndItsDerivatives) {
    for (int degree = 1; degree <= max_degree; ++degree) {
        const std::vector<double> knots = knots_of(degree);
        std::vector<Vector3d> points;
        for (std::size_t i = 0; i + static_cast<std::size_t>(degree) + 1 < knots.size(); ++i) {
            const double t = static_cast<double>(i);
            points.emplace_back(4 * t, 3 * std::sin(1.1 * t), std::cos(2.3 * t));
        }
        const auto curve = BsplineCurve::make(degree, knots, points).value();
        for (double u = -1.2; u < 2.8; u += 0.1) {
            const BasisFunctions basis = basis_functions(degree, knots, u);
            for (std::size_t k = 0; k < 3; ++k) {
                Vector3d sum = Vector3d::Zero();
                for (std::size_t j = 0; j <= static_cast<std::size_t>(degree); ++j)
                    sum += basis.derivative[k][j] * points[basis.first + j];
                const Vector3d wanted = curve.evaluate(u)[k];
                EXPECT_LT((sum - wanted).norm(), 1e-10 * (1 + wanted.norm())) << degree << " " << u << " " << k;
            }
        }
    }
}

TEST(BsplineBasis, SumsToOneUpToTheEnds) {
    for (int degree = 1; degree <= max_degree; ++degree)
        for (const double u : {-1.0, 0.2, 0.5, 1.1, 2.5}) {
            const BasisFunctions basis = basis_functions(degree, knots_of(degree), u);
            double value = 0, slope = 0;
            for (int j = 0; j <= degree; ++j) value += basis.derivative[0][j], slope += basis.derivative[1][j];
            EXPECT_NEAR(value, 1, 1e-14);
            EXPECT_NEAR(slope, 0, 1e-12);
        }
}

}  // namespace
