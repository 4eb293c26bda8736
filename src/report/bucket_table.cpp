#include "detail/bucket_table.hpp"

namespace trunnion::report::detail {

namespace {

/// fmin and fmax leave out NaN.
void merge_pairs(std::vector<float>& values, float (*of_two)(float, float)) {
    const std::size_t half = values.size() / 2;
    for (std::size_t i = 0; i < half; ++i) values[i] = of_two(values[2 * i], values[2 * i + 1]);
    values.resize(half);
}

float least_of(float a, float b) {
    return std::fmin(a, b);
}
float greatest_of(float a, float b) {
    return std::fmax(a, b);
}

}  // namespace

void BucketTable::add(const Begin& begin, std::span<const float> values) {
    if (begins_.empty() || rows_in_last_ == rows_per_bucket_) {
        if (begins_.size() == most_) halve();
        begins_.push_back(begin);
        for (std::size_t k = 0; k < values.size(); ++k) {
            least_[k].push_back(values[k]);
            greatest_[k].push_back(values[k]);
        }
        rows_in_last_ = 1;
        return;
    }
    ++rows_in_last_;
    for (std::size_t k = 0; k < values.size(); ++k) {
        least_[k].back() = least_of(least_[k].back(), values[k]);
        greatest_[k].back() = greatest_of(greatest_[k].back(), values[k]);
    }
}

/// All buckets are full and their number is even.
void BucketTable::halve() {
    for (std::size_t i = 0; i < begins_.size() / 2; ++i) begins_[i] = begins_[2 * i];
    begins_.resize(begins_.size() / 2);
    for (auto& values : least_) merge_pairs(values, least_of);
    for (auto& values : greatest_) merge_pairs(values, greatest_of);
    rows_per_bucket_ *= 2;
}

}  // namespace trunnion::report::detail
