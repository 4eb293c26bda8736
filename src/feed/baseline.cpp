// The inner loops for any processor.
#define TRUNNION_VARIANT baseline

#include "detail/bound_loads.hpp"
#include "detail/solver.hpp"

namespace trunnion::feed::baseline {

std::unique_ptr<InteriorPoint> make_interior_point() {
    return std::make_unique<Solver>();
}

}  // namespace trunnion::feed::baseline
