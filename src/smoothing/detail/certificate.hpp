#pragma once

#include <vector>

#include "detail/section.hpp"

namespace trunnion::smoothing {

/// What is proved of one section's shipped pieces.
struct Certificate {
    path::DeviationBound bound;
    std::vector<Excess> excess;          ///< where a tolerance is not held
    std::vector<double> use_at_vertex;   ///< vertices first … last
    std::vector<std::size_t> irregular;  ///< vertices near which |c′| may fall below 0.05
};

/// Bounds c − P on every piece ∩ block by the Bernstein hull of the difference, halved where the hull's slack matters.
/// Law vector: P is the slerp; the chord's distance from it is added.
Certificate certify(const path::Run& run, const Curve& curve, const Section& section);

}  // namespace trunnion::smoothing
