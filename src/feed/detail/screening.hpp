#pragma once

#include "trunnion/feed/interval.hpp"

/// Which inequalities can be active at a place at all.
namespace trunnion::feed {

/// Bits of the coordinates whose row must stand.
struct NeededRows {
    unsigned jerk = 0, acceleration = 0;
};

/// Largest x and |x′| that velocities and accelerations allow at a place.
struct Extent {
    double x = 0, d = 0;
};
Extent largest_motion(const PathSample& sample, const LimitSet& limits);

/// A row is left out where it follows from another one: with r = q′ₐ/q′_b the loads of coordinate a are r times those
/// of b plus what differs in q″ and q‴, bounded with the largest x and x′ that velocities and accelerations allow.
NeededRows needed_rows(const PathSample& sample, const LimitSet& limits);

}  // namespace trunnion::feed
