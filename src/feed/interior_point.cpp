#include "detail/interior_point.hpp"

namespace trunnion::feed {

void Trajectory::resize(std::size_t intervals) {
    x.assign(intervals + 1 + idle_lanes, 1);  // idle lanes stand at 1
    d.assign(intervals + 1 + idle_lanes, 0);
    e0.assign(intervals + idle_lanes, 0);
    e1.assign(intervals + idle_lanes, 0);
}

std::unique_ptr<InteriorPoint> InteriorPoint::make() {
#ifdef TRUNNION_WITH_AVX2
    if (__builtin_cpu_supports("avx2")) return avx2::make_interior_point();
#endif
    return baseline::make_interior_point();
}

}  // namespace trunnion::feed
