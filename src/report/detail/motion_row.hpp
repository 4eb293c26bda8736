#pragma once

#include <cstdint>
#include <limits>

#include "trunnion/machine/machine.hpp"

namespace trunnion::report::detail {

/// One instant of a motion, as a control would see it. NaN: not known.
struct MotionRow {
    double time_s = 0;
    machine::AxisPosition position;
    machine::AxisVelocity velocity;
    machine::AxisAcceleration acceleration;
    machine::AxisJerk jerk;
    std::int32_t line = 0;
    double path_length_mm = 0;
    double feed_mm_s = 0;
    double programmed_feed_mm_s = std::numeric_limits<double>::quiet_NaN();
    double contact_feed_mm_s = std::numeric_limits<double>::quiet_NaN();
    std::uint8_t cause = 0;
    bool rapid = false;
};

}  // namespace trunnion::report::detail
