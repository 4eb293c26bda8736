#include "detail/neighbour_difference.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace trunnion::report::detail {
namespace {

/// Passes to and fro along X, 1 mm apart; the feed of the third is half that of the others.
std::vector<PathPlace> passes() {
    std::vector<PathPlace> out;
    double way_mm = 0;
    for (int pass = 0; pass < 5; ++pass) {
        for (int i = 0; i <= 100; ++i) {
            PathPlace place;
            place.tip_mm = Eigen::Vector3d(pass % 2 == 0 ? i : 100 - i, pass, 0);
            place.feed_mm_s = pass == 2 ? 50 : 100;
            place.path_length_mm = way_mm++;
            out.push_back(place);
        }
    }
    return out;
}

TEST(NeighbourDifferences, SlowPassStandsOut) {
    const auto found = neighbour_differences(passes(), {0.1, 1.5});
    EXPECT_NEAR(found[50], 0, 1e-6);              // first pass beside the second
    EXPECT_NEAR(found[2 * 101 + 50], 0.5, 1e-6);  // the slow one
    EXPECT_NEAR(found[4 * 101 + 50], 0, 1e-6);
}

TEST(NeighbourDifferences, NothingWhereNoOtherPassIsNear) {
    for (const float share : neighbour_differences(passes(), {0.9})) EXPECT_TRUE(std::isnan(share));
}

TEST(NeighbourDifferences, RapidsAreNoPasses) {
    auto places = passes();
    for (PathPlace& place : places) place.rapid = place.tip_mm.y() == 2;
    const auto found = neighbour_differences(places, {1.5});
    EXPECT_TRUE(std::isnan(found[2 * 101 + 50]));
    EXPECT_NEAR(found[3 * 101 + 50], 0, 1e-6);  // its other neighbour
}

TEST(NeighbourDifferences, ReachFollowsTheSizeOfThePart) {
    std::vector<PathPlace> places(2);
    places[1].tip_mm = {100, 0, 0};
    EXPECT_EQ(neighbour_reaches_mm(places), (std::vector<double>{0.5, 2, 8}));
    places[1].tip_mm = {1000, 0, 0};
    EXPECT_EQ(neighbour_reaches_mm(places), (std::vector<double>{5, 20, 20}));
    EXPECT_EQ(neighbour_reaches_mm({}).size(), 3U);
}

}  // namespace
}  // namespace trunnion::report::detail
