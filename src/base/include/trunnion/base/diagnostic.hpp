#pragma once

#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace trunnion {

enum class Severity { note, warning, error };

/// Where a diagnostic points: into a text (file, line and column from 1; 0 = unknown) or onto a path.
struct Place {
    std::string file;
    int line = 0;
    int column = 0;
    double path_length_mm = std::numeric_limits<double>::quiet_NaN();
};

/// What went wrong, for a person to act on and for a program to test.
/// `code` is stable across releases (letters of the room and four digits: `NC0101`); docs/diagnostics.md lists all.
/// `value` and `limit` carry their unit. `count` > 1: the same thing was met that often, `place` is the first.
struct Diagnostic {
    std::string code;
    Severity severity = Severity::error;
    std::string text;
    Place place{};
    std::string value{};
    std::string limit{};
    std::string hint{};
    int count = 1;
};

/// One line: `FILE:LINE:COLUMN: error NC0101: text (value …, limit …); hint`. Allocates.
std::string to_string(const Diagnostic& diagnostic);
std::string_view to_string(Severity severity);

}  // namespace trunnion
