#pragma once

#include "trunnion/motion/controller.hpp"
#include "trunnion/motion/prediction.hpp"
#include "trunnion/program/program.hpp"

namespace trunnion::controller {

/// Dwells, and what tool changes and other words take on which the axes stand still.
struct StopTimes {
    double dwell_s = 0, tool_change_s = 0, other_s = 0;
    double sum_s() const { return dwell_s + tool_change_s + other_s; }
};
StopTimes stop_time(const program::Event& event, const motion::Controller& controller);
StopTimes stop_times(const program::Program& program, const motion::Controller& controller);

}  // namespace trunnion::controller
