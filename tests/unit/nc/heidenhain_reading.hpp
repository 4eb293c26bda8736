#pragma once

#include <string>
#include <string_view>

#include "sinumerik_reading.hpp"

namespace trunnion::nc {

/// Klartext on a machine with X, Y, Z, B and C.
inline Result<program::Program> read_klartext(std::string_view text, ReadOptions options = {}) {
    static const machine::Machine machine = machine_with("BC");
    options.dialect = Dialect::heidenhain;
    return read_with(machine, text, options);
}

/// Of blocks behind a start at X0 Y0 Z0 with F600, TCP off; millimetres.
inline Result<program::Program> after_start(std::string_view blocks) {
    return read_klartext(
        std::string("BEGIN PGM T MM\nL X+0 Y+0 Z+0 FMAX\nL F600\n").append(blocks).append("\nEND PGM T MM\n"));
}

/// The same under M128 with B and C at 0.
inline Result<program::Program> under_m128(std::string_view blocks) {
    return read_klartext(std::string("BEGIN PGM T MM\nL M128\nL X+0 Y+0 Z+0 B+0 C+0 FMAX\nL F600\n")
                             .append(blocks)
                             .append("\nEND PGM T MM\n"));
}

inline std::string klartext(std::string_view blocks) {
    return moves_of(after_start(blocks));
}
inline std::string klartext_m128(std::string_view blocks) {
    return moves_of(under_m128(blocks));
}

/// The code with which blocks are refused; `read` where they are not.
inline std::string code_of(const Result<program::Program>& program) {
    return program ? "read" : program.error().code;
}

}  // namespace trunnion::nc
