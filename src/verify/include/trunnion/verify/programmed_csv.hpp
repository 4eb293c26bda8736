#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "trunnion/verify/programmed_path.hpp"

namespace trunnion::verify {

/// Programmed poses as text: `x_mm,y_mm,z_mm,i,j,k,kind,line` and a column `<letter>_deg` for every rotary axis
/// whose place is known at some pose (empty at the others): at poses of kind `rotary` and the pose before each of them,
/// and along moves in machine coordinates. Numbers read back to the same double; angles to one unit in
/// the last place. `write` is called with pieces of text of some 64 KiB, in order.
void write_programmed_csv(const std::vector<ProgrammedPose>& poses, const machine::Machine& machine,
                          const std::function<void(std::string_view)>& write);
std::string programmed_csv(const std::vector<ProgrammedPose>& poses, const machine::Machine& machine);

/// The reverse. `kind`, `line` and the rotary columns may be missing (then `vector`, the row's own line in the text, no
/// words, which are taken to be literal in rows of kind `rotary`); the axis is normalised. `file` is only for
/// diagnostics. Errors, with the line: VER0201 no rows, VER0202 missing column, VER0203 not a number, VER0204 ragged
/// row, VER0205 a column twice, VER0207 unknown kind, VER0108 an axis of length 0, VER0102 a column of an axis that the
/// machine has not.
Result<std::vector<ProgrammedPose>> read_programmed_csv(std::string_view text, const machine::Machine& machine,
                                                        const std::string& file = {});

}  // namespace trunnion::verify
