#pragma once

#include <memory>
#include <string_view>

#include "trunnion/nc/read.hpp"

#include "detail/block_reader.hpp"

namespace trunnion::nc {

/// One reader per dialect. The text has no byte-order mark; it and the options outlive the reader.
using OpenReader = Result<std::unique_ptr<BlockReader>>(const ProgramText& text, std::string_view file_name,
                                                        const ReadOptions& options);
OpenReader open_apt, open_rs274, open_sinumerik, open_heidenhain, open_fanuc;

/// recognise() for a text of which lines are taken as they come.
Result<Dialect> recognise_lines(const ProgramText& text);

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
