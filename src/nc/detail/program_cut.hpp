#pragma once

#include <cstddef>

#include "trunnion/program/program.hpp"

namespace trunnion::nc {

/// Cuts a program in two: `part` becomes what ends with moves[last], `program` what goes on from there, with this pose
/// as its moves[0]. Events and words of path control between the two belong to `part` and to `program`; the path
/// control in force is said again at the start of `program`. A curve whose spans lie on both sides goes into both.
/// At least one move stands behind moves[last]. Cost: that of what goes on, which is little when `last` is near the
/// end.
void cut_behind(std::size_t last, program::Program& program, program::Program& part);

}  // namespace trunnion::nc
