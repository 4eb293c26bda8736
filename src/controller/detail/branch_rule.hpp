#pragma once

#include <vector>

#include "trunnion/base/result.hpp"
#include "trunnion/machine/machine.hpp"
#include "trunnion/motion/controller.hpp"
#include "trunnion/program/program.hpp"

namespace trunnion::controller {

/// Where a control with this rule lets the rotary axes stand at the end of every move. Errors: those of
/// path::choose_rotary_stands.
Result<std::vector<program::RotaryStand>> stands_by_rule(const program::Program& program,
                                                         const machine::Machine& machine, const machine::Setup& setup,
                                                         motion::BranchRule rule);

}  // namespace trunnion::controller
