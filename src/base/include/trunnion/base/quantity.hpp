#pragma once

#include <numbers>
#include <string_view>

#include "trunnion/base/result.hpp"

namespace trunnion {

inline constexpr double degree = std::numbers::pi / 180.0;  ///< rad
inline constexpr double inch_mm = 25.4;                     ///< mm

/// Exponents of length, angle and time.
struct Dimension {
    int length = 0;
    int angle = 0;
    int time = 0;
    bool operator==(const Dimension&) const = default;
};

namespace dimension {
inline constexpr Dimension ratio{};  ///< plain number or percent
inline constexpr Dimension length{1, 0, 0}, angle{0, 1, 0}, time{0, 0, 1};
inline constexpr Dimension velocity{1, 0, -1}, acceleration{1, 0, -2}, jerk{1, 0, -3};
inline constexpr Dimension angular_velocity{0, 1, -1}, angular_acceleration{0, 1, -2}, angular_jerk{0, 1, -3};
}  // namespace dimension

/// Reads what people write, `30 m/min`, `20um`, `0.83 rev/s^2`, `15 rpm`, `0.1 deg`, `100%`, into mm, rad, s.
/// Units: mm m um in deg rad rev rpm s ms min and %, joined by `/`, with `^n`.
/// Errors: BASE0001 no number, BASE0002 unit missing, BASE0003 unknown unit, BASE0004 another dimension than `wanted`.
Result<double> parse_quantity(std::string_view text, Dimension wanted);

}  // namespace trunnion
