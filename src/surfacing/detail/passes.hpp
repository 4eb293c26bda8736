#pragma once

#include <functional>
#include <vector>

#include "trunnion/base/result.hpp"

#include "detail/way.hpp"

namespace trunnion::surfacing::detail {

/// Appends the parts of a way that lie within the face as passes, in the order of motion, as poses between which
/// straight moves keep the chord tolerance. Errors: SURF0203, SURF0204.
Result<void> append_passes(const Job& job, const Way& way, int index, std::vector<Pass>& out);

/// Appends passes along the face's borders, one for each part between corners that is wanted. Errors as above.
Result<void> append_border_passes(const Job& job, const std::function<bool(const Way&)>& wanted,
                                  std::vector<Pass>& out);

}  // namespace trunnion::surfacing::detail
