#include "trunnion/geometry/dual_spline.hpp"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace {

using namespace trunnion;
using namespace trunnion::geometry;
using Eigen::Vector3d;

const std::vector<double> bezier{0, 0, 0, 0, 1, 1, 1, 1};

DualSpline twisted() {
    auto bottom = BsplineCurve::make(3, bezier, {{0, 0, 0}, {10, 5, 0}, {20, -5, 1}, {30, 0, 0}}).value();
    auto top = BsplineCurve::make(3, bezier, {{0, 3, 15}, {8, 5, 18}, {25, -9, 16}, {30, 4, 20}}).value();
    return DualSpline::make(bottom, top).value();
}

void expect_axis_series(const DualSpline& dual, double u) {
    constexpr double h = 1e-3;
    const auto before = dual.axis(u - h), at = dual.axis(u), after = dual.axis(u + h);
    double length2 = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        length2 += at[i].value() * at[i].value();
        EXPECT_NEAR(at[i].d1(), (after[i].value() - before[i].value()) / (2 * h), 1e-3);
        EXPECT_NEAR(at[i].d2(), (after[i].d1() - before[i].d1()) / (2 * h), 2e-2);
        EXPECT_NEAR(at[i].d3(), (after[i].d2() - before[i].d2()) / (2 * h), 1);
    }
    EXPECT_NEAR(length2, 1, 1e-14);
}

TEST(DualSpline, AxisIsAUnitSeries) {
    for (const double u : {0.1, 0.5, 0.8}) expect_axis_series(twisted(), u);
}

TEST(DualSpline, RefusesCurvesOverDifferentKnots) {
    const auto bottom = BsplineCurve::make(1, {0, 0, 1, 1}, {{0, 0, 0}, {1, 0, 0}}).value();
    const auto top = BsplineCurve::make(1, {0, 0, 2, 2}, {{0, 0, 5}, {1, 0, 5}}).value();
    const auto made = DualSpline::make(bottom, top);
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().code, "GEOM0106");
}

std::vector<Vector3d> points_of(const nlohmann::json& list) {
    std::vector<Vector3d> out;
    for (const auto& p : list) out.emplace_back(p[0].get<double>(), p[1].get<double>(), p[2].get<double>());
    return out;
}

TEST(DualSpline, TakesThePublishedFlankPath) {
    const auto path = std::filesystem::path(TRUNNION_SHARED_DIR) / "data/published/flank-2012.json";
    if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not here";
    const auto file = nlohmann::json::parse(std::ifstream(path));
    const auto knots = file["knots"].get<std::vector<double>>();
    const int degree = file["degree"].get<int>();
    const auto dual = DualSpline::make(BsplineCurve::make(degree, knots, points_of(file["bottom_mm"])).value(),
                                       BsplineCurve::make(degree, knots, points_of(file["top_mm"])).value());
    ASSERT_TRUE(dual);
    EXPECT_EQ(dual->bottom().pieces().size(), 5u);
    EXPECT_EQ(dual->bottom().evaluate(dual->begin())[0], Vector3d(5, 0, 0));
    EXPECT_LT((dual->top().evaluate(dual->end())[0] - Vector3d(60, 0, 15)).norm(), 1e-13);
    for (const double u : {0.1, 0.3, 0.5, 0.7, 0.9}) expect_axis_series(*dual, u);
}

}  // namespace
