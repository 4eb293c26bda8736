#pragma once

#include <string_view>

#include "trunnion/nc/read.hpp"

namespace trunnion::nc {

/// One reader per dialect. The text has no byte-order mark, no NUL and is shorter than 2 GB.
Result<program::Program> read_apt(std::string_view text, std::string_view file_name, const ReadOptions& options);
Result<program::Program> read_sinumerik(std::string_view text, std::string_view file_name, const ReadOptions& options);
Result<program::Program> read_rs274(std::string_view text, std::string_view file_name, const ReadOptions& options);
Result<program::Program> read_heidenhain(std::string_view text, std::string_view file_name, const ReadOptions& options);
Result<program::Program> read_fanuc(std::string_view text, std::string_view file_name, const ReadOptions& options);

/// Whether APT data knows this major word (capitals), be it to use, ignore or refuse it.
bool is_apt_word(std::string_view major) noexcept;

/// Whether a line, without blanks around it, could only stand in a HEIDENHAIN program.
bool is_heidenhain_line(std::string_view line) noexcept;

/// Whether a line of G-code, without blanks around it, could only stand in a program for FANUC and its like.
bool is_fanuc_line(std::string_view line) noexcept;

/// Position of a name in a list of names, appended if new; empty when the list cannot be longer.
std::optional<std::uint16_t> index_in(std::vector<std::string>& names, std::string_view name);

/// Says how lengths were taken where the program leaves or contradicts it: NC0011, NC0018.
struct UnitStatement {
    bool mm = false, inch = false;  ///< what the program states anywhere
};
void report_units(const UnitStatement& stated, Units wanted, class Findings& findings);

}  // namespace trunnion::nc
