#include <algorithm>
#include <array>

#include "trunnion/base/number.hpp"

#include "detail/dialects.hpp"
#include "detail/text.hpp"

namespace trunnion::nc {

namespace {

/// G words in tenths that LinuxCNC and SINUMERIK do not have.
constexpr int own_g_words[] = {62,  434, 435, 491, 501,  511,  531,  536,  541, 650,
                               660, 670, 682, 683, 1540, 1870, 2340, 2540, 2550};

bool begins_with(std::string_view line, std::string_view word) {
    return line.size() > word.size() && reads(line.substr(0, word.size()), word);
}

/// IF [..] GOTO, WHILE [..] DO: statements without O in front.
bool is_statement(std::string_view line) {
    for (const std::string_view word : {"IF", "WHILE"})
        if (begins_with(line, word) && skip_blanks(line.substr(word.size())).starts_with('[')) return true;
    return false;
}

/// The title of a program: O with four digits or more, and nothing behind it but a comment; O with a name of letters.
/// LinuxCNC has O with fewer digits before its subprograms too.
bool is_program_title(std::string_view line) {
    constexpr std::size_t fewest_digits = 4;
    if (line.size() < 2 || line.front() != 'O') return false;
    std::string_view rest = line.substr(1);
    while (!rest.empty() && is_digit(rest.front())) rest.remove_prefix(1);
    const std::size_t digits = line.size() - 1 - rest.size();
    if (digits == 0) return is_letter(line[1]);
    rest = skip_blanks(rest);
    return digits >= fewest_digits && (rest.empty() || rest.front() == '(' || rest.front() == ';');
}

}  // namespace

bool is_fanuc_line(std::string_view line) noexcept {
    if (line.empty()) return false;
    if (is_program_title(line)) return true;
    if (line.front() == '/') line = skip_blanks(line.substr(1));
    if (!line.empty() && upper(line.front()) == 'N') {
        line.remove_prefix(1);
        while (!line.empty() && (is_digit(line.front()) || is_blank(line.front()))) line.remove_prefix(1);
    }
    if (is_statement(line)) return true;
    while (!line.empty()) {
        const char c = upper(line.front());
        if (c == ';' || c == '#' || c == '=') return false;
        if (c == '(') {
            line.remove_prefix(std::min(line.find(')'), line.size() - 1) + 1);
            continue;
        }
        line.remove_prefix(1);
        if (c != 'G') continue;
        std::string_view number = line;
        const auto value = take_number(number);
        if (!value || *value < 0 || *value > 1000) continue;
        const int tenths = static_cast<int>(*value * 10 + 0.5);
        if (std::ranges::find(own_g_words, tenths) != std::end(own_g_words)) return true;
        line = number;
    }
    return false;
}

}  // namespace trunnion::nc
