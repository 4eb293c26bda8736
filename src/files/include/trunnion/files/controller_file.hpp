#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "trunnion/base/result.hpp"
#include "trunnion/motion/controller.hpp"

namespace trunnion::files {

/// Reads the description of a control (TOML).
///
///     name = "…"                      default: the file's stem
///     description = "…"               optional
///     kind = "blocks" | "linuxcnc" | "ideal" | "length-over-feed"
///     [parameters]                    of kinds blocks and linuxcnc, and there only
///     transition = { value = "arc", source = "documented" }
///     interpolator_cycle = { value = "3 ms", source = "documented", spread = "1 ms" }
///     look_ahead_blocks = { value = 10, source = "guessed" }
///     [axes.X]                        of kind linuxcnc: what its INI says, in place of the machine file
///     max_velocity = { value = "500 mm/s", source = "identified" }
///     max_acceleration = { value = "2.5 m/s^2", source = "identified" }
///
/// Every parameter says its value and where that comes from: "identified", "documented" or "guessed". `spread`: the
/// truth lies within value ± spread; default 0, 10 % and 30 % of the value. Choices take one of their words and have no
/// spread; where it makes sense a value may be "unlimited". Keys, meanings and words: motion::facts_of(),
/// `trunnion controller show`; those of kind linuxcnc are called as in LinuxCNC's INI file. All are needed but those
/// that the choices made do not use (motion::is_used); these are refused. Frequencies are in Hz. Of axes nothing is
/// needed.
///
/// Errors: FILE0101 file cannot be read, FILE0102 not TOML, FILE0103 key missing, FILE0104 unknown key, FILE0105 value
/// of another kind, FILE0113 not one of the possible words, FILE0116 values that contradict each other, FILE0117 value
/// out of what the parameter may be. Quantities keep their codes BASE0001…BASE0004.
Result<motion::Controller> read_controller_file(const std::filesystem::path& path);

/// The same from text; `file_name` is what diagnostics and Controller::file say.
Result<motion::Controller> read_controller(std::string_view toml_text, std::string_view file_name);

struct ShippedController {
    std::string name;   ///< what `-c` takes: the file's stem
    std::string title;  ///< the name in the file
    std::filesystem::path file;
};

/// The controller files (*.toml) of the data folders, as shipped_machines().
std::vector<ShippedController> shipped_controllers(std::span<const std::filesystem::path> data_folders);

/// A controller by the name of a shipped one or by file, as find_machine(). Errors: FILE0118 no such controller; and
/// those of read_controller_file.
Result<motion::Controller> find_controller(std::string_view name_or_file,
                                           std::span<const std::filesystem::path> data_folders);

}  // namespace trunnion::files
