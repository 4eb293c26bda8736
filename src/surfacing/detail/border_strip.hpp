#pragma once

#include <span>
#include <vector>

#include "trunnion/base/result.hpp"

#include "detail/way.hpp"

namespace trunnion::surfacing::detail {

/// More passes beside the borders where a tool leans along and across its feed: its edge cuts the ridge between two
/// passes ahead of one contact and behind the other, in the direction conjugate to the feed, so that where passes end
/// at a border a strip stays beside it that none of them cuts and that is wider than what the pass along the border
/// does. Nothing for balls, and where one of both leans is 0.
///
/// `borders`: ways along the face's borders; `passes`: those of the plan so far, to which the new ones are added with
/// the index −1. Errors: SURF0206, those of append_passes().
Result<void> append_strip_passes(const Job& job, int face, std::span<const Way> borders, std::vector<Pass>& passes);

}  // namespace trunnion::surfacing::detail
