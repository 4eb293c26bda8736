#include "detail/rs274_block.hpp"

#include <cmath>

#include <fmt/format.h>

#include "trunnion/base/number.hpp"

namespace trunnion::nc {

namespace {

constexpr std::string_view active_comments[] = {"MSG",     "DEBUG",     "PRINT",    "LOG",
                                                "LOGOPEN", "LOGAPPEND", "LOGCLOSE", "PROBEOPEN"};

/// The number that comes next, if blanks stand in it or behind its letter.
std::optional<double> number_with_blanks(std::string_view& text) {
    std::array<char, 64> digits;
    std::size_t count = 0;
    std::string_view after = text;
    for (; !after.empty(); after.remove_prefix(1)) {
        const char c = after.front();
        if (is_blank(c)) continue;
        if (!(is_digit(c) || c == '.' || (count == 0 && starts_number(c)))) break;
        if (count == digits.size()) return {};
        digits[count++] = c;
    }
    std::string_view number{digits.data(), count};
    const auto value = take_number(number);
    if (!value || !number.empty()) return {};
    text = after;
    return value;
}

}  // namespace

BlockScanner::Found BlockScanner::scan(LineCursor& cursor, Block& block) {
    block.line = cursor.number;
    block.file = cursor.file;
    block.present = 0;
    block.code_count = 0;
    block.deleted = false;
    block.empty = true;
    if (cursor.rest.starts_with('/')) {
        block.deleted = true;
        return Found::words;
    }
    assignments_.clear();
    for (; !cursor.rest.empty(); cursor.rest = skip_blanks(cursor.rest)) {
        const char c = cursor.rest.front();
        if (c == ';') break;
        if ((c == 'O' || c == 'o') && block.present == 0 && block.code_count == 0) {
            cursor.rest.remove_prefix(1);
            return Found::o_word;
        }
        if (c == '(' ? !comment(cursor) : !word(cursor, block)) return Found::refused;
    }
    if (!assignments_.empty()) assign();
    return Found::words;
}

bool BlockScanner::at_end(LineCursor& cursor) {
    while (cursor.front() == '(')
        if (!comment(cursor)) return false;
    const char next = cursor.front();
    if (next == '\0' || next == ';') return true;
    return refuse(cursor, "NC0331", cursor.column(), "not expected behind an O word", cursor.rest.substr(0, 12));
}

bool BlockScanner::comment(LineCursor& cursor) {
    std::string_view& rest = cursor.rest;
    const std::size_t end = rest.find(')');
    if (end == rest.npos)
        return refuse(cursor, "NC0203", cursor.column(), "a comment without its end", rest.substr(0, 20),
                      "close it with )");
    if (rest.substr(1, end).contains('('))
        return refuse(cursor, "NC0203", cursor.column(), "a comment within a comment", rest.substr(0, end + 1));
    if (const std::size_t comma = rest.find(','); comma < end)
        for (const std::string_view active : active_comments)
            if (reads(trimmed(rest.substr(1, comma - 1)), active))
                findings_.ignored(cursor.spot(), fmt::format("({},", active));
    rest.remove_prefix(end + 1);
    return true;
}

bool BlockScanner::word(LineCursor& cursor, Block& block) {
    const int at = cursor.column();
    const char letter = upper(cursor.rest.front());
    if (letter == '#') {
        block.empty = false;
        return assignment(cursor);
    }
    if (letter == 'O') return refuse(cursor, "NC0331", at, "an O word stands first in its line", "O");
    if (!is_letter(letter)) return refuse(cursor, "NC0202", at, "not expected here", cursor.rest.substr(0, 1));
    const std::string_view written = cursor.rest;
    cursor.rest = skip_blanks(cursor.rest.substr(1));
    auto value = number(cursor);
    if (!value) {
        if (!ParameterExpressions::starts_here(cursor))
            return refuse(cursor, "NC0201", at, "no finite number behind the letter", written.substr(0, 12));
        if (!expressions_.value(cursor, value)) return false;
    }
    const bool first = std::exchange(block.empty, false);
    if (letter == 'N' && first) return true;
    if (letter == 'G' || letter == 'M') return code(cursor, block, letter, *value, at);
    if (block.has(letter))
        return refuse(cursor, "NC0305", at, "the same letter twice in a block", written.substr(0, 1));
    block.present |= Block::bit(letter);
    block.value[Block::index(letter)] = *value;
    block.column[Block::index(letter)] = at;
    return true;
}

bool BlockScanner::assignment(LineCursor& cursor) {
    const int at = cursor.column();
    ParameterReference parameter;
    if (!expressions_.reference(cursor, parameter)) return false;
    if (!cursor.take('='))
        return refuse(cursor, "NC0320", cursor.column(), "= is missing", cursor.rest.substr(0, 12),
                      "a parameter is set by #1 = 2");
    ParameterValue ignored;
    if (control_.read(parameter, ignored) != ControlParameters::Answer::not_its_own)
        return refuse(cursor, "NC0330", at, "the control's own parameter cannot be set",
                      cursor.line.substr(static_cast<std::size_t>(at - 1), 12));
    ParameterValue value;
    if (!expressions_.value(cursor, value)) return false;
    assignments_.emplace_back(std::move(parameter), value);
    return true;
}

void BlockScanner::assign() {
    for (const auto& [parameter, value] : assignments_) parameters_.set(parameter, value);
}

bool BlockScanner::code(const LineCursor& cursor, Block& block, char letter, double value, int at) {
    const double tenths = std::round(value * 10);
    if (std::abs(value * 10 - tenths) > 1e-6 || !(tenths >= 0) || tenths > 1e6)
        return refuse(cursor, "NC0204", at, "no such word", letter == 'G' ? "G" : "M");
    if (block.code_count == Block::most_codes)
        return refuse(cursor, "NC0304", at, "too many G and M words in a block", {});
    block.codes[block.code_count++] = {letter, static_cast<int>(tenths), at};
    return true;
}

/// The number that follows. One scan in the usual case, a copy without blanks where blanks stand in it.
std::optional<double> BlockScanner::number(LineCursor& cursor) {
    std::string_view after = cursor.rest;
    const auto value = take_number(after);
    const std::string_view behind = skip_blanks(after);
    const bool goes_on =
        behind.size() < after.size() && !behind.empty() && (is_digit(behind.front()) || behind.front() == '.');
    if (!value || goes_on) return number_with_blanks(cursor.rest);
    cursor.rest = behind;
    return value;
}

}  // namespace trunnion::nc
