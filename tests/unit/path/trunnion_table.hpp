#pragma once

#include "trunnion/base/quantity.hpp"
#include "trunnion/machine/kinematics.hpp"

namespace trunnion {

/// C on A table, pivots at the machine zero, ISO 841 counts unless `reversed`; A ±120°, C endless.
inline machine::Machine trunnion_table(bool reversed = false) {
    machine::Machine m;
    m.name = "test table";
    m.axis_count = 5;
    m.rotary_count = 2;
    m.chain = {4, 3, 0, 1, 2};
    const char letters[] = "XYZAC";
    const Eigen::Vector3d directions[] = {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ(),
                                          Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ()};
    for (int i = 0; i < 5; ++i) {
        machine::Axis& axis = m.axes[i];
        axis.letter = letters[i];
        axis.rotary = i > 2;
        axis.reversed = axis.rotary && reversed;
        axis.direction = directions[i];
        axis.feed = axis.rotary ? machine::AxisLimits{90 * degree, 300 * degree, 1800 * degree}
                                : machine::AxisLimits{500, 2500, 5000};
        axis.rapid = axis.feed;
        if (!axis.rotary) axis.range_min = -1000, axis.range_max = 1000;
    }
    m.axes[3].range_min = -120 * degree;
    m.axes[3].range_max = 120 * degree;
    return m;
}

}  // namespace trunnion
