#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "trunnion/base/result.hpp"
#include "trunnion/machine/machine.hpp"
#include "trunnion/smoothing/smoothing.hpp"
#include "trunnion/verify/check.hpp"
#include "trunnion/verify/programmed_path.hpp"

namespace trunnion::pipeline {

/// Checks a setpoint file (.csv, .csv.gz) against what the program asks for that it was made from (programmed_poses()),
/// with the tolerances that smoothing was given. Errors: those of files and verify.
Result<verify::Verdict> check_setpoints(const std::filesystem::path& setpoints,
                                        const std::vector<verify::ProgrammedPose>& programmed,
                                        const machine::Machine& machine, const machine::Setup& setup,
                                        const smoothing::SmoothingOptions& tolerances);

/// A few lines for a person; the JSON of interfaces.md.
std::string report(const verify::Verdict& verdict);
std::string to_json(const verify::Verdict& verdict);

}  // namespace trunnion::pipeline
