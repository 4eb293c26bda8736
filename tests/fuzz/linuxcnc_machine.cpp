#include "trunnion/files/linuxcnc_machine.hpp"

#include <algorithm>

#include "trunnion/files/machine_file.hpp"

#include "entries.hpp"

namespace trunnion::fuzz {

namespace {

/// What was taken goes out again: as a machine file and, where its kinematics allow, as LinuxCNC's files.
void expect_written(const machine::Machine& machine) {
    const auto again = files::read_machine(files::machine_text(machine), "again");
    expect(again.has_value(), "what is read from LinuxCNC is a machine file");
    const auto made = files::linuxcnc_configuration(machine, "fuzz");
    expect(made.has_value(), "what is read from LinuxCNC can go back");
    const auto back = files::read_linuxcnc_machine(made->ini, "back", {},
                                                   [&](const std::string&) { return Result<std::string>(made->hal); });
    expect(back.has_value(), "its own files are read");
}

}  // namespace

/// Behind a zero byte the HAL file begins.
void take_linuxcnc_machine(std::string_view bytes) {
    const auto zero = std::min(bytes.find('\0'), bytes.size());
    const std::string hal(bytes.substr(std::min(zero + 1, bytes.size())));
    const auto read = files::read_linuxcnc_machine(bytes.substr(0, zero), "fuzz", {},
                                                   [&](const std::string&) { return Result<std::string>(hal); });
    if (!read) return expect_sound(read.error(), bytes.substr(0, zero));
    expect_written(read->machine);
}

}  // namespace trunnion::fuzz
