#include "detail/bucket_table.hpp"

#include <array>
#include <cmath>

#include <gtest/gtest.h>

namespace trunnion::report::detail {
namespace {

TEST(BucketTable, KeepsEveryRowWhileThereIsRoom) {
    BucketTable table(1, 8);
    for (int i = 0; i < 8; ++i) table.add({.time_s = i * 0.001, .line = i}, std::array{static_cast<float>(i)});
    ASSERT_EQ(table.size(), 8U);
    EXPECT_EQ(table.rows_per_bucket(), 1U);
    EXPECT_EQ(table.least(0)[5], 5.0F);
    EXPECT_EQ(table.greatest(0)[5], 5.0F);
}

TEST(BucketTable, ExtremesSurviveMerging) {
    constexpr std::size_t most = 64;
    BucketTable table(2, most);
    constexpr int rows = 10'000, spike = 7777;
    for (int i = 0; i < rows; ++i)
        table.add({.time_s = i * 0.001, .path_length_mm = i * 0.1, .line = i / 10},
                  std::array{i == spike ? 100.0F : std::sin(static_cast<float>(i)), -static_cast<float>(i)});
    EXPECT_LE(table.size(), most);
    EXPECT_GT(table.size(), most / 2 - 1);
    EXPECT_EQ(table.rows_per_bucket(), 256U);
    const std::size_t bucket = spike / table.rows_per_bucket();
    EXPECT_EQ(table.greatest(0)[bucket], 100.0F);
    EXPECT_LT(table.greatest(0)[bucket - 1], 1.01F);
    EXPECT_EQ(table.begins()[bucket].line, static_cast<int>(bucket * table.rows_per_bucket() / 10));
    EXPECT_EQ(table.greatest(1)[bucket], -static_cast<float>(bucket * table.rows_per_bucket()));
    EXPECT_EQ(table.least(1).back(), -static_cast<float>(rows - 1));
}

TEST(BucketTable, UnknownValuesAreLeftOut) {
    BucketTable table(1, 2);
    const float unknown = std::nanf("");
    for (const float value : {unknown, 3.0F, 1.0F, unknown, unknown, unknown, unknown, unknown})
        table.add({}, std::array{value});
    ASSERT_EQ(table.size(), 2U);
    EXPECT_EQ(table.least(0)[0], 1.0F);
    EXPECT_EQ(table.greatest(0)[0], 3.0F);
    EXPECT_TRUE(std::isnan(table.least(0)[1]));
}

}  // namespace
}  // namespace trunnion::report::detail
