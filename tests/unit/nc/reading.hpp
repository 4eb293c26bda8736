#pragma once

#include <string>
#include <string_view>

#include "trunnion/machine/machine.hpp"
#include "trunnion/nc/read.hpp"

namespace trunnion::nc {

/// A machine with X, Y, Z and the rotary letters given; nothing but letters and words matters to readers.
inline machine::Machine machine_with(std::string_view rotary) {
    machine::Machine machine;
    const std::string letters = std::string("XYZ").append(rotary);
    for (const char letter : letters) {
        machine::Axis& axis = machine.axes[static_cast<std::size_t>(machine.axis_count++)];
        axis.letter = letter;
        axis.rotary = machine.axis_count > 3;
    }
    machine.rotary_count = static_cast<int>(rotary.size());
    machine.words = {.tcp_on = {"M428"}, .tcp_off = {"M429"}, .ignore = {"M64"}, .following = {"E"}};
    return machine;
}

inline Result<program::Program> read_with(const machine::Machine& machine, std::string_view text,
                                          ReadOptions options = {}) {
    options.machine = &machine;
    return read_program(text, "test", options);
}

inline Result<program::Program> read_ac(std::string_view text, const ReadOptions& options = {}) {
    static const machine::Machine machine = machine_with("AC");
    return read_with(machine, text, options);
}

/// For a test's message.
inline std::string said(const Result<program::Program>& result) {
    return result ? "read " + std::to_string(result->moves.size()) + " moves" : to_string(result.error());
}

inline const Diagnostic* told(const program::Program& program, std::string_view code, std::string_view value = {}) {
    for (const Diagnostic& diagnostic : program.diagnostics)
        if (diagnostic.code == code && (value.empty() || diagnostic.value == value)) return &diagnostic;
    return nullptr;
}

}  // namespace trunnion::nc
