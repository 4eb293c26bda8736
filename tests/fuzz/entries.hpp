#pragma once

#include <span>
#include <string_view>

#include "trunnion/base/diagnostic.hpp"

namespace trunnion::fuzz {

/// A reader that must take any bytes: it answers with something sound or with a diagnostic. `take` stops the program
/// (expect) where the answer is neither.
struct Entry {
    std::string_view name;
    void (*take)(std::string_view bytes);
};

/// All readers, in the order of the list in entries.cpp.
std::span<const Entry> entries();

/// The entry of a name, or null.
const Entry* entry_named(std::string_view name);

/// Says what is not as promised and aborts, so that the fuzzer keeps the bytes.
void expect(bool holds, std::string_view promise);

/// A refusal has a code of letters and four digits, says something, and points into the text that was read.
void expect_sound(const Diagnostic& diagnostic, std::string_view bytes);

void take_program(std::string_view dialect, std::string_view bytes);
void take_machine_file(std::string_view bytes);
void take_linuxcnc_machine(std::string_view bytes);
void take_setup_file(std::string_view bytes);
void take_controller_file(std::string_view bytes);
void take_surface_file(std::string_view bytes);
void take_setpoints(std::string_view bytes);

}  // namespace trunnion::fuzz
