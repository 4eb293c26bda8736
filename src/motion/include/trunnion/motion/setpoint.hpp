#pragma once

#include <cstdint>

#include "trunnion/machine/machine.hpp"

namespace trunnion::motion {

/// One row of axis setpoints.
struct Setpoint {
    double time_s = 0;
    machine::AxisPosition position;
    std::int32_t line = 0;      ///< of the program, the block on whose span the row lies
    double path_length_mm = 0;  ///< s, the tip's way
    double feed_mm_s = 0;       ///< speed of the tip in the workpiece
};

}  // namespace trunnion::motion
