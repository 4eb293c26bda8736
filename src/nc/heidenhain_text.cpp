#include "detail/heidenhain_text.hpp"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <iterator>
#include <system_error>

#include "trunnion/base/number.hpp"

namespace trunnion::nc::heidenhain {

namespace {

constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";

bool is_name_character(char c) {
    return is_letter(c) || c == '_';
}

/// Without a comment, which begins with `;` outside quotation marks.
std::string_view without_comment(std::string_view line) {
    if (line.find(';') == line.npos) return line;
    bool quoted = false;
    for (std::size_t i = 0; i < line.size(); ++i) {
        if (line[i] == '"') quoted = !quoted;
        if (line[i] == ';' && !quoted) return line.substr(0, i);
    }
    return line;
}

/// A number in front of a block, and the blank behind it.
std::string_view without_number(std::string_view block) {
    std::size_t digits = 0;
    while (digits < block.size() && is_digit(block[digits])) ++digits;
    return digits == 0 ? block : skip_blanks(block.substr(digits));
}

/// Whether a line goes on in the next one; the mark may stand in the comment, as the control writes it.
bool goes_on(std::string_view line) {
    line = trimmed(line);
    return line.ends_with('~') && !line.starts_with(';') && !line.starts_with('*');
}

std::string_view without_mark(std::string_view text) {
    text = trimmed(text);
    if (text.ends_with('~')) text.remove_suffix(1);
    return trimmed(text);
}

std::string in_capitals(std::string_view text) {
    std::string capitals(text);
    for (char& c : capitals) c = upper(c);
    return capitals;
}

/// The number again, with a point for the comma.
std::optional<double> number_with_comma(std::string_view& text) noexcept {
    constexpr std::size_t longest = 64;
    std::array<char, longest> copy{};
    const std::size_t length = std::min(text.size(), longest);
    std::replace_copy(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(length), copy.begin(), ',', '.');
    std::string_view rest(copy.data(), length);
    const auto value = take_number(rest);
    if (value) text.remove_prefix(length - rest.size());
    return value;
}

}  // namespace

std::optional<double> take_klartext_number(std::string_view& text) noexcept {
    std::string_view rest = text;
    const auto value = take_number(rest);
    const bool comma = value ? rest.starts_with(',') : text.substr(0, 2).contains(',');
    if (comma) return number_with_comma(text);
    if (value) text = rest;
    return value;
}

std::string label_name(std::string_view written) {
    written = trimmed(written);
    if (written.starts_with('"')) return std::string(written.substr(0, written.find('"', 1)));
    std::size_t digits = 0;
    while (digits < written.size() && is_digit(written[digits])) ++digits;
    written = written.substr(0, digits);
    while (written.size() > 1 && written.front() == '0') written.remove_prefix(1);
    return std::string(written);
}

Spot Statement::spot(std::size_t index) const {
    const Part* part = &parts_.front();
    for (const Part& next : parts_)
        if (next.begin <= index) part = &next;
    return {part->line, part->column + static_cast<int>(index - part->begin), file_};
}

std::unique_ptr<Source> Source::keeping(std::string file, std::string text) {
    auto source = std::make_unique<Source>(std::move(file), std::string_view{});
    source->kept_ = std::move(text);
    const std::string_view kept = source->kept_;
    source->text_ = kept.starts_with(byte_order_mark) ? kept.substr(byte_order_mark.size()) : kept;
    return source;
}

std::string_view Source::take_line(LinePlace& place) {
    place.line = number_behind(place.line);
    return text_.line(place.offset, place.offset);
}

Source::Taken Source::next(LinePlace& place, Statement& statement) {
    while (place.offset < text_.size()) {
        const int number = place.line;
        const std::string_view line = take_line(place);
        std::string_view block = without_number(trimmed(without_comment(line)));
        const bool continued = goes_on(line);
        if (continued) block = without_mark(block);
        if ((block.empty() && !continued) || block.starts_with('*') || block.starts_with('%')) continue;
        statement.text_ = block;
        statement.file_ = file_;
        const std::ptrdiff_t column = block.empty() ? 0 : block.data() - line.data();
        statement.parts_.assign(1, {0, number, 1 + static_cast<int>(column)});
        if (continued && !join(place, statement)) return Taken::too_long;
        if (!statement.text_.empty()) return Taken::statement;
    }
    return Taken::end;
}

bool Source::join(LinePlace& place, Statement& statement) {
    statement.joined_ = statement.text_;
    bool continued = true;
    while (continued && place.offset < text_.size()) {
        const int number = place.line;
        const std::string_view line = take_line(place);
        continued = goes_on(line);
        const std::string_view block = without_mark(without_comment(line));
        if (block.empty()) continue;
        statement.joined_ += ' ';
        const int column = 1 + static_cast<int>(block.data() - line.data());
        statement.parts_.push_back({statement.joined_.size(), number, column});
        statement.joined_ += block;
        if (statement.joined_.size() > longest_statement) return false;
    }
    statement.text_ = statement.joined_;
    return true;
}

Source::Found Source::label(std::string_view name, LinePlace& place) {
    if (!indexed_) index_labels();
    const auto found = labels_.find(name);
    if (found == labels_.end()) return Found::nowhere;
    place = found->second.place;
    return found->second.twice ? Found::twice : Found::once;
}

void Source::index_labels() {
    indexed_ = true;
    LineScanner lines(text_.again());
    for (std::string_view line; lines.next(line);) {
        const std::string_view block = without_number(trimmed(without_comment(line)));
        if (!reads(block.substr(0, 3), "LBL")) continue;
        const LinePlace behind{lines.offset(), number_behind(lines.number())};
        const auto [label, is_new] = labels_.try_emplace(label_name(block.substr(3)), Label{behind});
        label->second.twice = !is_new;
    }
}

bool Cursor::take_word(std::string_view capitals) {
    rest_ = skip_blanks(rest_);
    if (!reads(rest_.substr(0, capitals.size()), capitals)) return false;
    if (rest_.size() > capitals.size() && is_name_character(rest_[capitals.size()])) return false;
    rest_.remove_prefix(capitals.size());
    return true;
}

std::string_view Cursor::name() {
    rest_ = skip_blanks(rest_);
    std::size_t length = 0;
    while (length < rest_.size() && length < name_.size() && is_name_character(rest_[length])) {
        name_[length] = upper(rest_[length]);
        ++length;
    }
    if (length > 1 && length < rest_.size() && is_digit(rest_[length])) {
        const std::string_view found(name_.data(), length);
        for (const std::string_view parameter : {"QL", "QR", "Q"})
            if (found.ends_with(parameter) && found != parameter) {
                length -= parameter.size();
                break;
            }
    }
    rest_.remove_prefix(length);
    return {name_.data(), length};
}

std::optional<std::string_view> Cursor::quoted() {
    if (front() != '"') return {};
    const std::size_t end = rest_.find('"', 1);
    if (end == rest_.npos) return {};
    const std::string_view found = rest_.substr(1, end - 1);
    rest_.remove_prefix(end + 1);
    return found;
}

std::string_view Cursor::bare() {
    rest_ = skip_blanks(rest_);
    std::size_t length = 0;
    while (length < rest_.size() && !is_blank(rest_[length])) ++length;
    const std::string_view found = rest_.substr(0, length);
    rest_.remove_prefix(length);
    return found;
}

Folder::Folder(std::string_view main_program) {
    std::error_code error;
    const std::filesystem::path file(main_program);
    if (!std::filesystem::is_regular_file(file, error)) return;
    folder_ = std::filesystem::canonical(file.has_parent_path() ? file.parent_path() : ".", error);
    if (error) folder_.clear();
}

void Folder::list() {
    listed_ = true;
    if (folder_.empty()) return;
    std::error_code error;
    for (std::filesystem::directory_iterator at(folder_, error), end; !error && at != end; at.increment(error))
        files_[in_capitals(at->path().filename().string())].push_back(at->path());
}

Folder::Found Folder::read(std::string_view name, std::unique_ptr<Source>& source) {
    if (name.find_first_of("/\\:") != name.npos || name.starts_with("..")) return Found::outside;
    if (!listed_) list();
    std::string wanted = in_capitals(name);
    if (!wanted.ends_with(".H")) wanted += ".H";
    const auto found = files_.find(wanted);
    if (found == files_.end()) return Found::nothing;
    if (found->second.size() > 1) return Found::several;
    std::error_code error;
    const std::filesystem::path file = std::filesystem::canonical(found->second.front(), error);
    if (error || !std::filesystem::is_regular_file(file, error)) return Found::unreadable;
    if (file.parent_path() != folder_) return Found::outside;
    std::ifstream stream(file, std::ios::binary);
    std::string text{std::istreambuf_iterator<char>(stream), {}};
    if (!stream || text.find('\0') != text.npos) return Found::unreadable;
    source = Source::keeping(file.string(), std::move(text));
    return Found::file;
}

}  // namespace trunnion::nc::heidenhain
