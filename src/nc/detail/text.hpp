#pragma once

#include <algorithm>
#include <cstddef>
#include <string_view>

#include "detail/program_text.hpp"

namespace trunnion::nc {

constexpr bool is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\r' || c == '\f' || c == '\v';
}
constexpr bool is_digit(char c) {
    return c >= '0' && c <= '9';
}
constexpr char upper(char c) {
    return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
}
constexpr bool is_letter(char c) {
    return upper(c) >= 'A' && upper(c) <= 'Z';
}
constexpr bool starts_number(char c) {
    return is_digit(c) || c == '+' || c == '-' || c == '.';
}

constexpr std::string_view skip_blanks(std::string_view text) {
    while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
    return text;
}

constexpr std::string_view trimmed(std::string_view text) {
    text = skip_blanks(text);
    while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
    return text;
}

/// `word` in capitals is `capitals`.
constexpr bool reads(std::string_view word, std::string_view capitals) {
    return word.size() == capitals.size() &&
           std::equal(word.begin(), word.end(), capitals.begin(), [](char a, char b) { return upper(a) == b; });
}

}  // namespace trunnion::nc
