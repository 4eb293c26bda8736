#include "detail/linuxcnc_ini.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "trunnion/base/number.hpp"

namespace trunnion::files::detail {

namespace {

constexpr std::string_view blanks = " \t\r";

std::string_view trimmed(std::string_view text) {
    const auto first = text.find_first_not_of(blanks);
    if (first == text.npos) return {};
    return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

/// Lines, those that end in a backslash joined with the next, each with its number.
class Lines {
  public:
    explicit Lines(std::string_view text) : text_(text) {}
    bool next(std::string& line) {
        if (text_.empty()) return false;
        first_ = last_ + 1;
        line.clear();
        while (take(line) && line.ends_with('\\')) line.pop_back();
        return true;
    }
    int number() const { return first_; }

  private:
    bool take(std::string& line) {
        if (text_.empty()) return false;
        const auto end = std::min(text_.find('\n'), text_.size());
        auto part = text_.substr(0, end);
        if (part.ends_with('\r')) part.remove_suffix(1);
        line += part;
        text_.remove_prefix(std::min(end + 1, text_.size()));
        ++last_;
        return true;
    }

    std::string_view text_;
    int first_ = 0, last_ = 0;
};

}  // namespace

std::vector<std::string_view> words_of(std::string_view text) {
    std::vector<std::string_view> out;
    for (text = trimmed(text); !text.empty(); text = trimmed(text)) {
        const auto end = std::min(text.find_first_of(blanks), text.size());
        out.push_back(text.substr(0, end));
        text.remove_prefix(end);
    }
    return out;
}

Result<LinuxcncIni> LinuxcncIni::parse(std::string_view text, std::string_view file_name) {
    LinuxcncIni out;
    out.file_name_ = file_name;
    Lines lines(text);
    std::string section, whole;
    while (lines.next(whole)) {
        const std::string_view line = trimmed(whole);
        IniEntry here{.section = section, .line = lines.number()};
        if (line.starts_with("#INCLUDE"))
            return fail(out.at(here, "FILE0120", "another file is included",
                               "LinuxCNC writes the whole as NAME.expanded: give that file"));
        if (line.empty() || line[0] == '#' || line[0] == ';') continue;
        if (line[0] == '[') {
            const auto end = line.find(']');
            if (end == line.npos) return fail(out.at(here, "FILE0120", "a section without its closing bracket"));
            section = trimmed(line.substr(1, end - 1));
            continue;
        }
        const auto equals = line.find('=');
        if (equals == line.npos || trimmed(line.substr(0, equals)).empty())
            return fail(out.at(here, "FILE0120", "neither a section nor KEY = VALUE"));
        if (section.empty()) return fail(out.at(here, "FILE0120", "a key outside of all sections"));
        here.key = trimmed(line.substr(0, equals));
        here.value = trimmed(line.substr(equals + 1));
        out.entries_.push_back(std::move(here));
    }
    return out;
}

const IniEntry* LinuxcncIni::find(std::string_view section, std::string_view key) const {
    const auto found = std::ranges::find_if(
        entries_, [&](const IniEntry& entry) { return entry.section == section && entry.key == key; });
    return found == entries_.end() ? nullptr : &*found;
}

std::vector<const IniEntry*> LinuxcncIni::all(std::string_view section, std::string_view key) const {
    std::vector<const IniEntry*> out;
    for (const IniEntry& entry : entries_)
        if (entry.section == section && entry.key == key) out.push_back(&entry);
    return out;
}

Result<const IniEntry*> LinuxcncIni::required(std::string_view section, std::string_view key) const {
    if (const IniEntry* found = find(section, key)) return found;
    return fail(at_file("FILE0121", fmt::format("there is no [{}]{}", section, key)));
}

Result<double> LinuxcncIni::number(const IniEntry& entry) const {
    std::string_view rest = entry.value;
    const auto value = take_number(rest, Exponent::allowed);
    if (value && trimmed(rest).empty()) return *value;
    return fail(at(entry, "FILE0122", fmt::format("[{}]{} is not a number", entry.section, entry.key),
                   "LinuxCNC knows no comment behind a value"));
}

Diagnostic LinuxcncIni::at(const IniEntry& entry, std::string code, std::string text, std::string hint) const {
    Diagnostic out = at_file(std::move(code), std::move(text), std::move(hint));
    out.place.line = entry.line;
    out.value = entry.value;
    return out;
}

Diagnostic LinuxcncIni::at_file(std::string code, std::string text, std::string hint) const {
    Diagnostic out{.code = std::move(code), .text = std::move(text), .place = {.file = file_name_}};
    out.hint = std::move(hint);
    return out;
}

}  // namespace trunnion::files::detail
