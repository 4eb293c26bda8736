#pragma once

#include <span>
#include <vector>

#include "detail/way.hpp"

namespace trunnion::surfacing::detail {

/// Joins passes of several faces, one of which begins where another one ends, as near as files are exact and with no
/// corner between their normals; and puts them in the order of motion.
void join_passes(std::vector<Pass>& passes);

/// Puts a pass behind another one; where that ends as the other begins, the place is there once.
void append(Pass& to, Pass&& from);

/// Whether a way along a border of a face is on one of the other faces too, smoothly: `face` itself does not count.
bool is_shared(const Way& way, std::span<const Face> others, const Face& face);

}  // namespace trunnion::surfacing::detail
