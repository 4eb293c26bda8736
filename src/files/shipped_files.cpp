#include "detail/shipped_files.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "detail/toml_reading.hpp"

namespace trunnion::files::detail {

namespace {

std::string title_of(const std::filesystem::path& file) {
    const auto text = read_text(file);
    if (!text) return {};
    const auto root = parse_toml(*text, file.string());
    return root ? (*root)["name"].value_or(std::string()) : std::string();
}

std::vector<std::filesystem::path> toml_files(const std::filesystem::path& folder) {
    std::vector<std::filesystem::path> out;
    std::error_code error;
    for (std::filesystem::directory_iterator at(folder, error), end; !error && at != end; at.increment(error))
        if (at->path().extension() == ".toml") out.push_back(at->path());
    return out;
}

}  // namespace

std::vector<ShippedFile> shipped_files(std::span<const std::filesystem::path> folders) {
    std::vector<ShippedFile> out;
    for (const auto& folder : folders)
        for (const auto& file : toml_files(folder))
            if (std::ranges::find(out, file.stem().string(), &ShippedFile::name) == out.end())
                out.push_back({file.stem().string(), title_of(file), file});
    std::ranges::sort(out, {}, &ShippedFile::name);
    return out;
}

std::filesystem::path file_named(std::string_view name_or_file, std::span<const std::filesystem::path> folders) {
    if (name_or_file.find('/') != std::string_view::npos || name_or_file.ends_with(".toml")) return name_or_file;
    std::error_code error;
    for (const auto& folder : folders) {
        const auto file = folder / fmt::format("{}.toml", name_or_file);
        if (!name_or_file.empty() && std::filesystem::is_regular_file(file, error)) return file;
    }
    return std::filesystem::is_regular_file(name_or_file, error) ? std::filesystem::path(name_or_file)
                                                                 : std::filesystem::path();
}

std::string list_of(const std::vector<ShippedFile>& files) {
    if (files.empty()) return "none is shipped here; name a file";
    std::string out = "shipped:";
    for (const auto& file : files) out += fmt::format(" {}{}", file.name, &file == &files.back() ? "" : ",");
    return out;
}

}  // namespace trunnion::files::detail
