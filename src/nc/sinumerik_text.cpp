#include "detail/sinumerik_text.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <system_error>

#include "trunnion/base/number.hpp"

namespace trunnion::nc::sinumerik {

namespace {

constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";

/// One letter and digits end there: in X=R1Y=R2 the parameter is R1.
std::size_t name_length(std::string_view text) {
    const std::size_t first = text.starts_with('$') ? 1 : 0;
    if (first == text.size() || is_digit(text[first])) return 0;
    const bool address = is_letter(text[0]) && text.size() > 1 && is_digit(text[1]);
    std::size_t length = first + (address ? 1 : 0);
    while (length < text.size() && (address ? is_digit(text[length]) : is_name_character(text[length]))) ++length;
    return length == first ? 0 : length;
}

/// Whether a line is more than blanks, a comment or a mark of tapes.
bool says_something(std::string_view line) {
    const std::string_view text = trimmed(line);
    return !text.empty() && text.front() != ';' && text.front() != '%';
}

/// Behind a decimal number: EX and a whole power of ten.
std::optional<double> scaled(double mantissa, std::string_view& rest) {
    std::string_view after = rest;
    if (!after.starts_with("EX") || after.size() < 3 || !starts_number(after[2])) return mantissa;
    after.remove_prefix(2);
    const auto power = take_number(after);
    if (!power || *power != std::floor(*power)) return {};
    const double value = mantissa * std::pow(10, *power);
    if (!std::isfinite(value)) return {};
    rest = after;
    return value;
}

std::string_view without(std::string_view name, std::string_view prefix, std::string_view suffix) {
    if (name.starts_with(prefix)) name.remove_prefix(prefix.size());
    if (name.ends_with(suffix)) name.remove_suffix(suffix.size());
    return name;
}

}  // namespace

std::string in_capitals(std::string_view text) {
    std::string capitals(text);
    for (char& c : capitals) c = upper(c);
    return capitals;
}

void Cursor::start(std::string_view capitals, const char* original, int number, std::string_view file) {
    line_ = rest_ = capitals;
    original_ = original;
    number_ = number;
    file_ = file;
}

bool Cursor::at_end() {
    rest_ = skip_blanks(rest_);
    return rest_.empty() || rest_.front() == ';';
}

char Cursor::front() {
    return at_end() ? '\0' : rest_.front();
}

bool Cursor::sees(std::string_view symbol) {
    rest_ = skip_blanks(rest_);
    return rest_.starts_with(symbol);
}

bool Cursor::take(std::string_view symbol) {
    if (!sees(symbol)) return false;
    rest_.remove_prefix(symbol.size());
    return true;
}

bool Cursor::take_word(std::string_view word) {
    if (peek_name() != word) return false;
    name();
    return true;
}

bool Cursor::want(std::string_view symbol) {
    if (take(symbol)) return true;
    return refuse("NC0501", column(), std::string(symbol) + " is missing", rest_.substr(0, 12));
}

bool Cursor::want_end() {
    if (at_end()) return true;
    return refuse("NC0524", column(), "nothing more can stand in this line", rest_.substr(0, 12));
}

bool Cursor::refuse_here() {
    if (at_end()) return refuse("NC0501", column(), "something is missing at the end of the line");
    return refuse("NC0202", column(), "not expected here", rest_.substr(0, 1));
}

std::string_view Cursor::name() {
    rest_ = skip_blanks(rest_);
    const std::string_view found = rest_.substr(0, name_length(rest_));
    rest_.remove_prefix(found.size());
    return found;
}

std::string_view Cursor::peek_name() const {
    const std::string_view next = skip_blanks(rest_);
    return next.substr(0, name_length(next));
}

std::optional<double> Cursor::number() {
    rest_ = skip_blanks(rest_);
    std::string_view after = rest_;
    auto value = take_number(after);
    if (value && after.starts_with('E')) value = scaled(*value, after);
    if (value) rest_ = after;
    return value;
}

bool Cursor::text(std::string& into) {
    rest_ = skip_blanks(rest_);
    const std::size_t end = rest_.find('"', 1);
    if (end == rest_.npos)
        return refuse("NC0515", column(), "a text without its end", rest_.substr(0, 20), "close it with \"");
    into.assign(original_ + (rest_.data() - line_.data()) + 1, end - 1);
    rest_.remove_prefix(end + 1);
    return true;
}

/// Behind a text between quotation marks; to the end where it is not closed.
bool Cursor::skip_text() {
    if (front() != '"') return false;
    const std::size_t end = rest_.find('"', 1);
    rest_.remove_prefix(end == rest_.npos ? rest_.size() : end + 1);
    return true;
}

bool Cursor::goes_to_word(std::string_view word) {
    while (!at_end()) {
        if (skip_text()) continue;
        if (const std::string_view found = name(); found == word)
            return true;
        else if (found.empty())
            advance(1);
    }
    return false;
}

bool Cursor::has_jump() const {
    for (const std::string_view jump : {"GOTOF", "GOTOB", "GOTO", "GOTOC", "GOTOS"})
        if (Cursor ahead = *this; ahead.goes_to_word(jump)) return true;
    return false;
}

Source::Source(std::string file, const ProgramText& text) : file_(std::move(file)), text_(text) {
    if (text.view().starts_with(byte_order_mark)) text_ = text.without(byte_order_mark.size());
}

std::unique_ptr<Source> Source::keeping(std::string file, std::string text) {
    auto source = std::make_unique<Source>(std::move(file), std::string_view{});
    source->kept_ = std::move(text);
    const std::string_view kept = source->kept_;
    source->text_ = kept.starts_with(byte_order_mark) ? kept.substr(byte_order_mark.size()) : kept;
    return source;
}

void Source::take_line(LinePlace& place, CapitalLine& line) {
    const std::string_view written = text_.line(place.offset, place.offset);
    place.line = number_behind(place.line);
    line.original = written.data();
    line.capitals = written;
    if (std::ranges::none_of(written, [](char c) { return c >= 'a' && c <= 'z'; })) return;
    line.buffer.resize(written.size());
    std::ranges::transform(written, line.buffer.begin(), upper);
    line.capitals = line.buffer;
}

/// A line with % and a name starts a section; % alone is a mark of tapes. What stands before the first one is a section
/// too, unless it is blank.
void Source::cut_sections() {
    sections_.emplace_back();
    bool first_is_blank = true;
    LineScanner lines(text_.again());
    LinePlace start;
    for (std::string_view line; lines.next(line); start = {lines.offset(), number_behind(lines.number())}) {
        if (sections_.size() == 1 && first_is_blank) first_is_blank = !says_something(line);
        if (!line.starts_with('%')) continue;
        const std::string header = in_capitals(trimmed(line.substr(1)));
        if (header.empty()) continue;
        const std::string_view name = std::string_view(header).substr(0, header.find_first_of(" \t;("));
        sections_.back().end = start.offset;
        Section section;
        section.main = name.ends_with("_MPF");
        section.name = without(without(name, "_N_", "_MPF"), "", "_SPF");
        section.begin = {lines.offset(), number_behind(lines.number())};
        sections_.push_back(std::move(section));
    }
    sections_.back().end = text_.size();
    if (sections_.size() > 1 && first_is_blank) sections_.erase(sections_.begin());
}

int Source::next_line_that_says_something(LinePlace place, std::size_t end) {
    while (place.offset < std::min(end, text_.size())) {
        const int number = place.line;
        if (says_something(text_.line(place.offset, place.offset))) return number;
        place.line = number_behind(place.line);
    }
    return 0;
}

Section& Source::main_section() {
    if (sections_.empty()) cut_sections();
    const auto main = std::ranges::find_if(sections_, &Section::main);
    return main == sections_.end() ? sections_.front() : *main;
}

Section* Source::section(std::string_view name) {
    if (sections_.empty()) cut_sections();
    const auto found = std::ranges::find(sections_, name, &Section::name);
    return found == sections_.end() || name.empty() ? nullptr : &*found;
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
    if (!listed_) list();
    const bool has_ending = name.ends_with(".SPF") || name.ends_with(".MPF");
    auto found = files_.end();
    if (has_ending) found = files_.find(name);
    for (const std::string_view ending : {".SPF", ".MPF"})
        if (found == files_.end() && !has_ending) found = files_.find(std::string(name).append(ending));
    if (found == files_.end()) return Found::nothing;
    if (found->second.size() > 1) return Found::several;
    std::error_code error;
    const std::filesystem::path file = std::filesystem::canonical(found->second.front(), error);
    if (error || !std::filesystem::is_regular_file(file, error)) return Found::unreadable;
    if (file.parent_path() != folder_) return Found::outside;
    std::ifstream stream(file, std::ios::binary);
    std::string text{std::istreambuf_iterator<char>(stream), {}};
    if (!stream || text.contains('\0')) return Found::unreadable;
    source = Source::keeping(found->second.front().string(), std::move(text));
    return Found::file;
}

}  // namespace trunnion::nc::sinumerik
