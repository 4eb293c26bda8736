#pragma once

#include <vector>

#include "trunnion/machine/machine.hpp"
#include "trunnion/verify/check.hpp"

namespace trunnion::verify {

/// Ratios and range excess of every axis into `verdict`, with the breaches. `at_rapid[i]`: row i is on a rapid; a
/// difference may use the rapid limits where any of its rows is.
void check_axes(const SetpointTable& setpoints, const std::vector<bool>& at_rapid, const machine::Machine& machine,
                double limit_excess, Verdict& verdict);

}  // namespace trunnion::verify
