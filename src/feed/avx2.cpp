// The inner loops for processors with AVX2: same operations, same bits.
#ifdef TRUNNION_WITH_AVX2
#define TRUNNION_VARIANT avx2

// What is not ours is compiled for any processor: the linker may keep this copy of it for everyone.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "trunnion/feed/feed_planner.hpp"

#include "detail/interior_point.hpp"
#include "detail/screening.hpp"

#pragma GCC push_options
#pragma GCC target("avx2")
#include "detail/bound_loads.hpp"
#include "detail/solver.hpp"
#pragma GCC pop_options

namespace trunnion::feed::avx2 {

std::unique_ptr<InteriorPoint> make_interior_point() {
    return std::make_unique<Solver>();
}

}  // namespace trunnion::feed::avx2
#endif
