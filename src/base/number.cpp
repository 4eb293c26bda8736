#include "trunnion/base/number.hpp"

#include <charconv>
#include <cmath>

namespace trunnion {

namespace {

bool is_digit(char c) {
    return c >= '0' && c <= '9';
}

/// End of the number's text, or `at` itself when there is none.
const char* scan(const char* at, const char* end, Exponent exponent) {
    int digits = 0;
    while (at != end && is_digit(*at)) ++at, ++digits;
    if (at != end && *at == '.') {
        ++at;
        while (at != end && is_digit(*at)) ++at, ++digits;
    }
    if (digits == 0) return nullptr;
    if (exponent == Exponent::refused || at == end || (*at != 'e' && *at != 'E')) return at;
    const char* power = at + 1;
    if (power != end && (*power == '+' || *power == '-')) ++power;
    if (power == end || !is_digit(*power)) return at;
    while (power != end && is_digit(*power)) ++power;
    return power;
}

}  // namespace

std::optional<double> take_number(std::string_view& text, Exponent exponent) noexcept {
    const char* at = text.data();
    const char* const end = at + text.size();
    bool negative = false;
    if (at != end && (*at == '+' || *at == '-')) negative = *at++ == '-';
    const char* const stop = scan(at, end, exponent);
    if (!stop) return {};
    double value = 0;
    const auto format = exponent == Exponent::allowed ? std::chars_format::general : std::chars_format::fixed;
    const auto [read, error] = std::from_chars(at, stop, value, format);
    if (error != std::errc{} || read != stop || !std::isfinite(value)) return {};
    text.remove_prefix(static_cast<std::size_t>(stop - text.data()));
    return negative ? -value : value;
}

}  // namespace trunnion
