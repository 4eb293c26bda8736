#pragma once

#include <functional>
#include <span>
#include <vector>

#include "trunnion/base/result.hpp"

#include "detail/way.hpp"

namespace trunnion::surfacing::detail {

/// Appends the parts of a way that lie within the region as passes, in the order of motion, as poses between which
/// straight moves keep the chord tolerance; one of them is where the way crosses a joint. Errors: SURF0203, SURF0204.
Result<void> append_passes(const Job& job, const Way& way, int index, std::vector<Pass>& out);

/// Appends passes along the borders of the job's one face, one for each part between corners that is wanted; none along
/// `joints`. Errors as above.
Result<void> append_border_passes(const Job& job, std::span<const Stretch* const> joints,
                                  const std::function<bool(const Way&)>& wanted, std::vector<Pass>& out);

}  // namespace trunnion::surfacing::detail
