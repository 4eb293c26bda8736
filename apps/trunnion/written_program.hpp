#pragma once

#include <string>

#include <CLI/CLI.hpp>

#include "trunnion/base/result.hpp"
#include "trunnion/nc/write.hpp"

namespace trunnion::app {

/// What the command line says about a program that is written, as text.
struct WrittenProgram {
    std::string file, dialect, units = "mm";
    std::string precision = "0.05um", angle_precision = "0.0000005deg";
    std::string curves = "dialect";  ///< their form
    bool block_numbers = false, inverse_time = false;

    void add_to(CLI::App& command, bool dialect_needed);
    /// Without the head. An empty dialect is rs274.
    Result<nc::WriteOptions> options() const;
    /// For the head of the program.
    std::string precision_text() const;
};

}  // namespace trunnion::app
