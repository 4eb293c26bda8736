#pragma once

#include "trunnion/program/program.hpp"

namespace trunnion::nc {

/// Equal, or both not known (NaN).
bool same(double a, double b);

/// Nothing moves from the one to the other: what `move` does not know (NaN) stays as it is, and positions compare only
/// where they count in the same frame.
bool same_place(const program::Move& before, const program::Move& move);

}  // namespace trunnion::nc
