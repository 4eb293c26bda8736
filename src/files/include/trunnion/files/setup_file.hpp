#pragma once

#include <filesystem>
#include <string_view>

#include "trunnion/base/result.hpp"
#include "trunnion/machine/machine.hpp"

namespace trunnion::files {

/// Reads a setup (TOML): how the part and the tool sit in the machine. Everything is optional.
///
///     [workpiece]  origin = ["0 mm", "0 mm", "50 mm"], rotation = { axis = [0, 0, 1], angle = "90 deg" }
///     [tool]       kind = "flat" | "ball" | "torus" | "taper" (flat), diameter, corner_radius, length ("0 mm"),
///                  controlled_point = "tip" | "centre" ("tip"; the centre is that of a ball or torus)
///     [tools.8]    as [tool], by the number or name that T (and H) words say; further cutting edges [tools."8 D2"]
///     [offsets.G54]  origin, rotation: a work offset relative to [workpiece]
///     [start], [home]  X = "0 mm", C = "90 deg" …: X Y Z are lengths, A B C angles, other letters either
///
/// A ball has corner_radius = diameter / 2 (need not be written); a torus needs it, above 0 and at most diameter / 2.
///
/// Errors: as read_machine_file, and FILE0114 tool whose dimensions contradict each other, FILE0115 a tool name that no
/// program can call.
Result<machine::Setup> read_setup_file(const std::filesystem::path& path);

/// The same from text; `file_name` is what diagnostics and Setup::file say.
Result<machine::Setup> read_setup(std::string_view toml_text, std::string_view file_name);

}  // namespace trunnion::files
