#include "detail/fanuc_text.hpp"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <iterator>
#include <utility>

#include "detail/text.hpp"

namespace trunnion::nc::fanuc {

namespace {

/// Digits at the start of a text, taken off it.
std::optional<int> take_whole(std::string_view& text) {
    int value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || text.empty() || !is_digit(text.front())) return {};
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    return value;
}

std::string_view without_block_delete(std::string_view line) {
    line = skip_blanks(line);
    if (!line.starts_with('/')) return line;
    line.remove_prefix(1);
    while (!line.empty() && is_digit(line.front())) line.remove_prefix(1);
    return skip_blanks(line);
}

/// The number of a file's name: `O0123.nc`, `123`.
std::optional<int> number_of_file(const std::filesystem::path& file) {
    const std::string stem = file.stem().string();
    std::string_view rest = stem;
    if (rest.starts_with('O') || rest.starts_with('o')) rest.remove_prefix(1);
    const auto number = take_whole(rest);
    return rest.empty() ? number : std::nullopt;
}

}  // namespace

bool begins_like_code(std::string_view line) {
    line = without_block_delete(line);
    if (line.empty()) return false;
    if (line.front() == '#' || line.front() == ':') return true;
    if (!is_letter(line.front())) return false;
    for (const std::string_view statement : {"IF", "WHILE", "GOTO"})
        if (line.size() > statement.size() && reads(line.substr(0, statement.size()), statement) &&
            (line[statement.size()] == '[' || is_blank(line[statement.size()]) || is_digit(line[statement.size()])))
            return true;
    line = skip_blanks(line.substr(1));
    return !line.empty() && (starts_number(line.front()) || line.front() == '#' || line.front() == '[');
}

Beginning beginning_of(const ProgramText& text) {
    Beginning beginning;
    LineScanner lines(text.again());
    for (std::string_view line; lines.next(line);) {
        line = trimmed(line);
        if (line.starts_with('%')) {
            beginning.place = {lines.offset(), number_behind(lines.number())};
            return beginning;
        }
        if (begins_like_code(line) || is_title(line)) return {};
        if (!line.empty() && line.front() != '(' && line.front() != ';' && line.front() != '*')
            beginning.behind_header = true;
    }
    return {};
}

std::optional<int> take_program_number(std::string_view& line) {
    std::string_view rest = skip_blanks(line);
    if (rest.empty() || (upper(rest.front()) != 'O' && rest.front() != ':')) return {};
    rest = skip_blanks(rest.substr(1));
    const auto number = take_whole(rest);
    if (number) line = rest;
    return number;
}

bool is_title(std::string_view line) {
    line = skip_blanks(line);
    if (line.size() < 2 || (upper(line.front()) != 'O' && line.front() != ':')) return false;
    const char second = skip_blanks(line.substr(1)).empty() ? ' ' : skip_blanks(line.substr(1)).front();
    return is_digit(second) || (line.front() != ':' && (is_letter(line[1]) || line[1] == '<'));
}

// ------------------------------------------------------------------------------------------------------------ sources

Source::Source(const ProgramText& text, std::string file)
    : file_(std::move(file)), text_(text), beginning_(beginning_of(text)) {}

std::unique_ptr<Source> Source::keeping(std::string file, std::string text) {
    auto source = std::make_unique<Source>(std::string_view{}, std::move(file));
    source->kept_ = std::move(text);
    source->text_ = source->kept_;
    source->beginning_ = beginning_of(source->text_);
    return source;
}

std::string_view Source::line_at(const Place& place) {
    const std::string_view before = text_.view().substr(0, place.offset);
    std::size_t behind = 0;
    return text_.line(before.rfind('\n') + 1, behind);
}

Place Source::line_behind(const Place& place) {
    Place behind{place.offset, number_behind(place.line)};
    text_.line(place.offset, behind.offset);
    return behind;
}

void Source::cut_sections() {
    sections_.push_back({.begin = beginning_.place, .end = text_.size()});
    bool code_before = false;
    Source scan(text_.again());
    Place place = beginning_.place;
    for (; place.offset < text_.size(); place = scan.line_behind(place)) {
        std::string_view line = skip_blanks(scan.line_at(place));
        if (line.starts_with('%')) break;
        if (is_title(line)) {
            sections_.back().end = place.offset;
            if (!code_before) sections_.pop_back();
            const auto number = take_program_number(line);
            sections_.push_back({.number = number.value_or(-1), .begin = place, .end = text_.size()});
            code_before = true;
        }
        code_before = code_before || begins_like_code(line);
    }
    sections_.back().end = std::min(sections_.back().end, place.offset);
}

Section Source::main_section() {
    Section section{.begin = beginning_.place, .end = text_.size()};
    Source scan(text_.again());
    for (Place place = section.begin; place.offset < text_.size(); place = scan.line_behind(place)) {
        std::string_view line = skip_blanks(scan.line_at(place));
        if (begins_like_code(line) && !is_title(line)) break;
        if (line.starts_with('%')) break;
        if (!is_title(line)) continue;
        section.begin = place;
        section.number = take_program_number(line).value_or(-1);
        break;
    }
    return section;
}

std::size_t Source::end_of(const Section& section) {
    if (sections_.empty()) cut_sections();
    const auto found =
        std::ranges::find(sections_, section.begin.offset, [](const Section& known) { return known.begin.offset; });
    return found == sections_.end() ? section.end : found->end;
}

const Section* Source::section(int number) {
    if (sections_.empty()) cut_sections();
    const auto found = std::ranges::find(sections_, number, &Section::number);
    return found == sections_.end() ? nullptr : &*found;
}

const std::vector<Place>& Source::labels(const Section& section, int number) {
    const auto [entry, is_new] = labels_.try_emplace({section.begin.offset, number});
    if (!is_new) return entry->second;
    const std::size_t end = end_of(section);
    Source scan(text_.again());
    for (Place place = section.begin; place.offset < end; place = scan.line_behind(place)) {
        std::string_view line = without_block_delete(scan.line_at(place));
        if (line.empty() || upper(line.front()) != 'N') continue;
        line = skip_blanks(line.substr(1));
        if (take_whole(line) == number) entry->second.push_back(place);
    }
    return entry->second;
}

// ------------------------------------------------------------------------------------------------------------- folder

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
        if (const auto number = number_of_file(at->path())) files_[*number].push_back(at->path());
}

Folder::Found Folder::read(int number, std::unique_ptr<Source>& source) {
    if (!listed_) list();
    const auto found = files_.find(number);
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

}  // namespace trunnion::nc::fanuc
