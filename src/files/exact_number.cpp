#include "detail/exact_number.hpp"

#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "trunnion/base/number.hpp"

namespace trunnion::files::detail {

namespace {

double read_back(std::string_view text, double unit) {
    return take_number(text, Exponent::allowed).value_or(0) * unit;
}

}  // namespace

std::optional<std::string> exact_number(double value, double unit) {
    const double quotient = value / unit;
    constexpr double far = std::numeric_limits<double>::infinity();
    for (const int digits : {15, 16, 17})
        for (const double near : {quotient, std::nextafter(quotient, -far), std::nextafter(quotient, far)}) {
            std::string text = fmt::format("{:.{}g}", near, digits);
            if (read_back(text, unit) == value) return text;
        }
    return {};
}

std::string number_in_unit(double value, double unit) {
    return exact_number(value, unit).value_or(fmt::format("{:.15g}", value / unit));
}

}  // namespace trunnion::files::detail
