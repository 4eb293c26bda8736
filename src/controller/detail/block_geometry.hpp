#pragma once

#include <vector>

#include <Eigen/Core>

#include "trunnion/machine/machine.hpp"
#include "trunnion/path/run.hpp"

namespace trunnion::controller {

/// The machine at one place of a run.
struct Station {
    machine::AxisPosition axes;
    Eigen::Vector3d tip_mm, tool_axis;  ///< in the workpiece
};

/// What lies between two stations: part of a block.
struct Segment {
    double way_mm = 0;        ///< of the tip in the workpiece; in machine space of the linear axes
    double rotary_rad = 0;    ///< Euclidean, of the rotary axes
    double share = 1;         ///< of the block
    std::uint32_t block = 0;  ///< index in Run::blocks
};

/// A run as the axes see it: segments that are straight in their space. stations.size() = segments.size() + 1.
struct RunGeometry {
    std::vector<Station> stations;
    std::vector<Segment> segments;
    bool refined = false;  ///< some block is more than one segment: a smaller tolerance may tell more
};

/// Resamples every block of a run in the workpiece and takes it through the machine, so finely that the segments stay
/// within `chord_mm` of the axes' way (a degree counts as a millimetre). Where the rotary axes change to another branch
/// from one end of a block to the other they go linearly. Cost about 1 µs a segment.
void trace(const path::Run& run, const machine::Machine& machine, double chord_mm, RunGeometry& out);

}  // namespace trunnion::controller
