#pragma once

#include <span>
#include <vector>

#include "trunnion/base/result.hpp"

#include "detail/way.hpp"

namespace trunnion::surfacing::detail {

/// A way in which a plane cuts one of several faces.
struct SectionWay {
    std::size_t face;
    Way way;
    int index;  ///< of the plane
};

struct PlaneSections {
    std::vector<SectionWay> ways;  ///< by index, then by face
    double least_interval_mm = 0, largest_interval_mm = 0, highest_ridge_mm = 0;
    std::vector<LeftPlace> too_high;  ///< with leave_out: places of ridges that nothing lowers
};

/// All ways in which parallel planes cut the faces, one job a face: the planes have the normal and the feed in the
/// middle of the first face in them, and are as far apart as the highest ridge on any face allows. Every way leads in
/// the direction of the feed. Errors: SURF0203, SURF0205, SURF0206, SURF0208, SURF0209.
Result<PlaneSections> plane_sections(std::span<const Job> jobs);

}  // namespace trunnion::surfacing::detail
