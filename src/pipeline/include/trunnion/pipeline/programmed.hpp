#pragma once

#include <vector>

#include "trunnion/base/result.hpp"
#include "trunnion/machine/machine.hpp"
#include "trunnion/program/program_parts.hpp"
#include "trunnion/smoothing/smoothing.hpp"
#include "trunnion/verify/programmed_path.hpp"

namespace trunnion::pipeline {

/// What a program asks for, all of it.
struct Programmed {
    std::vector<verify::ProgrammedPose> poses;
    std::vector<Diagnostic> diagnostics;  ///< what reading noticed
};

/// The poses of a program that comes part by part, with branch and winding chosen as plan() chooses them for the same
/// parts and tolerances. Errors: those of the reader, of path::choose_rotary_stands and verify::programmed_poses; its
/// VER0109 counts over all parts.
Result<Programmed> programmed_poses(program::ProgramParts& parts, const machine::Machine& machine,
                                    const machine::Setup& setup, const smoothing::SmoothingOptions& tolerances);

}  // namespace trunnion::pipeline
