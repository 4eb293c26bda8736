#include <algorithm>
#include <array>
#include <optional>

#include "trunnion/base/number.hpp"

#include "detail/dialects.hpp"
#include "detail/sinumerik_words.hpp"
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

constexpr int lines_that_may_tell = 4000;  ///< a SINUMERIK program may look like any G-code for a while

/// An identifier that only SINUMERIK programs have, in capitals.
bool is_sinumerik_name(std::string_view name) {
    constexpr std::string_view language[] = {"CASE",   "DEF",   "ENDFOR", "ENDLOOP", "ENDPROC", "EXTCALL",
                                             "EXTERN", "GOTOB", "GOTOC",  "GOTOF",   "PROC",    "UNTIL"};
    return name.size() > 2 && (sinumerik::is_word(name) || std::ranges::find(language, name) != std::end(language));
}

/// Addresses to which `=` is written: `X=R1`, `CR=5`, `A3=0.1`.
bool takes_equals(std::string_view name) {
    return name.size() == 1 || (is_letter(name[0]) && std::ranges::all_of(name.substr(1), is_digit)) || name == "CR" ||
           name == "AR";
}

/// The letters, digits and underscores that a text starts with, in capitals; longer ones are cut.
struct Name {
    std::array<char, 16> capitals{};
    std::size_t length = 0, letters = 0;

    explicit Name(std::string_view text) {
        while (length < text.size() && length < capitals.size() &&
               (is_letter(text[length]) || text[length] == '_' || is_digit(text[length]))) {
            capitals[length] = upper(text[length]);
            if (letters == length && !is_digit(text[length])) ++letters;
            ++length;
        }
    }
    std::string_view whole() const { return {capitals.data(), length}; }
    std::string_view without_digits() const { return {capitals.data(), letters}; }
};

/// Whether a line of G-code could only stand in a SINUMERIK program. Comments are passed over, and what follows a word
/// that is not known; but a name and a colon are a label.
bool is_sinumerik_line(std::string_view line) {
    if (line.starts_with("%_N_") || line.starts_with(";$PATH")) return true;
    while (!line.empty()) {
        const char c = line.front();
        if (c == ';') return false;
        if (c == '(') {
            line.remove_prefix(std::min(line.find(')'), line.size() - 1) + 1);
            continue;
        }
        const Name name(line);
        if (name.letters == 0) {
            if (c == '#' || c == '<') return false;
            line.remove_prefix(1);
            continue;
        }
        const std::string_view behind = skip_blanks(line.substr(name.length));
        if (is_sinumerik_name(name.whole()) || is_sinumerik_name(name.without_digits())) return true;
        if (takes_equals(name.whole()) && behind.starts_with('=')) return true;
        if (name.letters > 1) return behind == ":";
        line.remove_prefix(1);
        if (name.capitals.front() == 'G' && name.length == 4 && name.capitals[1] >= '5') return true;
    }
    return false;
}

/// A word for surfaces, G320 to G324, which the rs274 of this house alone has.
bool is_surface_line(std::string_view line) {
    for (; !line.empty() && line.front() != ';' && line.front() != '('; line.remove_prefix(1)) {
        if (upper(line.front()) != 'G' || !line.substr(1).starts_with("32") || line.size() < 4) continue;
        const bool ends = line.size() == 4 || (!is_digit(line[4]) && line[4] != '.');
        if (line[3] >= '0' && line[3] <= '4' && ends) return true;
    }
    return false;
}

/// MillPlus is told by its mark alone: its `B5=` would pass for SINUMERIK.
bool is_millplus_mark(std::string_view line) {
    return line.starts_with("%PM") || line.starts_with("%MM");
}

/// Which kind of G-code it is, from a line on that could be either.
Dialect which_g_code(std::string_view line, LineScanner lines) {
    const int last = lines.number() + lines_that_may_tell;
    if (is_millplus_mark(line)) return Dialect::fanuc;  // its reader says why it is not read
    do {
        if (is_surface_line(line)) return Dialect::rs274;
        if (is_sinumerik_line(trimmed(line))) return Dialect::sinumerik;
        if (is_fanuc_line(trimmed(line))) return Dialect::fanuc;
    } while (lines.number() < last && lines.next(line));
    return Dialect::rs274;
}

/// A listing that stands before the `%` of a tape, as NX writes it: what follows is for ISO controls unless it says
/// otherwise. Empty where there is no `%`.
std::optional<Dialect> behind_header(LineScanner lines) {
    const int last = lines.number() + lines_that_may_tell;
    for (std::string_view line; lines.number() < last && lines.next(line);) {
        if (!trimmed(line).starts_with('%')) continue;
        const Dialect dialect = which_g_code(trimmed(line), lines);
        return dialect == Dialect::rs274 ? Dialect::fanuc : dialect;
    }
    return {};
}

Diagnostic not_recognised(int line) {
    Diagnostic diagnostic{.code = "NC0004", .text = "not recognised as a part program in a dialect that is read"};
    diagnostic.place.line = line;
    diagnostic.place.column = 1;
    diagnostic.hint = "apt, rs274, sinumerik, heidenhain and fanuc are read; --dialect says which one it is";
    return diagnostic;
}

Diagnostic empty_program() {
    return {.code = "NC0002", .text = "the program is empty", .hint = "give a part program with at least one move"};
}

}  // namespace

Result<Dialect> recognise(std::string_view text) {
    return recognise_lines(text);
}

Result<Dialect> recognise_lines(const ProgramText& text) {
    LineScanner lines(text.again());
    bool comments = false;  // such as several dialects have
    for (std::string_view line; lines.next(line);) {
        line = trimmed(line);
        const bool comment = line.starts_with(';') && !is_sinumerik_line(line);
        comments = comments || comment;
        if (line.empty() || comment) continue;
        if (line.starts_with("$$") || is_apt_statement(line) || is_pose(line)) return Dialect::apt;
        if (is_heidenhain_line(line)) return Dialect::heidenhain;
        if (is_rs274_block(line) || is_sinumerik_line(line) || is_fanuc_line(line)) return which_g_code(line, lines);
        if (const auto dialect = behind_header(lines)) return *dialect;
        return fail(not_recognised(lines.number()));
    }
    return comments ? Result<Dialect>(Dialect::rs274) : fail(empty_program());
}

}  // namespace trunnion::nc
