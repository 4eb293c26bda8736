#pragma once

#include <filesystem>
#include <string>

#include "trunnion/base/result.hpp"
#include "trunnion/machine/machine.hpp"
#include "trunnion/program/program.hpp"
#include "trunnion/smoothing/smoothing.hpp"
#include "trunnion/verify/check.hpp"

namespace trunnion::pipeline {

/// Checks a setpoint file (.csv, .csv.gz) against the program it was made from, with the tolerances that smoothing was
/// given. Errors: those of files and verify.
Result<verify::Verdict> check_setpoints(const std::filesystem::path& setpoints, const program::Program& program,
                                        const machine::Machine& machine, const machine::Setup& setup,
                                        const smoothing::SmoothingOptions& tolerances);

/// A few lines for a person; the JSON of interfaces.md.
std::string report(const verify::Verdict& verdict);
std::string to_json(const verify::Verdict& verdict);

}  // namespace trunnion::pipeline
