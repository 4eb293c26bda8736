#include "trunnion/files/shipped_machines.hpp"

#include <fmt/format.h>

#include "trunnion/files/machine_file.hpp"

#include "detail/shipped_files.hpp"

namespace trunnion::files {

std::vector<ShippedMachine> shipped_machines(std::span<const std::filesystem::path> data_folders) {
    std::vector<ShippedMachine> out;
    for (auto& found : detail::shipped_files(data_folders))
        out.push_back({std::move(found.name), std::move(found.title), std::move(found.file)});
    return out;
}

Result<machine::Machine> find_machine(std::string_view name_or_file,
                                      std::span<const std::filesystem::path> data_folders) {
    const auto file = detail::file_named(name_or_file, data_folders);
    if (!file.empty()) return read_machine_file(file);
    Diagnostic unknown{.code = "FILE0112", .text = fmt::format("there is no machine '{}'", name_or_file)};
    unknown.hint = detail::list_of(detail::shipped_files(data_folders));
    return fail(std::move(unknown));
}

}  // namespace trunnion::files
