#pragma once

#include <filesystem>
#include <vector>

namespace trunnion::app {

/// Folders that hold shipped controller files, best first.
std::vector<std::filesystem::path> controller_folders();

}  // namespace trunnion::app
