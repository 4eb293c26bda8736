#include <array>

#include "trunnion/base/number.hpp"

#include "detail/dialects.hpp"
#include "detail/text.hpp"

namespace trunnion::nc {

namespace {

/// x y z or x y z i j k, with commas or blanks between, and nothing else.
bool is_pose(std::string_view line) {
    int numbers = 0;
    for (; !line.empty(); ++numbers) {
        if (!take_number(line, Exponent::allowed)) return false;
        const std::size_t before = line.size();
        line = skip_blanks(line);
        if (line.starts_with(',')) line = skip_blanks(line.substr(1));
        if (!line.empty() && line.size() == before) return false;
    }
    return numbers == 3 || numbers == 6;
}

/// A major word of APT, followed by a slash, a blank or the end of the line.
bool is_apt_statement(std::string_view line) {
    std::array<char, 12> word{};
    std::size_t length = 0;
    while (length < line.size() && length < word.size() && (is_letter(line[length]) || line[length] == '-')) {
        word[length] = upper(line[length]);
        ++length;
    }
    const bool whole = length == line.size() || line[length] == '/' || is_blank(line[length]);
    return whole && (is_apt_word({word.data(), length}) || line.starts_with("TOOL PATH/"));
}

/// A word of G-code, or one of the marks that only G-code has at the start of a line.
bool is_rs274_block(std::string_view line) {
    if (std::string_view("%(;#").contains(line.front())) return true;
    if (line.front() == '/') line = skip_blanks(line.substr(1));
    if (line.empty() || !is_letter(line.front())) return false;
    line = skip_blanks(line.substr(1));
    return !line.empty() && (starts_number(line.front()) || line.front() == '#' || line.front() == '[');
}

Diagnostic not_recognised(int line) {
    Diagnostic diagnostic{.code = "NC0004", .text = "not recognised as a part program in a dialect that is read"};
    diagnostic.place.line = line;
    diagnostic.place.column = 1;
    diagnostic.hint = "apt and rs274 are read; --dialect says which one it is";
    return diagnostic;
}

Diagnostic empty_program() {
    return {.code = "NC0002", .text = "the program is empty", .hint = "give a part program with at least one move"};
}

}  // namespace

Result<Dialect> recognise(std::string_view text) {
    LineScanner lines(text);
    for (std::string_view line; lines.next(line);) {
        line = trimmed(line);
        if (line.empty()) continue;
        if (line.starts_with("$$") || is_apt_statement(line) || is_pose(line)) return Dialect::apt;
        if (is_rs274_block(line)) return Dialect::rs274;
        return fail(not_recognised(lines.number()));
    }
    return fail(empty_program());
}

}  // namespace trunnion::nc
