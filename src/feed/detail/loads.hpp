#pragma once

#include "trunnion/feed/interval.hpp"

#include "detail/bernstein.hpp"

/// The loads on half an interval as polynomials, some coordinates side by side.
namespace trunnion::feed {

inline constexpr int group_size = 4, coordinate_groups = coordinates / group_size;
using Group = std::array<double, group_size>;

/// x and its derivatives on half an interval.
struct Speed {
    Bernstein<double, 3> x;
    Bernstein<double, 2> d;
    Bernstein<double, 1> e;
};

/// Half an interval: its samples, length, x on it, and upper bounds of x^½ as 1 / (a lower bound of x^(−½)).
struct Half {
    const PathSample &begin, &end;
    double length;
    Speed speed;
    Bernstein<double, 6> to_room;
};

/// Not yet divided by limits: q′, q″x + ½q′x′, q‴x + 3/2 q″x′ + ½q′x″.
struct GroupPolynomials {
    Bernstein<Group, 6> velocity, jerk;
    Bernstein<Group, 7> acceleration;
};
struct GroupLoads {
    Group velocity, acceleration, jerk;
};

/// 1 / limit of all coordinates.
using InverseLimits = std::array<GroupLoads, coordinate_groups>;

/// The polynomials of a group of coordinates, and hull bounds of load / limit.
using BoundLoads = void (*)(const Half& half, int group, const GroupLoads& inverse_limits, GroupPolynomials& loads,
                            GroupLoads& bounds);
/// For the processor at hand.
BoundLoads bound_loads_here();

namespace baseline {
void bound_loads(const Half&, int, const GroupLoads&, GroupPolynomials&, GroupLoads&);
}
#ifdef TRUNNION_WITH_AVX2
namespace avx2 {
void bound_loads(const Half&, int, const GroupLoads&, GroupPolynomials&, GroupLoads&);
}
#endif

}  // namespace trunnion::feed
