#pragma once

#include <array>

#include <Eigen/Geometry>

#include "trunnion/machine/kinematics.hpp"

namespace trunnion::machine {

/// Area that the tool axis sweeps on its sphere per rad² of both axes: 0 at the pole and at the rim.
inline double sweep_of(const Kinematics& k, const RotaryPosition& rotary) {
    if (k.rotary_count() < 2) return 1;
    std::array<Eigen::Vector3d, 2> rate;
    for (std::size_t a = 0; a < 2; ++a) {
        RotarySeries turning{Taylor3(rotary[0]), Taylor3(rotary[1])};
        turning[a].c[1] = 1;
        const VectorSeries axis = k.tool_axis(turning);
        rate[a] = {axis[0].d1(), axis[1].d1(), axis[2].d1()};
    }
    return rate[0].cross(rate[1]).norm();
}

}  // namespace trunnion::machine
