#pragma once

#include <optional>
#include <string>

namespace trunnion::files::detail {

/// The shortest decimal number that times `unit` is `value` again, to the last bit. Not every value is a multiple in
/// double numbers. Not for infinities.
std::optional<std::string> exact_number(double value, double unit);

/// That, or else 15 digits.
std::string number_in_unit(double value, double unit);

}  // namespace trunnion::files::detail
