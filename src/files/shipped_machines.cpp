#include "trunnion/files/shipped_machines.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "trunnion/files/machine_file.hpp"

#include "detail/toml_reading.hpp"

namespace trunnion::files {

namespace {

std::string title_of(const std::filesystem::path& file) {
    const auto text = detail::read_text(file);
    if (!text) return {};
    const auto root = detail::parse_toml(*text, file.string());
    return root ? (*root)["name"].value_or(std::string()) : std::string();
}

std::vector<std::filesystem::path> machine_files(const std::filesystem::path& folder) {
    std::vector<std::filesystem::path> out;
    std::error_code error;
    for (std::filesystem::directory_iterator at(folder, error), end; !error && at != end; at.increment(error))
        if (at->path().extension() == ".toml") out.push_back(at->path());
    return out;
}

bool names_a_file(std::string_view text) {
    return text.find('/') != std::string_view::npos || text.ends_with(".toml");
}

std::string list_of(const std::vector<ShippedMachine>& machines) {
    std::string out = machines.empty() ? "no machine is shipped here; name a file" : "shipped:";
    for (const auto& machine : machines)
        out += fmt::format(" {}{}", machine.name, &machine == &machines.back() ? "" : ",");
    return out;
}

}  // namespace

std::vector<ShippedMachine> shipped_machines(std::span<const std::filesystem::path> data_folders) {
    std::vector<ShippedMachine> out;
    for (const auto& folder : data_folders)
        for (const auto& file : machine_files(folder))
            if (std::ranges::find(out, file.stem().string(), &ShippedMachine::name) == out.end())
                out.push_back({file.stem().string(), title_of(file), file});
    std::ranges::sort(out, {}, &ShippedMachine::name);
    return out;
}

Result<machine::Machine> find_machine(std::string_view name_or_file,
                                      std::span<const std::filesystem::path> data_folders) {
    if (names_a_file(name_or_file)) return read_machine_file(name_or_file);
    for (const auto& folder : data_folders) {
        const auto file = folder / fmt::format("{}.toml", name_or_file);
        std::error_code error;
        if (!name_or_file.empty() && std::filesystem::is_regular_file(file, error)) return read_machine_file(file);
    }
    std::error_code error;
    if (std::filesystem::is_regular_file(name_or_file, error)) return read_machine_file(name_or_file);
    Diagnostic unknown{.code = "FILE0112", .text = fmt::format("there is no machine '{}'", name_or_file)};
    unknown.hint = list_of(shipped_machines(data_folders));
    return fail(std::move(unknown));
}

}  // namespace trunnion::files
