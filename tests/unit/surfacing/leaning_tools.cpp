#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/surfacing/machined_surface.hpp"
#include "trunnion/surfacing/plan_surface.hpp"

#include "sample_surfaces.hpp"

namespace {

using namespace trunnion;
using namespace trunnion::surfacing;
using namespace trunnion::surfacing::samples;

constexpr double scallop_mm = 0.02;

SurfaceOptions leaning(Strategy strategy, double lead_deg, double tilt_deg) {
    SurfaceOptions out{.strategy = strategy, .scallop_mm = scallop_mm, .chord_tolerance_mm = 0.001};
    out.gouge_tolerance_mm = 0.01;
    out.lead_rad = lead_deg * degree;
    out.tilt_rad = tilt_deg * degree;
    return out;
}

std::size_t along_borders(const SurfacePlan& plan) {
    return static_cast<std::size_t>(
        std::ranges::count_if(plan.passes, [](const Pass& pass) { return pass.index < 0; }));
}

/// The edge of such a tool cuts a ridge ahead of one contact and behind the other: where passes end there is none
/// ahead.
TEST(LeaningTools, KeepTheScallopBesideBordersWhereTheyLeanAlongAndAcross) {
    const Face face = facing(torus(60, 20, -0.12, 0.24, 0.09), {1, 0, 0});
    for (const machine::Tool& tool : {flat_tool(10), torus_tool(10, 1)})
        for (const double tilt_deg : {20, -20})
            for (const Strategy strategy : {Strategy::along_u, Strategy::along_v, Strategy::parallel_planes}) {
                const Cutter cutter = Cutter::make(tool).value();
                const auto plan = plan_surface(face, cutter, leaning(strategy, 10, tilt_deg)).value();
                const auto verdict = check_surface(face, cutter, plan.passes, {.grid_mm = 0.4, .ridge_spacing_mm = 4});
                EXPECT_LT(verdict.highest_mm, 1.005 * scallop_mm) << tilt_deg << " " << static_cast<int>(strategy);
            }
}

TEST(LeaningTools, HaveOnePassAlongEveryBorderWhereTheEdgeLiesAlongOrAcross) {
    const Face face = facing(torus(60, 20, -0.12, 0.24, 0.09), {1, 0, 0});
    const Cutter flat = Cutter::make(flat_tool(10)).value(), ball = Cutter::make(ball_tool(10)).value();
    EXPECT_EQ(along_borders(plan_surface(face, flat, leaning(Strategy::along_u, 10, 0)).value()), 4u);
    EXPECT_EQ(along_borders(plan_surface(face, flat, leaning(Strategy::along_u, 0, 0)).value()), 4u);
    EXPECT_EQ(along_borders(plan_surface(face, ball, leaning(Strategy::along_u, 10, 20)).value()), 4u);
    EXPECT_GT(along_borders(plan_surface(face, flat, leaning(Strategy::along_u, 10, 20)).value()), 4u);
    SurfaceOptions without = leaning(Strategy::along_u, 10, 20);
    without.borders = false;
    EXPECT_EQ(along_borders(plan_surface(face, flat, without).value()), 0u);
}

struct Lean {
    double lead_deg, tilt_deg;
};

class NightlyLeaningTools : public testing::TestWithParam<Lean> {};

TEST_P(NightlyLeaningTools, KeepTheScallop) {
    const std::pair<std::string, Face> faces[] = {{"torus", facing(torus(60, 20, -0.4, 0.8, 0.3), {1, 0, 0})},
                                                  {"cylinder", facing(cylinder(30, 20, 0.6), {0, 0, 1})},
                                                  {"plane", facing(plane(20, 15), {0, 0, 1})},
                                                  {"sphere", facing(torus(0, 40, -0.2, 0.4, 0.5), {1, 0, 0})}};
    double highest_mm = 0;
    int plans = 0;
    for (const auto& [name, face] : faces)
        for (const Strategy strategy : {Strategy::constant_scallop, Strategy::along_u, Strategy::along_v,
                                        Strategy::parallel_planes, Strategy::lin_koren})
            for (const double feed_deg : {0, 35})
                for (const machine::Tool& tool : {flat_tool(10), torus_tool(10, 1)}) {
                    SurfaceOptions options = leaning(strategy, GetParam().lead_deg, GetParam().tilt_deg);
                    options.feed_angle_rad = feed_deg * degree;
                    const Cutter cutter = Cutter::make(tool).value();
                    const auto plan = plan_surface(face, cutter, options);
                    if (!plan) {
                        EXPECT_EQ(plan.error().code, "SURF0209") << name;
                        continue;
                    }
                    const auto verdict = check_surface(face, cutter, plan->passes, {.grid_mm = 0.3});
                    EXPECT_LT(verdict.highest_mm, 1.005 * scallop_mm) << name << " " << static_cast<int>(strategy);
                    EXPECT_LT(verdict.deepest_mm, options.gouge_tolerance_mm)
                        << name << " " << static_cast<int>(strategy);
                    highest_mm = std::max(highest_mm, verdict.highest_mm);
                    ++plans;
                }
    RecordProperty("plans", plans);
    RecordProperty("highest um", std::to_string(1e3 * highest_mm));
}

INSTANTIATE_TEST_SUITE_P(Nightly, NightlyLeaningTools,
                         testing::Values(Lean{10, 20}, Lean{10, -20}, Lean{5, 8}, Lean{20, 10}, Lean{15, -30}));

}  // namespace
