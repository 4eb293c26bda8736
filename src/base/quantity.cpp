#include "trunnion/base/quantity.hpp"

#include <array>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "trunnion/base/number.hpp"

namespace trunnion {

namespace {

struct Unit {
    std::string_view name;
    double scale;
    Dimension dimension;
};

constexpr double revolution = 2.0 * std::numbers::pi;
constexpr std::array<Unit, 13> units{{{"mm", 1.0, dimension::length},
                                      {"m", 1e3, dimension::length},
                                      {"um", 1e-3, dimension::length},
                                      {"in", inch_mm, dimension::length},
                                      {"deg", degree, dimension::angle},
                                      {"rad", 1.0, dimension::angle},
                                      {"rev", revolution, dimension::angle},
                                      {"rpm", revolution / 60.0, dimension::angular_velocity},
                                      {"s", 1.0, dimension::time},
                                      {"ms", 1e-3, dimension::time},
                                      {"min", 60.0, dimension::time},
                                      {"%", 0.01, dimension::ratio},
                                      {"µm", 1e-3, dimension::length}}};

std::string_view trimmed(std::string_view text) {
    constexpr std::string_view blanks = " \t";
    const auto first = text.find_first_not_of(blanks);
    if (first == text.npos) return {};
    return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

/// One factor of a unit, `s^2`.
std::optional<Unit> parse_factor(std::string_view text) {
    text = trimmed(text);
    int power = 1;
    if (const auto caret = text.find('^'); caret != text.npos) {
        const auto digits = trimmed(text.substr(caret + 1));
        if (digits.size() != 1 || digits[0] < '1' || digits[0] > '9') return {};
        power = digits[0] - '0';
        text = trimmed(text.substr(0, caret));
    }
    for (const Unit& unit : units)
        if (unit.name == text)
            return Unit{unit.name,
                        std::pow(unit.scale, power),
                        {unit.dimension.length * power, unit.dimension.angle * power, unit.dimension.time * power}};
    return {};
}

std::optional<Unit> parse_unit(std::string_view text) {
    Unit total{text, 1.0, {}};
    for (int sign = 1;; sign = -1) {
        const auto slash = text.find('/');
        const auto factor = parse_factor(text.substr(0, slash));
        if (!factor) return {};
        total.scale = sign > 0 ? total.scale * factor->scale : total.scale / factor->scale;
        total.dimension.length += sign * factor->dimension.length;
        total.dimension.angle += sign * factor->dimension.angle;
        total.dimension.time += sign * factor->dimension.time;
        if (slash == text.npos) return total;
        text.remove_prefix(slash + 1);
    }
}

std::string_view example(Dimension wanted) {
    if (wanted == dimension::length) return "\"20 mm\"";
    if (wanted == dimension::angle) return "\"0.1 deg\"";
    if (wanted == dimension::time) return "\"1 ms\"";
    if (wanted == dimension::ratio) return "\"100%\"";
    if (wanted == dimension::velocity) return "\"30 m/min\"";
    if (wanted == dimension::acceleration) return "\"2.5 m/s^2\"";
    if (wanted == dimension::jerk) return "\"50 m/s^3\"";
    if (wanted == dimension::angular_velocity) return "\"15 rpm\"";
    if (wanted == dimension::angular_acceleration) return "\"10 rad/s^2\"";
    return "\"200 rad/s^3\"";
}

std::unexpected<Diagnostic> refuse(std::string code, std::string text, Dimension wanted) {
    return fail(
        {.code = std::move(code), .text = std::move(text), .hint = fmt::format("write it like {}", example(wanted))});
}

}  // namespace

Result<double> parse_quantity(std::string_view text, Dimension wanted) {
    std::string_view rest = trimmed(text);
    const auto number = take_number(rest, Exponent::allowed);
    if (!number) return refuse("BASE0001", fmt::format("'{}' is not a finite number with a unit", text), wanted);
    rest = trimmed(rest);
    if (rest.empty()) return refuse("BASE0002", fmt::format("'{}' has no unit", text), wanted);
    const auto unit = parse_unit(rest);
    if (!unit) return refuse("BASE0003", fmt::format("'{}' is not a known unit", rest), wanted);
    if (unit->dimension != wanted)
        return refuse("BASE0004", fmt::format("'{}' has the wrong kind of unit", text), wanted);
    return *number * unit->scale;
}

}  // namespace trunnion
