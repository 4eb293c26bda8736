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

/// What a motion may be off at one place; HUGE_VAL where something is not judged.
struct Allowed {
    double tip_mm = 0, height_mm = 0, angle_rad = 0;
    /// The largest share of a tolerance that is used: at most 1 keeps all of them.
    double used_by(const Distance& distance) const;
};

Distance distance_between(const Joint6& a, const Joint6& b, const ToolHeights& tool, double flank_mm);

/// How far the motion passes from programmed poses: the nearest point of its chords around the place in order. Where
/// that breaks a tolerance, the point that uses least of them, if it keeps all: the tool may come nearer to the pose on
/// another branch with the axis alone, or with the tip alone.
class PosePasses {
  public:
    /// `places`: of every row on the line. Rows that stand still are kept once.
    PosePasses(const ProgrammedLine& line, const std::vector<Gauge>& rows, const std::vector<Place>& places,
               double window_mm, const Allowed& allowed);

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
    Allowed allowed_;
};

}  // namespace trunnion::verify
