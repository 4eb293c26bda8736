#pragma once

#include <vector>

#include "trunnion/base/result.hpp"

#include "detail/way.hpp"

namespace trunnion::surfacing::detail {

/// A way of the sweep over a face; neighbouring indices run beside each other.
struct SweepWay {
    Way way;
    int index;
};

struct Sweep {
    std::vector<SweepWay> ways;  ///< by index
    double least_interval_mm = 0, largest_interval_mm = 0, highest_ridge_mm = 0;
};

/// Ways over the whole face by the strategy of the options. Errors: SURF0203, SURF0205, SURF0206.
Result<Sweep> sweep(const Job& job);

/// SURF0203 where the tool does not fit into the surface at a station.
Result<void> check_fit(const Job& job, const Station& station);

}  // namespace trunnion::surfacing::detail
