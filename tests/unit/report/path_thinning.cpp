#include "detail/path_thinning.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace trunnion::report::detail {
namespace {

PathPlace on_circle(int i, double radius_mm) {
    const double angle = i * 1e-3;
    PathPlace out;
    out.time_s = i * 1e-3;
    out.path_length_mm = radius_mm * angle;
    out.tip_mm = {radius_mm * std::cos(angle), radius_mm * std::sin(angle), 0};
    out.feed_mm_s = radius_mm;
    out.line = 1;
    return out;
}

/// How far every given place is from the polyline of the kept ones.
double farthest_mm(const std::vector<PathPlace>& given, const std::vector<PathPlace>& kept) {
    double out = 0;
    std::size_t k = 1;
    for (const PathPlace& place : given) {
        while (k + 1 < kept.size() && kept[k].time_s < place.time_s) ++k;
        const Eigen::Vector3d from = kept[k - 1].tip_mm, way = kept[k].tip_mm - from;
        const double square = way.squaredNorm();
        const double share = square > 0 ? std::clamp(way.dot(place.tip_mm - from) / square, 0.0, 1.0) : 0;
        out = std::max(out, (place.tip_mm - from - share * way).norm());
    }
    return out;
}

TEST(PathThinning, KeepsNearToACircleWithFewPlaces) {
    PathThinning thinning;
    std::vector<PathPlace> given;
    for (int i = 0; i <= 6283; ++i) given.push_back(on_circle(i, 10));
    for (const PathPlace& place : given) thinning.add(place);
    thinning.finish();
    EXPECT_EQ(thinning.places().front().time_s, given.front().time_s);
    EXPECT_EQ(thinning.places().back().time_s, given.back().time_s);
    // Chords of 2 µm leave 157 on this circle; the filter is within some factor of that.
    EXPECT_LT(thinning.places().size(), 400U);
    EXPECT_GT(thinning.places().size(), 100U);
    EXPECT_LT(farthest_mm(given, thinning.places()), 0.004);
}

TEST(PathThinning, StraightWithEvenFeedIsItsEnds) {
    PathThinning thinning;
    for (int i = 0; i <= 1000; ++i)
        thinning.add({.time_s = i * 1e-3, .path_length_mm = i * 0.1, .tip_mm = {i * 0.1, 0, 0}, .feed_mm_s = 100});
    thinning.finish();
    EXPECT_EQ(thinning.places().size(), 2U);
}

TEST(PathThinning, EndsOfBlocksAndDipsOfTheFeedStay) {
    PathThinning thinning;
    for (int i = 0; i <= 1000; ++i)
        thinning.add({.time_s = i * 1e-3,
                      .path_length_mm = i * 0.1,
                      .tip_mm = {i * 0.1, 0, 0},
                      .feed_mm_s = i == 300 ? 10.0 : 100.0,
                      .line = i < 500 ? 1 : 2});
    thinning.finish();
    const auto& kept = thinning.places();
    EXPECT_TRUE(std::ranges::any_of(kept, [](const PathPlace& p) { return p.feed_mm_s == 10; }));
    EXPECT_TRUE(std::ranges::any_of(kept, [](const PathPlace& p) { return p.time_s == 499 * 1e-3; }));
    EXPECT_LT(kept.size(), 10U);
}

TEST(PathThinning, NeverMoreThanAskedForWhateverComes) {
    constexpr std::size_t most = 200;
    PathThinning thinning(most);
    std::vector<PathPlace> given;
    for (int i = 0; i < 20'000; ++i) {
        given.push_back(on_circle(i, 50));
        given.back().line = i;
        given.back().rapid = i % 2 == 0;
        thinning.add(given.back());
    }
    thinning.finish();
    EXPECT_LE(thinning.places().size(), most);
    EXPECT_GT(thinning.places().size(), 30U);
    EXPECT_EQ(thinning.places().back().time_s, given.back().time_s);
    EXPECT_LT(farthest_mm(given, thinning.places()), 10);
}

TEST(CoarsePlaces, FewThatKeepTheEndsAndEveryDip) {
    std::vector<PathPlace> given;
    for (int i = 0; i <= 20'000; ++i) {
        given.push_back(on_circle(i, 50));
        given.back().line = i / 10;
        if (i % 5000 == 2500) given.back().feed_mm_s = 5;
    }
    constexpr std::size_t most = 300;
    const auto chosen = coarse_places(given, most);
    EXPECT_LE(chosen.size(), most);
    EXPECT_GT(chosen.size(), 30U);
    EXPECT_EQ(chosen.front(), 0);
    EXPECT_EQ(chosen.back(), 20'000);
    EXPECT_TRUE(std::ranges::is_sorted(chosen));
    for (const int dip : {2500, 7500, 12500, 17500})
        EXPECT_TRUE(std::ranges::binary_search(chosen, dip)) << "the dip at " << dip << " is not drawn";
}

TEST(CoarsePlaces, OfFewPlacesAllAndOfNoneNone) {
    EXPECT_TRUE(coarse_places({}, 100).empty());
    EXPECT_EQ(coarse_places({on_circle(0, 10)}, 100), std::vector<std::int32_t>{0});
    std::vector<PathPlace> corners;
    for (int i = 0; i < 20; ++i)
        corners.push_back({.time_s = i * 1.0, .tip_mm = Eigen::Vector3d(i, i % 2, 0), .feed_mm_s = 10});
    EXPECT_EQ(coarse_places(corners, 100).size(), corners.size());
}

}  // namespace
}  // namespace trunnion::report::detail
