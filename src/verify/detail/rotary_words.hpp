#pragma once

#include <vector>

#include "trunnion/machine/machine.hpp"
#include "trunnion/verify/check.hpp"

#include "detail/programmed_line.hpp"

namespace trunnion::verify {

/// Whether the rotary axes come through the literal words of the poses, in order, into `verdict`. Words that leave the
/// pose of the tool unchanged are seen here alone. `places`: of every row; a pose is looked for among the rows whose
/// place is within `window_mm` of its own.
void check_rotary_words(const SetpointTable& setpoints, const std::vector<ProgrammedPose>& poses,
                        const ProgrammedLine& line, const std::vector<Place>& places, double window_mm,
                        const machine::Machine& machine, const CheckOptions& options, Verdict& verdict);

}  // namespace trunnion::verify
