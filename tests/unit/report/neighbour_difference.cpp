#include "detail/neighbour_difference.hpp"

#include <algorithm>
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

/// What was left out does not move the answer at what stayed: the feed of a pass lies between its kept places.
TEST(NeighbourDifferences, SameOnThinnedPlaces) {
    std::vector<PathPlace> given;
    double way_mm = 0, time_s = 0;
    for (int pass = 0; pass < 6; ++pass)
        for (int i = 0; i <= 400; ++i) {
            const double x = 0.25 * (pass % 2 == 0 ? i : 400 - i);
            const double dip = pass == 3 ? 40 * std::exp(-0.01 * (x - 60) * (x - 60)) : 0;
            given.push_back({.time_s = time_s,
                             .path_length_mm = way_mm,
                             .tip_mm = {x, 1.0 * pass, 0},
                             .feed_mm_s = 80 + 0.2 * x - dip,
                             .line = pass});
            way_mm += i < 400 ? 0.25 : 1;
            time_s += 0.003;
        }
    PathThinning thinning;
    for (const PathPlace& place : given) thinning.add(place);
    thinning.finish();
    const std::vector<PathPlace>& kept = thinning.places();
    ASSERT_LT(kept.size(), given.size() / 4);
    const auto of_all = neighbour_differences(given, {0.1, 1.5}), of_kept = neighbour_differences(kept, {0.1, 1.5});
    std::size_t at = 0;
    float greatest = 0;
    for (std::size_t k = 0; k < kept.size(); ++k) {
        while (given[at].time_s < kept[k].time_s) ++at;
        if (std::isnan(of_all[at])) continue;
        EXPECT_NEAR(of_kept[k], of_all[at], 0.025) << "at " << kept[k].tip_mm.transpose();
        greatest = std::max(greatest, of_kept[k]);
    }
    EXPECT_NEAR(greatest, 0.43, 0.03);  // 40 of 92 mm/s
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
