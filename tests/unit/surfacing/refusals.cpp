#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "trunnion/base/quantity.hpp"
#include "trunnion/surfacing/plan_surface.hpp"

#include "sample_surfaces.hpp"

namespace {

using namespace trunnion;
using namespace trunnion::surfacing;
using namespace trunnion::surfacing::samples;

/// A plane that opposite borders cross on: beyond a share of its way it looks down.
Face turned_over(double size, double share) {
    const double end = size * (1 - 1 / share);
    return facing(geometry::BsplineSurface::make(
                      line(), line(), {{0, -size / 2, 0}, {0, size / 2, 0}, {size, -end / 2, 0}, {size, end / 2, 0}})
                      .value(),
                  {0, 0, 1});
}

Result<SurfacePlan> planned(const Face& face, double scallop_mm, Strategy strategy = Strategy::constant_scallop) {
    SurfaceOptions options;
    options.strategy = strategy;
    options.scallop_mm = scallop_mm;
    options.chord_tolerance_mm = scallop_mm / 20;
    return plan_surface(face, Cutter::make(ball_tool(6)).value(), options);
}

TEST(PlanRefuses, PlacesThatPassesDoNotGetTo) {
    const auto refused = planned(turned_over(16, 0.8), 0.05);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, "SURF0210");
    EXPECT_NE(refused.error().text.find("(14."), std::string::npos) << refused.error().text;  // beyond 12.8
    EXPECT_TRUE(planned(turned_over(16, 2), 0.05));  // borders that do not cross on the face
}

/// A sliver across a large box: nearly all of the places that count are beside the face, and cost little.
TEST(PlanRefuses, FinerScallopsThanTheWorkAllows) {
    Face sliver = facing(plane(200, 200), {0, 0, 1});
    sliver.loops = {{{0, 0}, {0.01, 0}, {1, 1}, {0.99, 1}}};
    const auto refused = planned(sliver, 2e-7, Strategy::along_u);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, "SURF0206");
    EXPECT_NE(refused.error().limit.find("600000"), std::string::npos) << to_string(refused.error());
    EXPECT_TRUE(planned(sliver, 0.1, Strategy::along_u));
}

}  // namespace
