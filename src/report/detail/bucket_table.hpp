#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace trunnion::report::detail {

/// Rows of time in a bounded number of buckets: of each quantity the least and the greatest value, of time, way, line
/// and cause what the bucket begins with. When all buckets are full, two by two become one.
class BucketTable {
  public:
    static constexpr std::size_t most_buckets = std::size_t{1} << 17;

    struct Begin {
        double time_s = 0;
        double path_length_mm = 0;
        std::int32_t line = 0;
        std::uint8_t cause = 0;
        bool rapid = false;
    };

    explicit BucketTable(std::size_t quantities, std::size_t most = most_buckets)
        : most_(most), least_(quantities), greatest_(quantities) {}

    /// `values`: one a quantity; NaN: none.
    void add(const Begin& begin, std::span<const float> values);

    std::size_t size() const { return begins_.size(); }
    std::size_t rows_per_bucket() const { return rows_per_bucket_; }
    const std::vector<Begin>& begins() const { return begins_; }
    const std::vector<float>& least(std::size_t quantity) const { return least_[quantity]; }
    const std::vector<float>& greatest(std::size_t quantity) const { return greatest_[quantity]; }

  private:
    void halve();

    std::size_t most_, rows_per_bucket_ = 1, rows_in_last_ = 0;
    std::vector<Begin> begins_;
    std::vector<std::vector<float>> least_, greatest_;
};

}  // namespace trunnion::report::detail
