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
    /// The highest ridge that Lin and Koren's rule would have left, where it is above the planned one: ways are closer
    /// there. 0: the rule holds everywhere.
    double rule_ridge_mm = 0;
    Eigen::Vector3d rule_ridge_at_mm{0, 0, 0};
    std::vector<LeftPlace> too_high;  ///< with leave_out: places of ridges that nothing lowers
    std::size_t work = 0;             ///< places at which ridges were measured
    double covered_mm2 = 0;           ///< between ways, over the face's box
};

/// Ways over the whole face by the strategy of the options, which is not parallel planes. Errors: SURF0203, SURF0205,
/// SURF0206, SURF0208, SURF0209.
Result<Sweep> sweep(const Job& job);

/// The direction of the feed in a face's middle.
Eigen::Vector3d feed_in_middle(const SurfaceOptions& options, const geometry::SurfaceShape& middle);

}  // namespace trunnion::surfacing::detail
