#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "trunnion/base/result.hpp"
#include "trunnion/machine/machine.hpp"

namespace trunnion::files {

/// Reads a machine description (TOML). Linear axes come first in Machine::axes, each kind in alphabetical order,
/// whatever the order of the file; `chain` keeps the order workpiece → tool.
///
///     name  = "…"                     default: the file's stem
///     chain = "C A X Y Z"             workpiece → tool; three linear and at most two rotary axes
///     [axes.X]                        one table for every letter of the chain and for no other
///     range = ["-355 mm", "355 mm"]   or "endless"; in the control's count, as all of the table
///     max_velocity, max_acceleration, max_jerk          > 0
///     rapid = { max_velocity, max_acceleration, max_jerk }   each optional: where rapids differ
///     type = "linear" | "rotary"      default: X Y Z U V W linear, all others rotary
///     direction = [1, 0, 0]           default: along X (X A U), Y (Y B V), Z (Z C W)
///     point = ["0 mm", …]             rotary only: a point on the axis, machine frame, all axes at 0; default the
///     origin reversed = true                 the control counts against ISO 841 [words] tcp_on, tcp_off, ignore,
///     following = ["M428", …]
///
/// Quantities are text with a unit (base/quantity.hpp). An unknown key is an error, so that a slip of the pen is not
/// silently the default. All errors name the file and the line.
///
/// Errors: FILE0101 file cannot be read, FILE0102 not TOML, FILE0103 key missing, FILE0104 unknown key, FILE0105 value
/// of another kind than wanted, FILE0106 limit not positive, FILE0107 chain and axes do not fit, FILE0108 range
/// reversed or empty, FILE0109 direction zero, FILE0110 not exactly three linear axes, FILE0111 more than two rotary
/// axes, FILE0113 not one of the words that are possible. Quantities keep their codes BASE0001…BASE0004 (a bare number
/// is BASE0002), a geometry that cannot be solved those of machine::Kinematics::make (MACH01xx).
Result<machine::Machine> read_machine_file(const std::filesystem::path& path);

/// The same from text; `file_name` is what diagnostics and Machine::file say.
Result<machine::Machine> read_machine(std::string_view toml_text, std::string_view file_name);

/// The machine as a file that read_machine() takes: it gives the same machine to the last bit of every limit, range and
/// point, but for the file's name.
std::string machine_text(const machine::Machine& machine);

}  // namespace trunnion::files
