#pragma once

#include "detail/way.hpp"

namespace trunnion::surfacing::detail {

/// A way with the direction in which the tool goes along it.
struct Track {
    const Way& way;
    bool backwards;
};

/// Height of the ridge that the tool leaves between two ways beside each other, near the place `s` of the first one:
/// where the tool on either way is equally far above the surface. At most `limit_mm`. Cost about 50 µs.
double ridge_between_mm(const Job& job, const Track& first, double s, const Track& second, double limit_mm);

}  // namespace trunnion::surfacing::detail
