#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "trunnion/nc/write.hpp"

namespace trunnion::nc {

/// Numbers with a fixed count of decimals, counted in steps of the last one.
struct DecimalGrid {
    int decimals = 0;
    double per_unit = 1;

    /// The coarsest grid on which rounding errs by no more than that.
    static DecimalGrid within(double largest_error) noexcept;
    std::int64_t steps(double value) const noexcept { return std::llrint(value * per_unit); }
    double value(std::int64_t steps) const noexcept { return static_cast<double>(steps) / per_unit; }
    /// Whether steps() means something: 15 digits.
    bool holds(double value) const noexcept { return std::abs(value) * per_unit < 9e15; }
};

/// How numbers look beside their digits.
struct NumberStyle {
    bool point_always = false;  ///< `1.` for 1
    bool plus_sign = false;     ///< `+1` for 1
};

/// Text on its way to the sink. Allocates only while its buffer grows to the length of the longest line.
class TextWriter {
  public:
    explicit TextWriter(const TextSink& sink) : sink_(sink) { buffer_.reserve(piece + 4096); }

    void put(std::string_view text) { buffer_ += text; }
    void put(char c) { buffer_ += c; }
    void integer(std::int64_t number);
    /// Without trailing zeros.
    void number(const DecimalGrid& grid, std::int64_t steps, NumberStyle style = {});
    /// With the fewest decimals that err by no more than `share` of it.
    void number_within(double value, double share, NumberStyle style = {});
    /// A blank, but not at the beginning of a line.
    void gap() {
        if (!buffer_.empty() && buffer_.back() != '\n') buffer_ += ' ';
    }
    void end_line();
    void flush();
    std::size_t lines() const { return lines_; }

  private:
    static constexpr std::size_t piece = std::size_t{1} << 16;

    const TextSink& sink_;
    std::string buffer_;
    std::size_t lines_ = 0;
};

}  // namespace trunnion::nc
