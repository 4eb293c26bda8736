#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace trunnion::files::detail {

struct ShippedFile {
    std::string name;   ///< the file's stem
    std::string title;  ///< the name in the file
    std::filesystem::path file;
};

/// The TOML files of some folders, by name; a folder named earlier wins where two have the same name.
std::vector<ShippedFile> shipped_files(std::span<const std::filesystem::path> folders);

/// The file that a name or a path means; empty: none. Names are looked for in the folders first, then as files; what
/// holds a `/` or ends in `.toml` is a path.
std::filesystem::path file_named(std::string_view name_or_file, std::span<const std::filesystem::path> folders);

/// `shipped: a, b`, for a hint.
std::string list_of(const std::vector<ShippedFile>& files);

}  // namespace trunnion::files::detail
