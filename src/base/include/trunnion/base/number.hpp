#pragma once

#include <optional>
#include <string_view>

namespace trunnion {

/// Whether a number may be written with an exponent. In NC text `E` is an address, so 10E5 is the number 10 and a word.
enum class Exponent { refused, allowed };

/// Reads the longest decimal number that `text` starts with: optional sign (+ or -), digits with at most one point, at
/// least one digit, an exponent where allowed. Never accepts inf, nan or hexadecimal. On success `text` is advanced
/// behind the number. Empty when there is no number or when its value is not finite in double.
/// Exactly rounded. Cost: one pass, no allocation.
std::optional<double> take_number(std::string_view& text, Exponent exponent = Exponent::refused) noexcept;

}  // namespace trunnion
