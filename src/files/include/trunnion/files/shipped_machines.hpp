#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "trunnion/base/result.hpp"
#include "trunnion/machine/machine.hpp"

namespace trunnion::files {

struct ShippedMachine {
    std::string name;   ///< what `-m` takes: the file's stem
    std::string title;  ///< the name in the file
    std::filesystem::path file;
};

/// The machine files (*.toml) of the data folders, by name; a folder named earlier wins where two have the same name.
/// Folders that do not exist are passed over, files that cannot be read have an empty title.
std::vector<ShippedMachine> shipped_machines(std::span<const std::filesystem::path> data_folders);

/// A machine by the name of a shipped one (`ucp710`) or by file (anything with a `/`, ending in `.toml`, or naming a
/// file). Errors: FILE0112 no such machine, the hint lists what is shipped; and those of read_machine_file.
Result<machine::Machine> find_machine(std::string_view name_or_file,
                                      std::span<const std::filesystem::path> data_folders);

}  // namespace trunnion::files
