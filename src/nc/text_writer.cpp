#include "detail/text_writer.hpp"

#include <array>
#include <charconv>

namespace trunnion::nc {

namespace {

constexpr int most_decimals = 12;
constexpr std::array<std::int64_t, most_decimals + 1> powers = [] {
    std::array<std::int64_t, most_decimals + 1> out{};
    std::int64_t power = 1;
    for (std::int64_t& entry : out) {
        entry = power;
        power *= 10;
    }
    return out;
}();

DecimalGrid grid_of(int decimals) {
    return {decimals, static_cast<double>(powers[static_cast<std::size_t>(decimals)])};
}

}  // namespace

DecimalGrid DecimalGrid::within(double largest_error) noexcept {
    constexpr double rounding = 1 + 1e-9;  // 0.0005 is meant to be three decimals
    int decimals = 0;
    while (decimals < most_decimals && 0.5 > largest_error * rounding * grid_of(decimals).per_unit) ++decimals;
    return grid_of(decimals);
}

void TextWriter::integer(std::int64_t number) {
    std::array<char, 24> digits;
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr;
    buffer_.append(digits.data(), end);
}

void TextWriter::number(const DecimalGrid& grid, std::int64_t steps, NumberStyle style) {
    std::array<char, 40> text;
    char* at = text.data();
    if (steps < 0)
        *at++ = '-';
    else if (style.plus_sign)
        *at++ = '+';
    const std::int64_t magnitude = std::abs(steps), power = powers[static_cast<std::size_t>(grid.decimals)];
    at = std::to_chars(at, text.data() + text.size(), magnitude / power).ptr;
    std::int64_t fraction = magnitude % power;
    if (fraction != 0 || style.point_always) *at++ = '.';
    for (std::int64_t place = power / 10; fraction != 0; place /= 10) {
        *at++ = static_cast<char>('0' + fraction / place);
        fraction %= place;
    }
    buffer_.append(text.data(), at);
}

void TextWriter::number_within(double value, double share, NumberStyle style) {
    int decimals = 0;
    DecimalGrid grid = grid_of(0);
    while (decimals < most_decimals && grid.holds(value) &&
           !(std::abs(grid.value(grid.steps(value)) - value) <= share * std::abs(value)))
        grid = grid_of(++decimals);
    number(grid, grid.steps(value), style);
}

void TextWriter::end_line() {
    buffer_ += '\n';
    ++lines_;
    if (buffer_.size() >= piece) flush();
}

void TextWriter::flush() {
    if (!buffer_.empty()) sink_(buffer_);
    buffer_.clear();
}

}  // namespace trunnion::nc
