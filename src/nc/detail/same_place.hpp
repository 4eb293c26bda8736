#pragma once

#include "trunnion/program/program.hpp"

namespace trunnion::nc {

/// Equal, or both not known (NaN).
bool same(double a, double b);

/// Nothing moves from the one to the other: what `move` does not know (NaN) stays as it is, and positions compare only
/// where they count in the same frame.
bool same_place(const program::Move& before, const program::Move& move);

/// Whether the tip goes, and does not only turn, between two places in one frame: some coordinate changes by more than
/// 1e-7 mm, or from one that is not known. One that is not known at the end stays.
bool goes(const Eigen::Vector3d& from_mm, const Eigen::Vector3d& to_mm);

/// Adds a move to a program, unless it is straight and nothing moves.
void append(program::Program& program, const program::Move& move);

}  // namespace trunnion::nc
