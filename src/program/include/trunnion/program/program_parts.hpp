#pragma once

#include "trunnion/base/result.hpp"
#include "trunnion/program/program.hpp"

namespace trunnion::program {

/// A program that comes part by part, so that one of any length fits into memory.
///
/// A part is a Program: its moves[0] is the last pose of the part before (of the first part: where motion starts), of
/// which every coordinate and rotary letter is known; indices count within the part. Names (rotary_letters,
/// following_letters, tools, offsets) only ever grow from part to part, so that indices into them stay valid. Between
/// two parts motion stands still. Diagnostics come with the last part.
class ProgramParts {
  public:
    virtual ~ProgramParts() = default;
    /// The next part into `part`, whose storage is used again; false behind the last one. Errors: those of the reader.
    virtual Result<bool> next(Program& part) = 0;
    /// How much of the program is read, 0 … 1; 0 where that is not known.
    virtual double share() const { return 0; }
};

}  // namespace trunnion::program
