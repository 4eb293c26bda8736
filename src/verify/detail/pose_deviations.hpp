#pragma once

#include <cstddef>
#include <vector>

#include "detail/programmed_line.hpp"

namespace trunnion::verify {

/// Distances between two poses.
struct Distance {
    double tip_mm = 0;     ///< of the controlled point
    double height_mm = 0;  ///< of the point at the flank height
    double angle_rad = 0;
};

Distance distance_between(const Joint6& a, const Joint6& b, const ToolHeights& tool, double flank_mm);

/// How far the motion passes from programmed poses: the nearest point of its chords around the place in order.
class PosePasses {
  public:
    /// `places`: of every row on the line. Rows that stand still are kept once.
    PosePasses(const ProgrammedLine& line, const std::vector<Gauge>& rows, const std::vector<Place>& places,
               double window_mm);

    struct Pass {
        Distance distance;
        std::size_t row = 0;  ///< where the chord begins
    };
    Pass at(std::size_t pose, const ProgrammedPose& programmed) const;

  private:
    struct Stop {
        std::size_t row = 0;
        double way_mm = 0;  // farthest so far
    };
    const ProgrammedLine& line_;
    const std::vector<Gauge>& rows_;
    std::vector<Stop> stops_;
    double window_mm_;
};

}  // namespace trunnion::verify
