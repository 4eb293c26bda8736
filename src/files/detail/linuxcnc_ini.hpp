#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "trunnion/base/result.hpp"

namespace trunnion::files::detail {

struct IniEntry {
    std::string section, key, value;
    int line = 0;
};

/// An INI file as LinuxCNC reads it: sections may come back, keys may stand there several times, of which the first
/// counts where one is wanted; comments have a line of their own.
class LinuxcncIni {
  public:
    /// Errors: FILE0120.
    static Result<LinuxcncIni> parse(std::string_view text, std::string_view file_name);

    /// The first entry, or null.
    const IniEntry* find(std::string_view section, std::string_view key) const;
    std::vector<const IniEntry*> all(std::string_view section, std::string_view key) const;
    const std::vector<IniEntry>& entries() const { return entries_; }

    /// Errors: FILE0121.
    Result<const IniEntry*> required(std::string_view section, std::string_view key) const;
    /// Errors: FILE0122.
    Result<double> number(const IniEntry& entry) const;

    Diagnostic at(const IniEntry& entry, std::string code, std::string text, std::string hint = {}) const;
    Diagnostic at_file(std::string code, std::string text, std::string hint = {}) const;

  private:
    std::string file_name_;
    std::vector<IniEntry> entries_;
};

/// Parts between blanks.
std::vector<std::string_view> words_of(std::string_view text);

}  // namespace trunnion::files::detail
