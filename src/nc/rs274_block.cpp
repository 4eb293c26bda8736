#include "detail/rs274_block.hpp"

#include <cmath>
#include <utility>

#include "trunnion/base/number.hpp"

namespace trunnion::nc {

BlockScanner::Step BlockScanner::next(Block& block) {
    if (!lines_.next(line_)) return Step::end;
    rest_ = skip_blanks(line_);
    block.line = lines_.number();
    block.present = 0;
    block.code_count = 0;
    block.deleted = false;
    block.empty = true;
    if (rest_.starts_with('%')) return ++percent_signs_ < 2 ? Step::block : Step::end;
    return scan(block) ? Step::block : Step::refused;
}

bool BlockScanner::scan(Block& block) {
    if (rest_.starts_with('/')) {
        block.deleted = true;
        return true;
    }
    for (; !rest_.empty(); rest_ = skip_blanks(rest_)) {
        const char c = rest_.front();
        if (c == ';') return true;
        if (c == '(' ? !comment() : !word(block)) return false;
    }
    return true;
}

bool BlockScanner::comment() {
    const std::size_t end = rest_.find(')');
    if (end == rest_.npos)
        return refuse("NC0203", column(), "a comment without its end", rest_.substr(0, 20), "close it with )");
    if (rest_.substr(1, end).contains('('))
        return refuse("NC0203", column(), "a comment within a comment", rest_.substr(0, end + 1));
    rest_.remove_prefix(end + 1);
    return true;
}

bool BlockScanner::word(Block& block) {
    const int at = column();
    const char letter = upper(rest_.front());
    if (letter == '#' || letter == '[' || letter == 'O')
        return refuse("NC0303", at, "parameters, expressions and O words are not evaluated", rest_.substr(0, 8),
                      "give the program with the numbers worked out");
    if (!is_letter(letter)) return refuse("NC0202", at, "not expected here", rest_.substr(0, 1));
    const std::string_view written = rest_;
    rest_ = skip_blanks(rest_.substr(1));
    if (!rest_.empty() && (rest_.front() == '#' || rest_.front() == '['))
        return refuse("NC0303", column(), "parameters and expressions are not evaluated", rest_.substr(0, 8),
                      "give the program with the numbers worked out");
    const auto value = number();
    if (!value) return refuse("NC0201", at, "no finite number behind the letter", written.substr(0, 12));
    const bool first = std::exchange(block.empty, false);
    if (letter == 'N' && first) return true;
    if (letter == 'G' || letter == 'M') return code(block, letter, *value, at);
    if (block.has(letter)) return refuse("NC0305", at, "the same letter twice in a block", written.substr(0, 1));
    block.present |= Block::bit(letter);
    block.value[Block::index(letter)] = *value;
    block.column[Block::index(letter)] = at;
    return true;
}

bool BlockScanner::code(Block& block, char letter, double value, int at) {
    const double tenths = std::round(value * 10);
    if (std::abs(value * 10 - tenths) > 1e-6 || !(tenths >= 0) || tenths > 1e6)
        return refuse("NC0204", at, "no such word", letter == 'G' ? "G" : "M");
    if (block.code_count == Block::most_codes) return refuse("NC0304", at, "too many G and M words in a block", {});
    block.codes[block.code_count++] = {letter, static_cast<int>(tenths), at};
    return true;
}

/// The number that follows. One scan in the usual case, a copy without blanks where blanks stand in it.
std::optional<double> BlockScanner::number() {
    std::string_view after = rest_;
    const auto value = take_number(after);
    const std::string_view behind = skip_blanks(after);
    const bool goes_on =
        behind.size() < after.size() && !behind.empty() && (is_digit(behind.front()) || behind.front() == '.');
    if (!value || goes_on) return number_with_blanks();
    rest_ = behind;
    return value;
}

std::optional<double> BlockScanner::number_with_blanks() {
    std::array<char, 64> digits;
    std::size_t count = 0;
    std::string_view after = rest_;
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
    rest_ = after;
    return value;
}

}  // namespace trunnion::nc
