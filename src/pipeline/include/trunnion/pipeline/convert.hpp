#pragma once

#include <filesystem>

#include "trunnion/base/result.hpp"
#include "trunnion/machine/machine.hpp"
#include "trunnion/nc/write.hpp"
#include "trunnion/program/program.hpp"

namespace trunnion::pipeline {

/// A program with every move with TCP on under one orientation law, `law`: the same tool path within `precision_rad` of
/// the tool axis at every place, tip and speed unchanged. Vectors become the rotary words that path building chooses
/// (path::choose_rotary_stands), rotary words become vectors by forward kinematics. A cutting move along which the two
/// laws differ by more is divided into parts that share its feed, or its time. Words that the program leaves open
/// become those where the axes stand. Moves with TCP off have rotary words under both laws.
///
/// Told in the program's diagnostics: PIPE0013 rapids that turn otherwise between their ends; PIPE0015 rotary words
/// that leave the tool's direction as it is, which vectors cannot say. Errors: those of choose_rotary_stands; PIPE0012
/// a move that would fall into more than 16 384 parts; PIPE0014 a curve that turns the tool.
Result<program::Program> translate(const program::Program& program, const machine::Machine& machine,
                                   const machine::Setup& setup, program::OrientationLaw law, double precision_rad);

/// Writes a program as a file that appears complete or not at all; a name that ends in `.gz` is compressed.
/// Errors: those of nc::write_program and files::OutputFile; PIPE0011 the file is the program's own source.
Result<nc::WriteSummary> write_program_file(const std::filesystem::path& file, const program::Program& program,
                                            const machine::Machine* machine, const nc::WriteOptions& options);

}  // namespace trunnion::pipeline
